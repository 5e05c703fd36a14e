// SPDX-License-Identifier: LGPL-2.1-or-later
// The cost of detection, once for each picture it looks at, and of the content area, in each frame.
#include <benchmark/benchmark.h>

#include <opencv2/imgproc.hpp>

#include <cmath>
#include <vector>

#include "content/content_area.h"
#include "core/content/noisy_texture.h"
#include "detect/detect.h"
#include "detect/dog.h"
#include "detect/merge.h"
#include "detect/shi_tomasi.h"

namespace csd {
namespace {

constexpr int patch = 21;
constexpr int window = 7;
constexpr std::size_t wanted = 50;

/// 640 × `lines`: a window that swings over a texture, noise, a round field on black, and text.
cv::Mat picture(int lines, int frame) {
  static const cv::Mat texture = blob_texture({700, 640});
  const cv::Size size(640, lines);
  cv::RNG rng(static_cast<std::uint64_t>(frame) + 1);
  const auto shift = [&](double rate) { return 30 + static_cast<int>(std::lround(25 * std::sin(rate * frame))); };
  const cv::Mat tissue = with_noise(texture({{shift(0.2), shift(0.15)}, size}), 2, rng);
  cv::Mat field = cv::Mat::zeros(size, CV_8UC1), result(size, CV_8UC1, cv::Scalar(16));
  cv::circle(field, {320, lines / 2}, 300, cv::Scalar(255), cv::FILLED);
  tissue.copyTo(result, field);
  cv::putText(result, "LASER OFF", {240, 250}, cv::FONT_HERSHEY_SIMPLEX, 1, cv::Scalar(235), 2);
  return result;
}

cv::Mat everywhere(const cv::Mat &luma) {
  return cv::Mat(luma.size(), CV_8UC1, cv::Scalar(255));
}

void dog(benchmark::State &state) {
  const cv::Mat luma = picture(static_cast<int>(state.range(0)), 0), all = everywhere(luma);
  for (auto _ : state) benchmark::DoNotOptimize(find_dog(luma, all).data());
}

void shi_tomasi(benchmark::State &state) {
  const cv::Mat luma = picture(static_cast<int>(state.range(0)), 0), all = everywhere(luma);
  for (auto _ : state) benchmark::DoNotOptimize(find_shi_tomasi(luma, all, window, patch / 2.0).data());
}

void merge(benchmark::State &state) {
  const cv::Mat luma = picture(static_cast<int>(state.range(0)), 0), all = everywhere(luma);
  const Candidates a = find_dog(luma, all), b = find_shi_tomasi(luma, all, window, patch / 2.0);
  for (auto _ : state) {
    const auto ranked = merge_by_rank(a, b, patch / 2.0);
    benchmark::DoNotOptimize(spread(ranked, luma.size(), 2 * patch, wanted).data());
  }
  state.counters["candidates"] = static_cast<double>(a.size() + b.size());
}

void detect_all(benchmark::State &state) {
  const cv::Mat luma = picture(static_cast<int>(state.range(0)), 0);
  for (auto _ : state) benchmark::DoNotOptimize(detect(luma, {}, {}, {patch, wanted}).data());
}

/// The mean over frames at 25 a second, most of which need no look. In the share `changed` of them the forbidden area
/// changes.
void content_area_per_frame(benchmark::State &state) {
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 128; ++i) frames.push_back(picture(static_cast<int>(state.range(0)), i));
  ContentAreaFinder finder;
  std::int64_t frame = 0, changed = 0;
  for (auto _ : state) {
    finder.update(frames[static_cast<std::size_t>(frame) % frames.size()], frame * 40'000'000, patch);
    changed += finder.changed() ? 1 : 0;
    ++frame;
  }
  state.counters["changed"] = static_cast<double>(changed) / static_cast<double>(frame);
}

BENCHMARK(dog)->Arg(480)->Arg(512)->Arg(576)->Unit(benchmark::kMillisecond);
BENCHMARK(shi_tomasi)->Arg(480)->Arg(512)->Arg(576)->Unit(benchmark::kMillisecond);
BENCHMARK(merge)->Arg(480)->Arg(512)->Arg(576)->Unit(benchmark::kMillisecond);
BENCHMARK(detect_all)->Name("detect")->Arg(480)->Arg(512)->Arg(576)->Unit(benchmark::kMillisecond);
BENCHMARK(content_area_per_frame)->Arg(480)->Arg(512)->Arg(576)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace csd
