// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack's errors. The element is linked with an algorithm that fails on demand, which replaces
// core/algorithms/make_algorithm.cpp.
#include <atomic>
#include <cmath>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>

#include "algorithms/make_algorithm.h"
#include "elements/csdtrack.h"
#include "meta/csdtrackmeta.h"
#include "track/algorithm.h"

// After all C++ headers: Check has a macro `fail`.
#include <gst/check/gstcheck.h>
#include <gst/check/gstharness.h>

namespace {

enum class Trouble { none, opencv, memory, runtime, number, construction };
std::atomic<Trouble> trouble = Trouble::none;

/// Where the failure happens: in one of the calls below, or in csdtrack's own access to the pixels.
enum class Stage { track, begin, finish, end, forget, statistics, pixels };
std::atomic<Stage> stage = Stage::track;

void fail_as_asked(Stage here) {
  if (here != stage) return;
  switch (trouble) {
    case Trouble::opencv:
      CV_Error(cv::Error::StsAssert, "planted");
    case Trouble::memory:
      throw std::bad_alloc();
    case Trouble::runtime:
      throw std::runtime_error("planted");
    case Trouble::number:
      throw 42;
    default:
      break;
  }
}

/// Finds every feature where it was, and none after a jump.
class Fragile : public csd::Algorithm {
 public:
  void track(const csd::FrameContext &context, std::vector<csd::Claim> &claims) override {
    fail_as_asked(Stage::track);
    for (auto &claim : claims) claim.kind = context.jumped ? csd::Claim::Kind::hidden : csd::Claim::Kind::tracked;
  }
  csd::Claim::Kind begin(csd::FeatureId, cv::Point2d, const csd::FrameContext &) override {
    fail_as_asked(Stage::begin);
    return csd::Claim::Kind::learning;
  }
  void end(csd::FeatureId) override { fail_as_asked(Stage::end); }
  void finish(const csd::FrameContext &) override { fail_as_asked(Stage::finish); }
  void forget() override { fail_as_asked(Stage::forget); }
  void add_to(csd::Stats &) const override { fail_as_asked(Stage::statistics); }
};

GstBuffer *noise(int width, int height, int index, int low = 0, int high = 256) {
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, static_cast<gsize>(GST_ROUND_UP_4(width)) * height, nullptr);
  GstMapInfo map;
  gst_buffer_map(buffer, &map, GST_MAP_WRITE);
  GRand *random = g_rand_new_with_seed(static_cast<guint32>(index));
  for (gsize i = 0; i < map.size; ++i) map.data[i] = static_cast<guint8>(g_rand_int_range(random, low, high));
  g_rand_free(random);
  gst_buffer_unmap(buffer, &map);
  GST_BUFFER_PTS(buffer) = index * 40 * GST_MSECOND;
  return buffer;
}

struct Bench {
  GstElement *track;
  GstHarness *h;
  GstBus *bus;
};

Bench bench(int width = 320, int height = 240) {
  auto *track = GST_ELEMENT(g_object_new(GST_TYPE_CSD_TRACK, "name", "csdtrack", nullptr));
  gst_object_ref_sink(track);
  Bench b{track, gst_harness_new_with_element(track, "sink", "src"), gst_bus_new()};
  gst_element_set_bus(track, b.bus);
  gchar *caps = g_strdup_printf("video/x-raw,format=GRAY8,width=%d,height=%d,framerate=25/1", width, height);
  gst_harness_set_src_caps_str(b.h, caps);
  g_free(caps);
  return b;
}

void close(Bench &b) {
  gst_element_set_bus(b.track, nullptr);
  gst_harness_teardown(b.h);
  gst_object_unref(b.bus);
  gst_object_unref(b.track);
}

/// A bench whose element has `property` set from the start: structural ones can't be set later.
Bench bench_with(const char *property, const char *value) {
  auto *track = GST_ELEMENT(g_object_new(GST_TYPE_CSD_TRACK, "name", "csdtrack", nullptr));
  gst_object_ref_sink(track);
  gst_util_set_object_arg(G_OBJECT(track), property, value);
  Bench b{track, gst_harness_new_with_element(track, "sink", "src"), gst_bus_new()};
  gst_element_set_bus(track, b.bus);
  gst_harness_set_src_caps_str(b.h, "video/x-raw,format=GRAY8,width=320,height=240,framerate=25/1");
  return b;
}

