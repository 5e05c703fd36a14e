// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackdec with lines on its pad `text`: which frame waits for what, and that none waits for ever.
#include "csdtrackdec_harness.h"

using namespace csd_check;

GST_START_TEST(lines_are_read_in_every_form) {
  const std::string plain = lines(0, 3);
  std::string escaped;
  for (const char c : line(1)) escaped += c == '"' ? std::string("&quot;") : std::string(1, c);
  std::string named = line(2);
  named.replace(named.find("csdtrack0"), 9, "a&amp;quot;&lt;b&gt;&apos;&#39;&#x26;&unknown;&");
  {  // A byte stream cut at any place; its last line is torn.
    TextHarness harness(ndjson);
    const std::string all = plain + line(3);
    for (std::size_t at = 0; at < all.size(); at += 7) harness.push_text(all.substr(at, 7));
    harness.end();
    for (int n = 0; n < 4; ++n) fail_unless_equals_int(harness.push(n * frame_time), n < 3 ? n : -1);
  }
  {  // All lines in one buffer.
    TextHarness harness(ndjson);
    harness.push_text(plain, 0);
    harness.end();
    for (int n = 0; n < 3; ++n) fail_unless_equals_int(harness.push(n * frame_time), n);
  }
  {
    TextHarness harness(markup);
    harness.push_line(escaped + std::string(1, '\0'), 1 * frame_time);
    harness.push_line(named, 2 * frame_time);
    fail_unless_equals_int(harness.push(1 * frame_time), 1);
    GstBuffer *out = gst_harness_push_and_pull(harness.h, frame_at(2 * frame_time));
    GstCsdHeader header;
    gst_csd_structure_get_header(gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, nullptr), &header);
    fail_unless_equals_string(header.source, "a&quot;<b>''&&unknown;&");
    gst_buffer_unref(out);
  }
}
GST_END_TEST

GST_START_TEST(the_buffers_time_takes_precedence_over_the_lines) {
  // A part of a recording that restarts at 0: its lines hold times of the whole recording.
  for (const char *caps : {utf8, ndjson}) {
    TextHarness harness(caps);
    for (guint64 n = 0; n < 5; ++n) harness.push_line(line(n, 100 * GST_SECOND) + "\n", n * frame_time);
    for (int n = 0; n < 5; ++n) fail_unless_equals_int(harness.push(n * frame_time), n);
  }
}
GST_END_TEST

GST_START_TEST(a_frame_waits_for_its_line_a_later_one_a_gap_or_the_end) {
  const struct {
    const char *what;
    void (*come)(TextHarness &);
    int number;
  } cases[] = {
      {"its line", [](TextHarness &h) { h.push_line(2); }, 2},
      {"its line, slightly early, then a later one",
       [](TextHarness &h) {
         h.push_line(line(2), 2 * frame_time - 5 * GST_MSECOND);
         h.push_line(3);
       },
       2},
      {"older ones, then a later one",
       [](TextHarness &h) {
         h.push_line(0);
         h.push_line(1);
         h.push_line(5);
       },
       -1},
      {"a gap", [](TextHarness &h) { h.text_event(gst_event_new_gap(0, GST_SECOND)); }, -1},
      {"the end", [](TextHarness &h) { h.end(); }, -1},
      {"the pad is unlinked",
       [](TextHarness &h) {
         GstPad *pad = gst_element_get_static_pad(h.element, "text");
         gst_pad_unlink(h.text->srcpad, pad);
         gst_object_unref(pad);
       },
       -1},
  };
  for (const auto &c : cases) {
    TextHarness harness;
    // A gap that ends before the frame says nothing about it.
    harness.text_event(gst_event_new_gap(0, frame_time));
    harness.wait_text();
    harness.push_waiting(2 * frame_time);
    c.come(harness);
    const int number = harness.pull_number();
    fail_unless(number == c.number, "%s: %d", c.what, number);
    fail_unless(harness.said(GST_MESSAGE_WARNING) == "", "%s", c.what);
  }
}
GST_END_TEST

