// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/detect.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

#include "detect/alike.h"
#include "detect/dog.h"
#include "detect/merge.h"
#include "detect/shi_tomasi.h"

namespace csd {
namespace {

constexpr double max_specular = 0.05;  // of the patch
constexpr double min_distance = 0.5;   // between features, share of the patch's side
constexpr int windows_per_patch = 3;   // the patch's side over the side of Shi and Tomasi's window
constexpr double per_bucket = 2;       // features per bucket, if spread evenly

/// Side of the buckets: `wanted` features fill each of them with per_bucket over the allowed area.
double bucket_side(const cv::Mat &allowed, const DetectOptions &options) {
  const double area = cv::countNonZero(allowed);
  return std::max<double>(std::sqrt(area * per_bucket / static_cast<double>(options.wanted)), options.patch);
}

}  // namespace

cv::Mat allowed_centres(cv::Size size, const cv::Mat &specular, const cv::Mat &forbidden, int patch) {
  cv::Mat allowed = cv::Mat::zeros(size, CV_8UC1);
  const int radius = patch / 2;
  const cv::Rect inside(radius, radius, size.width - 2 * radius, size.height - 2 * radius);
  if (patch < 1 || inside.width < 1 || inside.height < 1) return allowed;
  allowed(inside).setTo(255);
  if (!specular.empty()) {
    CV_Assert(specular.type() == CV_8UC1 && specular.size() == size);
    cv::Mat share;
    cv::boxFilter(specular != 0, share, CV_32F, {2 * radius + 1, 2 * radius + 1}, {-1, -1}, true, cv::BORDER_REPLICATE);
    allowed.setTo(0, share > max_specular * 255);
  }
  if (!forbidden.empty()) {
    CV_Assert(forbidden.type() == CV_8UC1 && forbidden.size() == size);
    allowed.setTo(0, forbidden);
  }
  return allowed;
}

std::vector<cv::Point2d> detect(const cv::Mat &luma, const cv::Mat &specular, const cv::Mat &forbidden,
                                const DetectOptions &options, std::span<const cv::Point2d> taken) {
  if (luma.empty() || options.wanted == 0) return {};
  CV_Assert(luma.type() == CV_8UC1);
  const cv::Mat allowed = allowed_centres(luma.size(), specular, forbidden, options.patch);
  if (cv::countNonZero(allowed) == 0) return {};

  const double radius = min_distance * options.patch;
  const int window = std::max(3, options.patch / windows_per_patch | 1);
  std::vector<cv::Point2d> ranked =
      merge_by_rank(find_dog(luma, allowed), find_shi_tomasi(luma, allowed, window, radius), radius, taken);
  if (options.max_look_alike < 1) {
    const LookAlikes alike(luma, options.patch);
    std::erase_if(ranked, [&](cv::Point2d p) { return alike.best(p) > options.max_look_alike; });
  }
  return spread(ranked, luma.size(), bucket_side(allowed, options), options.wanted, taken);
}

}  // namespace csd
