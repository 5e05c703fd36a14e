// SPDX-License-Identifier: LGPL-2.1-or-later
// The time of a frame on the streaming thread (Tracker::process), by size, format, number of features and algorithm.
// For comparison: OpenCV's PyrLK on as many points of the same frames. Then how csd's cost and memory grow, and whether
// its budget holds. Learning runs in its own thread, as in use.
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <string_view>
#include <thread>
#include <vector>

#include "algorithms/make_algorithm.h"
#include "core/picture.h"
#include "core/track/moving_scene.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace {

using Clock = std::chrono::steady_clock;

double ms(Clock::time_point from) {
  return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

struct Percentiles {
  double p50, p95;
};

Percentiles percentiles(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values[values.size() / 2], values[values.size() * 95 / 100]};
}

struct Format {
  csd::test::Layout layout;
  const char *name;
};

constexpr int pictures = 16;  // played forwards and backwards, so that the motion has no jump

int picture_of(int frame) {
  const int i = frame % (2 * pictures - 2);
  return i < pictures ? i : 2 * pictures - 2 - i;
}

/// The scene at the size of the working image, enlarged. So the working image's texture is equally fine at every size.
std::vector<cv::Mat> render(cv::Size size) {
  const double zoom = std::max(1.0, size.height / 576.0);
  const csd::MovingScene scene({static_cast<int>(size.width / zoom), static_cast<int>(size.height / zoom)});
  std::vector<cv::Mat> out;
  for (int i = 0; i < pictures; ++i) {
    cv::Mat enlarged;
    cv::resize(scene.render({0.6 * i, 4 * std::sin(0.3 * i)}), enlarged, size, 0, 0, cv::INTER_CUBIC);
    out.push_back(enlarged);
  }
  return out;
}

Percentiles time_tracker(const std::vector<csd::test::Packed> &frames, csd::AlgorithmKind algorithm, unsigned features,
                         int warm, int timed) {
  csd::Settings settings;
  settings.algorithm = algorithm;
  settings.max_features = features;
  csd::ThreadPool pool(0, 10);
  csd::Tracker tracker(settings, make_algorithm(settings, pool));
  int i = 0;
  const auto next = [&] {
    const auto pts = i * csd::second / 25;
    return tracker.process(frames[static_cast<std::size_t>(picture_of(i++))].view, pts, csd::second / 25).frame;
  };
  // The start (detection, LK, learning) is not part of a frame's cost. csd-2012's start ends when its descriptors have
  // taken over; the learners get time for that.
  for (int k = 0; k < warm; ++k) next();
  while (algorithm == csd::AlgorithmKind::csd_2012 && tracker.stats().learned < tracker.stats().detected && i < 20000) {
    next();
    if (tracker.stats().queue > 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::vector<double> times;
  for (int k = 0; k < timed; ++k) {
    const auto start = Clock::now();
    next();
    times.push_back(ms(start));
  }
  return percentiles(times);
}

Percentiles time_opencv(const std::vector<cv::Mat> &gray, unsigned features, int timed) {
  std::vector<cv::Point2f> points, next;
  cv::goodFeaturesToTrack(gray[0], points, static_cast<int>(features), 0.001, 10);
  std::vector<unsigned char> found;
  std::vector<float> error;
  std::vector<double> times;
  for (int i = 0; i < timed; ++i) {
    const auto &a = gray[static_cast<std::size_t>(picture_of(i))],
               &b = gray[static_cast<std::size_t>(picture_of(i + 1))];
    const auto start = Clock::now();
    cv::calcOpticalFlowPyrLK(a, b, points, next, found, error);
    times.push_back(ms(start));
  }
  return percentiles(times);
}

struct Growth {
  cv::Size size;
  unsigned features;
  std::int64_t budget = 0;  // ns
  int timed = 0;
};

struct Grown {
  double first, p50, p95, most;  // ms; first: the very first frame
  double heap;                   // MB in use at the end
  std::vector<double> times;
};

double heap() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

/// Points on a grid, exactly as many as wanted.
std::vector<csd::StartPoint> grid(cv::Size size, unsigned wanted) {
  std::vector<csd::StartPoint> points;
  const double side = std::sqrt(0.81 * size.area() / wanted);
  for (double y = 0.05 * size.height; y < 0.95 * size.height; y += side)
    for (double x = 0.05 * size.width; x < 0.95 * size.width && points.size() < wanted; x += side)
      points.push_back({static_cast<csd::FeatureId>(points.size()), {x, y}});
  return points;
}

Grown grow(const std::vector<csd::test::Packed> &frames, const Growth &what) {
  csd::Settings settings;
  settings.algorithm = csd::AlgorithmKind::csd;
  settings.points_from_start = true;
  settings.frame_budget = what.budget;
  csd::ThreadPool pool(0, 10);
  const double before = heap();
  csd::Tracker tracker(settings, make_algorithm(settings, pool));
  tracker.offer_start(grid(what.size, what.features));
  Grown out{};
  // Two seconds: all anchors are complete after the first.
  for (int i = 0; i < what.timed + 50; ++i) {
    const auto start = Clock::now();
    tracker.process(frames[static_cast<std::size_t>(picture_of(i))].view, i * csd::second / 25, csd::second / 25);
    const double took = ms(start);
    if (i == 0) out.first = took;
    if (i >= 50) out.times.push_back(took);
    out.most = std::max(out.most, took);
  }
  const auto p = percentiles(out.times);
  out.p50 = p.p50, out.p95 = p.p95, out.heap = heap() - before;
  return out;
}

std::vector<csd::test::Packed> pack_i420(const std::vector<cv::Mat> &scene) {
  std::vector<csd::test::Packed> frames;
  for (const auto &picture : scene) frames.push_back(csd::test::pack(picture, csd::test::Layout::i420));
  return frames;
}

void print_growth(bool quick) {
  const int timed = quick ? 5 : 200;
  std::printf("\ncsd by the number of features (points on a grid; I420), ms a frame p50 / p95, MB in use\n");
  std::printf("%-10s %8s  %16s  %6s\n", "size", "features", "csd", "MB");
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(1920, 1080)}) {
    const auto frames = pack_i420(render(size));
    for (const unsigned features : {1u, 10u, 30u, 100u, 300u, 1000u}) {
      const auto grown = grow(frames, {size, features, 0, timed});
      std::printf("%4dx%-5d %8u  %7.2f /%7.2f  %6.1f\n", size.width, size.height, features, grown.p50, grown.p95,
                  grown.heap);
      std::fflush(stdout);
      if (quick) return;
    }
  }
  std::printf("\ncsd by the size of the picture (100 features, I420), ms a frame p50 / p95, MB in use\n");
  std::printf("%-10s  %16s  %6s\n", "size", "csd", "MB");
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(640, 480), cv::Size(1024, 576), cv::Size(1280, 720),
                              cv::Size(1920, 1080), cv::Size(2560, 1440), cv::Size(3840, 2160)}) {
    const auto grown = grow(pack_i420(render(size)), {size, 100, 0, timed});
    std::printf("%4dx%-5d  %7.2f /%7.2f  %6.1f\n", size.width, size.height, grown.p50, grown.p95, grown.heap);
    std::fflush(stdout);
  }
  std::printf("\ncsd over time (640x480 I420, 100 features), ms a frame p50 / p95\n%-10s  %16s\n", "minute", "csd");
  const auto small = grow(pack_i420(render({640, 480})), {{640, 480}, 100, 0, 10 * 1500});
  for (std::size_t i = 0; i < 10; ++i) {
    const auto begin = small.times.begin() + static_cast<std::ptrdiff_t>(1500 * i);
    const auto p = percentiles({begin, begin + 1500});
    std::printf("%-10zu  %7.2f /%7.2f\n", i + 1, p.p50, p.p95);
  }
  std::printf(
      "\ncsd with a frame-budget (3840x2160 I420, 1000 features), ms a frame p50 / p95, the most, the first frame\n");
  std::printf("%-10s  %16s  %8s  %8s\n", "budget", "csd", "most", "first");
  const auto large = pack_i420(render({3840, 2160}));
  for (const int budget : {0, 33, 20}) {
    const auto grown = grow(large, {{3840, 2160}, 1000, budget * csd::second / 1000, timed});
    std::printf("%2d ms       %7.2f /%7.2f  %8.2f  %8.2f\n", budget, grown.p50, grown.p95, grown.most, grown.first);
  }
}

}  // namespace

