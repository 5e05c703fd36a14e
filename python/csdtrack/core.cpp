// SPDX-License-Identifier: LGPL-2.1-or-later
// The core on numpy arrays: what Python gives is checked here, and nothing is copied but the results.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "arguments.h"
#include "image/simd.h"
#include "pixels.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace py = pybind11;

namespace csd {
namespace {

constexpr int learner_nice = 10;  // learners give way, as those of the element do

constexpr std::size_t algorithms = static_cast<std::size_t>(AlgorithmKind::sift) + 1;

std::string_view algorithm_word(std::size_t i) {
  return algorithm_name(static_cast<AlgorithmKind>(i));
}

std::string_view state_word(std::size_t i) {
  return state_name(static_cast<FeatureState>(i));
}

/// The words word(0) … word(count − 1).
std::vector<std::string> words(std::size_t count, std::string_view (*word)(std::size_t)) {
  std::vector<std::string> result;
  for (std::size_t i = 0; i < count; ++i) result.emplace_back(word(i));
  return result;
}

// ---- A frame's result ----------------------------------------------------------------------------------------------

/// A row of the array that process() returns; numpy's U8 holds the longest of the states' words.
struct Row {
  std::uint32_t id;
  double x, y;
  char32_t state[8];
  double confidence;
  bool fresh;
};
static_assert(std::is_standard_layout_v<Row>);

py::dtype row_type() {
  py::list names, formats, offsets;
  const auto add = [&](const char *name, const char *format, std::size_t offset) {
    names.append(name);
    formats.append(format);
    offsets.append(offset);
  };
  add("id", "u4", offsetof(Row, id));
  add("x", "f8", offsetof(Row, x));
  add("y", "f8", offsetof(Row, y));
  add("state", "U8", offsetof(Row, state));
  add("confidence", "f8", offsetof(Row, confidence));
  add("fresh", "?", offsetof(Row, fresh));
  return {names, formats, offsets, sizeof(Row)};
}

py::array rows_of(const Tracks &tracks, const py::dtype &type) {
  py::array array(type, static_cast<py::ssize_t>(tracks.features.size()));
  auto *row = static_cast<Row *>(array.mutable_data());
  for (const Feature &feature : tracks.features) {
    *row = {feature.id, feature.x, feature.y, {}, feature.confidence, feature.fresh};
    std::ranges::copy(state_name(feature.state), row->state);
    ++row;
  }
  return array;
}

// ---- The tracker ---------------------------------------------------------------------------------------------------

class PyTracker {
 public:
  PyTracker(const Settings &settings, unsigned threads, bool bgr) : bgr_(bgr), type_(row_type()) {
    pool_.emplace(threads, learner_nice);
    tracker_.emplace(settings, *pool_);
  }

  /// A learner that is at work is waited for; other threads of Python go on meanwhile.
  ~PyTracker() {
    const py::gil_scoped_release release;
    tracker_.reset();
    pool_.reset();
  }

  PyTracker(const PyTracker &) = delete;
  PyTracker &operator=(const PyTracker &) = delete;

  py::array process(const py::object &frame, const py::object &pts, const py::object &duration, bool discont) {
    const Pixels pixels(frame, bgr_);
    const std::int64_t begin = frame_time(pts, "pts"), length = frame_time(duration, "duration");
    const Turn turn(busy_);
    const Tracks *tracks = nullptr;
    {
      const py::gil_scoped_release release;
      tracks = &follow(pixels.view(), begin, length, discont);
    }
    auto rows = rows_of(*tracks, type_);
    warn_if_small(*tracks);
    return rows;
  }

  FeatureId add_point(double x, double y) {
    if (!std::isfinite(x) || !std::isfinite(y))
      throw py::value_error("x=" + std::to_string(x) + ", y=" + std::to_string(y) + " is not finite: give pixels");
    const FeatureId id = tracker_->add_point(x, y);
    if (id == no_feature)
      throw std::runtime_error(std::to_string(max_points) +
                               " features are tracked already, which is all that can be: remove one");
    return id;
  }

  bool remove_point(const py::object &id) {
    return tracker_->remove_point(static_cast<FeatureId>(whole(id, "id", 0, no_feature - std::int64_t{1})));
  }

  void reset() { tracker_->reset(); }

