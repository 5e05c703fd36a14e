// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackdec with a file: the same tracks come back on the same frames, and no content of a file does harm.
#include "csdtrackdec_harness.h"

#include <sys/stat.h>

using namespace csd_check;

namespace {

void play_to_end(const std::string &text) {
  GError *error = play(launch(text));
  fail_unless(error == nullptr, "%s: %s", text.c_str(), error ? error->message : "");
}

GstCsdFeature feature_on(GstBuffer *buffer, guint i = 0) {
  GstCsdFeature feature;
  fail_unless(
      gst_csd_structure_get_feature(gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, nullptr), i, &feature));
  return feature;
}

}  // namespace

GST_START_TEST(a_recording_comes_back_byte_for_byte) {
  for (const char *role : {"track", "truth"}) {
    const std::string first = temporary("first.jsonl"), second = temporary("second.jsonl");
    const std::string size = "video/x-raw,width=320,height=240,framerate=30000/1001", as = std::string(" role=") + role;
    play_to_end("csdsimsrc num-buffers=40 ! " + size + " ! csdtrack algorithm=lk ! csdtrackenc" + as +
                " ! filesink location=" + first);
    // From another source, so that the tracks can only come from the file.
    play_to_end("videotestsrc num-buffers=40 ! " + size + ",format=NV12 ! csdtrackdec location=" + first +
                " ! csdtrackenc" + as + " ! filesink location=" + second);
    const std::string lines = read_file(first);
    fail_unless_equals_int(lines_of(lines).size(), 40);
    fail_unless(lines.find("\"state\":\"tracked\"") != std::string::npos);
    fail_unless(lines == read_file(second));
  }
}
GST_END_TEST

GST_START_TEST(positions_are_scaled_with_the_picture) {
  const std::string path = write_file("scaled.jsonl", line(0) + "\n");
  const struct {
    const char *size;
    int n;
    double x, y;
  } cases[] = {
      {"width=64,height=48", 0, 10.25, 20},
      {"width=128,height=96", 0, 21, 40.5},                  // (10.25 + ½)·2 − ½, (20 + ½)·2 − ½
      {"width=32,height=24", 0, 4.875, 9.75},                // (10.25 + ½)/2 − ½, (20 + ½)/2 − ½
      {"width=128,height=97", 0, 21, 20.5 * 97 / 48 - 0.5},  // the same, rounded
      {"width=128,height=99", -1, 0, 0},                     // another aspect
      {"width=128,height=48", -1, 0, 0},
      {"width=128,height=96,pixel-aspect-ratio=0/1", -1, 0, 0},  // no aspect
  };
  for (const auto &c : cases) {
    Harness harness(path, (std::string("video/x-raw,format=GRAY8,framerate=25/1,") + c.size).c_str());
    GstBuffer *out = gst_harness_push_and_pull(harness.h, frame_at(0));
    fail_unless_equals_int(number_on(out), c.n);
    if (c.n == 0) {
      GstCsdHeader header;
      gst_csd_structure_get_header(gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, nullptr), &header);
      fail_unless(std::string(c.size) ==
                  "width=" + std::to_string(header.width) + ",height=" + std::to_string(header.height));
      fail_unless_equals_int(header.tracked_width, 64);
      fail_unless_equals_int(header.tracked_height, 48);
      fail_unless_equals_float(feature_on(out).x, c.x);
      fail_unless_equals_float(feature_on(out).y, c.y);
    } else {
      assert_holds(harness.said(GST_MESSAGE_WARNING), "these are of a picture of 64×48 pixels, and the video, of 128×");
    }
    gst_buffer_unref(out);
    fail_unless(harness.said(GST_MESSAGE_WARNING) == "");
  }
}
GST_END_TEST

GST_START_TEST(a_crop_rectangle_counts_as_the_picture) {
  Harness harness(write_file("crop.jsonl", line(0) + "\n"),
                  "video/x-raw,format=GRAY8,width=128,height=96,framerate=25/1");
  GstBuffer *in = gst_buffer_new_allocate(nullptr, 128 * 96, nullptr);
  GST_BUFFER_PTS(in) = 0;
  GstVideoCropMeta *crop = gst_buffer_add_video_crop_meta(in);
  crop->x = 40;
  crop->y = 10;
  crop->width = 64;
  crop->height = 48;
  GstBuffer *out = gst_harness_push_and_pull(harness.h, in);
  fail_unless_equals_float(feature_on(out).x, 10.25);
  gst_buffer_unref(out);
}
GST_END_TEST

