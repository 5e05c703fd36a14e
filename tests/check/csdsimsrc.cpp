// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdsimsrc: its frames and their truth compared with the simulator's own, and its behaviour as a source.
#include "sim/simulator.h"

#include <glib/gstdio.h>
#include <gst/video/video.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "meta/csdtrackmeta.h"

// Defines a macro fail(), so it comes after headers with a function of that name.
#include <glib/gstdio.h>
#include <gst/check/gstcheck.h>
#include <gst/check/gstharness.h>

namespace {

/// The next frame. gst_harness_pull() gives up after a minute; the first takes longer under valgrind.
GstBuffer *pull(GstHarness *h) {
  GstBuffer *buffer = nullptr;
  while (!buffer) buffer = gst_harness_pull(h);
  return buffer;
}

struct Harness {
  GstHarness *h;
  explicit Harness(const std::string &properties, const char *caps = nullptr) {
    h = gst_harness_new_parse(("csdsimsrc name=sim " + properties).c_str());
    if (caps) gst_harness_set_sink_caps_str(h, caps);
  }
  ~Harness() { gst_harness_teardown(h); }
  GstBuffer *pull() {
    gst_harness_play(h);
    return ::pull(h);
  }
};

struct Truth {
  GstCsdHeader header{};
  std::vector<GstCsdFeature> features;
};

Truth truth_of(GstBuffer *buffer) {
  Truth t;
  const GstStructure *s = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRUTH_META_NAME, nullptr);
  fail_unless(s != nullptr);
  fail_unless(gst_csd_structure_get_header(s, &t.header));
  t.features.resize(t.header.n_features);
  for (guint i = 0; i < t.header.n_features; ++i) fail_unless(gst_csd_structure_get_feature(s, i, &t.features[i]));
  return t;
}

const char *word(csd::sim::Visibility v) {
  using V = csd::sim::Visibility;
  return v == V::visible ? "tracked" : v == V::hidden ? "occluded" : "out";
}

/// The core's simulator with the same settings.
csd::sim::Simulator simulator(const char *effects, csd::sim::Scenario scenario, double strength = 1) {
  csd::sim::SimSettings s;
  s.effects = csd::sim::scenario_effects(scenario, strength);
  s.effects.set(effects);
  s.size = {640, 480};
  s.seed = 4;
  s.style = csd::sim::Style::bowel;
  return csd::sim::Simulator(s);
}

bool same_pixels(GstBuffer *buffer, const cv::Mat &picture) {
  GstVideoInfo info;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_BGR, static_cast<guint>(picture.cols),
                            static_cast<guint>(picture.rows));
  GstMapInfo map;
  fail_unless(gst_buffer_map(buffer, &map, GST_MAP_READ));
  fail_unless_equals_uint64(map.size, info.size);
  bool same = true;
  for (int y = 0; y < picture.rows; ++y)
    same = same &&
           std::memcmp(map.data + y * info.stride[0], picture.ptr(y), 3 * static_cast<std::size_t>(picture.cols)) == 0;
  gst_buffer_unmap(buffer, &map);
  return same;
}

/// Runs a pipeline until its first error and returns that error's text.
std::string error_of(const std::string &properties) {
  GstElement *pipeline = gst_parse_launch(("csdsimsrc num-buffers=2 " + properties + " ! fakesink").c_str(), nullptr);
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  GstBus *bus = gst_element_get_bus(pipeline);
  GstMessage *message = gst_bus_timed_pop_filtered(bus, GST_CLOCK_TIME_NONE,
                                                   static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_EOS));
  std::string text;
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
    GError *error = nullptr;
    gst_message_parse_error(message, &error, nullptr);
    if (g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_SETTINGS)) text = error->message;
    g_error_free(error);
  }
  gst_message_unref(message);
  gst_object_unref(bus);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(pipeline);
  return text;
}

/// Plays to EOS; keeps the pipeline.
void play_to_end(GstElement *pipeline) {
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  GstBus *bus = gst_element_get_bus(pipeline);
  GstMessage *message = gst_bus_timed_pop_filtered(
      bus, GST_CLOCK_TIME_NONE, static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_WARNING | GST_MESSAGE_ERROR));
  fail_unless(GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS);
  gst_message_unref(message);
  gst_object_unref(bus);
}

}  // namespace

