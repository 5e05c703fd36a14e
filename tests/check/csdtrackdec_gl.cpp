// SPDX-License-Identifier: LGPL-2.1-or-later
//
// The recipe of docs/elements.md for large frames on a GPU, in OpenGL memory (Mesa's software GL is enough). It tracks
// a small copy and puts the tracks on the large frames, none of which is mapped or copied.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "csdtrackdec_harness.h"

using namespace csd_check;

namespace {

constexpr int width = 640, height = 360, small_width = 320, small_height = 180, frames = 12;
constexpr gsize large_bytes = gsize{4} * width * height;
/// GST_MAP_GL of gst/gl/gl.h: maps the texture in place.
constexpr int map_gl = GST_MAP_FLAG_LAST << 1;

/// Counts maps into system memory, and copies, of all memory of GL's allocator from watch() on.
std::atomic<int> large_maps = 0, small_maps = 0, large_copies = 0;
GstMemoryMapFullFunction real_map = nullptr;
GstMemoryCopyFunction real_copy = nullptr;

gpointer counting_map(GstMemory *memory, GstMapInfo *info, gsize size) {
  if (!(info->flags & map_gl)) ++(memory->size >= large_bytes ? large_maps : small_maps);
  return real_map(memory, info, size);
}

GstMemory *counting_copy(GstMemory *memory, gssize offset, gssize size) {
  if (memory->size >= large_bytes) ++large_copies;
  return real_copy(memory, offset, size);
}

/// Runs at the first frame, before another thread has it.
void watch(GstAllocator *allocator) {
  if (real_map) return;
  real_map = std::exchange(allocator->mem_map_full, counting_map);
  real_copy = std::exchange(allocator->mem_copy, counting_copy);
}

struct Place {
  guint id;
  double x, y;
};

/// Keyed by the frames' times.
using Places = std::map<GstClockTime, std::vector<Place>>;

Places::mapped_type places_on(GstBuffer *buffer, int of_width, int of_height) {
  std::vector<Place> places;
  GstCsdHeader header;
  const GstStructure *tracks = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, nullptr);
  fail_unless(tracks && gst_csd_structure_get_header(tracks, &header), "a frame without tracks");
  fail_unless(header.width == of_width && header.height == of_height);
  for (guint i = 0; i < header.n_features; ++i) {
    GstCsdFeature feature;
    fail_unless(gst_csd_structure_get_feature(tracks, i, &feature));
    places.push_back({feature.id, feature.x, feature.y});
  }
  return places;
}

/// Looks at buffers without making them writable, so that none is copied.
void look(GstElement *pipeline, const char *name, const char *pad_name, std::function<void(GstBuffer *)> call) {
  GstElement *element = gst_bin_get_by_name(GST_BIN(pipeline), name);
  GstPad *pad = gst_element_get_static_pad(element, pad_name);
  gst_pad_add_probe(
      pad, GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad *, GstPadProbeInfo *info, gpointer data) {
        (*static_cast<std::function<void(GstBuffer *)> *>(data))(GST_PAD_PROBE_INFO_BUFFER(info));
        return GST_PAD_PROBE_OK;
      },
      new std::function<void(GstBuffer *)>(std::move(call)),
      [](gpointer data) { delete static_cast<std::function<void(GstBuffer *)> *>(data); });
  gst_object_unref(pad);
  gst_object_unref(element);
}

std::string recipe(const std::string &decoder, const std::string &behind) {
  const auto caps = [](int w, int h) {
    return " ! video/x-raw(memory:GLMemory),width=" + std::to_string(w) + ",height=" + std::to_string(h);
  };
  return "gltestsrc pattern=mandelbrot num-buffers=" + std::to_string(frames) + caps(width, height) +
         ",framerate=25/1 ! tee name=t t. ! queue ! csdtrackdec name=r " + decoder + " ! " + behind +
         " t. ! queue ! glcolorscale" + caps(small_width, small_height) +
         " ! gldownload name=down ! video/x-raw ! csdtrack name=track max-features=20 ! csdtrackenc"
         " ! application/x-ndjson ! r.text";
}

void play_well(GstElement *pipeline) {
  GError *error = play(pipeline);
  fail_unless(error == nullptr, "%s", error ? error->message : "");
}

}  // namespace

