// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/settings.h"

#include <algorithm>
#include <thread>

#include "text/parse.h"

namespace csd {
namespace {

AlgorithmKind algorithm_of(GstCsdTrackAlgorithm algorithm) {
  switch (algorithm) {
    case GST_CSD_TRACK_ALGORITHM_LK:
      return AlgorithmKind::lk;
    case GST_CSD_TRACK_ALGORITHM_MS1:
      return AlgorithmKind::ms1;
    case GST_CSD_TRACK_ALGORITHM_MS2:
      return AlgorithmKind::ms2;
    case GST_CSD_TRACK_ALGORITHM_SIFT:
      return AlgorithmKind::sift;
    case GST_CSD_TRACK_ALGORITHM_CSD_FOREST:
      return AlgorithmKind::csd_forest;
    case GST_CSD_TRACK_ALGORITHM_CSD:
      return AlgorithmKind::csd;
    case GST_CSD_TRACK_ALGORITHM_CSD_2012:
      break;
  }
  return AlgorithmKind::csd_2012;
}

}  // namespace

Settings core_settings(const ElementSettings &s, std::string &error) {
  Settings core;
  core.points_from_start = is_truth(s.points);
  auto points = core.points_from_start ? Parsed<std::vector<cv::Point2d>>{} : parse_points(s.points);
  const auto region = parse_region(s.region);
  error = !points ? points.error : region.error;
  core.algorithm = algorithm_of(s.algorithm);
  core.max_features = s.max_features;
  core.points = std::move(points.value);
  core.replenish = s.replenish;
  core.forget_after = static_cast<std::int64_t>(s.forget_after);
  core.region = region.value;
  core.content_area = s.content_area == GST_CSD_TRACK_CONTENT_AREA_FULL ? ContentArea::full : ContentArea::automatic;
  core.patch_size = s.patch_size;
  core.search_radius = s.search_radius;
  core.training_time = static_cast<std::int64_t>(s.training_time);
  core.learn_synchronously = s.learning == GST_CSD_TRACK_LEARNING_SYNC;
  core.frame_budget = static_cast<std::int64_t>(s.frame_budget);
  core.seed = s.seed;
  return core;
}

unsigned thread_count(guint n_threads) {
  if (n_threads > 0) return n_threads;
  return std::max(2u, std::thread::hardware_concurrency()) - 1;
}

}  // namespace csd
