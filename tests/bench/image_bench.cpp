// SPDX-License-Identifier: LGPL-2.1-or-later
// The cost of the working image: load(), colour of one window and of the whole picture, and the gray window of
// GRAY16_LE.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "core/picture.h"
#include "image/gray_window.h"
#include "image/work_frame.h"

namespace csd {
namespace {

struct Size {
  int width, height;
};
constexpr Size sizes[] = {{640, 480}, {1280, 720}, {1920, 1080}, {3840, 2160}};
constexpr struct {
  const char *name;
  test::Layout layout;
} layouts[] = {{"I420", test::Layout::i420},          {"UYVY", test::Layout::uyvy},
               {"v210", test::Layout::v210},          {"BGRx", test::Layout::bgrx},
               {"r210", test::Layout::r210},          {"RGBA64_LE", test::Layout::rgba64_le},
               {"GRAY16_LE", test::Layout::gray16_le}};

cv::Mat noise(const Size &size) {
  cv::Mat bgr(size.height, size.width, CV_8UC3);
  cv::RNG(1).fill(bgr, cv::RNG::UNIFORM, 0, 256);
  return bgr;
}

void load(benchmark::State &state, test::Layout layout, Size size) {
  const auto packed = test::pack(noise(size), layout);
  WorkFrame frame;
  for (auto _ : state) {
    frame.load(packed.view);
    benchmark::DoNotOptimize(frame.luma().ptr());
  }
}

/// Another window of a frame in which every band has been used already.
void window(benchmark::State &state, test::Layout layout, Size size) {
  const auto packed = test::pack(noise(size), layout);
  WorkFrame frame;
  frame.load(packed.view);
  cv::Mat out;
  frame.gather_bgr({{0, 0}, frame.size()}, out);
  int x = 0;
  for (auto _ : state) {
    x = (x + 37) % 500;
    frame.gather({x, x / 2, 61, 61}, {2, -1, 1}, out);
    benchmark::DoNotOptimize(out.data);
  }
}

/// All the colour of a frame for the first time: scaled if necessary, and converted.
void whole(benchmark::State &state, test::Layout layout, Size size) {
  const auto packed = test::pack(noise(size), layout);
  WorkFrame frame;
  cv::Mat out;
  for (auto _ : state) {
    state.PauseTiming();
    frame.load(packed.view);
    state.ResumeTiming();
    frame.gather_bgr({{0, 0}, frame.size()}, out);
    benchmark::DoNotOptimize(out.data);
  }
}

/// The same for the second time.
void whole_again(benchmark::State &state, test::Layout layout, Size size) {
  const auto packed = test::pack(noise(size), layout);
  WorkFrame frame;
  frame.load(packed.view);
  cv::Mat out;
  for (auto _ : state) {
    frame.gather_bgr({{0, 0}, frame.size()}, out);
    benchmark::DoNotOptimize(out.data);
  }
}

/// Finds the range of a picture that uses 4 % of 16 bit.
void gray_window(benchmark::State &state, Size size) {
  cv::Mat1w picture(size.height, size.width);
  cv::RNG(1).fill(picture, cv::RNG::UNIFORM, 1000, 3600);
  FrameView view;
  view.width = size.width;
  view.height = view.rows = size.height;
  view.open_range = true;
  view.component[0] = {.data = picture.data, .row_stride = 2 * size.width, .pixel_stride = 2, .bytes = 2, .shift = 8};
  GrayWindow window;
  std::int64_t time = 0;
  for (auto _ : state) benchmark::DoNotOptimize(window.look(view, time += 40'000'000));
}

const int registered = [] {
  for (const Size &size : sizes)
    benchmark::RegisterBenchmark(("gray_window/" + std::to_string(size.height)).c_str(), [size](
                                                                                             benchmark::State &state) {
      gray_window(state, size);
    })->Unit(benchmark::kMicrosecond);
  constexpr struct {
    const char *name;
    void (*run)(benchmark::State &, test::Layout, Size);
  } runs[] = {{"load", load}, {"gather61", window}, {"gather_bgr_first", whole}, {"gather_bgr_again", whole_again}};
  for (const auto &run : runs)
    for (const auto &l : layouts)
      for (const Size &size : sizes)
        benchmark::RegisterBenchmark(
            (std::string(run.name) + '/' + l.name + '/' + std::to_string(size.height)).c_str(),
            [run = run.run, layout = l.layout, size](benchmark::State &state) { run(state, layout, size); })
            ->Unit(benchmark::kMicrosecond);
  return 0;
}();

}  // namespace
}  // namespace csd
