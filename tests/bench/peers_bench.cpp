// SPDX-License-Identifier: LGPL-2.1-or-later
// The cost per point and frame of csd, and of OpenCV's trackers as csd-peers runs them: 640 × 480, one thread.
#include <benchmark/benchmark.h>

#include <cmath>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

#include "algorithms/make_algorithm.h"
#include "programs/peers/peer.h"
#include "swing.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace csd {
namespace {

std::vector<cv::Point2d> grid(std::int64_t wanted) {
  std::vector<cv::Point2d> points;
  const double side = std::sqrt(560.0 * 400 / static_cast<double>(wanted));
  for (double y = 40; y < 440; y += side)
    for (double x = 40; x < 600 && static_cast<std::int64_t>(points.size()) < wanted; x += side)
      points.emplace_back(x, y);
  return points;
}

void count(benchmark::State &state) {
  state.counters["per_point"] = benchmark::Counter(static_cast<double>(state.iterations() * state.range(0)),
                                                   benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// Includes its support points and all other work of a frame.
void csd_frame(benchmark::State &state) {
  const auto frames = packed_swing();
  Settings settings;
  settings.algorithm = AlgorithmKind::csd;
  settings.points = grid(state.range(0));
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  std::size_t i = 0;
  const auto next = [&] {
    const auto pts = static_cast<std::int64_t>(i) * second / 25;
    benchmark::DoNotOptimize(tracker.process(frames[i++ % frames.size()].view, pts).features.data());
  };
  while (i < 50) next();  // until the anchors are made
  for (auto _ : state) next();
  count(state);
}
BENCHMARK(csd_frame)->Arg(100)->Arg(1000)->Unit(benchmark::kMillisecond);

void peer_frame(benchmark::State &state, const char *name) {
  cv::setNumThreads(1);
  const auto frames = swing();
  const auto peer = peers::find_peer(name)->make();
  std::size_t i = 0;
  const auto picture = [&] {
    const auto pts = static_cast<std::int64_t>(i) * second / 25;
    return programs::Picture{frames[i++ % frames.size()], pts};
  };
  peer->start(picture(), grid(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(peer->follow(picture()).size());
  count(state);
}
BENCHMARK_CAPTURE(peer_frame, lk_fb, "lk-fb")->Arg(100)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(peer_frame, kcf, "kcf")->Arg(10)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(peer_frame, csrt, "csrt")->Arg(10)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(peer_frame, median_flow, "medianflow")->Arg(10)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace csd