int count(GstBus *bus, GstMessageType type) {
  int n = 0;
  while (GstMessage *message = gst_bus_pop_filtered(bus, type)) {
    ++n;
    gst_message_unref(message);
  }
  return n;
}

guint features_in(GstBuffer *buffer, const char *state) {
  GstCsdHeader header;
  const GstStructure *s = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, nullptr);
  fail_unless(s != nullptr && gst_csd_structure_get_header(s, &header));
  guint n = 0;
  for (guint i = 0; i < header.n_features; ++i) {
    GstCsdFeature f;
    fail_unless(gst_csd_structure_get_feature(s, i, &f));
    fail_unless(std::isfinite(f.x) && std::isfinite(f.y) && std::isfinite(f.confidence));
    n += !state || std::strcmp(f.state, state) == 0;
  }
  return n;
}

guint pushed(Bench &b, GstBuffer *in, const char *state = nullptr) {
  GstBuffer *out = gst_harness_push_and_pull(b.h, in);
  fail_unless(out != nullptr);
  const guint n = features_in(out, state);
  gst_buffer_unref(out);
  return n;
}

}  // namespace

std::unique_ptr<csd::Algorithm> csd::make_algorithm(const Settings &, Executor &) {
  if (trouble == Trouble::construction) throw std::runtime_error("planted");
  return std::make_unique<Fragile>();
}

GST_START_TEST(an_exception_is_an_element_error) {
  for (const Trouble t : {Trouble::opencv, Trouble::memory, Trouble::runtime, Trouble::number}) {
    trouble = Trouble::none;
    Bench b = bench_with("points", "100,100");
    fail_unless_equals_int(pushed(b, noise(320, 240, 0)), 1);
    trouble = t;
    fail_unless_equals_int(gst_harness_push(b.h, noise(320, 240, 1)), GST_FLOW_ERROR);
    GstMessage *message = gst_bus_pop_filtered(b.bus, GST_MESSAGE_ERROR);
    fail_unless(message != nullptr);
    GError *error = nullptr;
    g_autofree gchar *debug = nullptr;
    gst_message_parse_error(message, &error, &debug);
    fail_unless(std::strstr(debug, "csdtrack.cpp(") != nullptr, "the error names another place: %s", debug);
    // The text says what to change.
    fail_unless(std::strstr(error->message, t == Trouble::memory ? "max-features" : "on-error=pass") != nullptr);
    const bool memory = t == Trouble::memory;
    fail_unless(g_error_matches(
        error, memory ? GST_RESOURCE_ERROR : GST_LIBRARY_ERROR,
        memory ? static_cast<int>(GST_RESOURCE_ERROR_FAILED) : static_cast<int>(GST_LIBRARY_ERROR_FAILED)));
    g_error_free(error);
    gst_message_unref(message);
    fail_unless_equals_int(count(b.bus, GST_MESSAGE_ERROR), 0);
    close(b);
  }
  trouble = Trouble::none;
}
GST_END_TEST

GST_START_TEST(on_error_pass_warns_once_and_passes_frames_unchanged) {
  Bench b = bench_with("points", "100,100;200,100");
  gst_util_set_object_arg(G_OBJECT(b.track), "on-error", "pass");
  gst_util_set_object_arg(G_OBJECT(b.track), "overlay", "draw");
  fail_unless_equals_int(pushed(b, noise(320, 240, 0), "learning"), 2);
  trouble = Trouble::opencv;
  for (int i = 1; i < 4; ++i) {
    GstBuffer *in = noise(320, 240, i), *same = noise(320, 240, i);
    GstBuffer *out = gst_harness_push_and_pull(b.h, in);
    fail_unless(out != nullptr);
    fail_unless_equals_int(features_in(out, "lost"), 2);
    GstMapInfo map;
    gst_buffer_map(same, &map, GST_MAP_READ);
    gst_check_buffer_data(out, map.data, map.size);
    gst_buffer_unmap(same, &map);
    gst_buffer_unref(same);
    gst_buffer_unref(out);
  }
  GstMessage *warning = gst_bus_pop_filtered(b.bus, GST_MESSAGE_WARNING);
  fail_unless(warning != nullptr);
  GError *text = nullptr;
  gst_message_parse_warning(warning, &text, nullptr);
  fail_unless(std::strstr(text->message, "on-error") == nullptr, "advises a setting that is already set: %s",
              text->message);
  g_error_free(text);
  gst_message_unref(warning);
  fail_unless_equals_int(count(b.bus, static_cast<GstMessageType>(GST_MESSAGE_WARNING | GST_MESSAGE_ERROR)), 0);
  trouble = Trouble::none;
  fail_unless_equals_int(pushed(b, noise(320, 240, 4), "tracked"), 2);  // it recovers
  GstStructure *stats = nullptr;
  g_object_get(b.track, "stats", &stats, nullptr);
  guint64 frames = 0, failed = 0;
  gst_structure_get(stats, "frames", G_TYPE_UINT64, &frames, "failed-frames", G_TYPE_UINT64, &failed, nullptr);
  fail_unless_equals_uint64(frames, 5);
  fail_unless_equals_uint64(failed, 3);
  gst_structure_free(stats);
  close(b);
}
GST_END_TEST

