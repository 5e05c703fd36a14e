// SPDX-License-Identifier: LGPL-2.1-or-later
// The paper's Fig. 11: what learning costs a feature in each frame, with both ways to look for a node's test, and what
// tracking one costs (§3.3).
//   learning-cost FEATURES FRAMES SEED
// follows detected features through the simulator's deformation with csd-2012, all work in one thread, and prints a
// table, tab separated: search, frame, then per feature ms of learning, leaves retrained, ms of everything else
// (working image, LK while learning, search of the window, cutting out samples).
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <functional>
#include <stdexcept>

#include "sim/simulator.h"
#include "track/tracker.h"

namespace {

using namespace csd;

/// Runs each job where it is posted, after those before it: what a frame costs is then the time that process() takes.
class Inline final : public Executor {
 public:
  void post(std::function<void()> job) override {
    jobs_.push_back(std::move(job));
    if (running_) return;
    running_ = true;
    for (; !jobs_.empty(); jobs_.pop_front()) jobs_.front()();
    running_ = false;
  }

 private:
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
  settings.points = points;
  settings.content_area = ContentArea::full;
  settings.learn_synchronously = true;
  settings.pair_search = search;
  Inline executor;
  Tracker tracker(settings, executor);
  const auto features = static_cast<double>(points.size());
  const auto duration = static_cast<std::int64_t>(second / simulator.settings().rate);
  cv::Mat picture;
  Stats before;
  for (std::uint64_t n = 0; n < frames; ++n) {
    simulator.render(n, picture);
    const auto began = std::chrono::steady_clock::now();
    tracker.process(view_of(picture), static_cast<std::int64_t>(n) * duration, duration);
    const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - began;
    const Stats now = tracker.stats();
    const double learning = static_cast<double>(now.learning_time - before.learning_time) / 1e6;
    std::printf("%s\t%llu\t%.4f\t%.3f\t%.4f\n", search == PairSearch::ranked ? "ranked" : "exhaustive",
                static_cast<unsigned long long>(n), learning / features,
                static_cast<double>(now.retrainings - before.retrainings) / features,
                (spent.count() - learning) / features);
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