GST_START_TEST(a_small_copy_is_tracked_and_no_large_frame_is_mapped) {
  Places tracked, put;
  std::map<GstClockTime, GstMemory *> sent;
  int same = 0;
  GstElement *pipeline = launch(recipe("", "fakesink name=out async=false"));
  std::mutex mutex;
  look(pipeline, "t", "sink", [&](GstBuffer *frame) {
    const std::lock_guard lock(mutex);
    GstMemory *memory = gst_buffer_peek_memory(frame, 0);
    watch(memory->allocator);
    sent[GST_BUFFER_PTS(frame)] = memory;
  });
  look(pipeline, "track", "src", [&](GstBuffer *frame) {
    const std::lock_guard lock(mutex);
    tracked[GST_BUFFER_PTS(frame)] = places_on(frame, small_width, small_height);
  });
  look(pipeline, "out", "sink", [&](GstBuffer *frame) {
    const std::lock_guard lock(mutex);
    put[GST_BUFFER_PTS(frame)] = places_on(frame, width, height);
    same += gst_buffer_peek_memory(frame, 0) == sent[GST_BUFFER_PTS(frame)];
  });
  play_well(pipeline);

  fail_unless_equals_int(put.size(), frames);
  fail_unless_equals_int(same, frames);
  fail_unless_equals_int(large_maps, 0);
  fail_unless_equals_int(large_copies, 0);
  // The count works: the small frames are mapped.
  fail_unless(small_maps >= frames, "%d small frames were mapped", small_maps.load());
  for (const auto &[time, places] : put) {
    const auto &of = tracked[time];
    fail_unless(!of.empty() && places.size() == of.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      fail_unless_equals_int(places[i].id, of[i].id);
      // A line has three decimals.
      fail_unless(std::abs(places[i].x - ((of[i].x + 0.5) * 2 - 0.5)) < 0.0011);
      fail_unless(std::abs(places[i].y - ((of[i].y + 0.5) * 2 - 0.5)) < 0.0011);
    }
  }
}
GST_END_TEST

/// The last frame's pixels, and its features' places.
static std::vector<guint8> shown(const std::string &overlay, std::vector<Place> &places) {
  std::vector<guint8> pixels(large_bytes);
  GstElement *pipeline = launch(recipe("overlay=" + overlay,
                                       "gloverlaycompositor ! gldownload ! video/x-raw,format=RGBA ! fakesink "
                                       "name=out async=false"));
  look(pipeline, "r", "src", [&](GstBuffer *frame) { places = places_on(frame, width, height); });
  look(pipeline, "out", "sink", [&](GstBuffer *frame) {
    fail_unless_equals_int(gst_buffer_extract(frame, 0, pixels.data(), pixels.size()), pixels.size());
  });
  play_well(pipeline);
  return pixels;
}

GST_START_TEST(the_gpu_draws_the_markers) {
  std::vector<Place> places;
  const auto without = shown("none", places), with = shown("meta", places);
  fail_unless(!places.empty());
  for (const Place &place : places) {
    // A marker's radius is about a hundredth of the picture's height. Its shape depends on the state.
    int changed = 0;
    for (int y = std::max(0, static_cast<int>(place.y) - 12); y < std::min(height, static_cast<int>(place.y) + 13); ++y)
      for (int x = std::max(0, static_cast<int>(place.x) - 12); x < std::min(width, static_cast<int>(place.x) + 13);
           ++x) {
        const auto at =
            static_cast<std::size_t>(4) * (static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x));
        changed += !std::equal(&with[at], &with[at] + 3, &without[at]);
      }
    fail_unless(changed > 0, "no marker at %g, %g", place.x, place.y);
  }
}
GST_END_TEST

static Suite *csdtrackdec_gl_suite() {
  Suite *s = suite_create("csdtrackdec_gl");
  TCase *tc = tcase_create("gl");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, a_small_copy_is_tracked_and_no_large_frame_is_mapped);
  tcase_add_test(tc, the_gpu_draws_the_markers);
  return s;
}

/// Checks in a process of its own, since each test's GL begins in its own fork.
static bool there_is_gl() {
  gint status = 1;
  return g_spawn_command_line_sync(
             "gst-launch-1.0 -q gltestsrc num-buffers=1 ! gloverlaycompositor ! gldownload ! video/x-raw ! fakesink",
             nullptr, nullptr, &status, nullptr) &&
         status == 0;
}

int main(int argc, char **argv) {
  if (!there_is_gl()) {
    g_printerr("SKIP: no OpenGL here: gst-launch-1.0 gltestsrc (gstreamer1.0-gl) does not play\n");
    return 77;
  }
  gst_check_init(&argc, &argv);
  return gst_check_run_suite(csdtrackdec_gl_suite(), "csdtrackdec_gl", __FILE__);
}
