// SPDX-License-Identifier: LGPL-2.1-or-later
// Learning and scanning of one context specific descriptor, patches of 21 × 21 pixels.
#include <benchmark/benchmark.h>

#include <opencv2/imgproc.hpp>

#include "csd2012/learn/colour_choice.h"
#include "csd2012/learn/growing_tree.h"
#include "csd2012/learn/smoke.h"
#include "image/simd.h"

namespace {

using namespace csd;

constexpr int side = 21;

/// Texture with a spectrum like tissue's: noise at several scales, plus sensor noise of σ = 3.
cv::Mat texture(int rows, int cols, std::uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat sum = cv::Mat::zeros(rows, cols, CV_32F);
  for (const double sigma : {2.0, 5.0, 12.0}) {
    cv::Mat noise(rows, cols, CV_32F);
    rng.fill(noise, cv::RNG::NORMAL, 0, 22 * sigma);
    cv::GaussianBlur(noise, noise, {}, sigma);
    sum += noise;
  }
  cv::Mat noise(rows, cols, CV_32F), out;
  rng.fill(noise, cv::RNG::NORMAL, 110, 3);
  sum += noise;
  sum.convertTo(out, CV_8U);
  return out;
}

/// A quarter of the samples show the feature (its place within a pixel, with noise and gain), the rest other places.
void fill(GrowingTree &tree, int samples) {
  const cv::Mat image = texture(480, 640, 1);
  cv::RNG rng(2);
  for (int i = 0; i < samples; ++i) {
    const bool feature = i % 4 == 0;
    const cv::Rect r(feature ? 300 + rng.uniform(-1, 2) : rng.uniform(0, 640 - side),
                     feature ? 200 + rng.uniform(-1, 2) : rng.uniform(0, 480 - side), side, side);
    cv::Mat patch, noise(side, side, CV_16S);
    rng.fill(noise, cv::RNG::NORMAL, 0, 4);
    image(r).convertTo(patch, CV_16S, rng.uniform(.8, 1.2));
    patch += noise;
    patch.convertTo(patch, CV_8U);
    tree.add(patch, feature ? Label::feature : Label::not_feature);
  }
}

struct Node {
  GrowingTree tree{side, {1, 1, 1}, {}};
  std::vector<SampleId> features, others;
  NodeSamples samples;

  explicit Node(int n) {
    fill(tree, n);
    for (SampleId i = 0; i < static_cast<SampleId>(n); ++i)
      (tree.samples().label(i) == Label::feature ? features : others).push_back(i);
    samples.gather(tree.samples(), features, others);
  }
};

void BM_NodeGather(benchmark::State &state) {
  Node node(static_cast<int>(state.range(0)));
  for (auto _ : state) node.samples.gather(node.tree.samples(), node.features, node.others);
  state.SetLabel(simd_target());
}
BENCHMARK(BM_NodeGather)->Arg(500)->Arg(2000)->Unit(benchmark::kMicrosecond);

void BM_NodeRanking(benchmark::State &state) {
  const Node node(static_cast<int>(state.range(0)));
  const LogTable log(node.samples.size());
  std::vector<double> v;
  std::vector<std::uint16_t> ranked;
  for (auto _ : state) {
    variance_ratios(node.samples, log, v);
    rank_pixels(v, 64, ranked);
    benchmark::DoNotOptimize(ranked.data());
  }
}
BENCHMARK(BM_NodeRanking)->Arg(50)->Arg(500)->Arg(2000)->Unit(benchmark::kMicrosecond);

template <auto count>
void pairs(benchmark::State &state) {
  const Node node(static_cast<int>(state.range(0)));
  Random random(1);
  std::vector<PixelPair> list(2528);
  for (PixelPair &p : list)
    p = {static_cast<std::uint16_t>(random.below(441)), static_cast<std::uint16_t>(random.below(441))};
  std::vector<SplitCounts> counts(list.size());
  for (auto _ : state) {
    count(node.samples, list, counts);
    benchmark::DoNotOptimize(counts.data());
  }
}
void BM_Pairs2528(benchmark::State &state) {
  pairs<count_pairs>(state);
}
void BM_Pairs2528Scalar(benchmark::State &state) {
  pairs<count_pairs_scalar>(state);
}
BENCHMARK(BM_Pairs2528)->Arg(500)->Arg(2000)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_Pairs2528Scalar)->Arg(2000)->Unit(benchmark::kMicrosecond);

void BM_Build(benchmark::State &state, PairSearch search) {
  GrowthOptions options;
  options.search.search = search;
  GrowingTree tree(side, {1, 1, 1}, options);
  fill(tree, static_cast<int>(state.range(0)));
  for (auto _ : state) tree.build();
  state.counters["nodes"] = static_cast<double>(tree.node_count());
  state.counters["depth"] = tree.publish()->depth();
}
BENCHMARK_CAPTURE(BM_Build, ranked, PairSearch::ranked)->Arg(900)->Arg(3700)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Build, exhaustive, PairSearch::exhaustive)->Arg(900)->Arg(3700)->Unit(benchmark::kMillisecond);

void BM_AddAndPublish(benchmark::State &state) {
  GrowingTree tree(side, {1, 1, 1}, {});
  fill(tree, 900);
  tree.build();
  const cv::Mat patch = texture(side, side, 5);
  const SampleId id = tree.add(patch, Label::feature);
  for (auto _ : state) {
    tree.replace(id, patch, Label::feature);
    benchmark::DoNotOptimize(tree.publish());
  }
}
BENCHMARK(BM_AddAndPublish)->Unit(benchmark::kMicrosecond);

void BM_Scan41(benchmark::State &state) {
  GrowingTree tree(side, {1, 1, 1}, {});
  fill(tree, 900);
  tree.build();
  const auto published = tree.publish();
  const cv::Mat image = texture(480, 640, 1);
  std::vector<std::int32_t> leaves;
  for (auto _ : state) published->scan(image, {290, 190, 41, 41}, leaves);
}
BENCHMARK(BM_Scan41)->Unit(benchmark::kMicrosecond);

void BM_ColourChoice(benchmark::State &state) {
  ColourPatches patches(side);
  cv::RNG rng(1);
  for (int i = 0; i < state.range(0); ++i) {
    cv::Mat m(side, side, CV_8UC3);
    rng.fill(m, cv::RNG::NORMAL, 100 + i % 4, 30);
    patches.add(m, i % 4 ? Label::not_feature : Label::feature);
  }
  for (auto _ : state) benchmark::DoNotOptimize(choose_colour(patches));
}
BENCHMARK(BM_ColourChoice)->Arg(200)->Arg(900)->Unit(benchmark::kMillisecond);

void BM_Smoke(benchmark::State &state) {
  Random random(1);
  const Smoke smoke(side, random);
  cv::Mat patch(side, side, CV_8UC3, cv::Scalar(10, 90, 200));
  for (auto _ : state) smoke.apply(patch, .25, random);
}
BENCHMARK(BM_Smoke)->Unit(benchmark::kMicrosecond);

}  // namespace
