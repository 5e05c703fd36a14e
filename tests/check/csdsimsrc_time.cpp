// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdsimsrc: its time. A new rate in mid-stream, playing backwards, queries, and settings that stay while it runs.
#include "sim/simulator.h"

#include <cmath>
#include <string>
#include <vector>

#include "meta/csdtrackmeta.h"

// Defines a macro fail(), so it comes after headers with a function of that name.
#include <gst/base/gstbasesrc.h>
#include <gst/check/gstcheck.h>

namespace {

constexpr char points[] = "20,20;40.5,30;50,12";
constexpr auto ms = GST_MSECOND;

struct Feature {
  double x, y;
};

/// A frame as it came out.
struct Frame {
  GstClockTime pts, duration;
  guint64 offset, number;  ///< the number is the truth's
  bool discont;
  std::vector<Feature> features;
};

/// The element `sim`, a capsfilter `caps` and a sink. Its frames are written down.
struct Play {
  GstElement *pipeline, *sim;
  std::vector<Frame> frames;
  guint change_at = 0;    ///< after so many frames…
  std::string change_to;  ///< …to these caps
  explicit Play(const std::string &properties, const char *rate, const char *sync = "false") {
    pipeline = gst_parse_launch(
        ("csdsimsrc name=sim points=\"" + std::string(points) + "\" " + properties +
         " ! capsfilter name=caps caps=" + caps_of(rate) + " ! fakesink name=sink signal-handoffs=true sync=" + sync)
            .c_str(),
        nullptr);
    sim = gst_bin_get_by_name(GST_BIN(pipeline), "sim");
    GstElement *sink = gst_bin_get_by_name(GST_BIN(pipeline), "sink");
    g_signal_connect(sink, "handoff", G_CALLBACK(+[](GstElement *, GstBuffer *b, GstPad *, Play *p) { p->take(b); }),
                     this);
    gst_object_unref(sink);
  }
  ~Play() {
    gst_element_set_state(pipeline, GST_STATE_NULL);
    gst_object_unref(sim);
    gst_object_unref(pipeline);
  }
  static std::string caps_of(const char *rate) {
    return std::string("video/x-raw,format=BGR,width=64,height=48,framerate=") + rate;
  }
  void take(GstBuffer *buffer) {
    const GstStructure *s = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRUTH_META_NAME, nullptr);
    GstCsdHeader header;
    fail_unless(s && gst_csd_structure_get_header(s, &header));
    Frame frame{GST_BUFFER_PTS(buffer),
                GST_BUFFER_DURATION(buffer),
                GST_BUFFER_OFFSET(buffer),
                header.frame,
                bool(GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DISCONT)),
                {}};
    for (guint i = 0; i < header.n_features; ++i) {
      GstCsdFeature f;
      fail_unless(gst_csd_structure_get_feature(s, i, &f));
      frame.features.push_back({f.x, f.y});
    }
    frames.push_back(frame);
    if (frames.size() == change_at) set_caps(change_to.c_str());
  }
  void set_caps(const char *rate) {
    GstElement *filter = gst_bin_get_by_name(GST_BIN(pipeline), "caps");
    gst_util_set_object_arg(G_OBJECT(filter), "caps", caps_of(rate).c_str());
    gst_object_unref(filter);
  }
  void preroll() {
    gst_element_set_state(pipeline, GST_STATE_PAUSED);
    gst_element_get_state(pipeline, nullptr, nullptr, GST_CLOCK_TIME_NONE);
  }
  bool seek(double rate, GstClockTime start, GstClockTime stop) {
    const auto flags = static_cast<GstSeekFlags>(GST_SEEK_FLAG_FLUSH | GST_SEEK_FLAG_ACCURATE);
    return gst_element_seek(pipeline, rate, GST_FORMAT_TIME, flags, GST_SEEK_TYPE_SET, gint64(start), GST_SEEK_TYPE_SET,
                            gint64(stop));
  }
  /// Plays to EOS; returns the number of LATENCY messages of the element.
  int to_end() {
    gst_element_set_state(pipeline, GST_STATE_PLAYING);
    GstBus *bus = gst_element_get_bus(pipeline);
    int latencies = 0;
    for (bool more = true; more;) {
      GstMessage *message = gst_bus_timed_pop(bus, GST_CLOCK_TIME_NONE);
      fail_unless(GST_MESSAGE_TYPE(message) != GST_MESSAGE_ERROR);
      more = GST_MESSAGE_TYPE(message) != GST_MESSAGE_EOS;
      latencies += GST_MESSAGE_TYPE(message) == GST_MESSAGE_LATENCY && GST_MESSAGE_SRC(message) == GST_OBJECT(sim);
      gst_message_unref(message);
    }
    gst_object_unref(bus);
    return latencies;
  }
};