GST_START_TEST(test_frames_and_truth_equal_the_simulators) {
  Harness h("scenario=occlusion strength=0.7 effects=fold,noise=2 seed=4 style=bowel");
  csd::sim::Simulator sim = simulator("fold,noise=2", csd::sim::Scenario::occlusion, 0.7);
  const auto surface = sim.on_surface(0, sim.detect(100));
  fail_unless(surface.size() > 80);
  cv::Mat picture;
  for (std::uint64_t n = 0; n < 60; ++n) {
    GstBuffer *buffer = h.pull();
    fail_unless_equals_uint64(GST_BUFFER_PTS(buffer), n * 40 * GST_MSECOND);
    fail_unless_equals_uint64(GST_BUFFER_DURATION(buffer), 40 * GST_MSECOND);
    fail_unless_equals_uint64(GST_BUFFER_OFFSET(buffer), n);
    if (n % 20 == 0 || n == 59) {
      sim.render(n, picture);
      fail_unless(same_pixels(buffer, picture));
    }
    const Truth t = truth_of(buffer);
    const auto expected = sim.truth(n, surface);
    fail_unless_equals_string(t.header.algorithm, "truth");
    fail_unless_equals_string(t.header.source, "sim");
    fail_unless_equals_uint64(t.header.frame, n);
    fail_unless_equals_int(t.header.width, 640);
    fail_unless_equals_int(t.header.tracked_height, 480);
    fail_unless_equals_int(t.header.n_features, static_cast<int>(expected.size()));
    for (std::size_t i = 0; i < expected.size(); ++i) {
      fail_unless_equals_int(t.features[i].id, static_cast<int>(i));
      fail_unless(t.features[i].x == expected[i].x && t.features[i].y == expected[i].y);
      fail_unless_equals_string(t.features[i].state, word(expected[i].visibility));
      const bool seen = expected[i].visibility == csd::sim::Visibility::visible;
      fail_unless(t.features[i].confidence == (seen ? 1.0 : 0.0));
    }
    gst_buffer_unref(buffer);
  }
}
GST_END_TEST;

GST_START_TEST(test_given_points) {
  Harness h("points=\"100.5,80;-20,10;320,240\" features=7");
  GstBuffer *buffer = h.pull();
  const Truth t = truth_of(buffer);
  fail_unless_equals_int(t.header.n_features, 3);
  const double expected[3][2] = {{100.5, 80}, {-20, 10}, {320, 240}};
  for (guint i = 0; i < 3; ++i) {
    fail_unless(std::abs(t.features[i].x - expected[i][0]) < 1e-6 && std::abs(t.features[i].y - expected[i][1]) < 1e-6);
    fail_unless_equals_string(t.features[i].state, i == 1 ? "out" : "tracked");
  }
  gst_buffer_unref(buffer);

  Harness few("features=7");
  buffer = few.pull();
  fail_unless_equals_int(truth_of(buffer).header.n_features, 7);
  gst_buffer_unref(buffer);
}
GST_END_TEST;

GST_START_TEST(test_caps_set_size_rate_and_format) {
  struct Case {
    const char *format;
    int width, height;
  };
  for (const Case &c : {Case{"I420", 321, 239},
                        {"NV12", 640, 480},
                        {"GRAY8", 200, 100},
                        {"v210", 320, 240},
                        {"BGR", 333, 200},
                        {"RGBx", 320, 240},
                        {"P010_10LE", 320, 240},
                        {"UYVY", 320, 240},
                        {"GRAY16_LE", 320, 240},
                        {"r210", 320, 240}}) {
    const std::string caps = std::string("video/x-raw,format=") + c.format + ",width=" + std::to_string(c.width) +
                             ",height=" + std::to_string(c.height) + ",framerate=30000/1001";
    Harness h("features=5", caps.c_str());
    GstBuffer *buffer = h.pull();
    GstCaps *got = gst_pad_get_current_caps(h.h->sinkpad);
    GstVideoInfo info;
    fail_unless(gst_video_info_from_caps(&info, got));
    gst_caps_unref(got);
    fail_unless_equals_int(info.width, c.width);
    fail_unless_equals_int(info.height, c.height);
    fail_unless_equals_string(gst_video_format_to_string(GST_VIDEO_INFO_FORMAT(&info)), c.format);
    fail_unless_equals_uint64(gst_buffer_get_size(buffer), info.size);
    fail_unless_equals_int(truth_of(buffer).header.width, c.width);
    gst_buffer_unref(buffer);
    buffer = h.pull();
    fail_unless_equals_uint64(GST_BUFFER_PTS(buffer), gst_util_uint64_scale(GST_SECOND, 1001, 30000));
    // Tissue, not a flat colour: the converted frame equals the rendered one.
    GstVideoFrame frame;
    fail_unless(gst_video_frame_map(&frame, &info, buffer, GST_MAP_READ));
    int lowest = 255, highest = 0;
    for (int x = 0; x < c.width; ++x) {
      const int v =
          static_cast<const guint8 *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0))[c.height / 2 * frame.info.stride[0] + x];
      lowest = MIN(lowest, v);
      highest = MAX(highest, v);
    }
    gst_video_frame_unmap(&frame);
    fail_unless(highest - lowest > 20, "%s", c.format);
    gst_buffer_unref(buffer);
  }
}
GST_END_TEST;

