// SPDX-License-Identifier: LGPL-2.1-or-later
//
// Which line of a file a frame gets, by its time and duration.
#include "csdtrackdec_harness.h"

using namespace csd_check;

GST_START_TEST(a_frame_gets_the_nearest_line_within_half_a_frame) {
  // At 0, 40, 80, 200 and 200 ms.
  const std::string path =
      write_file("near.jsonl", lines(0, 3) + line(3, 200 * GST_MSECOND) + "\n" + line(4, 200 * GST_MSECOND) + "\n");
  const struct {
    const char *what;
    std::vector<unsigned> ms;
    GstClockTime duration;
    std::string numbers;
  } cases[] = {
      {"as recorded", {0, 40, 80, 120, 160, 200}, frame_time, "0 1 2 . . 3 "},
      {"two frames of one time", {80, 200, 200, 200}, frame_time, "2 3 4 . "},
      {"rounded and jittering", {1, 39, 85, 119}, frame_time, "0 1 2 . "},
      {"half a frame late, and more", {20, 61, 101}, frame_time, "0 2 . "},
      {"half a frame early, and more", {180, 181}, frame_time, "3 4 "},
      {"twice the rate", {0, 20, 40, 60, 80}, frame_time / 2, "0 . 1 . 2 "},
      {"half the rate", {0, 80}, 2 * frame_time, "0 2 "},
      {"backwards", {200, 80, 40, 0}, frame_time, "3 2 1 0 "},
  };
  for (const auto &c : cases) {
    Harness harness(path);
    std::string numbers;
    for (const unsigned ms : c.ms) {
      const int number = harness.push(frame_at(ms * GST_MSECOND, c.duration));
      numbers += (number < 0 ? "." : std::to_string(number)) + " ";
    }
    fail_unless(numbers == c.numbers, "%s: %s", c.what, numbers.c_str());
  }
}
GST_END_TEST

GST_START_TEST(a_frame_without_a_duration_lasts_as_the_caps_say) {
  const std::string path = write_file("rate.jsonl", lines(0, 1));
  const struct {
    const char *framerate;
    unsigned ms;
    int number;
  } cases[] = {{"10/1", 50, 0}, {"10/1", 51, -1}, {"0/1", 2, 0}, {"0/1", 3, -1}};  // 0/1: times may be rounded
  for (const auto &c : cases) {
    Harness harness(path,
                    (std::string("video/x-raw,format=GRAY8,width=64,height=48,framerate=") + c.framerate).c_str());
    fail_unless_equals_int(harness.push(frame_at(c.ms * GST_MSECOND, GST_CLOCK_TIME_NONE)), c.number);
  }
}
GST_END_TEST

GST_START_TEST(without_duration_and_framerate_no_frame_gets_its_neighbours_line) {
  constexpr char no_rate[] = "video/x-raw,format=GRAY8,width=64,height=48,framerate=0/1";
  const auto time = [](guint64 n) { return gst_util_uint64_scale(n, GST_SECOND, 60); };
  const auto line_at = [&](guint64 n) { return line(n, time(n)) + "\n"; };
  std::string one_lost, every_second, late;
  for (guint64 n = 0; n < 20; ++n) {
    if (n != 5) one_lost += line_at(n);
    if (n % 2 == 0) every_second += line_at(n);
    late += line(n, time(n) + 4 * GST_MSECOND) + "\n";
  }
  for (const bool frame_dropped : {false, true}) {
    Harness lost(write_file("lost.jsonl", one_lost), no_rate), half(write_file("half.jsonl", every_second), no_rate),
        behind(write_file("behind.jsonl", late), no_rate);
    for (int n = 0; n < 20; ++n) {
      if (frame_dropped && n == 4) continue;  // the next frame doesn't last for two
      const auto frame = [&] { return frame_at(time(static_cast<guint64>(n)), GST_CLOCK_TIME_NONE); };
      fail_unless_equals_int(lost.push(frame()), n == 5 ? -1 : n);
      fail_unless_equals_int(half.push(frame()), n % 2 == 0 ? n : -1);
      fail_unless_equals_int(behind.push(frame()), n > 0 ? n : -1);
    }
  }
  TextHarness harness;
  gst_harness_set_src_caps_str(harness.h, no_rate);
  for (guint64 n = 0; n < 20; ++n)
    if (n != 5) harness.push_line(line(n), time(n));
  harness.end();
  for (int n = 0; n < 20; ++n) {
    GstBuffer *in = frame_at(time(static_cast<guint64>(n)), GST_CLOCK_TIME_NONE);
    fail_unless_equals_int(harness.push(in), n == 5 ? -1 : n);
  }
}
GST_END_TEST

