// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackdec live, with the pad `text`: the latency it reports, and that it holds no frame for longer. Time is
// GstTestClock's, which stands still until a test moves it.
#include <gst/check/gsttestclock.h>

#include <string>
#include <thread>

#include "csdtrackdec_harness.h"

using namespace csd_check;

namespace {

constexpr GstClockTime ms = GST_MSECOND, none = GST_CLOCK_TIME_NONE;

struct Latency {
  gboolean live;
  GstClockTime min, max;
};

/// What the LATENCY query hears from this src pad.
void answer_latency(GstPad *pad, const Latency &latency) {
  const auto answer = [](GstPad *, GstPadProbeInfo *info, gpointer data) {
    GstQuery *query = GST_PAD_PROBE_INFO_QUERY(info);
    if (GST_QUERY_TYPE(query) != GST_QUERY_LATENCY) return GST_PAD_PROBE_OK;
    const auto *its = static_cast<const Latency *>(data);
    gst_query_set_latency(query, its->live, its->min, its->max);
    return GST_PAD_PROBE_HANDLED;
  };
  gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_QUERY_UPSTREAM, answer, new Latency(latency),
                    [](gpointer data) { delete static_cast<Latency *>(data); });
}

Latency latency_of(GstElement *element, bool possible = true) {
  GstPad *pad = gst_element_get_static_pad(element, "src");
  GstQuery *query = gst_query_new_latency();
  fail_unless(gst_pad_query(pad, query) == possible);
  Latency latency{};
  gst_query_parse_latency(query, &latency.live, &latency.min, &latency.max);
  gst_query_unref(query);
  gst_object_unref(pad);
  return latency;
}

void assert_same(const Latency &found, const Latency &expected, const std::string &what) {
  fail_unless(found.live == expected.live && found.min == expected.min && found.max == expected.max,
              "%s: live %d, %" GST_TIME_FORMAT " to %" GST_TIME_FORMAT, what.c_str(), found.live,
              GST_TIME_ARGS(found.min), GST_TIME_ARGS(found.max));
}

/// The time at which the next clock wait ends.
GstClockTime next_alarm(GstTestClock *clock, const char *what) {
  GList *ids = nullptr;
  fail_unless(gst_test_clock_timed_wait_for_multiple_pending_ids(clock, 1, 20000, &ids), "nobody waits: %s", what);
  const GstClockTime time = gst_clock_id_get_time(ids->data);
  g_list_free_full(ids, gst_clock_id_unref);
  return time;
}

/// Both pads are live; a frame may be late by `latency`.
struct LiveHarness : TextHarness {
  GstTestClock *clock;

  explicit LiveHarness(GstClockTime latency = 100 * ms, const char *caps = utf8)
      : TextHarness(caps, 3600 * GST_SECOND, true) {
    gst_harness_set_upstream_latency(text, latency);
    clock = GST_TEST_CLOCK(gst_element_get_clock(element));
  }
  ~LiveHarness() { gst_object_unref(clock); }

  /// A frame that comes when captured finds no text until `due`, and then goes on without tracks.
  void assert_held_until(GstClockTime pts, GstClockTime due) {
    push_waiting(pts);
    fail_unless_equals_uint64(next_alarm(clock, "a frame for its text"), due);
    fail_unless(gst_harness_try_pull(h) == nullptr);
    fail_unless(gst_test_clock_crank(clock));
    fail_unless_equals_int(pull_number(), -1);
  }
  void assert_nobody_waits() { fail_unless_equals_int(gst_test_clock_peek_id_count(clock), 0); }
  bool latency_message() {
    GstMessage *message = gst_bus_pop_filtered(bus, GST_MESSAGE_LATENCY);
    if (message) gst_message_unref(message);
    return message != nullptr;
  }
};

}  // namespace

GST_START_TEST(the_latency_covers_both_pads) {
  const struct {
    Latency video, text, both;
  } cases[] = {
      {{TRUE, 40 * ms, none}, {TRUE, 400 * ms, none}, {TRUE, 400 * ms, none}},
      {{TRUE, 400 * ms, 900 * ms}, {TRUE, 40 * ms, 500 * ms}, {TRUE, 400 * ms, 500 * ms}},
      {{TRUE, 40 * ms, 80 * ms}, {FALSE, 0, none}, {TRUE, 40 * ms, 80 * ms}},
      {{FALSE, 0, none}, {TRUE, 400 * ms, 500 * ms}, {TRUE, 400 * ms, 500 * ms}},
      {{FALSE, 0, none}, {FALSE, 0, none}, {FALSE, 0, none}},
  };
  for (const auto &c : cases) {
    Harness harness;
    GstHarness *lines = gst_harness_new_with_element(harness.element, "text", nullptr);
    answer_latency(harness.h->srcpad, c.video);
    answer_latency(lines->srcpad, c.text);
    assert_same(latency_of(harness.element), c.both, "case " + std::to_string(&c - cases));
    gst_harness_teardown(lines);
  }
  // A queue is missing.
  Harness harness;
  GstHarness *lines = gst_harness_new_with_element(harness.element, "text", nullptr);
  answer_latency(harness.h->srcpad, {TRUE, 0, 40 * ms});
  answer_latency(lines->srcpad, {TRUE, 400 * ms, none});
  latency_of(harness.element, false);
  fail_unless(harness.said(GST_MESSAGE_WARNING) != "");
  gst_harness_teardown(lines);
}
GST_END_TEST

