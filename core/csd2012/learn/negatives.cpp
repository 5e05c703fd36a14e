// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/negatives.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace csd {

namespace {

constexpr int near_every = 3;        // every third random negative is near the feature
constexpr int tries = 20;            // per position: if most of the picture is forbidden there are fewer negatives
constexpr double min_deviation = 1;  // grey levels, of a patch that is correlated; below is sensor noise
constexpr int peaks_per_patch = 4;   // a local maximum is the highest within a patch's side divided by this

double distance(cv::Point a, cv::Point b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

bool allowed(cv::Point p, cv::Point feature, const cv::Rect &centres, const cv::Mat &forbidden,
             const NegativeRules &rules) {
  return centres.contains(p) && distance(p, feature) > rules.ignore_radius &&
         (forbidden.empty() || forbidden.at<unsigned char>(p) == 0);
}

cv::Rect patch_centres(cv::Size picture, int patch) {
  return {patch / 2, patch / 2, std::max(picture.width - patch + 1, 0), std::max(picture.height - patch + 1, 0)};
}

}  // namespace

std::vector<cv::Point> random_negatives(cv::Size picture, const cv::Mat &forbidden, cv::Point feature, int count,
                                        const NegativeRules &rules, Random &random) {
  std::vector<cv::Point> positions;
  const auto centres = patch_centres(picture, rules.patch);
  if (centres.empty()) return positions;
  const int reach = static_cast<int>(rules.near_radius);
  const cv::Rect around = cv::Rect(feature.x - reach, feature.y - reach, 2 * reach + 1, 2 * reach + 1) & centres;
  for (int i = 0; i < count; ++i) {
    const bool is_near = i % near_every == 0 && !around.empty();
    const auto &from = is_near ? around : centres;
    for (int t = 0; t < tries; ++t) {
      const cv::Point p(from.x + static_cast<int>(random.below(static_cast<unsigned>(from.width))),
                        from.y + static_cast<int>(random.below(static_cast<unsigned>(from.height))));
      if (!allowed(p, feature, centres, forbidden, rules)) continue;
      if (is_near && distance(p, feature) > rules.near_radius) continue;
      positions.push_back(p);
      break;
    }
  }
  return positions;
}

std::vector<cv::Point> similar_negatives(const cv::Mat &luma, const cv::Mat &forbidden, cv::Point feature, int count,
                                         double min_score, int radius, const NegativeRules &rules) {
  std::vector<cv::Point> positions;
  const int half = rules.patch / 2;
  const auto centres = patch_centres(luma.size(), rules.patch);
  const cv::Rect search = cv::Rect(feature.x - radius, feature.y - radius, 2 * radius + 1, 2 * radius + 1) & centres;
  if (search.empty() || !centres.contains(feature)) return positions;
  const cv::Mat patch = luma({feature.x - half, feature.y - half, rules.patch, rules.patch});
  const cv::Mat area = luma({search.x - half, search.y - half, search.width + 2 * half, search.height + 2 * half});
  cv::Scalar mean, deviation;
  cv::meanStdDev(patch, mean, deviation);
  if (deviation[0] < min_deviation) return positions;  // The correlation would be 0/0, which OpenCV defines as 1.
  cv::Mat score, highest;
  cv::matchTemplate(area, patch, score, cv::TM_CCOEFF_NORMED);
  // Does not take the same similar place twice.
  const int apart = 2 * (rules.patch / peaks_per_patch) + 1;
  cv::dilate(score, highest, cv::getStructuringElement(cv::MORPH_RECT, {apart, apart}));
  struct Peak {
    float score;
    cv::Point at;
  };
  std::vector<Peak> peaks;
  for (int y = 0; y < score.rows; ++y)
    for (int x = 0; x < score.cols; ++x) {
      const float s = score.at<float>(y, x);
      const cv::Point p(search.x + x, search.y + y);
      if (std::isfinite(s) && s >= static_cast<float>(min_score) && s <= 1.0f && s == highest.at<float>(y, x) &&
          allowed(p, feature, centres, forbidden, rules))
        peaks.push_back({s, p});
    }
  std::stable_sort(peaks.begin(), peaks.end(), [](const Peak &a, const Peak &b) { return a.score > b.score; });
  for (const auto &peak : peaks) {
    if (static_cast<int>(positions.size()) == count) break;
    positions.push_back(peak.at);
  }
  return positions;
}

}  // namespace csd