GST_START_TEST(test_interlaced_output_is_flagged) {
  Harness h("effects=interlacing,heart-strong features=0");
  GstBuffer *buffer = h.pull();
  GstCaps *caps = gst_pad_get_current_caps(h.h->sinkpad);
  GstVideoInfo info;
  fail_unless(gst_video_info_from_caps(&info, caps));
  gst_caps_unref(caps);
  fail_unless_equals_int(GST_VIDEO_INFO_INTERLACE_MODE(&info), GST_VIDEO_INTERLACE_MODE_INTERLEAVED);
  fail_unless_equals_int(GST_VIDEO_INFO_FIELD_ORDER(&info), GST_VIDEO_FIELD_ORDER_TOP_FIELD_FIRST);
  fail_unless(GST_BUFFER_FLAG_IS_SET(buffer, GST_VIDEO_BUFFER_FLAG_INTERLACED));
  fail_unless(GST_BUFFER_FLAG_IS_SET(buffer, GST_VIDEO_BUFFER_FLAG_TFF));
  fail_unless_equals_int(truth_of(buffer).header.n_features, 0);
  gst_buffer_unref(buffer);
}
GST_END_TEST;

GST_START_TEST(test_errors_are_described) {
  const std::string effects = error_of("effects=\"tools=1,smok=1\"");
  fail_unless(effects.find("\"smok\"") != effects.npos && effects.find("smoke") != effects.npos, "%s", effects.c_str());
  const std::string strength = error_of("effects=tools=9");
  fail_unless(strength.find("from 0 to 4") != strength.npos, "%s", strength.c_str());
  const std::string points = error_of("points=1,2,3");
  fail_unless(points.find("points") != points.npos, "%s", points.c_str());
  const std::string nowhere = error_of("points=\"5,5;50,-1e9\"");
  fail_unless(nowhere.find("50,-1e+09") != nowhere.npos, "%s", nowhere.c_str());
  for (const char *file : {"/no/such/file.png", "/dev/null"}) {
    const std::string texture = error_of(std::string("texture=") + file);
    fail_unless(texture.find(file) != texture.npos, "%s", texture.c_str());
  }
  const std::string none = error_of("features=3");
  fail_unless_equals_string(none.c_str(), "");
}
GST_END_TEST;

GST_START_TEST(test_a_texture_that_refers_to_other_files_is_refused) {
  g_autofree gchar *folder = g_dir_make_tmp("csdsimsrc-XXXXXX", nullptr);
  for (const char *content :
       {"#EXTM3U\n#EXT-X-VERSION:3\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\nhttp://127.0.0.1:9/a.ts\n",
        "<?xml version=\"1.0\"?>\n<MPD xmlns=\"urn:mpeg:dash:schema:mpd:2011\">\n"}) {
    g_autofree gchar *file = g_build_filename(folder, "picture.png", nullptr);
    fail_unless(g_file_set_contents(file, content, -1, nullptr));
    const std::string error = error_of(std::string("texture=") + file);
    fail_unless(error.find("is not a picture") != error.npos, "%s", error.c_str());
    g_remove(file);
  }
  g_rmdir(folder);
}
GST_END_TEST;

