// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackdec's pad `text`: requested, linked and released while another thread changes the element's state. The tests
// hook GStreamer's log messages to act between two of its steps.
#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "csdtrackdec_harness.h"

using namespace csd_check;

namespace {

/// The text's source: a pad that sends lines as a demuxer does.
class Source {
 public:
  explicit Source(const char *form = "text/x-raw,format=utf8", GstFormat unit = GST_FORMAT_TIME) {
    gst_pad_set_active(pad_, TRUE);
    announce(form, unit);
  }
  void announce(const char *form = "text/x-raw,format=utf8", GstFormat unit = GST_FORMAT_TIME) {
    gst_pad_push_event(pad_, gst_event_new_stream_start("text"));
    g_autoptr(GstCaps) caps = gst_caps_from_string(form);
    gst_pad_push_event(pad_, gst_event_new_caps(caps));
    GstSegment segment;
    gst_segment_init(&segment, unit);
    gst_pad_push_event(pad_, gst_event_new_segment(&segment));
  }
  ~Source() {
    gst_pad_set_active(pad_, FALSE);
    gst_object_unref(pad_);
  }
  Source(const Source &) = delete;
  Source &operator=(const Source &) = delete;

  void link(GstPad *text) { fail_unless(gst_pad_link(pad_, text) == GST_PAD_LINK_OK); }
  GstFlowReturn push(const std::string &line, GstClockTime pts) { return gst_pad_push(pad_, bytes(line, pts)); }
  GstFlowReturn push(guint64 n) { return push(line(n), n * frame_time); }

 private:
  GstPad *pad_ = GST_PAD(gst_object_ref_sink(gst_pad_new("src", GST_PAD_SRC)));
};

GstPad *request(GstElement *element) {
  GstPad *pad = gst_element_request_pad_simple(element, "text");
  fail_unless(pad != nullptr);
  return pad;
}

void release(GstElement *element, GstPad *pad) {
  gst_element_release_request_pad(element, pad);
  gst_object_unref(pad);
}

void change_state(GstElement *element, GstState state) {
  fail_unless(gst_element_set_state(element, state) == GST_STATE_CHANGE_SUCCESS);
}

/// csdtrackdec with a text pad linked while it starts, in one way or another. Expects its lines on its frames.
void expect_lines(GstElement *element, Source &source) {
  g_object_set(element, "max-wait", 3600 * GST_SECOND, nullptr);
  GstHarness *h = new_side(element, false, "sink", "src");
  gst_harness_set_src_caps_str(h, gray_64);
  std::thread streams([&] {
    for (guint64 n = 0; n < 3; ++n) fail_unless_equals_int(source.push(n), GST_FLOW_OK);
  });
  for (guint64 n = 0; n < 3; ++n) {
    GstBuffer *out = gst_harness_push_and_pull(h, frame_at(n * frame_time));
    fail_unless_equals_int(number_on(out), static_cast<int>(n));
    gst_buffer_unref(out);
  }
  streams.join();
  gst_harness_teardown(h);
}

GstElement *ready() {
  GstElement *element = gst_element_factory_make("csdtrackdec", nullptr);
  g_object_set(element, "max-wait", GST_MSECOND, nullptr);
  change_state(element, GST_STATE_READY);
  return element;
}

}  // namespace

GST_START_TEST(the_element_starts_while_the_pad_is_added) {
  GstElement *element = ready();
  GstPad *text = nullptr;
  {
    const When adds("GST_ELEMENT_PADS", "adding pad 'text'", [&] { change_state(element, GST_STATE_PAUSED); });
    text = request(element);
  }
  fail_unless(gst_pad_is_active(text));
  Source source;
  source.link(text);
  expect_lines(element, source);
  change_state(element, GST_STATE_NULL);
  release(element, text);
  gst_object_unref(element);
}
GST_END_TEST

GST_START_TEST(text_comes_before_the_element_has_started) {
  GstElement *element = ready();
  GstPad *text = nullptr;
  Source source;
  {
    // The line stays in the pad's queue.
    const When starts("GST_ELEMENT_PADS", "activate pads", [&] {
      text = request(element);
      source.link(text);
      fail_unless_equals_int(source.push(0), GST_FLOW_OK);
    });
    change_state(element, GST_STATE_PAUSED);
  }
  expect_lines(element, source);
  change_state(element, GST_STATE_NULL);
  release(element, text);
  gst_object_unref(element);
}
GST_END_TEST

GST_START_TEST(a_link_before_the_start_is_forgotten) {
  GstElement *element = ready();
  GstPad *text = request(element);
  {
    Source source;
    source.link(text);  // and unlinked
  }
  Harness harness("", gray_64, "none", element);
  harness.push(frame_at(0));
  assert_holds(harness.said(GST_MESSAGE_WARNING), "There are no tracks to put on the frames");
  change_state(element, GST_STATE_NULL);
  release(element, text);
}
GST_END_TEST

GST_START_TEST(no_pad_is_added_while_the_video_is_being_flushed) {
  Harness harness;
  harness.push(frame_at(0));
  gst_harness_push_event(harness.h, gst_event_new_flush_start());
  GstPad *text = gst_element_request_pad_simple(harness.element, "text");
  gst_harness_push_event(harness.h, gst_event_new_flush_stop(TRUE));
  new_segment(harness.h, 0);
  fail_unless_equals_int(harness.push(frame_at(0)), -1);
  fail_unless(text == nullptr);
  release(harness.element, request(harness.element));
}
GST_END_TEST

