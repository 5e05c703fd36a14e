// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack during access from other threads: properties, signals, stats and states from two to four threads while
// frames flow. Asserts little: the tsan set-up watches.
//
// CSDTRACK_OPERATIONS=N: the number of operations of four threads at full speed (2000).
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

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

/// Does everything once that can be done to a running csdtrack from outside.
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

using Clock = std::chrono::steady_clock;

/// Sleeps three times as long as the turn that began at `start`. Learners have a lower priority than the three threads
/// that take turns. With a fixed sleep, under TSan and on one processor, learners got no time: no feature was ever
/// learnt, and the test ran into its timeout. It sleeps half a millisecond at least, or frames would hardly get a turn.
void leave_time_to_learners(Clock::time_point start) {
  std::this_thread::sleep_for(std::max<Clock::duration>(std::chrono::microseconds(500), 3 * (Clock::now() - start)));
}

/// Until `learned` features have been learnt. Then a hundred rounds more, which include resets.
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
      const Clock::time_point start = Clock::now();
      talk(track, rounds.fetch_add(1, std::memory_order_relaxed), reset.load(std::memory_order_relaxed));
      while (GstMessage *message = gst_bus_pop(bus)) gst_message_unref(message);
      leave_time_to_learners(start);
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
    const Clock::time_point start = Clock::now();
    GstBuffer *out = gst_harness_push_and_pull(h, picture(320, 240, i));
    fail_unless(out != nullptr);
    gst_buffer_unref(out);
    leave_time_to_learners(start);
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

GST_START_TEST(lk_with_access_from_other_threads) {
  frames_flow_while_two_threads_talk("csdtrack algorithm=lk", 0);
}
GST_END_TEST

GST_START_TEST(csd_2012_with_access_while_it_learns) {
  frames_flow_while_two_threads_talk("csdtrack algorithm=csd-2012 max-features=6 n-threads=2 training-time=200000000",
                                     4);
}
GST_END_TEST

GST_START_TEST(states_change_while_another_thread_accesses_it) {
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
      fail_unless(gst_element_get_state(pipeline, nullptr, nullptr, GST_CLOCK_TIME_NONE) != GST_STATE_CHANGE_FAILURE);
    }
  over = true;
  talker.join();
  gst_object_unref(track);
  gst_object_unref(pipeline);
}
GST_END_TEST

namespace {

/// A pipeline from a test picture to a fakesink, with `track` in it.
GstElement *pipeline_of(const std::string &track, int buffers = -1) {
  const std::string launch = "videotestsrc pattern=ball num-buffers=" + std::to_string(buffers) +
                             " ! video/x-raw,format=GRAY8,width=160,height=120 ! " + track + " ! fakesink";
  GstElement *pipeline = gst_parse_launch(launch.c_str(), nullptr);
  fail_unless(pipeline != nullptr);
  return pipeline;
}

void settle(GstElement *pipeline) {
  fail_unless(gst_element_get_state(pipeline, nullptr, nullptr, GST_CLOCK_TIME_NONE) == GST_STATE_CHANGE_SUCCESS);
}

void change_state(GstElement *pipeline, unsigned round) {
  constexpr GstState states[] = {GST_STATE_PLAYING, GST_STATE_PAUSED, GST_STATE_PLAYING, GST_STATE_READY,
                                 GST_STATE_PLAYING, GST_STATE_NULL,   GST_STATE_PLAYING};
  const GstState wanted = states[round % std::size(states)];
  fail_unless(gst_element_set_state(pipeline, wanted) != GST_STATE_CHANGE_FAILURE);
  settle(pipeline);
  if (wanted != GST_STATE_PLAYING) return;
  gst_element_seek_simple(pipeline, GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH, static_cast<gint64>(round % 9 * GST_SECOND));
  // If a pipeline stops before a seek's segment has finished, its source may post an error; identity's does.
  settle(pipeline);
}

void no_error(GstMessage *message) {
  if (GST_MESSAGE_TYPE(message) != GST_MESSAGE_ERROR) return;
  GError *error = nullptr;
  gchar *detail = nullptr;
  gst_message_parse_error(message, &error, &detail);
  fail("%s: %s (%s)", GST_MESSAGE_SRC_NAME(message), error->message, detail);
}

void set_properties(GstElement *track, unsigned round) {
  g_object_set(track, "post-messages", round % 3, "message-interval", static_cast<guint64>(round % 2 * 50000000),
               "overlay", round % 3, "attach-roi", round % 2, "attach-meta", round % 2, "navigation", round % 2,
               nullptr);
}

void read_properties(GstElement *track) {
  guint n = 0;
  GParamSpec **specs = g_object_class_list_properties(G_OBJECT_GET_CLASS(track), &n);
  for (guint i = 0; i < n; ++i) {
    if (!(specs[i]->flags & G_PARAM_READABLE)) continue;
    GValue value = G_VALUE_INIT;
    g_value_init(&value, specs[i]->value_type);
    g_object_get_property(G_OBJECT(track), specs[i]->name, &value);
    g_value_unset(&value);
  }
  g_free(specs);
}

void emit_signals(GstElement *track, unsigned round) {
  guint id = 0;
  g_signal_emit_by_name(track, "add-point", 10. + round % 140, 10. + round % 100, &id);
  if (round % 3) g_signal_emit_by_name(track, "remove-point", id);
  if (round % 50 == 49) g_signal_emit_by_name(track, "reset");
}

}  // namespace