GST_START_TEST(follows_seeks) {
  // 2.7 MB, so that it searches by bisection. Every tenth line belongs to no frame.
  std::string content = "\xef\xbb\xbf";
  for (guint64 n = 0; n < 10000; ++n) {
    if (n % 10 == 9)
      content +=
          "{\"schema\":1,\"role\":\"track\",\"frame\":null,\"stream_time\":null,\"width\":64,\"height\":48,"
          "\"features\":[]}\r\n\n";
    else
      content += line(n) + "\r\n";
  }
  Harness harness(write_file("seek.jsonl", content));
  const auto check = [&](guint64 n) {
    fail_unless_equals_int(harness.push(n * frame_time), n < 10000 && n % 10 != 9 ? static_cast<int>(n) : -1);
  };
  for (const guint64 from : {0, 5000, 9990, 3, 7777, 0, 20000, 9998}) {
    flush(harness.h);
    new_segment(harness.h, from * frame_time);
    for (guint64 n = from; n < from + 12; ++n) check(n);
  }
  // Without a flush, too: a decoder's gap, or a segment that plays again.
  new_segment(harness.h, 0);
  for (guint64 n : {6000, 6001, 6100, 9000, 100, 99, 101, 102}) check(n);
  fail_unless(harness.said(GST_MESSAGE_ERROR) == "");
}
GST_END_TEST

GST_START_TEST(a_torn_last_line_is_skipped_until_it_is_whole) {
  const std::string path = write_file("torn.jsonl", line(0) + "\n" + line(1).substr(0, 100));
  Harness harness(path);
  fail_unless_equals_int(harness.push(0 * frame_time), 0);
  fail_unless_equals_int(harness.push(1 * frame_time), -1);
  fail_unless_equals_int(harness.push(2 * frame_time), -1);
  FILE *file = g_fopen(path.c_str(), "a");
  fputs((line(1).substr(100) + "\n" + line(2) + "\n" + line(3) + "\n" + line(4)).c_str(), file);
  fclose(file);
  fail_unless_equals_int(harness.push(3 * frame_time), 3);
  fail_unless_equals_int(harness.push(4 * frame_time), -1);
  fail_unless(harness.said(GST_MESSAGE_ERROR) == "");
}
GST_END_TEST

GST_START_TEST(a_line_without_tracks_and_one_without_features) {
  Harness harness(write_file(
      "none.jsonl",
      "{\"schema\":1,\"source\":null,\"role\":\"track\",\"algorithm\":null,\"frame\":null,\"pts\":0,\"stream_time\":0,"
      "\"width\":64,\"height\":48,\"features\":[]}\n"
      "{\"schema\":1,\"source\":\"t\",\"role\":\"track\",\"algorithm\":\"lk\",\"frame\":7,\"stream_time\":40000000,"
      "\"width\":64,\"height\":48,\"features\":[]}\n"));
  fail_unless_equals_int(harness.push(0 * frame_time), -1);
  fail_unless_equals_int(harness.push(1 * frame_time), 7);
}
GST_END_TEST

GST_START_TEST(no_frame_waits_for_megabytes_without_a_time) {
  Harness harness(write_file("blank.jsonl", line(0) + "\n" + std::string(9 << 20, '\n') + lines(1, 6)));
  std::string numbers;
  for (guint64 n = 0; n < 6; ++n) numbers += std::to_string(harness.push(n * frame_time)) + " ";
  // 4 MiB are read for each of two frames. The third finds its line behind the rest.
  fail_unless_equals_string(numbers.c_str(), "0 -1 -1 3 4 5 ");
}
GST_END_TEST

