// SPDX-License-Identifier: LGPL-2.1-or-later
//
// What csdtrackdec's thread and those of its sources tell each other: how downstream took the frames, what ends, and
// what a flush makes void.
#include <atomic>
#include <optional>

#include "csdtrackdec_harness.h"

using namespace csd_check;

namespace {

/// Downstream: takes frames up to a time, and no others. It can hold one for as long as the test wants.
class Downstream {
 public:
  explicit Downstream(Harness &harness) : pad_(gst_element_get_static_pad(harness.element, "src")) {
    probe_ = gst_pad_add_probe(pad_, GST_PAD_PROBE_TYPE_BUFFER, take, this, nullptr);
  }
  ~Downstream() {
    let_go();
    gst_pad_remove_probe(pad_, probe_);
    gst_object_unref(pad_);
  }
  Downstream(const Downstream &) = delete;
  Downstream &operator=(const Downstream &) = delete;

  void end_at(GstClockTime time) { end_ = time; }
  void hold() { held_ = true; }
  void wait_for_frame() {
    while (!inside_) g_usleep(1000);
  }
  void let_go() { held_ = false; }
  void link_anew() {
    GstPad *peer = gst_pad_get_peer(pad_);
    fail_unless(gst_pad_unlink(pad_, peer));
    fail_unless_equals_int(gst_pad_link(pad_, peer), GST_PAD_LINK_OK);
    gst_object_unref(peer);
  }

 private:
  static GstPadProbeReturn take(GstPad *, GstPadProbeInfo *info, gpointer data) {
    auto *self = static_cast<Downstream *>(data);
    GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
    for (self->inside_ = true; self->held_;) g_usleep(1000);
    self->inside_ = false;
    if (GST_BUFFER_PTS(buffer) < self->end_) return GST_PAD_PROBE_OK;
    gst_buffer_unref(buffer);
    GST_PAD_PROBE_INFO_FLOW_RETURN(info) = GST_FLOW_EOS;
    return GST_PAD_PROBE_HANDLED;
  }

  GstPad *const pad_;
  gulong probe_ = 0;
  std::atomic<GstClockTime> end_ = GST_CLOCK_TIME_NONE;
  std::atomic<bool> held_ = false, inside_ = false;
};

/// Pushes frames until downstream has said that it wants no more.
void push_until_eos(Harness &harness) {
  for (int n = 0; gst_harness_push(harness.h, frame_at(n * frame_time)) != GST_FLOW_EOS; ++n) {
    fail_unless(n < 20000, "no EOS");
    g_usleep(1000);
  }
  while (GstBuffer *buffer = gst_harness_try_pull(harness.h)) gst_buffer_unref(buffer);
}

void expect_frames(Harness &harness) {
  for (guint64 n = 0; n < 3; ++n) {
    fail_unless_equals_int(gst_harness_push(harness.h, frame_at(n * frame_time)), GST_FLOW_OK);
    GstBuffer *out = gst_harness_pull(harness.h);
    fail_unless(out && GST_BUFFER_PTS(out) == n * frame_time);
    gst_buffer_unref(out);
  }
}

}  // namespace

GST_START_TEST(frames_go_on_when_downstream_wants_them_again) {
  const struct {
    const char *name;
    void (*go)(Harness &, Downstream &);
  } ways[] = {
      {"a segment", [](Harness &harness, Downstream &) { new_segment(harness.h, 0); }},
      {"a stream",
       [](Harness &harness, Downstream &) {
         gst_harness_push_event(harness.h, gst_event_new_stream_start("another"));
         new_segment(harness.h, 0);
       }},
      {"a link", [](Harness &, Downstream &downstream) { downstream.link_anew(); }},
  };
  for (const auto &way : ways) {
    Harness harness;
    Downstream downstream(harness);
    downstream.end_at(2 * frame_time);
    push_until_eos(harness);
    downstream.end_at(GST_CLOCK_TIME_NONE);
    way.go(harness, downstream);
    const GstFlowReturn flow = gst_harness_push(harness.h, frame_at(0));
    fail_unless(flow == GST_FLOW_OK, "%s: %s", way.name, gst_flow_get_name(flow));
    gst_buffer_unref(gst_harness_pull(harness.h));
    expect_frames(harness);
  }
}
GST_END_TEST

GST_START_TEST(an_end_of_what_came_before_does_not_end_what_comes_next) {
  for (const bool stream : {true, false}) {
    Harness harness;
    Downstream downstream(harness);
    downstream.end_at(frame_time);
    downstream.hold();
    fail_unless_equals_int(gst_harness_push(harness.h, frame_at(frame_time)), GST_FLOW_OK);
    downstream.wait_for_frame();
    fail_unless_equals_int(gst_harness_push(harness.h, frame_at(2 * frame_time)), GST_FLOW_OK);
    if (stream) gst_harness_push_event(harness.h, gst_event_new_stream_start("another"));
    new_segment(harness.h, 0);
    downstream.let_go();
    fail_unless_equals_int(gst_harness_push(harness.h, frame_at(0)), GST_FLOW_OK);
    GstBuffer *out = gst_harness_pull(harness.h);
    fail_unless(out && GST_BUFFER_PTS(out) == 0);
    gst_buffer_unref(out);
    downstream.end_at(GST_CLOCK_TIME_NONE);
    expect_frames(harness);
  }
}
GST_END_TEST

