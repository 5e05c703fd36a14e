// SPDX-License-Identifier: LGPL-2.1-or-later
//
// Whose tracks does a frame carry? Each line names its recording and its frame: both must be those of the frame that
// gets it.
#include <mutex>
#include <string>
#include <vector>

#include "csdtrackdec_harness.h"

using namespace csd_check;

namespace {

/// "part1:7" for the tracks of part 1's frame 7; "" without tracks.
std::string whose(GstBuffer *buffer) {
  GstCsdHeader header;
  const GstStructure *tracks = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, nullptr);
  if (!tracks) return "";
  fail_unless(gst_csd_structure_get_header(tracks, &header));
  return std::string(header.source) + ":" + std::to_string(header.frame);
}

std::string name(int part, guint64 n) {
  return "part" + std::to_string(part) + ":" + std::to_string(n);
}

std::string line_of(int part, guint64 n, GstClockTime stream_time) {
  std::string text = line(n, stream_time);
  return text.replace(text.find("csdtrack0"), 9, "part" + std::to_string(part));
}

struct Parts : TextHarness {
  using TextHarness::TextHarness;

  void text_part(int part, guint64 from, guint64 to, GstClockTime offset = 0) {
    for (guint64 n = from; n < to; ++n) push_line(line_of(part, n, n * frame_time), n * frame_time + offset);
  }
  void expect_frames(int part, guint64 from, guint64 to, guint64 lines_to = G_MAXUINT64) {
    for (guint64 n = from; n < to; ++n) {
      GstBuffer *out = gst_harness_push_and_pull(h, frame_at(n * frame_time));
      const std::string found = whose(out), expected = n < lines_to ? name(part, n) : "";
      gst_buffer_unref(out);
      fail_unless(found == expected, "part %d, frame %d: '%s'", part, static_cast<int>(n), found.c_str());
    }
  }
  void begin_frames(GstClockTime base = 0) {
    fail_unless(gst_harness_push_event(h, gst_event_new_stream_start("again")));
    new_segment(h, 0, base);
  }
  void begin_text(GstClockTime base = 0) {
    text_event(gst_event_new_stream_start("text again"));
    text_event(segment_event(0, base));
  }
};

constexpr int count = 30;

void play_to_end(GstElement *pipeline) {
  GError *error = play(pipeline);
  fail_unless(error == nullptr, "%s", error ? error->message : "");
}

/// Records two parts of `count` frames, as part1.mkv and part2.mkv in `folder`; the tracks in them, or in text1.mkv and
/// text2.mkv.
void record(const std::string &folder, bool own_files) {
  for (int part = 1; part < 3; ++part) {
    const std::string n = std::to_string(part);
    play_to_end(launch(
        "csdsimsrc num-buffers=" + std::to_string(count) + " seed=" + n +
        " ! video/x-raw,width=160,height=120,framerate=25/1 ! csdtrack name=part" + n +
        " algorithm=lk points=80,60 ! tee name=t matroskamux name=m ! filesink location=" + folder + "part" + n +
        ".mkv t. ! queue ! videoconvert ! x264enc key-int-max=25 tune=zerolatency ! h264parse ! m. t. ! csdtrackenc ! "
        "queue max-size-time=0 max-size-buffers=0 max-size-bytes=0 ! " +
        (own_files ? "n.subtitle_0 matroskamux name=n ! filesink location=" + folder + "text" + n + ".mkv"
                   : "m.subtitle_0")));
  }
}

/// Plays both parts one after the other by `concat`, and expects each frame's own tracks on it.
void expect_playlist(const std::string &sources, const std::string &queue) {
  std::vector<std::string> found;
  std::mutex mutex;
  GstElement *pipeline = launch(
      "concat name=c ! csdtrackdec name=r max-wait=3600000000000 ! fakesink name=out sync=false concat name=k ! " +
      queue + " ! r.text " + sources);
  GstElement *out = gst_bin_get_by_name(GST_BIN(pipeline), "out");
  GstPad *pad = gst_element_get_static_pad(out, "sink");
  struct Data {
    std::vector<std::string> &found;
    std::mutex &mutex;
  } data{found, mutex};
  gst_pad_add_probe(
      pad, GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad *, GstPadProbeInfo *info, gpointer to) {
        auto *its = static_cast<Data *>(to);
        const std::lock_guard lock(its->mutex);
        its->found.push_back(whose(GST_PAD_PROBE_INFO_BUFFER(info)));
        return GST_PAD_PROBE_OK;
      },
      &data, nullptr);
  gst_object_unref(pad);
  gst_object_unref(out);
  play_to_end(pipeline);
  fail_unless_equals_int(found.size(), 2 * count);
  for (int i = 0; i < 2 * count; ++i) {
    const std::string expected = name(1 + i / count, static_cast<guint64>(i % count));
    fail_unless(found[static_cast<std::size_t>(i)] == expected, "frame %d: '%s'", i,
                found[static_cast<std::size_t>(i)].c_str());
  }
}

