// SPDX-License-Identifier: LGPL-2.1-or-later
// The cost of a feature, per frame and once: recursive start, search, update, learning. For comparison: OpenCV's PyrLK.
#include <benchmark/benchmark.h>

#include <cmath>
#include <opencv2/video/tracking.hpp>

#include "core/track/moving_scene.h"
#include "csd2012/feature_learner.h"
#include "csd2012/search.h"
#include "csd2012/smoothed.h"
#include "image/convert.h"
#include "image/patch.h"
#include "image/work_frame.h"
#include "track/recursive.h"

namespace csd {
namespace {

const MovingScene &scene() {
  static const MovingScene s({640, 480});
  return s;
}

cv::Mat gray(int frame) {
  cv::Mat out;
  cv::cvtColor(scene().render({2 * std::sin(frame * 0.4), 2 * std::cos(frame * 0.3)}), out, cv::COLOR_BGR2GRAY);
  return out;
}

std::vector<cv::Point2f> points(int count) {
  std::vector<cv::Point2f> p;
  for (int i = 0; i < count; ++i)
    p.emplace_back(50 + static_cast<float>((i * 53) % 540), 50 + static_cast<float>((i * 97) % 380));
  return p;
}

/// Each lesson has its own frame, from which one feature learns.
void learn(FeatureLearner &learner, const cv::Mat &bgr, const cv::Mat &luma, cv::Point at) {
  Snapshot s;
  s.bgr = bgr;
  s.luma = luma;
  learner.learn(s, at);
}

/// A learner after 12 frames, half a second at 25 frames a second.
std::unique_ptr<FeatureLearner> taught(PairSearch search, std::uint64_t seed, int lessons = 12) {
  LearnerOptions options;
  options.choices.exhaustive = search == PairSearch::exhaustive;
  auto learner = std::make_unique<FeatureLearner>(options, Random(seed), std::make_shared<LearningCounters>());
  const auto bgr = scene().render({0, 0});
  const auto luma = gray(0);
  const cv::Point at(60 + static_cast<int>(seed * 71 % 500), 60 + static_cast<int>(seed * 37 % 360));
  for (int i = 0; i < lessons; ++i) learn(*learner, bgr, luma, at);
  return learner;
}

void recursive_per_frame(benchmark::State &state) {
  RecursiveTracker tracker;
  const cv::Mat a = gray(0), b = gray(1);
  const auto start = points(static_cast<int>(state.range(0)));
  std::vector<unsigned char> found;
  tracker.keep(a);
  for (auto _ : state) {
    auto p = start;
    tracker.track(b, p, found);
    benchmark::DoNotOptimize(p.data());
  }
  state.counters["per_feature"] = benchmark::Counter(static_cast<double>(state.iterations() * state.range(0)),
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(recursive_per_frame)->Arg(50)->Arg(100)->Unit(benchmark::kMicrosecond);

void opencv_pyrlk_per_frame(benchmark::State &state) {
  const cv::Mat a = gray(0), b = gray(1);
  const auto start = points(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    std::vector<cv::Point2f> p;
    std::vector<unsigned char> found;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(a, b, start, p, found, error);
    benchmark::DoNotOptimize(p.data());
  }
  state.counters["per_feature"] = benchmark::Counter(static_cast<double>(state.iterations() * state.range(0)),
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(opencv_pyrlk_per_frame)->Arg(50)->Arg(100)->Unit(benchmark::kMicrosecond);

void gather_and_search_41(benchmark::State &state) {
  const auto learner = taught(PairSearch::ranked, 1);
  const auto tree = learner->published();
  WorkFrame frame;
  const cv::Mat bgr = scene().render({0, 0});
  cv::Mat yuv, channel;
  cv::cvtColor(bgr, yuv, cv::COLOR_BGR2YUV_I420);
  FrameView view;
  view.width = 640, view.height = view.rows = 480, view.model = ColourModel::yuv;
  view.component[0] = {yuv.data, 640, 1, 1, 0, 0, 0};
  view.component[1] = {yuv.data + 640 * 480, 320, 1, 1, 0, 1, 1};
  view.component[2] = {yuv.data + 640 * 600, 320, 1, 1, 0, 1, 1};
  frame.load(view);
  const cv::Point at(131, 97);
  const double sigma = csd2012::Choices{}.smoothing;
  const int reach = 30 + csd2012::smoothing_margin(sigma);
  cv::Mat raw;
  for (auto _ : state) {
    frame.gather({at.x - reach, at.y - reach, 2 * reach + 1, 2 * reach + 1}, tree->space(), raw);
    csd2012::smooth(raw, sigma, channel);
    auto result = search(*tree, channel, {at.x - 30, at.y - 30}, {{at.x - 20, at.y - 20, 41, 41}, 1}, {at, 10});
    benchmark::DoNotOptimize(result.weighted);
  }
  state.counters["nodes"] = static_cast<double>(tree->trees().front()->nodes().size());
}
BENCHMARK(gather_and_search_41)->Unit(benchmark::kMicrosecond);

void update_per_frame(benchmark::State &state) {
  const auto learner = taught(PairSearch::ranked, 1);
  cv::Mat channel;
  to_space(scene().render({0, 0}), learner->published()->space(), channel);
  Random random(3);
  const auto cut = [&](cv::Point p, int side) {
    cv::Mat patch;
    sample_patch(channel, p, side, patch);
    return patch;
  };
  for (auto _ : state) {
    state.PauseTiming();
    DescriptorUpdate update;
    update.feature = cut({131, 97}, learner->surroundings());
    for (int i = 0; i < 10; ++i)
      update.negatives.push_back(
          cut({10 + static_cast<int>(random.below(620)), 10 + static_cast<int>(random.below(460))}, learner->grown()));
    state.ResumeTiming();
    learner->update(update);
  }
}
BENCHMARK(update_per_frame)->Unit(benchmark::kMicrosecond)->Iterations(2000);

void learn_a_feature(benchmark::State &state) {
  const auto search = state.range(0) ? PairSearch::exhaustive : PairSearch::ranked;
  state.SetLabel(state.range(0) ? "exhaustive search" : "ranked search");
  std::uint64_t seed = 0;
  for (auto _ : state) benchmark::DoNotOptimize(taught(search, ++seed)->published());
}
BENCHMARK(learn_a_feature)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->Iterations(5);

}  // namespace
}  // namespace csd