int main(int argc, char **argv) {
  const bool quick = argc > 1 && std::string_view(argv[1]) == "--quick";
  if (argc > 1 && !quick) {
    std::printf("usage: bench-frames [--quick]\nPrints ms a frame, p50 and p95. --quick: few frames, one size.\n");
    return std::string_view(argv[1]) == "--help" ? 0 : 2;
  }
  const int timed = quick ? 10 : 200, warm = quick ? 10 : 60;
  std::vector<cv::Size> sizes{{640, 480}, {1280, 720}, {1920, 1080}, {3840, 2160}};
  if (quick) sizes.resize(1);
  const Format formats[] = {
      {csd::test::Layout::i420, "I420"}, {csd::test::Layout::uyvy, "UYVY"}, {csd::test::Layout::v210, "v210"}};
  std::printf(
      "ms a frame on the streaming thread, p50 / p95 of %d frames; OpenCV's PyrLK on as many points of the gray "
      "frames\n",
      timed);
  std::printf("%-10s %-5s %8s  %16s  %16s  %16s  %16s\n", "size", "", "features", "csd", "csd-2012", "lk",
              "OpenCV PyrLK");
  for (const auto &size : sizes) {
    const auto scene = render(size);
    std::vector<cv::Mat> gray(scene.size());
    for (std::size_t i = 0; i < scene.size(); ++i) cv::cvtColor(scene[i], gray[i], cv::COLOR_BGR2GRAY);
    for (const auto &format : formats) {
      std::vector<csd::test::Packed> frames;
      for (const auto &picture : scene) frames.push_back(csd::test::pack(picture, format.layout));
      for (const unsigned features : {50u, 100u}) {
        const auto ours = time_tracker(frames, csd::AlgorithmKind::csd, features, warm, timed);
        const auto paper = time_tracker(frames, csd::AlgorithmKind::csd_2012, features, warm, timed);
        const auto lk = time_tracker(frames, csd::AlgorithmKind::lk, features, 10, timed);
        const auto opencv = time_opencv(gray, features, timed);
        std::printf("%4dx%-5d %-5s %8u  %7.2f /%7.2f  %7.2f /%7.2f  %7.2f /%7.2f  %7.2f /%7.2f\n", size.width,
                    size.height, format.name, features, ours.p50, ours.p95, paper.p50, paper.p95, lk.p50, lk.p95,
                    opencv.p50, opencv.p95);
        std::fflush(stdout);
      }
    }
  }
  print_growth(quick);
}