namespace {

struct Held {
  std::atomic<bool> inside = false, stopped = false, stopped_inside = false;
};

/// Holds the element's thread while it posts the text's error, for 300 ms or until the element has stopped.
GstBusSyncReply hold(GstBus *, GstMessage *message, gpointer data) {
  auto &held = *static_cast<Held *>(data);
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
    held.inside = true;
    for (int i = 0; i < 300 && !held.stopped; ++i) g_usleep(1000);
    held.stopped_inside = held.stopped.load();
  }
  gst_message_unref(message);
  return GST_BUS_DROP;
}

}  // namespace

GST_START_TEST(the_element_stops_after_reading_the_text_of_a_released_pad) {
  Held held;
  GstElement *element = ready();
  GstBus *bus = gst_bus_new();
  gst_bus_set_sync_handler(bus, hold, &held, nullptr);
  gst_element_set_bus(element, bus);
  GstHarness *h = new_side(element, false, "sink", "src");
  gst_harness_set_src_caps_str(h, gray_64);
  Source source;
  GstPad *text = request(element);
  source.link(text);
  source.push("no line", 0);
  gst_harness_push(h, frame_at(0));
  while (!held.inside) g_usleep(1000);
  std::thread releases([&] { release(element, GST_PAD(gst_object_ref(text))); });
  while (GST_OBJECT_PARENT(text)) g_usleep(1000);  // the pad is removed
  change_state(element, GST_STATE_READY);
  held.stopped = true;
  releases.join();
  fail_unless(!held.stopped_inside, "it stopped while reading a line");
  gst_object_unref(text);
  gst_harness_teardown(h);
  change_state(element, GST_STATE_NULL);
  gst_element_set_bus(element, nullptr);
  gst_object_unref(bus);
  gst_object_unref(element);
}
GST_END_TEST

GST_START_TEST(pads_come_and_go_during_state_changes) {
  GstElement *element = ready();
  Source source;
  std::atomic<bool> over = false;
  // A pad that stops forgets the stream's events, and another one has none: a source that went on without them would be
  // at fault.
  std::mutex starts;
  // GstAggregator leaves it to the application that no pad is added while the element starts or stops.
  std::mutex requests;
  std::thread streams([&] {
    while (!over) {
      {
        const std::lock_guard lock(starts);
        source.announce();
        source.push("\n", 0);
      }
      g_usleep(100);
    }
  });
  std::thread pads([&] {
    while (!over) {
      GstPad *text = nullptr;
      {
        const std::scoped_lock lock(starts, requests);
        text = request(element);
        source.link(text);
      }
      g_usleep(200);
      release(element, text);
    }
  });
  for (int i = 0; i < 150; ++i) {
    {
      const std::scoped_lock lock(starts, requests);
      change_state(element, GST_STATE_PAUSED);
    }
    g_usleep(300);
    const std::lock_guard lock(requests);
    change_state(element, GST_STATE_READY);
  }
  over = true;
  streams.join();
  pads.join();
  change_state(element, GST_STATE_NULL);
  gst_object_unref(element);
}
GST_END_TEST

GST_START_TEST(frames_pass_a_text_that_is_being_flushed) {
  for (const bool unlinked : {false, true})
    for (const bool waiting : {false, true}) {
      // Either max-wait is over, or the text is unlinked; before the flush has ended.
      TextHarness harness(utf8, unlinked ? 3600 * GST_SECOND : 20 * GST_MSECOND);
      if (waiting) fail_unless_equals_int(gst_harness_push(harness.h, frame_at(0)), GST_FLOW_OK);
      gst_harness_push_event(harness.text, gst_event_new_flush_start());
      GstPad *pad = gst_element_get_static_pad(harness.element, "text");
      if (unlinked) fail_unless(gst_pad_unlink(harness.text->srcpad, pad));
      if (!waiting) fail_unless_equals_int(gst_harness_push(harness.h, frame_at(0)), GST_FLOW_OK);
      fail_unless_equals_int(harness.pull_number(), -1);
      fail_unless_equals_int(harness.push(frame_time), -1);
      const std::string warning = harness.said(GST_MESSAGE_WARNING);
      if (!unlinked) assert_holds(warning, "no text has come within 20 ms");
      // The flush ends.
      g_object_set(harness.element, "max-wait", 3600 * GST_SECOND, nullptr);
      if (unlinked) fail_unless_equals_int(gst_pad_link(harness.text->srcpad, pad), GST_PAD_LINK_OK);
      gst_harness_push_event(harness.text, gst_event_new_flush_stop(TRUE));
      harness.text_event(segment_event(0));
      harness.push_line(2);
      harness.wait_text();  // frames don't wait until text is in time again
      fail_unless_equals_int(harness.push(2 * frame_time), 2);
      harness.push_waiting(3 * frame_time);
      harness.push_line(3);
      fail_unless_equals_int(harness.pull_number(), 3);
      gst_object_unref(pad);
    }
}
GST_END_TEST

static Suite *csdtrackdec_pads_suite() {
  Suite *s = suite_create("csdtrackdec_pads");
  TCase *tc = tcase_create("pads");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, the_element_starts_while_the_pad_is_added);
  tcase_add_test(tc, no_pad_is_added_while_the_video_is_being_flushed);
  tcase_add_test(tc, a_link_before_the_start_is_forgotten);
  tcase_add_test(tc, text_comes_before_the_element_has_started);
  tcase_add_test(tc, the_element_stops_after_reading_the_text_of_a_released_pad);
  tcase_add_test(tc, pads_come_and_go_during_state_changes);
  tcase_add_test(tc, frames_pass_a_text_that_is_being_flushed);
  return s;
}

GST_CHECK_MAIN(csdtrackdec_pads)