GST_START_TEST(lines_match_by_stream_time) {
  Harness harness(write_file("stream.jsonl", lines(0, 200)));
  // Timestamps begin at 100 s, at a stream time of 4 s.
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.start = 100 * GST_SECOND;
  segment.time = 4 * GST_SECOND;
  gst_harness_push_event(harness.h, gst_event_new_segment(&segment));
  fail_unless_equals_int(harness.push(100 * GST_SECOND), 100);
  fail_unless_equals_int(harness.push(101 * GST_SECOND), 125);
  fail_unless_equals_int(harness.push(GST_CLOCK_TIME_NONE), -1);
}
GST_END_TEST

GST_START_TEST(ts_offset_is_added_to_the_time_of_the_lines) {
  Harness harness(write_file("offset.jsonl", lines(100, 110)));  // from 4 s on
  fail_unless_equals_int(harness.push(0 * frame_time), -1);
  g_object_set(harness.element, "ts-offset", -4 * static_cast<gint64>(GST_SECOND), nullptr);
  for (int n = 1; n < 5; ++n) fail_unless_equals_int(harness.push(n * frame_time), 100 + n);
  g_object_set(harness.element, "ts-offset", 4 * static_cast<gint64>(GST_SECOND), nullptr);
  fail_unless_equals_int(harness.push(207 * frame_time), 107);
}
GST_END_TEST

GST_START_TEST(a_frame_cut_by_a_seek_is_matched_by_its_end) {
  const std::string path = write_file("cut.jsonl", lines(0, 200));
  for (const GstClockTime cut : {5 * GST_MSECOND, 35 * GST_MSECOND}) {
    const GstClockTime start = 100 * frame_time + cut;
    Harness harness(path);
    new_segment(harness.h, start);
    fail_unless_equals_int(harness.push(frame_at(start, frame_time - cut)), 100);
    fail_unless_equals_int(harness.push(101 * frame_time), 101);
  }
}
GST_END_TEST

GST_START_TEST(a_short_frame_at_the_segments_start_has_its_own_line) {
  // Frames of 20 ms although the caps say 40 ms: as if the first one were cut.
  std::string content;
  for (guint64 n = 0; n < 9; ++n) content += line(n, n * 20 * GST_MSECOND) + "\n";
  Harness harness(write_file("short.jsonl", content));
  new_segment(harness.h, 100 * GST_MSECOND);
  for (guint64 n = 5; n < 9; ++n)
    fail_unless_equals_int(harness.push(frame_at(n * 20 * GST_MSECOND, 20 * GST_MSECOND)), static_cast<int>(n));
}
GST_END_TEST

static Suite *csdtrackdec_match_suite() {
  Suite *s = suite_create("csdtrackdec_match");
  TCase *tc = tcase_create("match");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, a_frame_gets_the_nearest_line_within_half_a_frame);
  tcase_add_test(tc, a_frame_without_a_duration_lasts_as_the_caps_say);
  tcase_add_test(tc, without_duration_and_framerate_no_frame_gets_its_neighbours_line);
  tcase_add_test(tc, lines_match_by_stream_time);
  tcase_add_test(tc, ts_offset_is_added_to_the_time_of_the_lines);
  tcase_add_test(tc, a_frame_cut_by_a_seek_is_matched_by_its_end);
  tcase_add_test(tc, a_short_frame_at_the_segments_start_has_its_own_line);
  return s;
}

GST_CHECK_MAIN(csdtrackdec_match)
