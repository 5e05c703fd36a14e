// SPDX-License-Identifier: LGPL-2.1-or-later
// The cost of aligning one feature in a frame, and of its anchor during learning, on each SIMD target. For comparison:
// OpenCV's PyrLK forward and backward.
#include <benchmark/benchmark.h>

#include <cmath>
#include <opencv2/video/tracking.hpp>
#include <string>

#include "core/patch/warped_picture.h"
#include "core/simd_targets.h"
#include "core/track/moving_scene.h"
#include "image/work_frame.h"
#include "patch/align.h"
#include "patch/anchor_median.h"

namespace csd {
namespace {

constexpr int features = 100;
const cv::Size size{640, 480};

/// Two frames of a texture with sensor noise, and a hundred features with their places in both.
struct Scene {
  cv::Mat first, second;
  Pyramid pyramid;
  GlareWeights glare;
  std::vector<Anchor> anchors;
  std::vector<AffineState> start;
  std::vector<cv::Point2f> points;

  Scene(double degrees, bool highlights) : anchors(features) {
    const test::Waves texture(1, 6, 60, 22);
    const test::View before{{{320, 240}}, 1, 120, 2, 1, size};
    // Between the frames, the texture moves by half a pixel at the centre and up to 3 px at the edge.
    const auto turn = test::similarity(degrees), more = test::similarity(degrees + .3, 1.005);
    const test::View after{{{320.4, 239.7}, more}, .95, 118, 2, 2, size};
    first = render(texture, before);
    second = render(texture, after);
    Pyramid p;
    p.build(first);
    pyramid.build(second);
    if (highlights) {  // in nearly every patch
      WorkFrame frame;
      frame.load(MovingScene::gray_view(cv::Mat(size, CV_8UC1, 100)));
      cv::Mat forbidden = cv::Mat::zeros(size, CV_8UC1);
      for (int y = 0; y < size.height; y += 16)
        for (int x = 0; x < size.width; x += 16) forbidden({x, y, 4, 4}).setTo(255);
      glare.build(frame, forbidden);
    }
    for (std::size_t i = 0; i < features; ++i) {
      const auto n = static_cast<int>(i);
      const cv::Point2d at(140 + (n * 53) % 360, 90 + (n * 97) % 300);
      points.emplace_back(at);
      for (int l = 0; l <= Anchor::coarsest; ++l) anchors[i].set(l, make_anchor_level(sample(p, {}, {at}, l)));
      // A prediction with an error of about half a pixel.
      const cv::Vec2d u = more * cv::Vec2d(at.x - 320, at.y - 240);
      start.push_back({{320.4 + u[0] + .5 * std::sin(n), 239.7 + u[1] + .5 * std::cos(n)}, turn});
    }
  }
};

enum class Kind { upright, turned, masked };

const Scene &scene(Kind kind) {
  static const Scene upright(0, false), turned(35, false), masked(0, true);
  return kind == Kind::upright ? upright : kind == Kind::turned ? turned : masked;
}

using Align = decltype(&align);

void per_feature(benchmark::State &state) {
  state.counters["per_feature"] = benchmark::Counter(static_cast<double>(state.iterations() * features),
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void fine_pass(benchmark::State &state, Align run, Kind kind) {
  const Scene &s = scene(kind);
  double iterations = 0;
  for (auto _ : state)
    for (std::size_t i = 0; i < features; ++i) {
      const Alignment a =
          run(s.pyramid, s.glare, s.anchors[i].level(0), 0, s.start[i], {}, AlignModel::affine, fine_precision);
      iterations += a.iterations;
    }
  per_feature(state);
  state.counters["iterations"] = iterations / static_cast<double>(state.iterations() * features);
}

void coarse_and_fine(benchmark::State &state, Align run, Kind kind) {
  const Scene &s = scene(kind);
  for (auto _ : state)
    for (std::size_t i = 0; i < features; ++i) {
      const Alignment coarse =
          run(s.pyramid, s.glare, s.anchors[i].level(1), 1, s.start[i], {}, AlignModel::similarity, coarse_precision);
      AlignPrior prior;
      prior.position = coarse.information * .25;
      Alignment fine =
          run(s.pyramid, s.glare, s.anchors[i].level(0), 0, coarse.state, prior, AlignModel::affine, fine_precision);
      benchmark::DoNotOptimize(fine.zncc);
    }
  per_feature(state);
}

/// A level's samples over the training time, each with its own gain, bias and noise.
std::vector<PatchSample> training(std::size_t samples) {
  const test::Waves texture(1, 6, 60, 22);
  cv::RNG random(1);
  std::vector<PatchSample> out(samples);
  for (auto &sample : out) {
    const double gain = random.uniform(.8, 1.2), bias = random.uniform(100., 130.);
    for (int y = -PatchPlane::radius; y <= PatchPlane::radius; ++y)
      for (int x = -PatchPlane::radius; x <= PatchPlane::radius; ++x) {
        sample.value.at(x, y) = static_cast<float>(gain * texture.at(x, y) + bias + random.gaussian(2));
        sample.weight.at(x, y) = 1;
      }
  }
  return out;
}

void anchor_add(benchmark::State &state) {
  const auto samples = training(AnchorMedian::most);
  AnchorMedian median;
  median.add(samples[0]);
  for (auto _ : state) {
    if (median.size() == AnchorMedian::most) {
      state.PauseTiming();
      median = {};
      median.add(samples[0]);
      state.ResumeTiming();
    }
    median.add(samples[median.size()]);
  }
}

void anchor_make(benchmark::State &state) {
  AnchorMedian median;
  for (const auto &sample : training(13)) median.add(sample);
  for (auto _ : state) benchmark::DoNotOptimize(median.make().patch.data.data());
}

void anchor_add_and_make_scalar(benchmark::State &state) {
  const auto samples = training(13);
  for (auto _ : state) {
    std::vector<CompactPatch> compacts;
    for (const auto &sample : samples) {
      compacts.push_back(compact_scalar(sample));
      if (compacts.size() > 1) bring_to_scalar(compacts.front(), compacts.back());
    }
    benchmark::DoNotOptimize(make_anchor_level(median_of_scalar(compacts)).patch.data.data());
  }
}
BENCHMARK(anchor_add_and_make_scalar)->Unit(benchmark::kMicrosecond);

void opencv_pyrlk_forward_backward(benchmark::State &state) {
  const Scene &s = scene(Kind::upright);
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

const int registered = [] {
  const auto add = [](const std::string &name, auto what, Align run, Kind kind, std::int64_t target) {
    benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State &state) {
      const test::OnTarget scope(target);
      what(state, run, kind);
    })->Unit(benchmark::kMicrosecond);
  };
  const auto add_all = [&](const std::string &name, Align run, std::int64_t target) {
    add("fine_pass/" + name, fine_pass, run, Kind::upright, target);
    add("fine_pass_turned/" + name, fine_pass, run, Kind::turned, target);
    add("fine_pass_masked/" + name, fine_pass, run, Kind::masked, target);
    add("coarse_and_fine/" + name, coarse_and_fine, run, Kind::upright, target);
  };
  const auto add_anchor = [](const std::string &name, void (*what)(benchmark::State &), std::int64_t target) {
    benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State &state) {
      const test::OnTarget scope(target);
      what(state);
    })->Unit(benchmark::kMicrosecond);
  };
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    add_all(hwy::TargetName(target), align, target);
    add_anchor(std::string("anchor_add/") + hwy::TargetName(target), anchor_add, target);
    add_anchor(std::string("anchor_make/") + hwy::TargetName(target), anchor_make, target);
  }
  add_all("scalar", align_scalar, 0);
  return 0;
}();

}  // namespace
}  // namespace csd