  py::dict stats() const {
    const Stats stats = tracker_->stats();
    py::dict result;
    result["frames"] = stats.frames;
    for (std::size_t i = 0; i < feature_states; ++i) result[py::str(std::string(state_word(i)))] = stats.features[i];
    result["detected"] = stats.detected;
    result["learning_time"] = stats.learning_time;
    result["learned"] = stats.learned;
    result["retrainings"] = stats.retrainings;
    result["false_correspondences"] = stats.false_correspondences;
    result["queue"] = stats.queue;
    result["waited"] = stats.waited;
    result["simd"] = simd_target();
    return result;
  }

 private:
  /// The core's process() belongs to one thread at a time.
  class Turn {
   public:
    explicit Turn(std::atomic<bool> &busy) : busy_(busy) {
      if (busy_.exchange(true))
        throw std::runtime_error(
            "process() is at work in another thread: a Tracker follows one stream, use one for each");
    }
    ~Turn() { busy_ = false; }
    Turn(const Turn &) = delete;
    Turn &operator=(const Turn &) = delete;

   private:
    std::atomic<bool> &busy_;
  };

  const Tracks &follow(const FrameView &view, std::int64_t pts, std::int64_t duration, bool discont) {
    try {
      return tracker_->process(view, pts, duration, discont);
    } catch (const cv::Exception &e) {
      if (e.code == cv::Error::StsNoMem) throw std::bad_alloc();
      throw std::runtime_error("OpenCV failed while tracking: " + e.err);
    }
  }

  void warn_if_small(const Tracks &tracks) {
    const cv::Size size(tracks.width, tracks.height);
    if (!tracks.too_small || size == warned_) return;
    warned_ = size;
    const std::string text = "a picture of " + std::to_string(size.width) + "×" + std::to_string(size.height) +
                             " pixels is smaller than a feature's patch: set patch_size lower, or give a larger one";
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) != 0) throw py::error_already_set();
  }

  bool bgr_;
  py::dtype type_;
  cv::Size warned_;  ///< the size of which it was said that it is too small
  std::atomic<bool> busy_{false};
  std::optional<ThreadPool> pool_;  // outlives the tracker
  std::optional<Tracker> tracker_;
};

std::unique_ptr<PyTracker> make_tracker(const py::object &algorithm, const py::object &order,
                                        const py::object &max_features, const py::object &points, bool replenish,
                                        const py::object &forget_after, const py::object &region,
                                        const py::object &content_area, const py::object &patch_size,
                                        const py::object &search_radius, const py::object &training_time,
                                        const py::object &learning, const py::object &n_threads,
                                        const py::object &frame_budget, const py::object &seed) {
  const auto small = [](py::handle value, const char *name, std::int64_t most) {
    return static_cast<unsigned>(whole(value, name, 0, most));
  };
  Settings s;
  s.algorithm = static_cast<AlgorithmKind>(choice(algorithm, "algorithm", words(algorithms, algorithm_word)));
  s.max_features = small(max_features, "max_features", max_points);
  s.points = given_points(points);
  s.replenish = replenish;
  s.forget_after = time_setting(forget_after, "forget_after");
  s.region = given_region(region);
  s.content_area = choice(content_area, "content_area", {"auto", "full"}) ? ContentArea::full : ContentArea::automatic;
  s.patch_size = small(patch_size, "patch_size", 1024);
  s.search_radius = small(search_radius, "search_radius", 2048);
  s.training_time = time_setting(training_time, "training_time");
  s.learn_synchronously = choice(learning, "learning", {"async", "sync"}) == 1;
  s.frame_budget = time_setting(frame_budget, "frame_budget");
  s.seed = whole_seed(seed);
  const bool bgr = choice(order, "order", {"rgb", "bgr"}) == 1;
  return std::make_unique<PyTracker>(s, small(n_threads, "n_threads", 256), bgr);
}