constexpr const char *queues[] = {"queue", "queue max-size-time=0 max-size-bytes=0 max-size-buffers=1000"};

bool can_record() {
  return have("x264enc") && have("matroskamux") && have("avdec_h264") && have("concat");
}

}  // namespace

GST_START_TEST(a_playlist_with_the_text_in_the_same_files) {
  if (!can_record()) return;
  const std::string folder = temporary("");
  record(folder, false);
  for (const char *queue : queues) {
    std::string sources;
    for (const char *n : {"1", "2"})
      sources += " filesrc location=" + folder + "part" + n + ".mkv ! matroskademux name=d" + n + " d" + n +
                 ".video_0 ! queue ! h264parse ! avdec_h264 ! " + queue + " ! c. d" + n + ".subtitle_0 ! " + queue +
                 " ! k.";
    expect_playlist(sources, queue);
  }
}
GST_END_TEST

GST_START_TEST(a_playlist_with_the_text_in_files_of_its_own) {
  if (!can_record()) return;
  const std::string folder = temporary("");
  record(folder, true);
  for (const char *queue : queues) {
    std::string sources;
    for (const char *n : {"1", "2"})
      sources += " filesrc location=" + folder + "part" + n +
                 ".mkv ! matroskademux ! queue ! h264parse ! avdec_h264 ! " + queue +
                 " ! c. filesrc location=" + folder + "text" + n + ".mkv ! matroskademux ! " + queue + " ! k.";
    expect_playlist(sources, queue);
  }
}
GST_END_TEST

