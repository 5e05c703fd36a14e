// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack while others talk to it: properties, signals, stats and states from two threads as frames flow. What is
// asserted is little: the tsan set-up looks on.
#include <atomic>
#include <chrono>
#include <thread>

#include "csdtrack_harness.h"

namespace {

guint64 stat(GstElement *track, const char *name) {
  GstStructure *stats = nullptr;
  guint64 value = 0;
  g_object_get(track, "stats", &stats, nullptr);
  fail_unless(gst_structure_get_uint64(stats, name, &value));
  gst_structure_free(stats);
  return value;
}

/// Everything that may be done to a running csdtrack from outside, once.
void talk(GstElement *track, unsigned round, bool reset) {
  guint id = 0;
  g_signal_emit_by_name(track, "add-point", 40. + round % 200, 60. + round % 100, &id);
  g_object_set(track, "post-messages", round % 3, "message-interval", static_cast<guint64>(round % 2 * 50000000),
               "overlay", round % 3, "attach-roi", round % 2, "attach-meta", round % 2, nullptr);
  gchar *points = nullptr;
  g_object_get(track, "points", &points, nullptr);
  g_free(points);
  stat(track, "frames");
  gboolean removed = FALSE;
  if (id != G_MAXUINT) g_signal_emit_by_name(track, "remove-point", id, &removed);
  if (reset && round % 16 == 15) g_signal_emit_by_name(track, "reset");
}

/// Until `learned` features have been learnt; then for a hundred rounds more, in which it is reset, too.
void frames_flow_while_two_threads_talk(const char *launch, guint64 learned) {
  GstHarness *h = harness(launch);
  GstBus *bus = gst_bus_new();
  GstElement *track = gst_harness_find_element(h, "csdtrack");
  gst_element_set_bus(track, bus);
  std::atomic<bool> over{false};
  std::atomic<bool> reset{false};
  std::atomic<unsigned> rounds{0};
  auto busy = [&] {
    while (!over.load(std::memory_order_relaxed)) {
      talk(track, rounds.fetch_add(1, std::memory_order_relaxed), reset.load(std::memory_order_relaxed));
      while (GstMessage *message = gst_bus_pop(bus)) gst_message_unref(message);
      std::this_thread::sleep_for(std::chrono::microseconds(500));  // else the frames hardly get a turn
    }
  };
  std::thread one(busy), other(busy);
  guint64 frames = 0;
  unsigned end = 100;
  for (int i = 0; !reset || rounds.load(std::memory_order_relaxed) < end; ++i, ++frames) {
    if (!reset && stat(track, "learned") >= learned) {
      reset = true;
      end = rounds + 100;
    }
    GstBuffer *out = gst_harness_push_and_pull(h, picture(320, 240, i));
    fail_unless(out != nullptr);
    gst_buffer_unref(out);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // learners have the lower priority
  }
  over = true;
  one.join();
  other.join();
  fail_unless_equals_uint64(stat(track, "frames"), frames);
  gst_element_set_bus(track, nullptr);
  gst_object_unref(bus);
  gst_object_unref(track);
  gst_harness_teardown(h);
}

}  // namespace

GST_START_TEST(lk_is_talked_to) {
  frames_flow_while_two_threads_talk("csdtrack algorithm=lk", 0);
}
GST_END_TEST

GST_START_TEST(csd_2012_is_talked_to_as_it_learns) {
  frames_flow_while_two_threads_talk("csdtrack algorithm=csd-2012 max-features=6 n-threads=2 training-time=200000000",
                                     4);
}
GST_END_TEST

GST_START_TEST(states_change_while_another_thread_talks) {
  GstElement *pipeline = gst_parse_launch(
      "videotestsrc pattern=ball ! video/x-raw,format=GRAY8,width=320,height=240 ! csdtrack name=t max-features=4 ! "
      "fakesink",
      nullptr);
  GstElement *track = gst_bin_get_by_name(GST_BIN(pipeline), "t");
  std::atomic<bool> over{false};
  std::thread talker([&] {
    for (unsigned round = 0; !over.load(std::memory_order_relaxed); ++round) {
      talk(track, round, true);
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  });
  const GstState states[] = {GST_STATE_PLAYING, GST_STATE_READY, GST_STATE_PAUSED, GST_STATE_PLAYING, GST_STATE_NULL};
  for (int turn = 0; turn < 4; ++turn)
    for (const GstState state : states) {
      fail_unless(gst_element_set_state(pipeline, state) != GST_STATE_CHANGE_FAILURE);
      fail_unless(gst_element_get_state(pipeline, nullptr, nullptr, 20 * GST_SECOND) != GST_STATE_CHANGE_FAILURE);
    }
  over = true;
  talker.join();
  gst_object_unref(track);
  gst_object_unref(pipeline);
}
GST_END_TEST

static Suite *csdtrack_threads_suite() {
  Suite *suite = suite_create("csdtrack_threads");
  TCase *tc = tcase_create("threads");
  tcase_set_timeout(tc, 240);
  suite_add_tcase(suite, tc);
  tcase_add_test(tc, lk_is_talked_to);
  tcase_add_test(tc, csd_2012_is_talked_to_as_it_learns);
  tcase_add_test(tc, states_change_while_another_thread_talks);
  return suite;
}

GST_CHECK_MAIN(csdtrack_threads)