GST_START_TEST(the_latency_is_at_least_min_upstream_latency) {
  LiveHarness harness;
  answer_latency(harness.h->srcpad, {TRUE, 0, 500 * ms});
  g_object_set(harness.element, "min-upstream-latency", 50 * ms, nullptr);
  assert_same(latency_of(harness.element), {TRUE, 100 * ms, 500 * ms}, "less than upstream's");
  g_object_set(harness.element, "min-upstream-latency", 300 * ms, nullptr);
  assert_same(latency_of(harness.element), {TRUE, 300 * ms, 700 * ms}, "more than upstream's");
  harness.assert_held_until(0, 300 * ms);
  Harness still("", gray_64, "none", nullptr, false);
  g_object_set(still.element, "min-upstream-latency", 300 * ms, nullptr);
  fail_unless(!latency_of(still.element).live);
}
GST_END_TEST

GST_START_TEST(a_new_latency_counts_for_the_next_frame) {
  LiveHarness harness;
  harness.assert_held_until(0, 100 * ms);
  // Of another stream of text.
  gst_harness_set_upstream_latency(harness.text, 200 * ms);
  latency_of(harness.element);
  harness.assert_held_until(1 * frame_time, 1 * frame_time + 200 * ms);
  g_object_set(harness.element, "min-upstream-latency", 300 * ms, nullptr);
  latency_of(harness.element);
  harness.assert_held_until(10 * frame_time, 10 * frame_time + 300 * ms);
  // What the user adds is said at once.
  while (harness.latency_message()) continue;
  g_object_set(harness.element, "latency", 50 * ms, nullptr);
  fail_unless(harness.latency_message());
  assert_same(latency_of(harness.element), {TRUE, 350 * ms, none}, "with `latency`");
  harness.assert_held_until(20 * frame_time, 20 * frame_time + 350 * ms);
}
GST_END_TEST