namespace {

constexpr int recorded_frames = 20, recorded_bytes = 160 * 120 * 3 / 2;

/// Makes the fifth to the ninth frame fail as they reach csdtrack.
GstPadProbeReturn trouble_begins(GstPad *, GstPadProbeInfo *info, gpointer element) {
  auto *track = static_cast<GstElement *>(element);
  GstBuffer *frame = gst_pad_probe_info_get_buffer(info);
  const auto index = GST_BUFFER_OFFSET(frame);
  const bool now = index >= 4 && index < 9;
  trouble = now ? Trouble::runtime : Trouble::none;
  if (now && stage == Stage::pixels) gst_buffer_set_size(frame, 1000);
  guint id = 0;
  g_signal_emit_by_name(track, "add-point", 30. + static_cast<double>(index), 40., &id);
  if (index > 4) g_signal_emit_by_name(track, "remove-point", id - 4);
  if (index == 7) g_signal_emit_by_name(track, "reset");
  GstStructure *stats = nullptr;
  g_object_get(track, "stats", &stats, nullptr);
  if (stats) gst_structure_free(stats);
  return GST_PAD_PROBE_OK;
}

GstPadProbeReturn trouble_ends(GstPad *, GstPadProbeInfo *info, gpointer) {
  if (trouble != Trouble::none && stage == Stage::pixels)
    gst_buffer_set_size(gst_pad_probe_info_get_buffer(info), recorded_bytes);
  return GST_PAD_PROBE_OK;
}

/// The output of a recorder with this element in its pipeline: the encoded stream, each picture with its time.
std::string recorded(const std::string &element, int &warnings) {
  const std::string line = "videotestsrc num-buffers=" + std::to_string(recorded_frames) +
                           " pattern=smpte motion=hsweep ! video/x-raw,format=I420,width=160,height=120 ! " + element +
                           " name=track ! x264enc threads=1 pass=quant rc-lookahead=5 ! appsink name=out sync=false";
  GError *error = nullptr;
  GstElement *pipeline = gst_parse_launch(line.c_str(), &error);
  fail_unless(pipeline != nullptr && error == nullptr, "%s", error ? error->message : "");
  GstElement *track = gst_bin_get_by_name(GST_BIN(pipeline), "track");
  GstElement *out = gst_bin_get_by_name(GST_BIN(pipeline), "out");
  if (element != "identity")
    for (const auto &[name, probe] : {std::pair("sink", &trouble_begins), std::pair("src", &trouble_ends)}) {
      GstPad *pad = gst_element_get_static_pad(track, name);
      gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, probe, track, nullptr);
      gst_object_unref(pad);
    }
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  std::string stream;
  for (GstSample *sample = nullptr; g_signal_emit_by_name(out, "try-pull-sample", 20 * GST_SECOND, &sample), sample;) {
    GstBuffer *buffer = gst_sample_get_buffer(sample);
    GstMapInfo map;
    gst_buffer_map(buffer, &map, GST_MAP_READ);
    stream += std::to_string(GST_BUFFER_PTS(buffer)) + ":";
    stream.append(reinterpret_cast<const char *>(map.data), map.size);
    gst_buffer_unmap(buffer, &map);
    gst_sample_unref(sample);
  }
  trouble = Trouble::none;
  GstBus *bus = gst_element_get_bus(pipeline);
  warnings = count(bus, GST_MESSAGE_WARNING);
  fail_unless_equals_int(count(bus, GST_MESSAGE_ERROR), 0);
  gst_object_unref(bus);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(out);
  gst_object_unref(track);
  gst_object_unref(pipeline);
  return stream;
}

}  // namespace

