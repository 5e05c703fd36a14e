// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "base/types.h"
#include "content/specular.h"

namespace csd {

enum class AlgorithmKind : std::uint8_t { csd, csd_2012, lk, ms1, ms2, sift, csd_forest };
std::string_view algorithm_name(AlgorithmKind kind);  ///< "csd", "csd-2012", …: as in the element's property

enum class ContentArea : std::uint8_t { automatic, full };

/// The settings of a tracker, fixed at construction. Pixels are the picture's.
struct Settings {
  AlgorithmKind algorithm = AlgorithmKind::csd;
  unsigned max_features = 50;
  std::vector<cv::Point2d> points;  ///< if not empty: track exactly these, no detection
  bool points_from_start = false;   ///< track exactly the points of Tracker::offer_start(), no detection
  bool replenish = true;
  std::int64_t forget_after = 10 * second;  ///< 0: never
  cv::Rect region;                          ///< where detection may look; empty: everywhere
  ContentArea content_area = ContentArea::automatic;
  unsigned patch_size = 0;     ///< 0: from the picture's height
  unsigned search_radius = 0;  ///< 0: from the picture's height
  std::int64_t training_time = second / 2;
  bool learn_synchronously = false;
  std::int64_t frame_budget = 0;  ///< ns; when spent, the least urgent features of a frame wait (csd); 0: none
  std::uint64_t seed = 1;

  // For experiments and tests: no property sets these.
  std::function<std::int64_t()> clock;  ///< ns, measures frame_budget; empty: the steady clock
  SpecularOptions specular;             ///< detection places no feature near these
};

struct Stats {
  std::uint64_t frames = 0;
  std::array<std::uint64_t, feature_states> features{};  ///< of the last frame, by state
  std::uint64_t detected = 0;                            ///< features that ever started
  std::int64_t learning_time = 0;                        ///< ns inside learning jobs, all threads together
  std::uint64_t learned = 0;                             ///< descriptors that replaced the recursive tracker
  std::uint64_t retrainings = 0;                         ///< leaves retrained (§2.2.2)
  std::uint64_t false_correspondences = 0;               ///< patches wrongly called the feature (§2.2.2)
  std::uint64_t queue = 0;                               ///< waiting learning jobs
  std::uint64_t waited = 0;                              ///< reports with Feature::fresh false
};

}  // namespace csd
