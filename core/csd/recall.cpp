// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/recall.h"

#include <algorithm>

namespace csd {
namespace {

constexpr std::size_t hypotheses = 60;  // matches of which all pairs are tried

/// Standard deviation of a pyramid level, grey levels.
double contrast(const cv::Mat &level) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(level, mean, deviation);
  return deviation[0] / 256;
}

/// Least squares over the matches that agree with `like`.
Similarity refit(const std::vector<Correspondence> &matches, const Similarity &like, double limit) {
  std::vector<double> weights;
  weights.reserve(matches.size());
  for (const auto &m : matches) weights.push_back(squared(like(m.from) - m.to) <= limit ? 1 : 0);
  const auto moments = PointMoments::of(matches, weights.data());
  return moments.degenerate() ? like : fit_similarity(moments);
}

}  // namespace

std::optional<Similarity> agree_on_similarity(const std::vector<Correspondence> &matches, double tolerance,
                                              std::size_t least, double max_zoom) {
  const double limit = tolerance * tolerance;
  const auto agreeing = [&](const Similarity &s) {
    return static_cast<std::size_t>(std::count_if(
        matches.begin(), matches.end(), [&](const Correspondence &m) { return squared(s(m.from) - m.to) <= limit; }));
  };
  Similarity best;
  std::size_t most = 0;
  const auto n = std::min(matches.size(), hypotheses);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      // Nearer pairs do not determine the rotation.
      if (squared(matches[j].from - matches[i].from) < 16 * limit) continue;
      const auto s = similarity_through(matches[i], matches[j]);
      if (!s.zooms_at_most(max_zoom)) continue;
      if (const auto count = agreeing(s); count > most) {
        most = count;
        best = s;
      }
    }
  if (most < least) return {};
  for (int round = 0; round < 3; ++round) best = refit(matches, best, limit);
  if (agreeing(best) < least || !best.zooms_at_most(max_zoom)) return {};
  return best;
}

void Recall::remember(const CsdFrame &frame, const NeighbourField &field, int chart) {
  const auto n = field.size(chart);
  if (n == 0) return;
  if (scenes_.empty() || scenes_.back().chart < chart) {
    // Keeps the oldest scene, where the operation began, and the latest ones.
    if (scenes_.size() >= count(frame.tuning.max_scenes)) scenes_.erase(scenes_.begin() + 1);
    scenes_.push_back({});
    scenes_.back().chart = chart;
  }
  auto scene = std::find_if(scenes_.begin(), scenes_.end(), [&](const Scene &s) { return s.chart == chart; });
  if (scene == scenes_.end()) return;
  // In a fade to black, points stay visible long after the picture has too little contrast to match.
  const double worth = static_cast<double>(n) * contrast(frame.pyramid.level(Pyramid::levels - 1));
  const bool usual = worth >= frame.tuning.usual_share * scene->usual;
  scene->usual += (scene->usual == 0 ? 1.0 : frame.tuning.scene_rate * frame.steps) * (worth - scene->usual);
  if (!usual) return;
  scene->field = field;
  scene->field.keep(chart);
  frame.pyramid.level(1).copyTo(scene->picture);
  frame.weights.level(1).copyTo(scene->mask);
  scene->time = frame.time;
  scene->described = false;
}

void Recall::describe(const cv::Mat &level, const cv::Mat &mask, const Tuning &tuning,
                      std::vector<cv::KeyPoint> &keypoints, cv::Mat &descriptors) {
  if (!sift_) sift_ = cv::SIFT::create(static_cast<int>(tuning.max_keypoints), 3, tuning.keypoint_contrast);
  cv::Mat picture;
  // After darkness the picture is dim at first.
  const double gain = tuning.stretched / std::max(contrast(level), tuning.min_contrast) / 256;
  level.convertTo(picture, CV_8U, gain, 128 - gain * cv::mean(level)[0]);
  sift_->detectAndCompute(picture, mask > GlareWeights::highlight, keypoints, descriptors);
}