/// The recording is bit-exact, whichever stage of csdtrack fails for some frames.
GST_START_TEST(a_recording_is_bit_exact_when_any_stage_fails) {
  GstElementFactory *x264 = gst_element_factory_find("x264enc");
  if (!x264) return;
  gst_object_unref(x264);
  int warnings = 0;
  const std::string plain = recorded("identity", warnings);
  fail_unless(plain.size() > 1000);
  fail_unless(recorded("identity", warnings) == plain, "the encoder itself is not deterministic");
  for (const Stage failing :
       {Stage::track, Stage::begin, Stage::finish, Stage::end, Stage::forget, Stage::statistics, Stage::pixels}) {
    stage = failing;
    const bool same = recorded("csdtrack on-error=pass attach-roi=true", warnings) == plain;
    fail_unless(same, "a different stream if stage %d fails", static_cast<int>(failing));
    // Readers of the statistics get none, and no frame suffers.
    fail_unless_equals_int(warnings, failing == Stage::statistics ? 0 : 1);
  }
  stage = Stage::track;
}
GST_END_TEST

GST_START_TEST(a_discontinuity_reaches_the_algorithm) {
  Bench b = bench_with("points", "100,100");
  const auto claimed = [&b](int index, bool discont, GstClockTime gap) {
    GstBuffer *in = noise(320, 240, index);
    GST_BUFFER_DURATION(in) = 40 * GST_MSECOND;
    GST_BUFFER_PTS(in) += gap;
    if (discont) GST_BUFFER_FLAG_SET(in, GST_BUFFER_FLAG_DISCONT);
    return pushed(b, in, index == 0 ? "learning" : "tracked") == 1;
  };
  fail_unless(claimed(0, true, 0));
  fail_unless(claimed(1, false, 0));
  fail_unless(!claimed(2, true, 0));
  fail_unless(claimed(3, false, 500 * GST_MSECOND));
  fail_unless(!claimed(4, false, 1001 * GST_MSECOND));
  fail_unless(!claimed(5, false, 500 * GST_MSECOND));  // backwards
  gst_harness_push_event(b.h, gst_event_new_flush_start());
  gst_harness_push_event(b.h, gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(b.h, gst_event_new_segment(&segment));
  GstBuffer *anew = noise(320, 240, 0);
  GST_BUFFER_FLAG_SET(anew, GST_BUFFER_FLAG_DISCONT);
  fail_unless_equals_int(pushed(b, anew, "learning"), 1);  // of a new stream
  close(b);
}
GST_END_TEST

GST_START_TEST(an_exception_at_start_fails_the_state_change) {
  trouble = Trouble::construction;
  auto *track = GST_ELEMENT(g_object_new(GST_TYPE_CSD_TRACK, nullptr));
  gst_object_ref_sink(track);
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(track, bus);
  fail_unless_equals_int(gst_element_set_state(track, GST_STATE_READY), GST_STATE_CHANGE_SUCCESS);
  fail_unless_equals_int(gst_element_set_state(track, GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
  fail_unless_equals_int(count(bus, GST_MESSAGE_ERROR), 1);
  trouble = Trouble::none;
  fail_unless_equals_int(gst_element_set_state(track, GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
  gst_element_set_state(track, GST_STATE_NULL);
  gst_element_set_bus(track, nullptr);
  gst_object_unref(bus);
  gst_object_unref(track);
}
GST_END_TEST

GST_START_TEST(a_gap_buffer_loses_features_and_half_a_frame_is_an_error) {
  // A buffer marked as a gap is no error: features are lost, nothing more.
  Bench b = bench_with("points", "100,100");
  fail_unless_equals_int(pushed(b, noise(320, 240, 0)), 1);
  GstBuffer *gap = gst_buffer_new();
  GST_BUFFER_FLAG_SET(gap, GST_BUFFER_FLAG_GAP);
  fail_unless_equals_int(pushed(b, gap, "lost"), 1);
  fail_unless_equals_int(count(b.bus, static_cast<GstMessageType>(GST_MESSAGE_WARNING | GST_MESSAGE_ERROR)), 0);
  // Half a frame is a damaged frame.
  gst_util_set_object_arg(G_OBJECT(b.track), "on-error", "pass");
  fail_unless_equals_int(pushed(b, noise(320, 120, 2), "lost"), 1);
  fail_unless_equals_int(count(b.bus, GST_MESSAGE_WARNING), 1);
  gst_util_set_object_arg(G_OBJECT(b.track), "on-error", "error");
  fail_unless_equals_int(gst_harness_push(b.h, noise(320, 120, 3)), GST_FLOW_ERROR);
  fail_unless_equals_int(count(b.bus, GST_MESSAGE_ERROR), 1);
  close(b);
}
GST_END_TEST

GST_START_TEST(frames_without_timestamps_are_tracked) {
  Bench b = bench_with("points", "100,100");
  for (int i = 0; i < 5; ++i) {
    GstBuffer *in = noise(320, 240, i);
    GST_BUFFER_PTS(in) = GST_CLOCK_TIME_NONE;
    fail_unless_equals_int(pushed(b, in), 1);
  }
  GstMessage *message = gst_bus_pop_filtered(b.bus, GST_MESSAGE_ELEMENT);
  guint64 time = 0;
  fail_unless(gst_structure_get_uint64(gst_message_get_structure(message), "running-time", &time));
  fail_unless(time == GST_CLOCK_TIME_NONE);
  gst_message_unref(message);
  close(b);
}
GST_END_TEST

GST_START_TEST(frames_too_small_for_a_feature_warn_once) {
  for (const int side : {1, 2, 4}) {
    Bench b = bench(side, side);
    for (int i = 0; i < 3; ++i) fail_unless_equals_int(pushed(b, noise(side, side, i)), 0);
    fail_unless_equals_int(count(b.bus, GST_MESSAGE_WARNING), 1);
    close(b);
  }
}
GST_END_TEST

GST_START_TEST(flat_frames_have_no_features_and_no_warnings) {
  for (const int value : {0, 16, 128, 255}) {
    Bench b = bench();
    for (int i = 0; i < 3; ++i) fail_unless_equals_int(pushed(b, noise(320, 240, i, value, value + 1)), 0);
    fail_unless_equals_int(count(b.bus, static_cast<GstMessageType>(GST_MESSAGE_WARNING | GST_MESSAGE_ERROR)), 0);
    close(b);
  }
  Bench b = bench();
  for (int i = 0; i < 3; ++i) fail_unless(pushed(b, noise(320, 240, i)) <= 50);
  close(b);
}
GST_END_TEST

GST_START_TEST(the_largest_frame_passes) {
  Bench b = bench(16384, 16384);
  constexpr gsize size = gsize{16384} * 16384;
  GstBuffer *frame = gst_buffer_new_allocate(nullptr, size, nullptr);
  gst_buffer_memset(frame, 0, 128, size);
  fail_unless_equals_int(pushed(b, frame, nullptr) > 50, 0);
  fail_unless_equals_int(count(b.bus, GST_MESSAGE_ERROR), 0);
  close(b);
}
GST_END_TEST

static Suite *csdtrack_errors_suite() {
  gst_element_register_csdtrack(nullptr);  // as where the plugin is linked in: with all that it needs
  Suite *suite = suite_create("csdtrack_errors");
  TCase *tc = tcase_create("errors");
  suite_add_tcase(suite, tc);
  tcase_add_test(tc, an_exception_is_an_element_error);
  tcase_add_test(tc, on_error_pass_warns_once_and_passes_frames_unchanged);
  tcase_add_test(tc, a_recording_is_bit_exact_when_any_stage_fails);
  tcase_add_test(tc, a_discontinuity_reaches_the_algorithm);
  tcase_add_test(tc, an_exception_at_start_fails_the_state_change);
  tcase_add_test(tc, a_gap_buffer_loses_features_and_half_a_frame_is_an_error);
  tcase_add_test(tc, frames_without_timestamps_are_tracked);
  tcase_add_test(tc, frames_too_small_for_a_feature_warn_once);
  tcase_add_test(tc, flat_frames_have_no_features_and_no_warnings);
  tcase_add_test(tc, the_largest_frame_passes);
  return suite;
}

GST_CHECK_MAIN(csdtrack_errors)