GST_START_TEST(a_loop_whose_base_grows) {
  Parts harness;
  for (int part = 1; part < 4; ++part) {
    const GstClockTime base = static_cast<GstClockTime>(part - 1) * 5 * frame_time;
    if (part > 1) harness.text_event(segment_event(0, base));
    harness.text_part(part, 0, 5);
  }
  for (int part = 1; part < 4; ++part) {
    if (part > 1) new_segment(harness.h, 0, static_cast<GstClockTime>(part - 1) * 5 * frame_time);
    harness.expect_frames(part, 0, 5);
  }
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(both_streams_begin_again_at_0_in_either_order) {
  for (const bool text_first : {true, false})
    for (const guint64 lines : {3, 5, 8}) {  // fewer than the frames, as many, more
      Parts harness;
      harness.text_part(1, 0, lines);
      // Frames that have no line wait for what comes next: part 2's text, or the end of part 1's.
      if (text_first) {
        harness.begin_text();
        harness.text_part(2, 0, 5);
      } else {
        harness.text_event(gst_event_new_gap(lines * frame_time, GST_SECOND));
      }
      harness.expect_frames(1, 0, 5, lines);
      harness.begin_frames();
      if (!text_first) {
        harness.begin_text();
        harness.text_part(2, 0, 5);
      }
      harness.expect_frames(2, 0, 5);
    }
}
GST_END_TEST

GST_START_TEST(a_flush_of_the_text_alone_leaves_no_old_line) {
  Parts harness;
  harness.text_part(1, 0, 9);
  harness.expect_frames(1, 0, 3);
  harness.flush_text();
  harness.text_event(segment_event(0));
  harness.text_part(2, 0, 9);
  harness.expect_frames(2, 3, 9);
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(a_flush_of_the_video_alone_keeps_the_lines) {
  Parts harness;
  harness.text_part(1, 0, 9);
  harness.expect_frames(1, 0, 3);
  flush(harness.h);
  new_segment(harness.h, 0);
  harness.expect_frames(1, 5, 9);
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(text_that_ends_early_or_begins_late) {
  {
    Parts harness;
    harness.text_part(1, 0, 3);
    harness.end();
    harness.expect_frames(1, 0, 6, 3);
    assert_silent(harness);
  }
  {  // Without EOS a frame waits for max-wait.
    Parts harness(utf8, GST_MSECOND);
    harness.text_part(1, 0, 1);
    harness.wait_text();
    harness.expect_frames(1, 0, 4, 1);
    assert_holds(harness.said(GST_MESSAGE_WARNING), "no text has come within 1 ms");
    assert_silent(harness);
  }
  Parts harness;
  harness.text_part(1, 3, 6);
  for (int n = 0; n < 3; ++n) fail_unless_equals_int(harness.push(n * frame_time), -1);
  harness.expect_frames(1, 3, 6);
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(location_is_for_the_first_stream_only) {
  Harness harness(write_file("first.jsonl", lines(0, 9)));
  for (int n = 0; n < 3; ++n) fail_unless_equals_int(harness.push(n * frame_time), n);
  gst_harness_push_event(harness.h, gst_event_new_stream_start("another"));
  new_segment(harness.h, 0, 3 * frame_time);
  for (int n = 0; n < 3; ++n) fail_unless_equals_int(harness.push(n * frame_time), -1);
  assert_holds(harness.said(GST_MESSAGE_WARNING), "another video follows the one that location is for");
  assert_silent(harness);
}
GST_END_TEST

namespace {

/// What brings a pad's stream, when a SEEK comes.
struct Upstream {
  int seeks = 0;
  TextThread *text = nullptr;  ///< set for the pads that it flushes
  std::vector<GstPad *> pads;
};

/// Flushes as a demuxer does.
gboolean on_event(GstPad *pad, GstObject *parent, GstEvent *event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_SEEK) return gst_pad_event_default(pad, parent, event);
  auto *upstream = static_cast<Upstream *>(pad->eventdata);
  ++upstream->seeks;
  const auto push = [&](GstEvent *(*make)()) {
    for (GstPad *each : upstream->pads) {
      GstEvent *flush_event = make();
      gst_event_set_seqnum(flush_event, gst_event_get_seqnum(event));
      gst_pad_push_event(each, flush_event);
    }
  };
  push([] { return gst_event_new_flush_start(); });
  if (upstream->text) upstream->text->drop();
  push([] { return gst_event_new_flush_stop(TRUE); });
  gst_event_unref(event);
  return TRUE;
}

}  // namespace

GST_START_TEST(a_seek_flushes_each_pad_once) {
  for (const bool one_demuxer : {true, false})
    for (const bool after_eos : {true, false}) {
      Parts harness;
      Upstream video{0, nullptr, {harness.h->srcpad}}, text{0, harness.thread.get(), {harness.text->srcpad}};
      if (one_demuxer) video = {0, harness.thread.get(), {harness.h->srcpad, harness.text->srcpad}};
      gst_pad_set_event_function_full(harness.h->srcpad, on_event, &video, nullptr);
      gst_pad_set_event_function_full(harness.text->srcpad, on_event, &text, nullptr);
      harness.text_part(1, 0, 9);
      harness.expect_frames(1, 0, 3);
      if (after_eos) {
        harness.end();
        gst_harness_push_event(harness.h, gst_event_new_eos());
        harness.wait_text();
      }
      fail_unless(gst_harness_push_upstream_event(
          harness.h,
          gst_event_new_seek(1, GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH, GST_SEEK_TYPE_SET, 0, GST_SEEK_TYPE_NONE, 0)));
      fail_unless_equals_int(video.seeks, 1);
      fail_unless_equals_int(text.seeks, one_demuxer ? 0 : 1);
      new_segment(harness.h, 0);
      harness.text_event(segment_event(0));
      harness.text_part(2, 0, 5);
      harness.expect_frames(2, 0, 5);
      assert_silent(harness);
    }
}
GST_END_TEST

GST_START_TEST(a_new_link_and_a_new_connection_go_on) {
  for (const bool relink : {true, false}) {
    Parts harness;
    harness.text_part(1, 0, 4);
    if (relink) {
      harness.thread->then([&] {
        GstPad *pad = gst_element_get_static_pad(harness.element, "text");
        fail_unless(gst_pad_unlink(harness.text->srcpad, pad));
        fail_unless_equals_int(gst_pad_link(harness.text->srcpad, pad), GST_PAD_LINK_OK);
        gst_object_unref(pad);
      });
    } else {
      harness.end();
      harness.begin_text();
    }
    harness.text_part(2, 1, 9);  // repeats three lines
    harness.expect_frames(1, 0, 4);
    harness.wait_begun(5);
    harness.expect_frames(2, 4, 9);
    assert_silent(harness);
  }
}
GST_END_TEST

GST_START_TEST(a_sparse_second_part_begins_with_a_gap) {
  Parts harness;
  harness.text_part(1, 0, 5);
  harness.begin_text();
  harness.text_event(gst_event_new_gap(0, 3 * frame_time));
  harness.text_part(2, 3, 5);
  harness.expect_frames(1, 0, 5);
  harness.begin_frames();
  for (int n = 0; n < 3; ++n) fail_unless_equals_int(harness.push(n * frame_time), -1);
  harness.expect_frames(2, 3, 5);
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(the_line_of_a_clipped_frame_comes_back_onto_it) {
  // The segment begins 15 ms into frame 2: it lasts for the 25 ms that are left.
  constexpr GstClockTime start = 2 * frame_time + 15 * GST_MSECOND;
  GstHarness *enc = gst_harness_new("csdtrackenc");
  gst_harness_set_sink_caps_str(enc, ndjson);
  gst_harness_set_src_caps_str(enc, gray_64);
  new_segment(enc, start);
  GstBuffer *frame = frame_at(start, 25 * GST_MSECOND);
  attach_many(frame, 2, 1);
  gst_harness_push(enc, frame);
  GstBuffer *encoded_line = gst_harness_pull(enc);
  const std::string text = text_in(encoded_line);
  gst_buffer_unref(encoded_line);
  gst_harness_teardown(enc);
  {
    Harness harness(write_file("clipped.jsonl", text));
    new_segment(harness.h, start);
    fail_unless_equals_int(harness.push(frame_at(start, 25 * GST_MSECOND)), 2);
  }
  TextHarness harness;
  new_segment(harness.h, start);
  harness.text_event(segment_event(start));
  harness.push_line(text, start);
  fail_unless_equals_int(harness.push(frame_at(start, 25 * GST_MSECOND)), 2);
}
GST_END_TEST

GST_START_TEST(a_small_copy_with_square_pixels_of_an_anamorphic_video) {
  // 720×576 at 16:11 is shown as 1047.3×576, so 524×288 with square pixels is half of it in both directions.
  std::string text = line(0);
  text.replace(text.find("\"width\":64,\"height\":48"), 22, "\"width\":524,\"height\":288,\"pixel_aspect\":[1,1]");
  const std::string path = write_file("square.jsonl", text + "\n");
  const auto put = [&](const char *aspect, bool tracked) {
    Harness harness(path, (std::string("video/x-raw,format=GRAY8,width=720,height=576,framerate=25/1,") +
                           "pixel-aspect-ratio=" + aspect)
                              .c_str());
    GstBuffer *in = gst_buffer_new_allocate(nullptr, 720 * 576, nullptr);
    GST_BUFFER_PTS(in) = 0;
    GstBuffer *out = gst_harness_push_and_pull(harness.h, in);
    const GstStructure *tracks = gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, nullptr);
    fail_unless((tracks != nullptr) == tracked, "%s", aspect);
    if (tracked) {
      GstCsdFeature feature;
      fail_unless(gst_csd_structure_get_feature(tracks, 0, &feature));
      fail_unless_equals_float(feature.x, (10.25 + 0.5) * 720 / 524 - 0.5);
      fail_unless_equals_float(feature.y, (20 + 0.5) * 2 - 0.5);
    } else {
      assert_holds(harness.said(GST_MESSAGE_WARNING), "has another aspect");
    }
    gst_buffer_unref(out);
    assert_silent(harness);
  };
  put("16/11", true);
  put("1/1", false);
  put("12/11", false);
}
GST_END_TEST

static Suite *csdtrackdec_whose_suite() {
  Suite *s = suite_create("csdtrackdec_whose");
  TCase *tc = tcase_create("whose");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, a_playlist_with_the_text_in_the_same_files);
  tcase_add_test(tc, a_playlist_with_the_text_in_files_of_its_own);
  tcase_add_test(tc, a_loop_whose_base_grows);
  tcase_add_test(tc, both_streams_begin_again_at_0_in_either_order);
  tcase_add_test(tc, a_flush_of_the_text_alone_leaves_no_old_line);
  tcase_add_test(tc, a_flush_of_the_video_alone_keeps_the_lines);
  tcase_add_test(tc, text_that_ends_early_or_begins_late);
  tcase_add_test(tc, location_is_for_the_first_stream_only);
  tcase_add_test(tc, a_seek_flushes_each_pad_once);
  tcase_add_test(tc, a_new_link_and_a_new_connection_go_on);
  tcase_add_test(tc, a_sparse_second_part_begins_with_a_gap);
  tcase_add_test(tc, the_line_of_a_clipped_frame_comes_back_onto_it);
  tcase_add_test(tc, a_small_copy_with_square_pixels_of_an_anamorphic_video);
  return s;
}

GST_CHECK_MAIN(csdtrackdec_whose)
