// SPDX-License-Identifier: LGPL-2.1-or-later
// The core on numpy arrays. Checks Python's values here, and copies nothing but the results.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "algorithms/make_algorithm.h"
#include "arguments.h"
#include "image/simd.h"
#include "pixels.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace py = pybind11;

namespace csd {
namespace {

constexpr int learner_nice = 10;  // learners yield to other threads, as the element's do

constexpr std::size_t algorithms = static_cast<std::size_t>(AlgorithmKind::csd_forest) + 1;

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

/// A row of the array that process() returns. numpy's U8 holds the longest state's word.
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
  PyTracker(const Settings &settings, unsigned threads, bool bgr)
      : algorithm_(algorithm_name(settings.algorithm)),
        bgr_(bgr),
        type_(row_type()),
        pool_(std::make_unique<ThreadPool>(threads, learner_nice)),
        tracker_(std::make_unique<Tracker>(settings, make_algorithm(settings, *pool_))) {}

  /// Waits for a working learner while other Python threads go on. A forked process has no learner to wait for, so it
  /// leaks what is left of it.
  ~PyTracker() {
    if (getpid() != process_) {
      static_cast<void>(tracker_.release());
      static_cast<void>(pool_.release());
      return;
    }
    const py::gil_scoped_release release;
    tracker_.reset();
    pool_.reset();
  }

  PyTracker(const PyTracker &) = delete;
  PyTracker &operator=(const PyTracker &) = delete;

  /// If a method is called without __init__() before it, pybind11 allocates with this operator, and would then use
  /// uninitialised memory as a tracker.
  static void *operator new(std::size_t) {
    throw py::type_error("this Tracker was made without __init__(): make it by csdtrack.Tracker(...)");
  }
  static void operator delete(void *memory) { ::operator delete(memory); }

  py::array process(const py::object &frame, const py::object &pts, const py::object &duration,
                    const py::object &discont) {
    Tracker &tracker = own_tracker();
    const Pixels pixels(frame, bgr_);
    const bool anew = truth(discont, "discont");
    const std::int64_t begin = frame_time(pts, "pts"), length = frame_time(duration, "duration");
    const Turn turn(busy_);
    const Tracks *tracks = nullptr;
    {
      const py::gil_scoped_release release;
      tracks = &follow(tracker, pixels.view(), begin, length, anew);
    }
    auto rows = rows_of(*tracks, type_);
    warn_if_small(*tracks);
    return rows;
  }

  FeatureId add_point(const py::object &x, const py::object &y) {
    const FeatureId id = own_tracker().add_point(coordinate(x, "x"), coordinate(y, "y"));
    if (id == no_feature)
      throw std::runtime_error(std::to_string(max_points) +
                               " features are tracked already, which is all that can be: remove one");
    return id;
  }

  bool remove_point(const py::object &id) {
    return own_tracker().remove_point(static_cast<FeatureId>(whole(id, "id", 0, no_feature - std::int64_t{1})));
  }

  void reset() { own_tracker().reset(); }

  const std::string &algorithm() const { return algorithm_; }

  py::dict stats() const {
    const Stats stats = own_tracker().stats();
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
  /// Only one thread at a time may be in the core's process().
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

  /// After a fork, the tracker's threads are missing, and their locks stay locked.
  Tracker &own_tracker() const {
    if (getpid() != process_)
      throw std::runtime_error(
          "this Tracker was made before os.fork(), and its threads are not in this process: make one here");
    return *tracker_;
  }

  static const Tracks &follow(Tracker &tracker, const FrameView &view, std::int64_t pts, std::int64_t duration,
                              bool discont) {
    try {
      return tracker.process(view, pts, duration, discont);
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
    // 2: the caller of __init__.py's process().
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 2) != 0) throw py::error_already_set();
  }

  std::string algorithm_;
  bool bgr_;
  py::dtype type_;
  cv::Size warned_;  ///< the size last warned about as too small
  std::atomic<bool> busy_{false};
  pid_t process_ = getpid();          ///< the process in which its threads run
  std::unique_ptr<ThreadPool> pool_;  // outlives the tracker
  std::unique_ptr<Tracker> tracker_;
};

PyTracker *make_tracker(const py::object &algorithm, const py::object &order, const py::object &max_features,
                        const py::object &points, const py::object &replenish, const py::object &forget_after,
                        const py::object &region, const py::object &content_area, const py::object &patch_size,
                        const py::object &search_radius, const py::object &training_time, const py::object &learning,
                        const py::object &n_threads, const py::object &frame_budget, const py::object &seed) {
  const auto small = [](py::handle value, const char *name, std::int64_t highest) {
    return static_cast<unsigned>(whole(value, name, 0, highest));
  };
  Settings s;
  s.algorithm = static_cast<AlgorithmKind>(choice(algorithm, "algorithm", words(algorithms, algorithm_word)));
  s.max_features = small(max_features, "max_features", max_points);
  s.points = given_points(points);
  s.replenish = truth(replenish, "replenish");
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
  return ::new PyTracker(s, small(n_threads, "n_threads", 256), bgr);
}

PYBIND11_MODULE(_core, m) {
  m.attr("__version__") = CSDTRACK_VERSION;
  m.attr("STATES") = py::tuple(py::cast(words(feature_states, state_word)));
  m.attr("ALGORITHMS") = py::tuple(py::cast(words(algorithms, algorithm_word)));

  // Documentation, and names and defaults of arguments, are in the class in __init__.py that wraps this one.
  py::class_<PyTracker>(m, "Tracker")
      .def(py::init(&make_tracker))
      .def("process", &PyTracker::process)
      .def("add_point", &PyTracker::add_point)
      .def("remove_point", &PyTracker::remove_point)
      .def("reset", &PyTracker::reset)
      .def_property_readonly("stats", &PyTracker::stats)
      .def_property_readonly("_algorithm", &PyTracker::algorithm);
}

}  // namespace
}  // namespace csd