GST_START_TEST(a_gap_that_ends_beyond_all_time_lasts_for_ever) {
  constexpr GstClockTime most = GST_CLOCK_TIME_NONE - 1, a_second = GST_SECOND;
  const struct {
    GstClockTime begin, duration;
  } gaps[] = {{a_second, most}, {a_second, most - a_second}, {a_second, most / 2}, {most - 10, 100}, {most - 10, 5}};
  for (const auto &[begin, duration] : gaps) {
    TextHarness harness(utf8, GST_MSECOND);
    harness.text_event(gst_event_new_gap(begin, duration));
    harness.wait_text();
    for (const GstClockTime time : {0 * a_second, 2 * a_second, 3600 * a_second}) {
      fail_unless_equals_int(harness.push(time), -1);
      fail_unless(harness.said(GST_MESSAGE_WARNING) == "", "%" G_GUINT64_FORMAT " for %" G_GUINT64_FORMAT ": it waited",
                  begin, duration);
    }
  }
  // A gap of unknown length only says that nothing comes before its start.
  TextHarness harness(utf8, GST_MSECOND);
  harness.text_event(gst_event_new_gap(GST_SECOND, GST_CLOCK_TIME_NONE));
  harness.wait_text();
  harness.push(0 * frame_time);
  fail_unless(harness.said(GST_MESSAGE_WARNING) == "");
  harness.push(2 * GST_SECOND);
  assert_holds(harness.said(GST_MESSAGE_WARNING), "no text has come within 1 ms");
}
GST_END_TEST

GST_START_TEST(a_flush_or_a_stop_ends_the_wait) {
  {
    TextHarness harness;
    harness.push_waiting(2 * frame_time);
    Waiting frame(harness, 3 * frame_time);
    gst_harness_push_event(harness.h, gst_event_new_flush_start());
    fail_unless_equals_int(frame.join(), GST_FLOW_FLUSHING);
    // The frame that waited is gone.
    gst_harness_push_event(harness.h, gst_event_new_flush_stop(TRUE));
    new_segment(harness.h, 0);
    harness.push_line(5);
    fail_unless_equals_int(harness.push(5 * frame_time), 5);
    fail_unless(gst_harness_try_pull(harness.h) == nullptr);
  }
  {
    TextHarness harness;
    harness.push_waiting(2 * frame_time);
    Waiting frame(harness, 3 * frame_time);
    gst_element_set_state(harness.element, GST_STATE_NULL);
    fail_unless_equals_int(frame.join(), GST_FLOW_FLUSHING);
  }
}
GST_END_TEST

GST_START_TEST(no_frame_waits_longer_than_max_wait) {
  TextHarness harness(utf8, GST_MSECOND);
  for (int n = 0; n < 3; ++n) fail_unless_equals_int(harness.push(n * frame_time), -1);
  assert_holds(harness.said(GST_MESSAGE_WARNING), "no text has come within 1 ms. Put a queue before each pad");
  g_object_set(harness.element, "max-wait", 3600 * GST_SECOND, nullptr);
  harness.push_line(0);  // too late for any frame; the next frame doesn't wait either
  harness.wait_text();
  fail_unless_equals_int(harness.push(3 * frame_time), -1);
  // Text is ahead again, so frames wait again.
  harness.push_line(4);
  harness.wait_text();
  fail_unless_equals_int(harness.push(4 * frame_time), 4);
  harness.push_waiting(5 * frame_time);
  harness.push_line(5);
  fail_unless_equals_int(harness.pull_number(), 5);
  fail_unless(harness.said(GST_MESSAGE_WARNING) == "");
}
GST_END_TEST

GST_START_TEST(with_max_wait_0_no_frame_waits_and_nothing_warns) {
  TextHarness harness(utf8, 0);
  fail_unless_equals_int(harness.push(0 * frame_time), -1);
  harness.push_line(1);
  harness.wait_text();
  fail_unless_equals_int(harness.push(1 * frame_time), 1);
  fail_unless(harness.said(GST_MESSAGE_WARNING) == "");
}
GST_END_TEST

