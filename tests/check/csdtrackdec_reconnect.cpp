// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackdec whose text breaks off and starts again: its source ended, reconnected or was linked again.
#include "csdtrackdec_harness.h"

using namespace csd_check;

namespace {

/// How another stream of text can begin.
struct Way {
  const char *name;
  void (*go)(TextHarness &);
};

/// The events with which a source begins.
void begin_stream(TextHarness &harness, const char *id = "another", guint group = 0) {
  GstEvent *start = gst_event_new_stream_start(id);
  if (group != 0) gst_event_set_group_id(start, group);
  harness.text_event(start);
  g_autoptr(GstCaps) caps = gst_pad_get_current_caps(harness.text->srcpad);
  GstSegment segment;
  gst_segment_init(
      &segment, gst_structure_has_name(gst_caps_get_structure(caps, 0), ndjson) ? GST_FORMAT_BYTES : GST_FORMAT_TIME);
  harness.text_event(gst_event_new_segment(&segment));
}

constexpr Way ways[] = {
    {"STREAM_START", [](TextHarness &h) { begin_stream(h); }},
    {"EOS, STREAM_START",
     [](TextHarness &h) {
       h.end();
       begin_stream(h);
     }},
    {"a new link",
     [](TextHarness &h) {
       h.thread->then([&h] {
         GstPad *pad = gst_element_get_static_pad(h.element, "text");
         fail_unless(gst_pad_unlink(h.text->srcpad, pad));
         fail_unless_equals_int(gst_pad_link(h.text->srcpad, pad), GST_PAD_LINK_OK);
         gst_object_unref(pad);
       });
     }},
};

void assert_torn(TextHarness &harness, const char *way, const char *line) {
  const std::string warning = harness.said(GST_MESSAGE_WARNING);
  fail_unless(warning.find("What came to the pad text broke off in " + std::string(line)) != std::string::npos,
              "%s: '%s'", way, warning.c_str());
}

}  // namespace

GST_START_TEST(a_torn_line_is_dropped_with_a_warning) {
  for (const Way &way : ways) {
    TextHarness harness(ndjson);
    harness.push_text(lines(0, 2) + line(2).substr(0, 99));
    way.go(harness);
    harness.push_text(lines(3, 6));
    for (int n = 0; n < 6; ++n) {
      const int number = harness.push(n * frame_time);
      if (n == 1) harness.wait_begun(2);
      fail_unless(number == (n == 2 ? -1 : n), "%s: %d at frame %d; %s", way.name, number, n,
                  harness.said(GST_MESSAGE_ERROR).c_str());
    }
    assert_torn(harness, way.name, "line 3: ");
    assert_silent(harness);
  }
}
GST_END_TEST

GST_START_TEST(without_loss_there_is_no_warning) {
  for (const Way &way : ways)
    for (const char *rest : {"", " \r", "\n"}) {
      TextHarness harness(ndjson);
      harness.push_text(lines(0, 2) + rest);
      way.go(harness);
      harness.push_text(lines(2, 4));
      harness.end();
      for (int n = 0; n < 4; ++n) {
        fail_unless_equals_int(harness.push(n * frame_time), n);
        if (n == 1) harness.wait_begun(2);
      }
      assert_silent(harness);
    }
}
GST_END_TEST

