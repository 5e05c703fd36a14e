// SPDX-License-Identifier: LGPL-2.1-or-later
// Each allocation of csdtrack and each start of a thread fails once, one after the other: every frame must come out as
// it went in all the same, and tracking must go on. The element is linked in, so that these functions stand in for the
// ones that its core and OpenCV call. GLib ends the process when it is out of memory, and isn't meddled with.
//
// CSDTRACK_FAULTS=N plants about N faults of each kind (10), spread over all there are (0: each of them).
#include <dlfcn.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <opencv2/core.hpp>
#include <vector>

#include "csdtrack.h"
#include "csdtrack_harness.h"
#include "meta.h"

namespace {

enum Kind { operator_new, opencv_allocation, thread_start, kinds };
constexpr const char *kind_names[kinds] = {"operator new", "OpenCV allocation", "thread start"};

/// How many calls of a kind still succeed; below zero all do. `lasting`: all that come after the failing one fail, too.
std::atomic<long> left[kinds] = {-1, -1, -1};
std::atomic<long> calls[kinds];
std::atomic<bool> lasting = false, counting = false;

bool fails(Kind kind) {
  if (!counting) return false;
  ++calls[kind];
  long now = left[kind];
  while (now >= 0) {
    if (now == 0 && lasting) return true;
    if (left[kind].compare_exchange_weak(now, now - 1)) return now == 0;
  }
  return false;
}

/// What OpenCV allocates for itself is left alone, but for pictures: its SIFT (4.6) throws from a destructor when that
/// fails, and nobody who calls it can help that.
bool is_of_opencv(void *caller) {
  Dl_info info;
  return dladdr(caller, &info) && info.dli_fname && std::strstr(info.dli_fname, "libopencv");
}

void *allocate_or_null(std::size_t size, std::size_t alignment, void *caller) noexcept {
  if (counting && !is_of_opencv(caller) && fails(operator_new)) return nullptr;
  return alignment ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                   : std::malloc(size ? size : 1);
}

void *allocate(std::size_t size, std::size_t alignment, void *caller) {
  void *memory = allocate_or_null(size, alignment, caller);
  if (!memory) throw std::bad_alloc();
  return memory;
}

/// OpenCV's own, that fails on demand.
class Allocator : public cv::MatAllocator {
 public:
  cv::UMatData *allocate(int dims, const int *sizes, int type, void *data, size_t *step, cv::AccessFlag flags,
                         cv::UMatUsageFlags usage) const override {
    if (fails(opencv_allocation)) CV_Error(cv::Error::StsNoMem, "planted");
    return cv::Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
  }
  bool allocate(cv::UMatData *data, cv::AccessFlag flags, cv::UMatUsageFlags usage) const override {
    return cv::Mat::getStdAllocator()->allocate(data, flags, usage);
  }
  void deallocate(cv::UMatData *data) const override { cv::Mat::getStdAllocator()->deallocate(data); }
};

}  // namespace