/// A synchronising sink, in a pipeline where each frame's text comes 400 ms after the frame. The reported latency says
/// so.
GST_START_TEST(a_synchronising_sink_shows_frames_with_late_text) {
  constexpr guint64 count = 26, late = 400 * ms, processing = 20 * ms;  // the latter is the sink's own
  constexpr guint64 early = 10 * ms;                                    // before the latency is over
  GstElement *pipeline = gst_pipeline_new(nullptr), *element = gst_element_factory_make("csdtrackdec", nullptr),
             *sink = gst_element_factory_make("fakesink", nullptr);
  GstClock *clock = gst_test_clock_new();
  g_object_set(sink, "sync", TRUE, "async", FALSE, "max-lateness", gint64{20 * ms}, nullptr);
  gst_bin_add_many(GST_BIN(pipeline), element, sink, nullptr);
  fail_unless(gst_element_link(element, sink));
  gst_pipeline_use_clock(GST_PIPELINE(pipeline), clock);
  const auto source = [&](const char *name, const char *caps_text, const Latency &latency) {
    GstPad *theirs = gst_element_get_static_pad(element, name);
    if (!theirs) theirs = gst_element_request_pad_simple(element, name);
    GstPad *pad = gst_pad_new(name, GST_PAD_SRC);
    gst_object_ref_sink(pad);
    answer_latency(pad, latency);
    fail_unless_equals_int(gst_pad_link_full(pad, theirs, GST_PAD_LINK_CHECK_NOTHING), GST_PAD_LINK_OK);
    gst_object_unref(theirs);
    gst_pad_set_active(pad, TRUE);
    g_autoptr(GstCaps) caps = gst_caps_from_string(caps_text);
    gst_check_setup_events_with_stream_id(pad, element, caps, GST_FORMAT_TIME, name);
    return pad;
  };
  gst_element_set_state(pipeline, GST_STATE_PAUSED);
  GstPad *video = source("sink", gray_64, {TRUE, 0, none}), *text = source("text", utf8, {TRUE, late, none});
  fail_unless_equals_int(gst_element_set_state(pipeline, GST_STATE_PLAYING), GST_STATE_CHANGE_SUCCESS);

  // Each frame is finished long after the next one is captured.
  std::thread frames([&] {
    for (guint64 n = 0; n < count; ++n) gst_pad_push(video, frame_at(n * frame_time));
  });
  auto *test_clock = GST_TEST_CLOCK(clock);
  for (guint64 n = 0; n < count; ++n) {
    const GstClockTime due = n * frame_time + late;
    gst_test_clock_set_time(test_clock, due - early);
    GstBuffer *words = bytes(line(n), n * frame_time);
    GST_BUFFER_DURATION(words) = frame_time;
    fail_unless_equals_int(gst_pad_push(text, words), GST_FLOW_OK);
    // csdtrackdec waits too, until the text of this frame, and then of the next one, is due.
    for (int i = 0; next_alarm(test_clock, "the sink, until a frame is due") != due + processing; ++i) {
      fail_unless(i < 20000, "frame %" G_GUINT64_FORMAT " doesn't come to the sink", n);
      g_usleep(1000);
    }
    fail_unless(gst_test_clock_crank(test_clock));
  }
  frames.join();
  guint64 rendered = 0, dropped = 0;
  for (int i = 0; rendered + dropped < count; ++i) {  // csdtrackdec's thread still renders the last one
    fail_unless(i < 20000);
    g_usleep(1000);
    GstStructure *stats = nullptr;
    g_object_get(sink, "stats", &stats, nullptr);
    fail_unless(
        gst_structure_get(stats, "rendered", G_TYPE_UINT64, &rendered, "dropped", G_TYPE_UINT64, &dropped, nullptr));
    gst_structure_free(stats);
  }
  fail_unless_equals_uint64(rendered, count);
  fail_unless_equals_uint64(dropped, 0);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  for (GstPad *pad : {video, text}) gst_object_unref(pad);
  gst_object_unref(clock);
  gst_object_unref(pipeline);
}
GST_END_TEST