/// The truth at any time: that of a simulator with a frame every 10 ms.
struct Truth {
  csd::sim::Simulator simulator;
  std::vector<cv::Point2d> surface;
  Truth() : simulator(settings()) {
    const cv::Point2d pixels[] = {{20, 20}, {40.5, 30}, {50, 12}};
    surface = simulator.on_surface(0, pixels);
  }
  static csd::sim::SimSettings settings() {
    csd::sim::SimSettings s;
    s.size = {64, 48};
    s.rate = 100;
    return s;
  }
  void check(const Frame &frame) {
    fail_unless_equals_uint64(frame.pts % (10 * ms), 0);
    const auto expected = simulator.truth(frame.pts / (10 * ms), surface);
    fail_unless_equals_int(frame.features.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      fail_unless(
          std::abs(frame.features[i].x - expected[i].x) < 1e-6 && std::abs(frame.features[i].y - expected[i].y) < 1e-6,
          "at %u ms: %f,%f for %f,%f", unsigned(frame.pts / ms), frame.features[i].x, frame.features[i].y,
          expected[i].x, expected[i].y);
  }
};

}  // namespace

GST_START_TEST(a_new_rate_goes_on_in_time) {
  Play play("num-buffers=20", "10/1");
  play.change_at = 10;
  play.change_to = "50/1";
  play.to_end();
  fail_unless_equals_int(play.frames.size(), 20);
  Truth truth;
  for (guint64 n = 0; n < 20; ++n) {
    const Frame &frame = play.frames[n];
    fail_unless_equals_uint64(frame.pts, n < 10 ? n * 100 * ms : 1000 * ms + (n - 10) * 20 * ms);
    fail_unless_equals_uint64(frame.duration, n < 10 ? 100 * ms : 20 * ms);
    fail_unless_equals_uint64(frame.offset, n);
    fail_unless_equals_uint64(frame.number, n);
    truth.check(frame);
  }
}
GST_END_TEST

/// After a seek, frames are counted from the start of the stream at the present rate.
GST_START_TEST(a_seek_after_a_new_rate) {
  Play play("num-buffers=30", "10/1");
  play.change_at = 10;
  play.change_to = "50/1";
  play.preroll();
  play.frames.clear();
  fail_unless(play.seek(1, 0, 1100 * ms));
  play.to_end();
  fail_unless_equals_int(play.frames.size(), 15);
  play.frames.clear();
  fail_unless(play.seek(1, 1100 * ms, 1200 * ms));
  play.to_end();
  fail_unless_equals_int(play.frames.size(), 5);
  Truth truth;
  for (guint64 n = 0; n < 5; ++n) {
    fail_unless_equals_uint64(play.frames[n].pts, 1100 * ms + n * 20 * ms);
    fail_unless_equals_uint64(play.frames[n].offset, 55 + n);
    truth.check(play.frames[n]);
  }
}
GST_END_TEST

GST_START_TEST(a_new_rate_of_a_live_source_is_another_latency) {
  Play play("num-buffers=12 is-live=true", "20/1", "true");
  play.change_at = 6;
  play.change_to = "50/1";
  fail_unless_equals_int(play.to_end(), 2);  // of the first rate, and of the second
  GstQuery *latency = gst_query_new_latency();
  gboolean live = FALSE;
  GstClockTime least = 0;
  fail_unless(gst_element_query(play.sim, latency));
  gst_query_parse_latency(latency, &live, &least, nullptr);
  fail_unless(live);
  fail_unless_equals_uint64(least, 20 * ms);
  gst_query_unref(latency);
  for (std::size_t n = 1; n < 12; ++n)
    fail_unless_equals_uint64(play.frames[n].pts - play.frames[n - 1].pts, (n <= 6 ? 50 : 20) * ms);
}
GST_END_TEST

GST_START_TEST(backwards_frames_come_from_the_last_to_the_first) {
  Play play("", "25/1");
  play.preroll();
  play.frames.clear();
  fail_unless(play.seek(-1, 100 * ms, 400 * ms));
  play.to_end();
  // Frames 9 (360…400 ms) to 2 (80…120 ms).
  fail_unless_equals_int(play.frames.size(), 8);
  Truth truth;
  for (guint64 i = 0; i < 8; ++i) {
    const Frame &frame = play.frames[i];
    fail_unless_equals_uint64(frame.offset, 9 - i);
    fail_unless_equals_uint64(frame.pts, (9 - i) * 40 * ms);
    fail_unless_equals_uint64(frame.duration, 40 * ms);
    fail_unless(frame.discont);
    truth.check(frame);
  }
  // From within a frame, to the first one; then forwards again.
  play.frames.clear();
  fail_unless(play.seek(-1, 0, 110 * ms));
  play.to_end();
  fail_unless_equals_int(play.frames.size(), 3);
  for (guint64 i = 0; i < 3; ++i) fail_unless_equals_uint64(play.frames[i].offset, 2 - i);
  play.frames.clear();
  fail_unless(play.seek(1, 40 * ms, 120 * ms));
  play.to_end();
  fail_unless_equals_int(play.frames.size(), 2);
  fail_unless_equals_uint64(play.frames[0].offset, 1);
}
GST_END_TEST