GST_START_TEST(an_end_within_a_line_is_reported_once) {
  TextHarness harness(ndjson);
  harness.push_text(lines(0, 1) + line(1));
  harness.end();
  begin_stream(harness);
  for (int n = 0; n < 2; ++n) {
    harness.push_text(lines(2, 3));
    fail_unless_equals_int(harness.push(n * frame_time), n == 0 ? 0 : -1);
  }
  assert_torn(harness, "EOS", "line 2: ");
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(repeated_lines_take_up_where_the_old_ones_ended) {
  // Repeated lines have another number. The frames don't restart. Those that had their lines keep them.
  for (const char *caps : {ndjson, utf8})
    for (const Way &way : ways) {
      TextHarness harness(caps);
      const auto send = [&](guint64 from, guint64 to, guint64 number) {
        for (guint64 n = from; n < to; ++n) harness.push_line(line(number + n, n * frame_time) + "\n", n * frame_time);
      };
      send(0, 6, 0);
      way.go(harness);
      send(1, 3, 100);  // no frame comes for these any more
      way.go(harness);
      send(3, 9, 200);
      harness.end();
      // STREAM_START alone may also be another recording's, whose frames are still to come.
      const bool ambiguous = &way == &ways[0];
      for (int n = 0; n < 10; ++n) {
        // Frame 6 waits while the text goes the second way, and may find just then that nothing is linked, or that the
        // text has ended.
        if (n == 6) harness.wait_begun(7);
        if (n == 7) harness.wait_begun(9);
        const int number = harness.push(n * frame_time), expected = n < 6 ? n : n < 9 && !ambiguous ? 200 + n : -1;
        fail_unless(number == expected || (n == 6 && number == -1), "%s, %s: %d at frame %d; %s", caps, way.name,
                    number, n, harness.said(GST_MESSAGE_ERROR).c_str());
      }
      if (ambiguous) assert_holds(harness.said(GST_MESSAGE_WARNING), "the text has begun again at an earlier time");
      assert_silent(harness);
    }
}
GST_END_TEST

GST_START_TEST(lines_far_ahead_hide_none_of_a_new_stream) {
  // 256 lines with times that no frame reaches.
  TextHarness harness(ndjson);
  std::string far;
  for (guint64 n = 0; n < 256; ++n) far += line(n, n * frame_time + 1000 * GST_SECOND) + "\n";
  harness.push_text(far);
  fail_unless_equals_int(harness.push(0 * frame_time), -1);
  begin_stream(harness);
  harness.push_text(lines(0, 3));
  harness.wait_text();
  for (int n = 1; n < 3; ++n) fail_unless_equals_int(harness.push(n * frame_time), n);
}
GST_END_TEST

GST_START_TEST(lines_after_a_refused_line_are_read) {
  for (const char *caps : {utf8, ndjson}) {
    TextHarness harness(caps);
    harness.push_line("nonsense\n", 0);
    fail_unless_equals_int(harness.push(0 * frame_time), -1);
    assert_holds(harness.said(GST_MESSAGE_ERROR), "is no JSON");
    begin_stream(harness);
    harness.push_line(line(1) + "\n", frame_time);
    harness.wait_text();
    fail_unless_equals_int(harness.push(frame_time), 1);
    assert_silent(harness);
  }
}
GST_END_TEST

GST_START_TEST(the_next_parts_of_both_streams_stay_apart) {
  // As concat plays one recording after another. Either the text or the video runs ahead.
  for (const bool ahead : {true, false}) {
    TextHarness harness;
    const auto begin_frames = [&](guint group) {
      GstEvent *start = gst_event_new_stream_start("video");
      gst_event_set_group_id(start, group);
      gst_harness_push_event(harness.h, start);
      new_segment(harness.h, 0);
    };
    const auto send = [&](guint group) {
      begin_stream(harness, "text", group);
      for (guint64 n = 0; n < 4; ++n) harness.push_line(line(10 * group + n, n * frame_time), n * frame_time);
    };
    const auto play = [&](int group) {
      for (int n = 0; n < 4; ++n) fail_unless_equals_int(harness.push(n * frame_time), 10 * group + n);
    };
    begin_frames(1);
    send(1);
    if (ahead) {
      send(2);
      play(1);
      begin_frames(2);
    } else {
      play(1);
      begin_frames(2);
      send(2);
    }
    play(2);
    assert_silent(harness);
  }
}
GST_END_TEST

static Suite *csdtrackdec_reconnect_suite() {
  Suite *s = suite_create("csdtrackdec_reconnect");
  TCase *tc = tcase_create("text");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, a_torn_line_is_dropped_with_a_warning);
  tcase_add_test(tc, without_loss_there_is_no_warning);
  tcase_add_test(tc, an_end_within_a_line_is_reported_once);
  tcase_add_test(tc, repeated_lines_take_up_where_the_old_ones_ended);
  tcase_add_test(tc, lines_far_ahead_hide_none_of_a_new_stream);
  tcase_add_test(tc, lines_after_a_refused_line_are_read);
  tcase_add_test(tc, the_next_parts_of_both_streams_stay_apart);
  return s;
}

GST_CHECK_MAIN(csdtrackdec_reconnect)