GST_START_TEST(four_threads_at_full_speed) {
  constexpr const char *algorithms[] = {"csd", "csd-2012", "csd-forest", "lk"};
  const char *wanted = g_getenv("CSDTRACK_OPERATIONS");
  const unsigned operations = wanted ? static_cast<unsigned>(std::atol(wanted)) : 2000;
  GstElement *pipeline =
      pipeline_of(std::string("csdtrack name=t max-features=6 n-threads=2 algorithm=") + algorithms[__i__]);
  GstElement *track = gst_bin_get_by_name(GST_BIN(pipeline), "t");
  GstBus *bus = gst_element_get_bus(pipeline);
  const unsigned changes = std::max(14u, operations / 500);  // of state, each of which takes long
  std::atomic<unsigned> done = 0, states = 0;
  const auto until_done = [&](auto &&act) {
    return std::thread([&, act] {
      for (unsigned round = 0; done < operations || states < changes; ++round, ++done) act(round);
    });
  };
  std::vector<std::thread> threads;
  threads.push_back(until_done([&](unsigned round) { set_properties(track, round); }));
  threads.push_back(until_done([&](unsigned round) { emit_signals(track, round); }));
  threads.push_back(until_done([&](unsigned) { read_properties(track); }));
  threads.push_back(until_done([&](unsigned round) {
    change_state(pipeline, round);
    ++states;
    while (GstMessage *message = gst_bus_pop(bus)) {
      no_error(message);
      gst_message_unref(message);
    }
  }));
  for (auto &thread : threads) thread.join();
  g_print("%s: %u operations, %u of them changes of state\n", algorithms[__i__], done.load(), states.load());
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(bus);
  gst_object_unref(track);
  gst_object_unref(pipeline);
}
GST_END_TEST

/// Plays to the end of the stream; no frame may be missing.
static void plays_to_its_end(GstElement *pipeline, int elements, guint64 frames) {
  fail_unless(gst_element_set_state(pipeline, GST_STATE_PLAYING) != GST_STATE_CHANGE_FAILURE);
  GstBus *bus = gst_element_get_bus(pipeline);
  GstMessage *end = gst_bus_timed_pop_filtered(bus, GST_CLOCK_TIME_NONE,
                                               static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
  fail_unless(GST_MESSAGE_TYPE(end) == GST_MESSAGE_EOS);
  gst_message_unref(end);
  gst_object_unref(bus);
  for (int i = 0; i < elements; ++i) {
    GstElement *track = gst_bin_get_by_name(GST_BIN(pipeline), ("t" + std::to_string(i)).c_str());
    fail_unless_equals_uint64(stat(track, "frames"), frames);
    gst_object_unref(track);
  }
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(pipeline);
}

GST_START_TEST(eight_elements_in_a_process) {
  constexpr const char *algorithms[] = {"csd", "csd-2012", "lk", "csd-forest"};
  std::string branches = "tee name=s";
  for (int i = 0; i < 8; ++i)
    branches += std::string(i ? " ! fakesink s." : "") + " ! queue ! csdtrack max-features=5 n-threads=2 name=t" +
                std::to_string(i) + " algorithm=" + algorithms[i % 4];
  plays_to_its_end(pipeline_of(branches, 20), 8, 20);
}
GST_END_TEST

GST_START_TEST(any_number_of_threads) {
  for (const char *algorithm : {"csd", "csd-2012"})
    plays_to_its_end(
        pipeline_of("csdtrack name=t0 max-features=20 n-threads=" + std::to_string(__i__) + " algorithm=" + algorithm,
                    12),
        1, 12);
}
GST_END_TEST

static Suite *csdtrack_threads_suite() {
  Suite *suite = suite_create("csdtrack_threads");
  TCase *tc = tcase_create("threads");
  tcase_set_timeout(tc, 0);  // meson's applies
  suite_add_tcase(suite, tc);
  tcase_add_test(tc, lk_with_access_from_other_threads);
  tcase_add_test(tc, csd_2012_with_access_while_it_learns);
  tcase_add_test(tc, states_change_while_another_thread_accesses_it);
  tcase_add_loop_test(tc, four_threads_at_full_speed, 0, 4);
  tcase_add_test(tc, eight_elements_in_a_process);
  tcase_add_loop_test(tc, any_number_of_threads, 1, 17);
  return suite;
}

GST_CHECK_MAIN(csdtrack_threads)