PYBIND11_MODULE(_core, m) {
  const Settings defaults;
  m.attr("STATES") = py::tuple(py::cast(words(feature_states, state_word)));
  m.attr("ALGORITHMS") = py::tuple(py::cast(words(algorithms, algorithm_word)));

  py::class_<PyTracker> tracker(m, "Tracker", R"(Tracks points on deforming tissue through the frames of one stream.

All arguments are keywords, and those that the GStreamer element csdtrack has too, with "-" for "_", mean the same,
have the same ranges and the same defaults: docs/elements.md. Times are whole nanoseconds. A Tracker may be handed
from thread to thread; only process() must not run twice at a time.)");
  tracker.attr("__module__") = "csdtrack";
  tracker
      .def(py::init(&make_tracker), py::kw_only(),
           py::arg("algorithm") = std::string(algorithm_name(defaults.algorithm)), py::arg("order") = "rgb",
           py::arg("max_features") = defaults.max_features, py::arg("points") = py::none(),
           py::arg("replenish") = defaults.replenish, py::arg("forget_after") = defaults.forget_after,
           py::arg("region") = py::none(), py::arg("content_area") = "auto",
           py::arg("patch_size") = defaults.patch_size, py::arg("search_radius") = defaults.search_radius,
           py::arg("training_time") = defaults.training_time, py::arg("learning") = "async", py::arg("n_threads") = 0,
           py::arg("frame_budget") = defaults.frame_budget, py::arg("seed") = defaults.seed,
           R"(
algorithm      one of csdtrack.ALGORITHMS
order          "rgb", or "bgr" as OpenCV has it: of the last axis of colour frames
max_features   0…10000: how many features detection keeps; 0: only points that are given
points         N×2, x and y in pixels: track exactly these, ids 0…N-1, no detection
replenish      new features where old ones ended (csd only)
forget_after   ns: a detected feature that is lost or out for so long ends; 0: never
region         (x, y, width, height) in whole pixels: where detection may look; None: everywhere
content_area   "auto": the dark border and burnt-in graphics are left alone; "full": all is tissue
patch_size     0…1024 px: side of a feature's patch; 0: from the frame's height
search_radius  0…2048 px; 0: from the frame's height (csd-2012 only)
training_time  ns: how long a feature is "learning"
learning       "async": frames don't wait for learning; "sync": they do, and results are the same on each run
               (only csd-2012 learns beside the frames)
n_threads      0…256 learner threads; 0: one fewer than there are processors, at least 1
frame_budget   ns: past it the least urgent features of a frame wait; 0: none (csd only)
seed           of every random choice

Raises TypeError and ValueError, which say what to write instead.)")
      .def("process", &PyTracker::process, py::arg("frame"), py::arg("pts") = py::none(),
           py::arg("duration") = py::none(), py::arg("discont") = false,
           R"(
Tracks all features into the next frame; returns them as a structured array, a row each, by ascending id.

frame     uint8, H×W (gray) or H×W×3 (colour), any strides; read in place, not changed and not kept
pts       when it was taken, ns; None: one duration after the last one
duration  ns; None: unknown, then 40 ms (25 frames a second)
discont   the frame does not follow on the last one. So is taken, too, a pts more than half a second off

Fields: id (uint32), x, y (float64, pixels, centres at integers, 0,0 the top left one; always finite), state (str, one
of csdtrack.STATES), confidence (float64, 0…1), fresh (bool). Only "learning" and "tracked" claim a position, which is
so exactly where confidence >= 0.5. A frame of another size begins anew, with new ids.

Other threads of Python run meanwhile. Raises TypeError and ValueError for a frame that can't be read, RuntimeError
where another thread's process() is at work or tracking fails; warns once where a frame is too small to track in.)")
      .def("add_point", &PyTracker::add_point, py::arg("x"), py::arg("y"),
           R"(
Also tracks x, y, pixels of the next frame; returns its id. From any thread, never waits for a frame.

Raises ValueError where x or y is not finite, RuntimeError where 10000 features are tracked already.)")
      .def("remove_point", &PyTracker::remove_point, py::arg("id"),
           R"(
Ends a feature, given or detected, with the next frame. False if there is none of this id. From any thread.)")
      .def("reset", &PyTracker::reset,
           R"(
Forgets the stream: with the next frame all features end, and points begin again under new ids, or detection does.
From any thread.)")
      .def_property_readonly(
          "stats", &PyTracker::stats,
          "dict: frames; features of the last frame by state; detected, learning_time (ns), learned, retrainings, "
          "false_correspondences, queue, waited, simd: as the element's stats");
}

}  // namespace
}  // namespace csd