GST_START_TEST(text_that_runs_ahead_is_held_back_not_lost) {
  TextHarness harness;
  for (guint64 n = 0; n < 1000; ++n) harness.push_line(n);
  harness.end();
  // The pad's queue holds one buffer, and two until the latency is known.
  while (harness.thread->taken() < 1) g_usleep(1000);
  g_usleep(20000);
  fail_unless(harness.thread->taken() <= 2);
  for (int n = 0; n < 500; ++n) {
    fail_unless_equals_int(harness.push(n * frame_time), n);
    // At most the frame's own line, the next one, and the queue.
    fail_unless(harness.thread->taken() <= static_cast<guint64>(n) + 4);
  }
  // The video has a gap, then goes on. After its end, the text is no longer held back.
  gst_harness_push_event(harness.h, gst_event_new_gap(700 * frame_time, frame_time));
  fail_unless_equals_int(harness.push(700 * frame_time), 700);
  gst_harness_push_event(harness.h, gst_event_new_eos());
  harness.wait_text();
  fail_unless_equals_uint64(harness.thread->taken(), 1000);
  fail_unless_equals_int(harness.thread->flow(), GST_FLOW_OK);
}
GST_END_TEST

GST_START_TEST(both_streams_seek) {
  TextHarness harness;
  for (guint64 n = 0; n < 5; ++n) harness.push_line(n);
  for (int n = 0; n < 3; ++n) fail_unless_equals_int(harness.push(n * frame_time), n);
  for (const guint64 to : {100, 1}) {
    flush(harness.h);
    harness.flush_text();
    new_segment(harness.h, to * frame_time);
    harness.text_event(segment_event(to * frame_time));
    harness.push_line(line(999), (to - 1) * frame_time);  // before the segment
    for (guint64 n = to; n < to + 3; ++n) harness.push_line(n);
    for (guint64 n = to; n < to + 3; ++n) fail_unless_equals_int(harness.push(n * frame_time), static_cast<int>(n));
  }
}
GST_END_TEST

GST_START_TEST(a_flush_drops_a_torn_line) {
  TextHarness harness(ndjson);
  harness.push_waiting(0);
  // The first piece has been read once the last one is taken.
  for (const unsigned at : {0u, 50u, 100u}) harness.push_text(line(7).substr(at, 50));
  harness.wait_text();
  harness.flush_text();
  harness.text_event(segment_event(0));
  harness.push_text(line(0) + "\n");
  fail_unless_equals_int(harness.pull_number(), 0);
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(a_handler_of_a_warning_may_flush_the_text) {
  TextHarness harness(ndjson);
  gst_bus_set_sync_handler(
      harness.bus,
      [](GstBus *, GstMessage *message, gpointer its) {
        if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_WARNING) static_cast<TextHarness *>(its)->flush_text();
        return GST_BUS_PASS;
      },
      &harness, nullptr);
  harness.push_waiting(0);
  harness.push_text(line(0).substr(0, 50));
  harness.end();
  std::string said;
  while ((said = harness.said(GST_MESSAGE_WARNING)).empty()) g_usleep(1000);  // the handler has returned
  assert_holds(said, "broke off in line 1");
  harness.text_event(segment_event(0));
  harness.push_text(line(0) + "\n");
  fail_unless_equals_int(harness.pull_number(), 0);
  gst_bus_set_sync_handler(harness.bus, nullptr, nullptr, nullptr);
}
GST_END_TEST

GST_START_TEST(a_new_segment_says_nothing_about_lines_without_timestamps) {
  TextHarness harness(ndjson);
  harness.push_line(line(0) + "\n", GST_SECOND);
  harness.text_event(segment_event(0));
  harness.push_text(line(30) + "\n");  // at its own 1.2 s, not a second later
  harness.end();
  fail_unless_equals_int(harness.push(25 * frame_time), 0);
  fail_unless_equals_int(harness.push(30 * frame_time), 30);
}
GST_END_TEST

GST_START_TEST(a_segment_can_play_again) {
  // The text runs ahead into the second round, and then into the third.
  TextHarness harness;
  const auto text_round = [&](guint64 round) {
    if (round > 0) harness.text_event(segment_event(0, round * GST_SECOND));
    for (guint64 n = 0; n < 4; ++n) harness.push_line(line(10 * round + n, n * frame_time), n * frame_time);
  };
  const auto frames_round = [&](int round) {
    if (round > 0) new_segment(harness.h, 0, static_cast<GstClockTime>(round) * GST_SECOND);
    for (int n = 0; n < 5; ++n) fail_unless_equals_int(harness.push(n * frame_time), n < 4 ? 10 * round + n : -1);
  };
  for (guint64 round = 0; round < 3; ++round) text_round(round);
  frames_round(0);
  frames_round(1);
  harness.end();
  frames_round(2);
}
GST_END_TEST