GST_START_TEST(invalid_lines_are_refused_with_their_number_and_a_reason) {
  const auto with = [](const char *from, const char *to) {
    std::string bad = line(1);
    return lines(0, 1) + bad.replace(bad.find(from), strlen(from), to) + "\n";
  };
  const struct {
    std::string content;
    const char *reason;
  } cases[] = {
      {"frame,pts,stream_time,id,x,y,state,confidence,fresh\n", "Line 1 of \""},
      {"frame,pts,stream_time,id,x,y,state,confidence,fresh\n", "is no JSON"},
      {lines(0, 1) + "\n\nnot JSON\n", "Line 4 of \""},
      {with("\"frame\"", "frame"), ": is no JSON: "},
      {with(":1,", ":2,"), ": schema 2 is not known (1 is)"},
      {with("\"role\":\"track\"", "\"role\":\"other\""), ": `role` is 'other', neither track nor truth"},
      {with("\"role\":\"track\",", ""), ": `role` is '', neither track nor truth"},
      {with("11.250", "NaN"), ": is no JSON: "},
      {with("11.250", "1e999"), ": is no JSON: a value is misspelt or too large, or a bracket"},
      {with("11.250", "99999999999999999999"), ": is no JSON: a value is misspelt or too large, or a bracket"},
      {with("11.250", "\"11\""), ": `x` is no number"},
      {with("11.250", "-1e7"), ": `x` is beyond 1048576 pixels"},
      {with("\"y\":20.000,", ""), ": `y` is no number"},
      {with("\"id\":3", "\"id\":-3"), ": `id` is no whole number from 0 to 4294967294"},
      {with("[{", "[{\"id\":3,\"x\":1,\"y\":1,\"state\":\"lost\",\"confidence\":0},{"), ": feature 3 after feature 3"},
      {with("0.931", "2"), ": a confidence is from 0 to 1"},
      {with("\"width\":64,", ""), ": has no `width` or no `height`"},
      {with("\"height\":48", "\"height\":0"), ": has no `width` or no `height`"},
      {with("null", std::string(100000, '[').c_str()), ": is no JSON: brackets are nested more than 16 deep"},
      {line(3) + "\n" + line(2) + "\n", ": `stream_time` 80000000 after 120000000: lines must be sorted by it"},
      {line(0) + "\n" + line(1, G_MAXINT64) + "\n", ": `stream_time` is more than 146 years"},
      {std::string(9 << 20, ' ') + "\n", ": is longer than 8 MiB"},
      {std::string(9 << 20, '\0'), ": is longer than 8 MiB"},
  };
  for (const auto &c : cases) {
    Harness harness(write_file("hostile.jsonl", c.content));
    // A frame is handled in another thread. A few more may come before upstream hears of it.
    GstFlowReturn flow = GST_FLOW_OK;
    for (guint64 n = 0; n < 100 && flow == GST_FLOW_OK; ++n)
      flow = gst_harness_push(harness.h, frame_at(n * frame_time));
    fail_unless_equals_int(flow, GST_FLOW_ERROR);
    const std::string text = harness.said(GST_MESSAGE_ERROR);
    assert_holds(text, c.reason);
    assert_holds(text, "hostile.jsonl\"");
    assert_holds(text, "Set location to a .jsonl file that csdtrackenc has written.");
    assert_silent(harness);
  }
}
GST_END_TEST

GST_START_TEST(an_unreadable_file_is_refused_in_ready) {
  const std::string pipe = temporary("pipe");
  fail_unless(mkfifo(pipe.c_str(), 0600) == 0);
  const struct {
    std::string location;
    int code;
    const char *text;
  } cases[] = {
      {temporary("missing.jsonl"), GST_RESOURCE_ERROR_NOT_FOUND,
       "can't be read: No such file or directory. Set location"},
      {temporary("."), GST_RESOURCE_ERROR_OPEN_READ, "is no file. Set location"},
      {pipe, GST_RESOURCE_ERROR_OPEN_READ, "link what comes by a pipe or a network to the pad text"},
      {temporary("\xe9.jsonl"), GST_RESOURCE_ERROR_NOT_FOUND, "No such file or directory"},  // Latin-1
  };
  for (const auto &c : cases) {
    GstElement *element = gst_element_factory_make("csdtrackdec", nullptr);
    GstBus *bus = gst_bus_new();
    gst_element_set_bus(element, bus);
    g_object_set(element, "location", c.location.c_str(), nullptr);
    fail_unless_equals_int(gst_element_set_state(element, GST_STATE_READY), GST_STATE_CHANGE_FAILURE);
    GstMessage *message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR);
    GError *error = nullptr;
    gst_message_parse_error(message, &error, nullptr);
    fail_unless(g_error_matches(error, GST_RESOURCE_ERROR, c.code), "%s", error->message);
    assert_holds(error->message, c.text);
    fail_unless(g_utf8_validate(error->message, -1, nullptr));
    g_error_free(error);
    gst_message_unref(message);
    gst_element_set_state(element, GST_STATE_NULL);
    gst_element_set_bus(element, nullptr);
    gst_object_unref(bus);
    gst_object_unref(element);
  }
}
GST_END_TEST

