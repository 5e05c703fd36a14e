// SPDX-License-Identifier: LGPL-2.1-or-later
// The cost of the baselines per feature and frame, in a whole Tracker: 640 × 480, I420, `features` detected.
#include <benchmark/benchmark.h>

#include "algorithms/make_algorithm.h"
#include "swing.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace csd {
namespace {

void frame(benchmark::State &state, AlgorithmKind algorithm) {
  static const auto frames = packed_swing();
  Settings settings;
  settings.algorithm = algorithm;
  settings.max_features = static_cast<unsigned>(state.range(0));
  settings.content_area = ContentArea::full;
  settings.forget_after = 0;
  ThreadPool pool;
  Tracker tracker(settings, make_algorithm(settings, pool));
  std::size_t i = 0;
  const auto next = [&] {
    const auto pts = static_cast<std::int64_t>(i) * second / 25;
    benchmark::DoNotOptimize(tracker.process(frames[i++ % frames.size()].view, pts).features.data());
  };
  next();  // detection
  for (auto _ : state) next();
  const auto stats = tracker.stats();
  state.counters["tracked"] = static_cast<double>(stats.features[static_cast<std::size_t>(FeatureState::tracked)]);
  state.counters["per_feature"] = benchmark::Counter(static_cast<double>(state.iterations() * state.range(0)),
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(frame, lk, AlgorithmKind::lk)->Arg(50)->Arg(100)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, ms1, AlgorithmKind::ms1)->Arg(50)->Arg(100)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, ms2, AlgorithmKind::ms2)->Arg(50)->Arg(100)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, sift, AlgorithmKind::sift)->Arg(50)->Arg(100)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace csd
