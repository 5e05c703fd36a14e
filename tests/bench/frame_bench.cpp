// SPDX-License-Identifier: LGPL-2.1-or-later
// The cost of a frame in `csd` before it aligns a feature: luma, pyramid and glare weights. For comparison: OpenCV's
// time for an 8-bit pyramid.
#include <benchmark/benchmark.h>

#include <hwy/highway.h>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "content/glare_weights.h"
#include "core/picture.h"
#include "image/pyramid.h"
#include "image/simd.h"
#include "image/work_frame.h"

namespace csd {
namespace {

const cv::Size sizes[] = {{640, 480}, {1280, 720}, {1920, 1080}};
constexpr struct {
  const char *name;
  test::Layout layout;
} layouts[] = {{"I420", test::Layout::i420}, {"I420_10LE", test::Layout::i420_10le}, {"RGB", test::Layout::rgb}};

/// Smooth tissue with highlights, and an endoscope's round picture area.
struct Scene {
  test::Packed packed;
  cv::Mat forbidden;

  Scene(cv::Size size, test::Layout layout) {
    cv::Mat bgr(size, CV_8UC3);
    cv::RNG random(1);
    random.fill(bgr, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(bgr, bgr, {}, size.height / 100.);
    for (int i = 0; i < 60; ++i)
      cv::circle(bgr, {random.uniform(0, size.width), random.uniform(0, size.height)},
                 random.uniform(1, size.height / 60), cv::Scalar(255, 255, 255), -1);
    packed = test::pack(bgr, layout);
    WorkFrame frame;
    frame.load(packed.view);
    forbidden = cv::Mat(frame.size(), CV_8UC1, cv::Scalar(255));
    cv::circle(forbidden, cv::Point(frame.size() / 2), frame.size().width * 45 / 100, cv::Scalar(0), -1);
  }
};

void load(benchmark::State &state, const Scene &scene) {
  WorkFrame frame;
  for (auto _ : state) {
    frame.load(scene.packed.view);
    benchmark::DoNotOptimize(frame.luma().ptr());
  }
}

void pyramid(benchmark::State &state, const Scene &scene) {
  WorkFrame frame;
  frame.load(scene.packed.view);
  Pyramid levels;
  for (auto _ : state) {
    levels.build(frame.luma());
    benchmark::DoNotOptimize(levels.level(4).ptr());
  }
}

/// If the working image is smaller than the picture, this includes scaling the colour, since load() drops it.
void glare(benchmark::State &state, const Scene &scene) {
  WorkFrame frame;
  GlareWeights weights;
  for (auto _ : state) {
    state.PauseTiming();
    frame.load(scene.packed.view);
    state.ResumeTiming();
    weights.build(frame, scene.forbidden);
    benchmark::DoNotOptimize(weights.level(4).ptr());
  }
}

void all(benchmark::State &state, const Scene &scene) {
  WorkFrame frame;
  Pyramid levels;
  GlareWeights weights;
  for (auto _ : state) {
    frame.load(scene.packed.view);
    levels.build(frame.luma());
    weights.build(frame, scene.forbidden);
    benchmark::DoNotOptimize(weights.level(4).ptr());
  }
}

void opencv(benchmark::State &state, const Scene &scene) {
  WorkFrame frame;
  frame.load(scene.packed.view);
  cv::Mat smooth;
  std::vector<cv::Mat> levels;
  for (auto _ : state) {
    cv::GaussianBlur(frame.luma(), smooth, {}, 1);
    cv::buildPyramid(smooth, levels, Pyramid::levels - 1);
    benchmark::DoNotOptimize(levels.back().data);
  }
}

// Each on the machine's best SIMD target, and on AVX2 where that isn't the best.
const int registered = [] {
  constexpr struct {
    const char *name;
    void (*run)(benchmark::State &, const Scene &);
  } runs[] = {{"load", load}, {"pyramid", pyramid}, {"glare", glare}, {"load_pyramid_glare", all}, {"OpenCV", opencv}};
  const std::int64_t best = hwy::SupportedTargets();
  std::vector<std::int64_t> targets{best};
  if (best & -best & (HWY_AVX3 | HWY_AVX3_DL)) targets.push_back(best & ~(HWY_AVX3 | HWY_AVX3_DL));
  for (const auto &run : runs)
    for (const auto &l : layouts)
      for (const cv::Size &size : sizes)
        for (const auto target : targets) {
          if (run.run == opencv && (target != best || &l != layouts)) continue;
          benchmark::RegisterBenchmark((std::string(run.name) + '/' + l.name + '/' + std::to_string(size.height) +
                                        (target == best ? "" : "/AVX2"))
                                           .c_str(),
                                       [run = run.run, layout = l.layout, size, target](benchmark::State &state) {
                                         hwy::SetSupportedTargetsForTest(target);
                                         run(state, Scene(size, layout));
                                         hwy::SetSupportedTargetsForTest(0);
                                       })
              ->Unit(benchmark::kMicrosecond);
        }
  return 0;
}();

}  // namespace
}  // namespace csd
