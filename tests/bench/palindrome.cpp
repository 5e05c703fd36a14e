// SPDX-License-Identifier: LGPL-2.1-or-later
// Plays clips forward and then backward: a feature must come home. Prints, for each algorithm, how often a position was
// claimed, how often two claims on the same image disagree, and how often a claim is far from the last frame's. A
// measurement, no test.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "track/thread_pool.h"
#include "track/tracker.h"

namespace {

using Positions = std::map<csd::FeatureId, cv::Point2d>;

struct Score {
  double claimed = 0, apart = 0, jumps = 0;
  std::size_t features = 0;
};

csd::FrameView view(const cv::Mat &i420, cv::Size size) {
  csd::FrameView v;
  v.width = size.width;
  v.height = v.rows = size.height;
  v.model = csd::ColourModel::yuv;
  v.kr = 0.299;  // cv::cvtColor's
  v.kb = 0.114;
  const std::ptrdiff_t width = size.width, luma = width * size.height;
  v.component[0] = {i420.data, width, 1, 1, 0, 0, 0};
  v.component[1] = {i420.data + luma, width / 2, 1, 1, 0, 1, 1};
  v.component[2] = {i420.data + luma + luma / 4, width / 2, 1, 1, 0, 1, 1};
  return v;
}

Score play(const std::vector<cv::Mat> &frames, cv::Size size, csd::AlgorithmKind algorithm) {
  csd::Settings settings;
  settings.algorithm = algorithm;
  settings.replenish = false;
  settings.forget_after = 0;
  settings.learn_synchronously = true;
  csd::ThreadPool pool;
  csd::Tracker tracker(settings, pool);
  std::vector<Positions> forward;
  Score score;
  std::size_t claims = 0, chances = 0, both = 0, apart = 0, steps = 0, jumps = 0;
  Positions last;
  const std::size_t n = frames.size();
  for (std::size_t i = 0; i < 2 * n; ++i) {
    const auto &frame = frames[i < n ? i : 2 * n - 1 - i];
    const auto &tracks = tracker.process(view(frame, size), static_cast<std::int64_t>(i) * csd::second / 25);
    Positions here;
    for (const auto &f : tracks.features) {
      if (f.state == csd::FeatureState::ended) continue;
      ++chances;
      if (f.state == csd::FeatureState::learning || f.state == csd::FeatureState::tracked) here[f.id] = {f.x, f.y};
    }
    claims += here.size();
    for (const auto &[id, p] : here)
      if (const auto then = last.find(id); then != last.end()) {
        ++steps;
        jumps += cv::norm(then->second - p) > 10;
      }
    last = here;
    if (i < n) {
      forward.push_back(here);
      score.features = std::max(score.features, tracks.features.size());
    } else {
      for (const auto &[id, p] : here)
        if (const auto then = forward[2 * n - 1 - i].find(id); then != forward[2 * n - 1 - i].end()) {
          ++both;
          apart += cv::norm(then->second - p) > 5;
        }
    }
  }
  score.claimed = chances ? static_cast<double>(claims) / static_cast<double>(chances) : 0;
  score.apart = both ? static_cast<double>(apart) / static_cast<double>(both) : 0;
  score.jumps = steps ? static_cast<double>(jumps) / static_cast<double>(steps) : 0;
  return score;
}

}  // namespace

int main(int argc, char **argv) {
  if (argc < 2 || std::string_view(argv[1]) == "--help") {
    std::printf(
        "usage: palindrome VIDEO...\nAt most 160 frames of each, forward and back, learning=sync, 50 features.\n");
    return argc < 2 ? 2 : 0;
  }
  std::printf(
      "| clip | features | csd-2012: claimed | > 5 px apart | > 10 px a frame | lk: claimed | > 5 px apart "
      "| > 10 px a frame |\n|---|---|---|---|---|---|---|---|\n");
  for (int k = 1; k < argc; ++k) {
    cv::VideoCapture video(argv[k]);
    std::vector<cv::Mat> frames;
    cv::Size size;
    for (cv::Mat bgr; frames.size() < 160 && video.read(bgr);) {
      size = {bgr.cols & ~1, bgr.rows & ~1};
      cv::Mat i420;
      cv::cvtColor(bgr(cv::Rect({0, 0}, size)), i420, cv::COLOR_BGR2YUV_I420);
      frames.push_back(i420);
    }
    if (frames.empty()) {
      std::fprintf(stderr, "palindrome: %s: no video in it\n", argv[k]);
      return 1;
    }
    const auto ours = play(frames, size, csd::AlgorithmKind::csd_2012), lk = play(frames, size, csd::AlgorithmKind::lk);
    std::printf("| %s | %zu | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f |\n",
                std::filesystem::path(argv[k]).stem().c_str(), ours.features, ours.claimed, ours.apart, ours.jumps,
                lk.claimed, lk.apart, lk.jumps);
    std::fflush(stdout);
  }
}