GST_START_TEST(backwards_from_the_end_and_at_a_new_rate) {
  Play play("num-buffers=10", "10/1");
  play.preroll();
  play.frames.clear();
  play.change_at = 5;
  play.change_to = "50/1";
  fail_unless(play.seek(-1, 0, GST_CLOCK_TIME_NONE));
  play.to_end();
  // One was shown before the seek: nine are left, 900, 800, …500 ms, then at the new rate 480, 460, …
  fail_unless_equals_int(play.frames.size(), 9);
  Truth truth;
  for (guint64 i = 0; i < 9; ++i) {
    fail_unless_equals_uint64(play.frames[i].pts, i < 5 ? (9 - i) * 100 * ms : 500 * ms - (i - 4) * 20 * ms);
    truth.check(play.frames[i]);
  }
  Play endless("", "10/1");
  endless.preroll();
  fail_if(endless.seek(-1, 0, GST_CLOCK_TIME_NONE), "there is no end to begin at");
}
GST_END_TEST

GST_START_TEST(queries) {
  Play play("num-buffers=100", "25/1");
  gint64 value = 0;
  const auto unknown = [&value](const Play &p) {
    return !gst_element_query_duration(p.sim, GST_FORMAT_TIME, &value) || value == -1;
  };
  fail_unless(unknown(play), "the rate isn't known yet");
  play.preroll();
  fail_unless(gst_element_query_duration(play.pipeline, GST_FORMAT_TIME, &value));
  fail_unless_equals_int64(value, 4 * GST_SECOND);
  fail_unless(gst_element_query_duration(play.sim, GST_FORMAT_DEFAULT, &value));
  fail_unless_equals_int64(value, 100);
  fail_unless(gst_element_query_duration(play.sim, GST_FORMAT_BYTES, &value));
  fail_unless_equals_int64(value, 100 * 64 * 48 * 3);
  const struct {
    GstFormat from;
    gint64 value;
    GstFormat to;
    gint64 expected;
  } conversions[] = {{GST_FORMAT_DEFAULT, 50, GST_FORMAT_TIME, 2 * GST_SECOND},
                     {GST_FORMAT_TIME, 3 * GST_SECOND, GST_FORMAT_DEFAULT, 75},
                     {GST_FORMAT_BYTES, 64 * 48 * 3 * 5, GST_FORMAT_TIME, 200 * gint64(ms)}};
  for (const auto &c : conversions) {
    fail_unless(gst_element_query_convert(play.sim, c.from, c.value, c.to, &value));
    fail_unless_equals_int64(value, c.expected);
  }
  Play endless("", "25/1");
  endless.preroll();
  fail_unless(unknown(endless));
}
GST_END_TEST

GST_START_TEST(settings_stay_while_it_runs) {
  Play play("effects=noise=1 seed=4", "25/1");
  play.preroll();
  g_object_set(play.sim, "effects", "interlacing=1", "seed", guint64{5}, "is-live", TRUE, "points", "", "features", 3u,
               "strength", 2., "texture", "none", nullptr);
  gst_util_set_object_arg(G_OBJECT(play.sim), "scenario", "zoom");
  gst_util_set_object_arg(G_OBJECT(play.sim), "style", "liver");
  const auto text = [&](const char *name) {
    GValue value = G_VALUE_INIT;
    g_object_get_property(G_OBJECT(play.sim), name, &value);
    gchar *serialized = gst_value_serialize(&value);
    const std::string out = serialized;
    g_free(serialized);
    g_value_unset(&value);
    return out;
  };
  const std::pair<const char *, const char *> before[] = {
      {"effects", "\"noise\\=1\""}, {"seed", "4"},     {"is-live", "false"},
      {"features", "100"},          {"strength", "1"}, {"texture", "\"\""},
      {"scenario", "deformation"},  {"style", "heart"}};
  for (const auto &[name, value] : before) fail_unless(text(name) == value, "%s: %s", name, text(name).c_str());
  fail_unless(text("points").find("40.5") != std::string::npos);

  gst_element_set_state(play.pipeline, GST_STATE_READY);
  g_object_set(play.sim, "effects", nullptr, "seed", guint64{5}, "is-live", TRUE, nullptr);
  fail_unless(text("effects") == "\"\"" && text("seed") == "5" && text("is-live") == "true");
  fail_unless(gst_base_src_is_live(GST_BASE_SRC(play.sim)));
}
GST_END_TEST

static Suite *csdsimsrc_time_suite() {
  Suite *s = suite_create("csdsimsrc_time");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  tcase_add_test(tc, a_new_rate_goes_on_in_time);
  tcase_add_test(tc, a_seek_after_a_new_rate);
  tcase_add_test(tc, a_new_rate_of_a_live_source_is_another_latency);
  tcase_add_test(tc, backwards_frames_come_from_the_last_to_the_first);
  tcase_add_test(tc, backwards_from_the_end_and_at_a_new_rate);
  tcase_add_test(tc, queries);
  tcase_add_test(tc, settings_stay_while_it_runs);
  return s;
}

GST_CHECK_MAIN(csdsimsrc_time)