bool Recall::knows(int chart) const {
  return std::any_of(scenes_.begin(), scenes_.end(), [chart](const Scene &s) { return s.chart == chart; });
}

bool blank(const CsdFrame &frame) {
  return contrast(frame.pyramid.level(Pyramid::levels - 1)) < frame.tuning.min_contrast;
}

bool Recall::seen(const Scene &scene, const Present &present) {
  return static_cast<double>(present.field.size(scene.chart)) >
         present.handful * present.share * static_cast<double>(scene.field.size());
}

bool Recall::nothing(const Present &present) const {
  return std::none_of(scenes_.begin(), scenes_.end(), [&](const Scene &s) { return seen(s, present); });
}

bool Recall::wanted(const Scene &scene, const Present &present) const {
  if (seen(scene, present)) return false;
  const auto later = [&](const Scene &s) { return s.chart > scene.chart && seen(s, present); };
  return nothing(present) || std::any_of(scenes_.begin(), scenes_.end(), later);
}

bool Recall::due(const CsdFrame &frame, const NeighbourField &field, double share) {
  const auto &tuning = frame.tuning;
  const Present present{field, share, tuning.handful};
  if (nothing(present)) last_nothing_ = frame.time;
  if (frame.time - last_nothing_ > nanoseconds(tuning.settles)) return false;
  std::int64_t gone = -1;
  for (const auto &s : scenes_)
    if (wanted(s, present)) gone = gone < 0 ? frame.time - s.time : std::min(gone, frame.time - s.time);
  if (gone < 0) return false;
  const auto pause = std::clamp(static_cast<std::int64_t>(tuning.tries_while_gone * static_cast<double>(gone)),
                                nanoseconds(tuning.try_every), nanoseconds(tuning.try_at_least_every));
  if (frame.time - last_try_ < pause || blank(frame)) return false;
  last_try_ = frame.time;
  return true;
}

void Recall::forget(int chart) {
  std::erase_if(scenes_, [chart](const Scene &s) { return s.chart == chart; });
}

int Recall::find(const CsdFrame &frame, const NeighbourField &field, double share, NeighbourField &found) {
  const auto &tuning = frame.tuning;
  const Present present{field, share, tuning.handful};
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  describe(frame.pyramid.level(1), frame.weights.level(1), tuning, keypoints, descriptors);
  if (descriptors.rows < 2) return -1;
  const cv::BFMatcher matcher(cv::NORM_L2);
  // clang 14 can't compile libstdc++'s std::views::reverse.
  // NOLINTNEXTLINE(modernize-loop-convert)
  for (auto newest = scenes_.rbegin(); newest != scenes_.rend(); ++newest) {
    Scene &scene = *newest;
    if (!wanted(scene, present)) continue;
    if (!scene.described) describe(scene.picture, scene.mask, tuning, scene.keypoints, scene.descriptors);
    scene.described = true;
    if (scene.descriptors.empty()) continue;
    std::vector<std::vector<cv::DMatch>> nearest;
    matcher.knnMatch(scene.descriptors, descriptors, nearest, 2);
    std::erase_if(nearest,
                  [&](const auto &m) { return m.size() < 2 || m[0].distance >= tuning.match_ratio * m[1].distance; });
    std::sort(nearest.begin(), nearest.end(), [](const auto &m, const auto &o) {
      return m[0].distance * o[1].distance < o[0].distance * m[1].distance;
    });
    std::vector<Correspondence> matches;
    matches.reserve(nearest.size());
    for (const auto &m : nearest)
      matches.push_back({scene.keypoints[static_cast<std::size_t>(m[0].queryIdx)].pt,
                         keypoints[static_cast<std::size_t>(m[0].trainIdx)].pt});
    const auto motion =
        agree_on_similarity(matches, tuning.match_tolerance * frame.unit, count(tuning.min_matches), tuning.max_zoom);
    if (!motion) continue;
    found = scene.field;
    found.move([&](cv::Point2d p) { return 2 * (*motion)(p / 2); });
    return scene.chart;
  }
  return -1;
}

}  // namespace csd