GST_START_TEST(only_overlay_draw_changes_pixels) {
  const std::string path = write_file("overlay.jsonl", lines(0, 3));
  for (const char *overlay : {"none", "meta", "draw"}) {
    const bool draw = std::string(overlay) == "draw", meta = std::string(overlay) == "meta";
    Harness harness(path, nullptr, overlay);
    if (meta) gst_harness_add_propose_allocation_meta(harness.h, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
    gst_harness_set_src_caps_str(harness.h, gray_64);
    for (int i = 0; i < 5; ++i) {
      const bool tracked = i < 3;
      GstBuffer *in = frame_at(i * frame_time);
      GstMemory *memory = gst_buffer_peek_memory(in, 0);
      gst_buffer_ref(in);  // as in a tee's other branch
      GstBuffer *out = gst_harness_push_and_pull(harness.h, in);
      fail_unless_equals_int(number_on(out), tracked ? i : -1);
      fail_unless_equals_int(number_on(in), -1);
      fail_unless((gst_buffer_peek_memory(out, 0) == memory) == !(draw && tracked), "%s, frame %d", overlay, i);
      fail_unless((gst_buffer_get_video_overlay_composition_meta(out) != nullptr) == (meta && tracked));
      guint8 pixels[64 * 48];
      memset(pixels, 100, sizeof pixels);
      gst_check_buffer_data(in, pixels, sizeof pixels);
      fail_unless((gst_buffer_memcmp(out, 0, pixels, sizeof pixels) == 0) == !(draw && tracked));
      gst_buffer_unref(in);
      gst_buffer_unref(out);
    }
    GstBuffer *in = frame_at(GST_CLOCK_TIME_NONE);  // not shared: the same buffer comes out
    GstBuffer *out = gst_harness_push_and_pull(harness.h, in);
    fail_unless(out == in);
    gst_buffer_unref(out);
    fail_unless(harness.said(GST_MESSAGE_WARNING) == "");
  }
}
GST_END_TEST

GST_START_TEST(other_elements_metas_stay) {
  Harness harness(write_file("others.jsonl", line(5, 0) + "\n"));
  GstBuffer *in = frame_at(0);
  attach(in, "live", 1, 64, 48, 1, 2);
  GstBuffer *out = gst_harness_push_and_pull(harness.h, in);
  fail_unless(gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, "live") != nullptr);
  fail_unless(gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, "csdtrack0") != nullptr);
  fail_unless_equals_int(number_on(out), 5);
  gst_buffer_unref(out);
}
GST_END_TEST

GST_START_TEST(location_is_read_in_ready_and_its_absence_is_reported_once) {
  const std::string path = write_file("late.jsonl", lines(0, 9));
  Harness harness;
  g_object_set(harness.element, "location", path.c_str(), nullptr);  // in PLAYING it doesn't change
  for (int i = 0; i < 3; ++i) fail_unless_equals_int(harness.push(i * frame_time), -1);
  assert_holds(harness.said(GST_MESSAGE_WARNING), "There are no tracks to put on the frames. Set location");
  fail_unless(harness.said(GST_MESSAGE_WARNING) == "");
  gst_element_set_state(harness.element, GST_STATE_READY);
  g_object_set(harness.element, "location", path.c_str(), nullptr);
  gst_element_set_state(harness.element, GST_STATE_PLAYING);
  gst_harness_push_event(harness.h, gst_event_new_stream_start("again"));
  gst_harness_set_src_caps_str(harness.h, gray_64);
  new_segment(harness.h, 0);
  fail_unless_equals_int(harness.push(3 * frame_time), 3);
}
GST_END_TEST

GST_START_TEST(location_can_be_set_after_a_failed_start) {
  Harness harness;
  gst_element_set_state(harness.element, GST_STATE_READY);
  GstPad *pad = gst_element_get_static_pad(harness.element, "src");
  const GstPadActivateModeFunction activate = GST_PAD_ACTIVATEMODEFUNC(pad);
  gst_pad_set_activatemode_function(pad, [](GstPad *, GstObject *, GstPadMode, gboolean) -> gboolean { return FALSE; });
  fail_unless_equals_int(gst_element_set_state(harness.element, GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
  gst_pad_set_activatemode_function(pad, activate);
  gst_object_unref(pad);
  g_object_set(harness.element, "location", "another.jsonl", nullptr);
  g_autofree gchar *location = nullptr;
  g_object_get(harness.element, "location", &location, nullptr);
  fail_unless_equals_string(location, "another.jsonl");
}
GST_END_TEST

static Suite *csdtrackdec_suite() {
  Suite *s = suite_create("csdtrackdec");
  TCase *tc = tcase_create("file");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, a_recording_comes_back_byte_for_byte);
  tcase_add_test(tc, positions_are_scaled_with_the_picture);
  tcase_add_test(tc, a_crop_rectangle_counts_as_the_picture);
  tcase_add_test(tc, follows_seeks);
  tcase_add_test(tc, a_torn_last_line_is_skipped_until_it_is_whole);
  tcase_add_test(tc, a_line_without_tracks_and_one_without_features);
  tcase_add_test(tc, no_frame_waits_for_megabytes_without_a_time);
  tcase_add_test(tc, invalid_lines_are_refused_with_their_number_and_a_reason);
  tcase_add_test(tc, an_unreadable_file_is_refused_in_ready);
  tcase_add_test(tc, only_overlay_draw_changes_pixels);
  tcase_add_test(tc, other_elements_metas_stay);
  tcase_add_test(tc, location_is_read_in_ready_and_its_absence_is_reported_once);
  tcase_add_test(tc, location_can_be_set_after_a_failed_start);
  return s;
}

GST_CHECK_MAIN(csdtrackdec)