GST_START_TEST(test_a_texture_whose_name_is_not_utf8) {
  // The file exists but holds no picture. For a missing file, filesrc itself posts a message that is not UTF-8.
  g_autofree gchar *folder = g_dir_make_tmp("csdsimsrc-XXXXXX", nullptr);
  g_autofree gchar *file = g_build_filename(folder, "\xe9.png", nullptr);
  fail_unless(g_file_set_contents(file, "picture", -1, nullptr));
  GstElement *source = gst_element_factory_make("csdsimsrc", nullptr);
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(source, bus);
  g_object_set(source, "texture", file, nullptr);
  gst_element_set_state(source, GST_STATE_PAUSED);
  GstMessage *message = gst_bus_timed_pop_filtered(bus, GST_CLOCK_TIME_NONE, GST_MESSAGE_ERROR);
  fail_unless(message != nullptr);
  GError *error = nullptr;
  gst_message_parse_error(message, &error, nullptr);
  fail_unless(g_utf8_validate(error->message, -1, nullptr));
  g_error_free(error);
  gst_message_unref(message);
  g_remove(file);
  g_rmdir(folder);
  gst_element_set_state(source, GST_STATE_NULL);
  gst_element_set_bus(source, nullptr);
  gst_object_unref(bus);
  gst_object_unref(source);
}
GST_END_TEST;

GST_START_TEST(test_seek) {
  GstElement *pipeline = gst_parse_launch(
      "csdsimsrc seed=4 style=bowel features=5 ! fakesink name=sink signal-handoffs=true sync=false", nullptr);
  GstElement *sink = gst_bin_get_by_name(GST_BIN(pipeline), "sink");
  gst_element_set_state(pipeline, GST_STATE_PAUSED);
  gst_element_get_state(pipeline, nullptr, nullptr, GST_CLOCK_TIME_NONE);
  fail_unless(gst_element_seek(
      pipeline, 1, GST_FORMAT_TIME, static_cast<GstSeekFlags>(GST_SEEK_FLAG_FLUSH | GST_SEEK_FLAG_ACCURATE),
      GST_SEEK_TYPE_SET, 3 * GST_SECOND, GST_SEEK_TYPE_SET, 3 * GST_SECOND + 200 * GST_MSECOND));
  gst_element_get_state(pipeline, nullptr, nullptr, GST_CLOCK_TIME_NONE);
  GstSample *sample = nullptr;
  g_object_get(sink, "last-sample", &sample, nullptr);
  GstBuffer *buffer = gst_sample_get_buffer(sample);
  fail_unless_equals_uint64(GST_BUFFER_OFFSET(buffer), 75);
  fail_unless_equals_uint64(GST_BUFFER_PTS(buffer), 3 * GST_SECOND);
  csd::sim::Simulator sim = simulator("", csd::sim::Scenario::deformation);
  cv::Mat picture;
  sim.render(75, picture);
  fail_unless(same_pixels(buffer, picture));
  gst_sample_unref(sample);

  // Five frames to the end of the segment.
  play_to_end(pipeline);
  g_object_get(sink, "last-sample", &sample, nullptr);
  fail_unless_equals_uint64(GST_BUFFER_OFFSET(gst_sample_get_buffer(sample)), 79);
  gst_sample_unref(sample);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(sink);
  gst_object_unref(pipeline);
}
GST_END_TEST;

GST_START_TEST(test_live_frames_come_at_their_time) {
  GstElement *pipeline = gst_parse_launch(
      "csdsimsrc name=sim is-live=true features=0 num-buffers=6 ! video/x-raw,width=160,height=120,framerate=20/1 ! "
      "fakesink name=sink sync=true",
      nullptr);
  GstElement *sink = gst_bin_get_by_name(GST_BIN(pipeline), "sink");
  GstElement *sim = gst_bin_get_by_name(GST_BIN(pipeline), "sim");
  GstQuery *latency = gst_query_new_latency();
  fail_unless_equals_int(gst_element_set_state(pipeline, GST_STATE_PAUSED), GST_STATE_CHANGE_NO_PREROLL);
  fail_if(gst_element_query(sim, latency), "the framerate isn't known yet");
  play_to_end(pipeline);  // the sink would warn about a source with too little latency
  gboolean live = FALSE;
  GstClockTime least = 0, most = 0;
  fail_unless(gst_element_query(sim, latency));
  gst_query_parse_latency(latency, &live, &least, &most);
  fail_unless(live && least == 50 * GST_MSECOND && most == GST_CLOCK_TIME_NONE);
  GstSample *sample = nullptr;
  g_object_get(sink, "last-sample", &sample, nullptr);
  const GstClockTime last = GST_BUFFER_PTS(gst_sample_get_buffer(sample));
  // The clock has reached the last frame's time. The first frame is not from before the scene was made.
  GstClock *clock = gst_element_get_clock(pipeline);
  fail_unless(gst_clock_get_time(clock) - gst_element_get_base_time(pipeline) >= last);
  fail_unless(last > 250 * GST_MSECOND);
  gst_object_unref(clock);
  gst_sample_unref(sample);
  gst_query_unref(latency);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(sim);
  gst_object_unref(sink);
  gst_object_unref(pipeline);
}
GST_END_TEST;

