// SPDX-License-Identifier: LGPL-2.1-or-later
// What one feature's alignment costs in a frame, on each SIMD target; OpenCV's PyrLK there and back beside it.
#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <cmath>
#include <opencv2/video/tracking.hpp>
#include <string>

#include "core/track/warped_picture.h"
#include "track/align.h"

namespace csd {
namespace {

constexpr int features = 100;
const cv::Size size{640, 480};

/// Two frames of a texture with sensor noise, and a hundred features: where they were, where they are.
struct Scene {
  cv::Mat first, second;
  Pyramid pyramid;
  GlareWeights glare;
  std::vector<Anchor> anchors;
  std::vector<AffineState> start;
  std::vector<cv::Point2f> points;

  explicit Scene(double degrees) : anchors(features) {
    const test::Waves texture(1, 6, 60, 22);
    const test::View before{{{320, 240}}, 1, 120, 2, 1, size};
    // From one frame to the next: half a pixel at the centre, up to 3 px at the edge.
    const auto turn = test::similarity(degrees), more = test::similarity(degrees + .3, 1.005);
    const test::View after{{{320.4, 239.7}, more}, .95, 118, 2, 2, size};
    first = render(texture, before);
    second = render(texture, after);
    Pyramid p;
    p.build(first);
    pyramid.build(second);
    for (std::size_t i = 0; i < features; ++i) {
      const auto n = static_cast<int>(i);
      const cv::Point2d at(140 + (n * 53) % 360, 90 + (n * 97) % 300);
      points.emplace_back(at);
      for (int l = 0; l <= Anchor::coarsest; ++l) anchors[i].set(l, make_anchor_level(sample(p, glare, {at}, l)));
      // A prediction that is off by about half a pixel.
      const cv::Vec2d u = more * cv::Vec2d(at.x - 320, at.y - 240);
      start.push_back({{320.4 + u[0] + .5 * std::sin(n), 239.7 + u[1] + .5 * std::cos(n)}, turn});
    }
  }
};

const Scene &scene(bool turned) {
  static const Scene upright(0), rotated(35);
  return turned ? rotated : upright;
}

using Align = decltype(&align);

void per_feature(benchmark::State &state) {
  state.counters["per_feature"] = benchmark::Counter(static_cast<double>(state.iterations() * features),
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void fine_pass(benchmark::State &state, Align run, bool turned) {
  const Scene &s = scene(turned);
  double iterations = 0;
  for (auto _ : state)
    for (std::size_t i = 0; i < features; ++i) {
      const Alignment a = run(s.pyramid, s.glare, s.anchors[i].level(0), 0, s.start[i], {}, AlignModel::affine);
      iterations += a.iterations;
    }
  per_feature(state);
  state.counters["iterations"] = iterations / static_cast<double>(state.iterations() * features);
}

void coarse_and_fine(benchmark::State &state, Align run, bool turned) {
  const Scene &s = scene(turned);
  for (auto _ : state)
    for (std::size_t i = 0; i < features; ++i) {
      const Alignment coarse =
          run(s.pyramid, s.glare, s.anchors[i].level(1), 1, s.start[i], {}, AlignModel::similarity);
      AlignPrior prior;
      prior.position = coarse.information * .25;
      const Alignment fine = run(s.pyramid, s.glare, s.anchors[i].level(0), 0, coarse.state, prior, AlignModel::affine);
      benchmark::DoNotOptimize(fine.zncc);
    }
  per_feature(state);
}

void opencv_pyrlk_forward_backward(benchmark::State &state) {
  const Scene &s = scene(false);
  for (auto _ : state) {
    std::vector<cv::Point2f> there, back;
    std::vector<unsigned char> found;
    std::vector<float> error;
    const cv::Size window(21, 21);
    cv::calcOpticalFlowPyrLK(s.first, s.second, s.points, there, found, error, window, 2);
    cv::calcOpticalFlowPyrLK(s.second, s.first, there, back, found, error, window, 2);
    benchmark::DoNotOptimize(back.data());
  }
  per_feature(state);
}
BENCHMARK(opencv_pyrlk_forward_backward)->Unit(benchmark::kMicrosecond);

void on_target(std::int64_t target) {
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

const int registered = [] {
  const auto add = [](const std::string &name, auto what, Align run, bool turned, std::int64_t target) {
    benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State &state) {
      on_target(target);
      what(state, run, turned);
      on_target(0);
    })->Unit(benchmark::kMicrosecond);
  };
  const auto add_all = [&](const std::string &name, Align run, std::int64_t target) {
    add("fine_pass/" + name, fine_pass, run, false, target);
    add("fine_pass_turned/" + name, fine_pass, run, true, target);
    add("coarse_and_fine/" + name, coarse_and_fine, run, false, target);
  };
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) add_all(hwy::TargetName(target), align, target);
  add_all("scalar", align_scalar, 0);
  return 0;
}();

}  // namespace
}  // namespace csd