// Not inlined: the return address is the caller's, and g++ 12 takes half of an inlined pair for a mismatch.
[[gnu::noinline]] void *operator new(std::size_t size) {
  return allocate(size, 0, __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new[](std::size_t size) {
  return allocate(size, 0, __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new(std::size_t size, std::align_val_t a) {
  return allocate(size, static_cast<std::size_t>(a), __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new[](std::size_t size, std::align_val_t a) {
  return allocate(size, static_cast<std::size_t>(a), __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new(std::size_t size, const std::nothrow_t &) noexcept {
  return allocate_or_null(size, 0, __builtin_return_address(0));
}
[[gnu::noinline]] void *operator new[](std::size_t size, const std::nothrow_t &) noexcept {
  return allocate_or_null(size, 0, __builtin_return_address(0));
}
[[gnu::noinline]] void operator delete(void *memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void *memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void *memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void *memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void *memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void *memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void *memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void *memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

extern "C" int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *data) {
  static const auto real = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return fails(thread_start) ? EAGAIN : real(thread, attributes, run, data);
}

namespace {

constexpr int size = 128;
constexpr int frames = 14;  // whose allocations may fail, but for the last

/// Moves by a pixel a frame, so that there is something to do.
GstBuffer *moving(int index) {
  GstBuffer *buffer = picture(size, size, index);
  GstMapInfo map;
  gst_buffer_map(buffer, &map, GST_MAP_WRITE);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      map.data[y * size + x] = static_cast<guint8>((texture(x + index, y) + texture(2 * (x + index), 2 * y)) / 2);
  gst_buffer_unmap(buffer, &map);
  return buffer;
}

struct Outcome {
  bool started = false;
  int warnings = 0, errors = 0;
  guint claimed = 0;  ///< positions in the last frame, which is given all it wants
};

/// What applications do between frames. None of it changes what is tracked.
void talk_to(GstElement *track) {
  GstStructure *stats = nullptr;
  g_object_get(track, "stats", &stats, nullptr);
  if (stats) gst_structure_free(stats);
  guint id = 0;
  g_signal_emit_by_name(track, "add-point", -1e6, 0.0, &id);
  gboolean ended = FALSE;
  g_signal_emit_by_name(track, "remove-point", id, &ended);
  g_object_set(track, "frame-budget", guint64{0}, nullptr);
  gst_element_send_event(track, gst_event_new_navigation(gst_structure_new(
                                    "application/x-gst-navigation", "event", G_TYPE_STRING, "mouse-move", "pointer_x",
                                    G_TYPE_DOUBLE, 5.0, "pointer_y", G_TYPE_DOUBLE, 5.0, nullptr)));
}

/// A whole life of the element. What fails is counted from the start of the threads to the frame before the last.
Outcome live(const char *algorithm) {
  auto *track =
      GST_ELEMENT(g_object_new(GST_TYPE_CSD_TRACK, "name", "csdtrack", "max-features", 4, "n-threads", 2, nullptr));
  gst_object_ref_sink(track);
  gst_util_set_object_arg(G_OBJECT(track), "algorithm", algorithm);
  gst_util_set_object_arg(G_OBJECT(track), "on-error", "pass");
  gst_util_set_object_arg(G_OBJECT(track), "overlay", "meta");
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(track, bus);
  Outcome outcome;
  gst_element_set_state(track, GST_STATE_READY);
  counting = true;
  outcome.started = gst_element_set_state(track, GST_STATE_PAUSED) != GST_STATE_CHANGE_FAILURE;
  if (outcome.started) {
    counting = false;
    GstHarness *h = gst_harness_new_with_element(track, "sink", "src");
    gst_harness_add_propose_allocation_meta(h, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
    counting = true;
    gst_harness_set_src_caps_str(h, "video/x-raw,format=GRAY8,width=128,height=128,framerate=25/1");
    counting = false;
    for (int i = 0; i < frames; ++i) {
      GstBuffer *in = moving(i), *same = moving(i);
      counting = i + 1 < frames;
      const GstFlowReturn flow = gst_harness_push(h, in);
      if (i == frames / 2) talk_to(track);
      counting = false;
      fail_unless_equals_int(flow, GST_FLOW_OK);
      GstBuffer *out = gst_harness_try_pull(h);
      fail_unless(out != nullptr, "frame %d is gone", i);
      fail_unless_equals_uint64(GST_BUFFER_PTS(out), GST_BUFFER_PTS(same));
      GstMapInfo map;
      gst_buffer_map(same, &map, GST_MAP_READ);
      gst_check_buffer_data(out, map.data, map.size);
      gst_buffer_unmap(same, &map);
      GstCsdHeader header;
      const GstStructure *said = gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, nullptr);
      fail_unless(!said || gst_csd_structure_get_header(said, &header), "frame %d has half a meta", i);
      if (i + 1 == frames)
        for (const auto &[id, state] : states(out)) outcome.claimed += state == "tracked" || state == "learning";
      gst_buffer_unref(same);
      gst_buffer_unref(out);
    }
    gst_element_set_bus(track, nullptr);
    gst_harness_teardown(h);
  }
  counting = false;
  gst_element_set_bus(track, nullptr);
  gst_element_set_state(track, GST_STATE_NULL);
  while (GstMessage *message = gst_bus_pop(bus)) {
    outcome.warnings += GST_MESSAGE_TYPE(message) == GST_MESSAGE_WARNING;
    outcome.errors += GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR;
    gst_message_unref(message);
  }
  gst_object_unref(bus);
  gst_object_unref(track);
  return outcome;
}

void plant(const char *algorithm, Kind kind, bool last) {
  const char *wanted = g_getenv("CSDTRACK_FAULTS");
  live(algorithm);  // what is made once in a process is made here
  for (auto &n : calls) n = 0;
  const Outcome whole = live(algorithm);
  fail_unless(whole.started && whole.claimed == 4 && whole.warnings == 0 && whole.errors == 0, "%s: %u claims, %d, %d",
              algorithm, whole.claimed, whole.warnings, whole.errors);
  const long there = calls[kind], most = wanted ? std::atol(wanted) : 10;
  const long step = most > 0 ? std::max(1L, there / most) : 1;
  lasting = last;
  long planted = 0, noticed = 0, refused = 0, recovered = 0;
  for (long n = 0; n < there; n += step, ++planted) {
    left[kind] = n;
    const Outcome outcome = live(algorithm);
    left[kind] = -1;
    fail_unless(outcome.warnings <= 1, "%s: %d warnings for fault %ld", algorithm, outcome.warnings, n);
    // Only a start may be refused, and says so; a frame never.
    fail_unless_equals_int(outcome.errors, outcome.started ? 0 : 1);
    // What lk and csd-2012 lose they never find again: that is how they are.
    fail_unless(!outcome.started || outcome.claimed > 0 || std::strcmp(algorithm, "csd") != 0,
                "nothing is claimed after fault %ld", n);
    noticed += outcome.warnings;
    refused += !outcome.started;
    recovered += outcome.claimed > 0;
  }
  lasting = false;
  g_print("%s, %s%s: %ld of %ld faults planted: %ld starts refused, %ld warned of, %ld with claims in the end\n",
          algorithm, kind_names[kind], last ? " and all later ones" : "", planted, there, refused, noticed, recovered);
  fail_unless(there > 0 && noticed + refused > 0, "no fault of %s showed", kind_names[kind]);
}

}  // namespace

constexpr const char *algorithms[] = {"csd", "csd-2012", "lk"};

GST_START_TEST(an_allocation_fails) {
  plant(algorithms[__i__], operator_new, false);
}
GST_END_TEST

GST_START_TEST(memory_is_short) {
  plant(algorithms[__i__], operator_new, true);
}
GST_END_TEST

GST_START_TEST(opencv_gets_no_memory) {
  plant(algorithms[__i__], opencv_allocation, false);
}
GST_END_TEST

GST_START_TEST(a_thread_does_not_start) {
  plant("csd", thread_start, false);
  plant("csd", thread_start, true);
}
GST_END_TEST

static Suite *csdtrack_faults_suite() {
  csd::register_track_metas();
  static Allocator allocator;
  cv::Mat::setDefaultAllocator(&allocator);
  cv::setNumThreads(1);
  Suite *suite = suite_create("csdtrack_faults");
  TCase *tcase = tcase_create("general");
  tcase_set_timeout(tcase, 0);  // meson's holds
  suite_add_tcase(suite, tcase);
  tcase_add_loop_test(tcase, an_allocation_fails, 0, G_N_ELEMENTS(algorithms));
  tcase_add_loop_test(tcase, memory_is_short, 0, G_N_ELEMENTS(algorithms));
  tcase_add_loop_test(tcase, opencv_gets_no_memory, 0, G_N_ELEMENTS(algorithms));
  tcase_add_test(tcase, a_thread_does_not_start);
  return suite;
}

GST_CHECK_MAIN(csdtrack_faults)