GST_START_TEST(text_that_stops_holds_no_frame_beyond_the_latency) {
  LiveHarness harness;
  for (guint64 n = 0; n < 2; ++n) harness.push_line(n);
  for (int n = 0; n < 2; ++n) fail_unless_equals_int(harness.push(n * frame_time), n);
  for (guint64 n = 2; n < 6; ++n) harness.assert_held_until(n * frame_time, n * frame_time + 100 * ms);
  assert_holds(harness.said(GST_MESSAGE_WARNING), "no text has come within 100 ms, the latency. Put a queue");
  // Late text is dropped. Then text is in time again, and frames get it while they wait.
  for (guint64 n = 2; n < 7; ++n) harness.push_line(n);
  fail_unless_equals_int(harness.push(6 * frame_time), 6);
  for (guint64 n = 7; n < 9; ++n) {
    harness.push_waiting(n * frame_time);
    fail_unless_equals_uint64(next_alarm(harness.clock, "a frame for its text"), n * frame_time + 100 * ms);
    harness.push_line(n);
    fail_unless_equals_int(harness.pull_number(), static_cast<int>(n));
    harness.assert_nobody_waits();
  }
  // A late frame takes the text that is there.
  gst_test_clock_set_time(harness.clock, GST_SECOND);
  harness.assert_held_until(9 * frame_time,
                            9 * frame_time + 100 * ms);  // long ago; GstTestClock only wants to be asked
  fail_unless_equals_uint64(gst_clock_get_time(GST_CLOCK(harness.clock)), GST_SECOND);
  harness.push_line(10);
  harness.wait_text();
  fail_unless_equals_int(harness.push(10 * frame_time), 10);
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(a_shorter_max_wait_takes_precedence) {
  // It is measured by the system's clock, and the test's stands still.
  LiveHarness harness;
  g_object_set(harness.element, "max-wait", 10 * ms, nullptr);
  fail_unless_equals_int(harness.push(0 * frame_time), -1);
  assert_holds(harness.said(GST_MESSAGE_WARNING), "no text has come within 10 ms. Put a queue");
  g_object_set(harness.element, "max-wait", 3600 * GST_SECOND, nullptr);
  gst_test_clock_set_time(harness.clock, frame_time + 95 * ms);
  harness.assert_held_until(frame_time, frame_time + 100 * ms);
  g_object_set(harness.element, "max-wait", guint64{0}, nullptr);
  fail_unless_equals_int(harness.push(20 * frame_time), -1);
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(each_pad_has_its_own_segment) {
  // The frames begin at 100 s, the text at 0, and both at a running time of 10 s.
  LiveHarness harness;
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.start = segment.position = 100 * GST_SECOND;
  segment.time = 0;
  segment.base = 10 * GST_SECOND;
  gst_harness_push_event(harness.h, gst_event_new_segment(&segment));
  harness.text_event(segment_event(0, 10 * GST_SECOND));
  harness.push_line(0);
  fail_unless_equals_int(harness.push(100 * GST_SECOND), 0);
  harness.assert_held_until(100 * GST_SECOND + frame_time, 10 * GST_SECOND + frame_time + 100 * ms);
  harness.push_line(2);
  fail_unless_equals_int(harness.push(100 * GST_SECOND + 2 * frame_time), 2);
}
GST_END_TEST

GST_START_TEST(each_pad_is_flushed_by_itself) {
  LiveHarness harness;
  {
    harness.push_waiting(0);
    next_alarm(harness.clock, "a frame for its text");
    gst_harness_push_event(harness.h, gst_event_new_flush_start());
    fail_unless_equals_int(gst_harness_push(harness.h, frame_at(0)), GST_FLOW_FLUSHING);
    // The base class waits on, for no frame.
    gst_harness_push_event(harness.h, gst_event_new_flush_stop(TRUE));
    fail_unless(gst_harness_try_pull(harness.h) == nullptr);
    new_segment(harness.h, 0);
  }
  // The lines stay for later frames. If the text is flushed, its lines go, and the frame waits on.
  harness.push_line(1);
  harness.push_line(2);
  fail_unless_equals_int(harness.push(1 * frame_time), 1);
  harness.wait_text();
  harness.flush_text();
  harness.text_event(segment_event(0));
  harness.assert_held_until(2 * frame_time, 2 * frame_time + 100 * ms);
  harness.push_waiting(3 * frame_time);
  next_alarm(harness.clock, "a frame for its text");
  harness.flush_text();
  fail_unless_equals_uint64(next_alarm(harness.clock, "the same frame"), 3 * frame_time + 100 * ms);
  harness.text_event(segment_event(0));
  harness.push_line(3);
  fail_unless_equals_int(harness.pull_number(), 3);
}
GST_END_TEST

GST_START_TEST(sparse_text_with_gaps_holds_nothing) {
  LiveHarness harness;
  for (guint64 n = 0; n < 20; ++n) {
    if (n % 5 == 0)
      harness.push_line(n);
    else
      harness.text_event(gst_event_new_gap(n * frame_time, frame_time));
    fail_unless_equals_int(harness.push(n * frame_time), n % 5 == 0 ? static_cast<int>(n) : -1);
    harness.assert_nobody_waits();
  }
  // A gap that comes while a frame waits.
  harness.push_waiting(21 * frame_time);
  next_alarm(harness.clock, "a frame for its text");
  harness.text_event(gst_event_new_gap(21 * frame_time, GST_SECOND));
  fail_unless_equals_int(harness.pull_number(), -1);
  harness.assert_nobody_waits();
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(the_latency_counts_from_the_base_time_after_a_pause) {
  LiveHarness harness;
  gst_element_set_state(harness.element, GST_STATE_PAUSED);
  gst_test_clock_set_time(harness.clock, GST_SECOND);
  // As a pipeline does it: the time in PAUSED is no running time.
  gst_element_set_base_time(harness.element, GST_SECOND);
  gst_element_set_state(harness.element, GST_STATE_PLAYING);
  harness.push_waiting(0);
  fail_unless_equals_uint64(next_alarm(harness.clock, "a frame for its text"), GST_SECOND + 100 * ms);
  harness.push_line(0);
  fail_unless_equals_int(harness.pull_number(), 0);
}
GST_END_TEST

static Suite *csdtrackdec_live_suite() {
  Suite *s = suite_create("csdtrackdec_live");
  TCase *tc = tcase_create("text");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, the_latency_covers_both_pads);
  tcase_add_test(tc, the_latency_is_at_least_min_upstream_latency);
  tcase_add_test(tc, a_new_latency_counts_for_the_next_frame);
  tcase_add_test(tc, a_synchronising_sink_shows_frames_with_late_text);
  tcase_add_test(tc, text_that_stops_holds_no_frame_beyond_the_latency);
  tcase_add_test(tc, a_shorter_max_wait_takes_precedence);
  tcase_add_test(tc, each_pad_has_its_own_segment);
  tcase_add_test(tc, each_pad_is_flushed_by_itself);
  tcase_add_test(tc, sparse_text_with_gaps_holds_nothing);
  tcase_add_test(tc, the_latency_counts_from_the_base_time_after_a_pause);
  return s;
}

GST_CHECK_MAIN(csdtrackdec_live)