GST_START_TEST(test_tracks_and_truth_on_one_frame) {
  GstHarness *h = gst_harness_new_parse("csdsimsrc num-buffers=3 features=10 ! csdtrack name=tracker learning=sync");
  gst_harness_play(h);
  for (int i = 0; i < 3; ++i) {
    GstBuffer *buffer = pull(h);
    fail_unless(gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, "tracker") != nullptr);
    fail_unless_equals_int(truth_of(buffer).header.n_features, 10);
    gst_buffer_unref(buffer);
  }
  gst_harness_teardown(h);
}
GST_END_TEST;

GST_START_TEST(test_csdtrack_starts_from_the_truth) {
  // The third point is hidden by the field stop, the fourth is outside.
  GstHarness *h = gst_harness_new_parse(
      "csdsimsrc num-buffers=20 effects=field-stop points=\"200,200;300.5,120.25;2,2;-50,100;350,300\" "
      "! csdtrack name=tracker algorithm=lk points=truth");
  gst_harness_play(h);
  const guint ids[] = {0, 1, 4};
  for (int n = 0; n < 20; ++n) {
    GstBuffer *buffer = pull(h);
    const GstStructure *s = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, "tracker");
    GstCsdHeader header;
    fail_unless(s && gst_csd_structure_get_header(s, &header));
    fail_unless_equals_int(header.n_features, 3);
    const Truth t = truth_of(buffer);
    for (guint i = 0; i < 3; ++i) {
      GstCsdFeature f;
      fail_unless(gst_csd_structure_get_feature(s, i, &f));
      fail_unless_equals_int(f.id, ids[i]);
      const GstCsdFeature &truth = t.features[ids[i]];
      fail_unless(std::hypot(f.x - truth.x, f.y - truth.y) < (n == 0 ? 1e-9 : 2), "frame %d, %u", n, f.id);
    }
    gst_buffer_unref(buffer);
  }
  gst_harness_teardown(h);
}
GST_END_TEST;

GST_START_TEST(test_csdtrack_reports_missing_truth) {
  GstElement *pipeline = gst_parse_launch("videotestsrc num-buffers=3 ! csdtrack points=truth ! fakesink", nullptr);
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  GstBus *bus = gst_element_get_bus(pipeline);
  int warnings = 0;
  for (bool more = true; more;) {
    GstMessage *message = gst_bus_timed_pop_filtered(
        bus, GST_CLOCK_TIME_NONE,
        static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_WARNING | GST_MESSAGE_ERROR));
    fail_unless(message && GST_MESSAGE_TYPE(message) != GST_MESSAGE_ERROR);
    warnings += GST_MESSAGE_TYPE(message) == GST_MESSAGE_WARNING;
    more = GST_MESSAGE_TYPE(message) != GST_MESSAGE_EOS;
    gst_message_unref(message);
  }
  fail_unless_equals_int(warnings, 1);
  gst_object_unref(bus);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(pipeline);
}
GST_END_TEST;

static Suite *csdsimsrc_suite() {
  Suite *s = suite_create("csdsimsrc");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  tcase_add_test(tc, test_frames_and_truth_equal_the_simulators);
  tcase_add_test(tc, test_given_points);
  tcase_add_test(tc, test_caps_set_size_rate_and_format);
  tcase_add_test(tc, test_interlaced_output_is_flagged);
  tcase_add_test(tc, test_errors_are_described);
  tcase_add_test(tc, test_a_texture_that_refers_to_other_files_is_refused);
  tcase_add_test(tc, test_a_texture_whose_name_is_not_utf8);
  tcase_add_test(tc, test_seek);
  tcase_add_test(tc, test_live_frames_come_at_their_time);
  tcase_add_test(tc, test_tracks_and_truth_on_one_frame);
  tcase_add_test(tc, test_csdtrack_starts_from_the_truth);
  tcase_add_test(tc, test_csdtrack_reports_missing_truth);
  return s;
}

GST_CHECK_MAIN(csdsimsrc)