GST_START_TEST(in_reverse_lines_match_in_ascending_running_time) {
  {  // The running time is 1000 s less the timestamp.
    TextHarness harness;
    new_segment(harness.h, 0, 0, -1);
    harness.text_event(segment_event(0, 0, -1));
    for (guint64 n = 400; n > 0; --n) harness.push_line(n);
    for (int n = 400; n > 0; --n) fail_unless_equals_int(harness.push(n * frame_time), n);
  }
  // Demuxers turn the order of their parts, not of what is in them. What is out of order is skipped; no frame waits.
  TextHarness harness;
  new_segment(harness.h, 0, 0, -1);
  harness.text_event(segment_event(0, 0, -1));
  for (const guint64 part : {6, 3, 0})
    for (guint64 n = part; n < part + 3; ++n) harness.push_line(n);
  harness.end();
  for (int n = 8; n >= 0; --n) fail_unless_equals_int(harness.push(n * frame_time), n % 3 == 0 ? n : -1);
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(an_invalid_line_is_refused_and_the_video_goes_on) {
  const struct {
    const char *caps, *text, *reason;
  } cases[] = {
      {utf8, "Hello, world", "Line 3 of what came to the pad text: is no JSON"},
      {markup, "<i>Hello</i>", "Line 3 of what came to the pad text: is no JSON"},
      {ndjson, "{\"schema\":9}\n", "schema 9 is not known (1 is). Link what csdtrackenc has written"},
  };
  for (const auto &c : cases) {
    TextHarness harness(c.caps);
    for (guint64 n = 0; n < 2; ++n) harness.push_line(line(n) + "\n", n * frame_time);
    harness.push_line(c.text, 2 * frame_time);
    for (guint64 n = 2; n < 5; ++n) harness.push_line(line(n) + "\n", n * frame_time);
    // What comes after it is ignored, and flows.
    for (int n = 0; n < 5; ++n) fail_unless_equals_int(harness.push(n * frame_time), n < 2 ? n : -1);
    for (int n = 5; harness.thread->taken() < 6; ++n) fail_unless_equals_int(harness.push(n * frame_time), -1);
    fail_unless_equals_int(harness.thread->flow(), GST_FLOW_OK);
    assert_holds(harness.said(GST_MESSAGE_ERROR), c.reason);
    assert_silent(harness);
  }
  TextHarness endless(ndjson);
  for (int i = 0; i < 10; ++i) endless.push_text(std::string(1 << 20, 'x'));
  fail_unless_equals_int(endless.push(0 * frame_time), -1);
  assert_holds(endless.said(GST_MESSAGE_ERROR), "Line 1 of what came to the pad text: is longer than 8 MiB");
  TextHarness unsorted;
  unsorted.push_line(2);
  unsorted.push_line(1);
  fail_unless_equals_int(unsorted.push(10 * frame_time), -1);
  assert_holds(unsorted.said(GST_MESSAGE_ERROR),
               "its running time 40000000 comes after 80000000: lines must be sorted");
}
GST_END_TEST

GST_START_TEST(with_location_the_pad_is_not_read) {
  Harness harness(write_file("location.jsonl", lines(0, 2)));
  GstHarness *text = gst_harness_new_with_element(harness.element, "text", nullptr);
  gst_harness_set_src_caps_str(text, utf8);
  for (guint64 n = 0; n < 1000; ++n) fail_unless_equals_int(gst_harness_push(text, bytes("nonsense", 0)), GST_FLOW_OK);
  fail_unless_equals_int(harness.push(frame_time), 1);
  assert_holds(harness.said(GST_MESSAGE_WARNING), "is not read, for location is set");
  fail_unless(harness.said(GST_MESSAGE_WARNING) == "");
  gst_harness_teardown(text);
}
GST_END_TEST

GST_START_TEST(there_is_one_text_pad_and_it_can_be_requested_again) {
  GstElement *element = gst_element_factory_make("csdtrackdec", nullptr);
  for (int i = 0; i < 2; ++i) {
    GstPad *pad = gst_element_request_pad_simple(element, "text");
    fail_unless(pad != nullptr);
    GstPadTemplate *other = gst_element_class_get_pad_template(GST_ELEMENT_GET_CLASS(element), "text");
    fail_unless(gst_element_request_pad(element, other, nullptr, nullptr) == nullptr);
    gst_element_release_request_pad(element, pad);
    gst_object_unref(pad);
  }
  gst_object_unref(element);
}
GST_END_TEST

GST_START_TEST(tracks_come_back_out_of_a_recording) {
  if (!have("x264enc") || !have("matroskamux") || !have("avdec_h264")) return;
  const std::string recording = temporary("r.mkv"), first = temporary("first.jsonl"),
                    second = temporary("second.jsonl");
  const auto play_to_end = [](const std::string &text) {
    GError *error = play(launch(text));
    fail_unless(error == nullptr, "%s: %s", text.c_str(), error ? error->message : "");
  };
  const std::string wide = "queue max-size-time=5000000000 max-size-buffers=0 max-size-bytes=0 ! ";
  // x264enc with its defaults: it delays by 2 s.
  play_to_end(
      "csdsimsrc num-buffers=90 ! video/x-raw,format=I420,width=160,height=120,framerate=30000/1001 ! "
      "csdtrack algorithm=lk ! tee name=t matroskamux name=m ! filesink location=" +
      recording + " t. ! queue ! x264enc ! h264parse ! m. t. ! " + wide + "csdtrackenc ! m.subtitle_0 t. ! " + wide +
      "csdtrackenc ! filesink location=" + first);
  const std::string lines = read_file(first);
  fail_unless_equals_int(lines_of(lines).size(), 90);
  std::string joined;
  for (const std::string &line : lines_of(lines)) joined += line;
  fail_unless(extracted(recording) == joined);

  // The decoder may be slow under valgrind.
  play_to_end("filesrc location=" + recording +
              " ! matroskademux name=d csdtrackdec name=r max-wait=3600000000000 ! csdtrackenc ! " +
              "filesink location=" + second + " d.video_0 ! queue ! decodebin ! r.sink d.subtitle_0 ! queue ! r.text");
  // The times are Matroska's, in milliseconds; the tracks are unchanged.
  const auto before = lines_of(lines), after = lines_of(read_file(second));
  fail_unless_equals_int(after.size(), 90);
  for (std::size_t i = 0; i < after.size(); ++i) {
    const auto tracks = [](const std::string &line) { return line.substr(line.find("\"reference\"")); };
    fail_unless(tracks(before[i]).find("\"id\"") != std::string::npos);
    fail_unless(tracks(after[i]) == tracks(before[i]), "%s", after[i].c_str());
    const auto source = [](const std::string &line) { return line.substr(0, line.find("\"pts\"")); };
    fail_unless(source(after[i]) == source(before[i]), "%s", after[i].c_str());
  }
}
GST_END_TEST

static Suite *csdtrackdec_text_suite() {
  Suite *s = suite_create("csdtrackdec_text");
  TCase *tc = tcase_create("text");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, lines_are_read_in_every_form);
  tcase_add_test(tc, the_buffers_time_takes_precedence_over_the_lines);
  tcase_add_test(tc, a_frame_waits_for_its_line_a_later_one_a_gap_or_the_end);
  tcase_add_test(tc, a_gap_that_ends_beyond_all_time_lasts_for_ever);
  tcase_add_test(tc, a_flush_or_a_stop_ends_the_wait);
  tcase_add_test(tc, no_frame_waits_longer_than_max_wait);
  tcase_add_test(tc, with_max_wait_0_no_frame_waits_and_nothing_warns);
  tcase_add_test(tc, text_that_runs_ahead_is_held_back_not_lost);
  tcase_add_test(tc, both_streams_seek);
  tcase_add_test(tc, a_flush_drops_a_torn_line);
  tcase_add_test(tc, a_handler_of_a_warning_may_flush_the_text);
  tcase_add_test(tc, a_new_segment_says_nothing_about_lines_without_timestamps);
  tcase_add_test(tc, a_segment_can_play_again);
  tcase_add_test(tc, in_reverse_lines_match_in_ascending_running_time);
  tcase_add_test(tc, an_invalid_line_is_refused_and_the_video_goes_on);
  tcase_add_test(tc, with_location_the_pad_is_not_read);
  tcase_add_test(tc, there_is_one_text_pad_and_it_can_be_requested_again);
  tcase_add_test(tc, tracks_come_back_out_of_a_recording);
  return s;
}

GST_CHECK_MAIN(csdtrackdec_text)
