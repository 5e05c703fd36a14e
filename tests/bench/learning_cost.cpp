// SPDX-License-Identifier: LGPL-2.1-or-later
// The paper's Fig. 11: the cost of learning a feature in each frame, for both searches for a node's test, and the cost
// of tracking it (§3.3).
//   learning-cost FEATURES FRAMES SEED
// Follows detected features through the simulator's deformation with csd-2012, with all work in one thread. Prints a
// table, tab separated: search, frame, then per feature the ms of learning, leaves retrained, and the ms of everything
// else (working image, LK while learning, search of the window, cutting out samples). Times are the thread's processor
// time, so other load on the machine doesn't count. Work done once a frame is divided by FEATURES.
#include <time.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <functional>
#include <stdexcept>

#include "csd2012/csd2012.h"
#include "sim/simulator.h"
#include "track/tracker.h"

namespace {

using namespace csd;

/// Processor time of this thread, ms.
double processor_ms() {
  timespec now{};
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) != 0) throw std::runtime_error("no clock of the thread");
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

/// Runs each job when it is posted, after the earlier ones: so process()'s time is a frame's cost.
class Inline final : public Executor {
 public:
  void post(std::function<void()> job) override {
    jobs_.push_back(std::move(job));
    if (running_) return;
    running_ = true;
    const double began = processor_ms();
    for (; !jobs_.empty(); jobs_.pop_front()) jobs_.front()();
    spent_ms_ += processor_ms() - began;
    running_ = false;
  }

  /// Processor time of all jobs so far: csd-2012 posts its learning, and nothing else.
  double spent_ms() const { return spent_ms_; }

 private:
  double spent_ms_ = 0;
  std::deque<std::function<void()>> jobs_;
  bool running_ = false;
};

FrameView view_of(const cv::Mat &bgr) {
  FrameView view;
  view.width = bgr.cols;
  view.height = view.rows = bgr.rows;
  view.model = ColourModel::rgb;
  const auto stride = static_cast<std::ptrdiff_t>(bgr.step);
  for (std::size_t c = 0; c < 3; ++c) {
    view.component[c].data = bgr.data + 2 - c;
    view.component[c].row_stride = stride;
    view.component[c].pixel_stride = 3;
  }
  return view;
}

void measure(PairSearch search, sim::Simulator &simulator, const std::vector<cv::Point2d> &points,
             std::uint64_t frames) {
  Settings settings;
  settings.algorithm = AlgorithmKind::csd_2012;
  settings.points = points;
  settings.content_area = ContentArea::full;
  settings.learn_synchronously = true;
  Inline executor;
  csd2012::Choices choices;
  choices.exhaustive = search == PairSearch::exhaustive;
  Tracker tracker(settings, std::make_unique<Csd2012>(settings, executor, choices));
  const auto features = static_cast<double>(points.size());
  const auto duration = static_cast<std::int64_t>(second / simulator.settings().rate);
  cv::Mat picture;
  Stats before;
  double learned_ms = 0;
  for (std::uint64_t n = 0; n < frames; ++n) {
    simulator.render(n, picture);
    const double began = processor_ms();
    tracker.process(view_of(picture), static_cast<std::int64_t>(n) * duration, duration);
    const double spent = processor_ms() - began, learning = executor.spent_ms() - learned_ms;
    learned_ms += learning;
    const Stats now = tracker.stats();
    std::printf("%s\t%llu\t%.4f\t%.3f\t%.4f\n", search == PairSearch::ranked ? "ranked" : "exhaustive",
                static_cast<unsigned long long>(n), learning / features,
                static_cast<double>(now.retrainings - before.retrainings) / features, (spent - learning) / features);
    before = now;
  }
}

int usage() {
  std::fprintf(stderr, "usage: learning-cost FEATURES FRAMES SEED\n");
  return 2;
}

}  // namespace

int main(int argc, char **argv) try {
  if (argc != 4) return usage();
  const auto features = std::strtoull(argv[1], nullptr, 10), frames = std::strtoull(argv[2], nullptr, 10);
  if (features == 0 || frames == 0) return usage();
  sim::SimSettings settings;
  settings.seed = std::strtoull(argv[3], nullptr, 10);
  sim::Simulator simulator(settings);
  const auto points = simulator.detect(features);
  if (points.empty()) throw std::runtime_error("no feature in the first frame");
  std::printf("search\tframe\tlearning_ms\tretrained\ttracking_ms\n");
  measure(PairSearch::exhaustive, simulator, points, frames);
  measure(PairSearch::ranked, simulator, points, frames);
  return 0;
} catch (const std::exception &e) {
  std::fprintf(stderr, "learning-cost: %s\n", e.what());
  return 1;
}