GST_START_TEST(text_flows_on_unread_after_the_video) {
  for (const bool gap : {false, true}) {
    TextHarness harness;
    Downstream downstream(harness);
    downstream.hold();
    gst_harness_push(harness.h, frame_at(0));
    harness.push_line(0);
    downstream.wait_for_frame();
    // One in the queue, maybe after an event, and another that waits for room.
    if (gap) harness.text_event(gst_event_new_gap(1 * frame_time, frame_time));
    for (guint64 n = 2; n < 6; ++n) harness.push_line(n);
    harness.wait_begun(3);
    g_usleep(20000);  // see push_waiting()
    gst_harness_push_event(harness.h, gst_event_new_eos());
    downstream.let_go();
    harness.wait_text();
    fail_unless_equals_uint64(harness.thread->taken(), 5);
    fail_unless_equals_int(harness.thread->flow(), GST_FLOW_OK);
  }
}
GST_END_TEST

GST_START_TEST(an_event_in_hand_during_a_flush_is_flushed) {
  for (const GstEventType type : {GST_EVENT_GAP, GST_EVENT_SEGMENT_DONE, GST_EVENT_EOS}) {
    TextHarness harness;  // with the pad text, GStreamer's base class goes on while the video is being flushed
    harness.push_line(0);
    fail_unless_equals_int(harness.push(0 * frame_time), 0);
    std::atomic<bool> pushed = false, flushed = false;
    const std::string processing = std::string("Processing ") + gst_event_type_get_name(type) + " event";
    {
      const When in_hand("aggregator", processing.c_str(), [&] {
        while (!pushed) g_usleep(1000);
        flush(harness.h);
        flushed = true;
      });
      gst_harness_push_event(harness.h, type == GST_EVENT_GAP ? gst_event_new_gap(frame_time, frame_time)
                                        : type == GST_EVENT_EOS
                                            ? gst_event_new_eos()
                                            : gst_event_new_segment_done(GST_FORMAT_TIME, frame_time));
      pushed = true;
      while (!flushed) g_usleep(1000);
    }
    new_segment(harness.h, 0);
    harness.push_line(1);
    fail_unless_equals_int(harness.push(1 * frame_time), 1);
    while (GstEvent *event = gst_harness_try_pull_event(harness.h)) {
      fail_unless(GST_EVENT_TYPE(event) != type, "%s after the flush", gst_event_type_get_name(type));
      gst_event_unref(event);
    }
  }
}
GST_END_TEST

GST_START_TEST(downstream_is_told_that_it_cannot_pull) {
  Harness harness;
  const auto pull = [](GstPad *, GstPadProbeInfo *info, gpointer) {
    GstQuery *query = GST_PAD_PROBE_INFO_QUERY(info);
    if (GST_QUERY_TYPE(query) != GST_QUERY_SCHEDULING) return GST_PAD_PROBE_OK;
    gst_query_set_scheduling(query, GST_SCHEDULING_FLAG_SEEKABLE, 1, -1, 0);
    gst_query_add_scheduling_mode(query, GST_PAD_MODE_PULL);
    return GST_PAD_PROBE_HANDLED;
  };
  gst_pad_add_probe(harness.h->srcpad, GST_PAD_PROBE_TYPE_QUERY_UPSTREAM, pull, nullptr, nullptr);
  GstPad *src = gst_element_get_static_pad(harness.element, "src");
  GstQuery *query = gst_query_new_scheduling();
  fail_unless(!gst_pad_query(src, query) || !gst_query_has_scheduling_mode(query, GST_PAD_MODE_PULL));
  gst_query_unref(query);
  gst_object_unref(src);
}
GST_END_TEST

static Suite *csdtrackdec_flow_suite() {
  Suite *s = suite_create("csdtrackdec_flow");
  TCase *tc = tcase_create("flow");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, frames_go_on_when_downstream_wants_them_again);
  tcase_add_test(tc, an_end_of_what_came_before_does_not_end_what_comes_next);
  tcase_add_test(tc, text_flows_on_unread_after_the_video);
  tcase_add_test(tc, an_event_in_hand_during_a_flush_is_flushed);
  tcase_add_test(tc, downstream_is_told_that_it_cannot_pull);
  return s;
}

GST_CHECK_MAIN(csdtrackdec_flow)
