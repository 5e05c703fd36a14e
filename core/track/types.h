// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "content/specular.h"

namespace csd {

using FeatureId = std::uint32_t;
inline constexpr FeatureId no_feature = 0xffffffffu;  ///< "failed", never an id
inline constexpr std::size_t max_points = 10000;      ///< as many as a user may give

/// What is known about a feature in a frame. `learning` and `tracked` claim that it is where its x and y are.
enum class FeatureState : std::uint8_t { learning, tracked, occluded, lost, out, ended };
inline constexpr std::size_t feature_states = 6;
/// "learning", "tracked", … : the words of the metadata schema.
std::string_view state_name(FeatureState state);
inline bool claims_position(FeatureState state) {
  return state == FeatureState::learning || state == FeatureState::tracked;
}

struct Feature {
  FeatureId id = 0;
  double x = 0, y = 0;  ///< pixels of the picture, centres at integers; always finite
  FeatureState state = FeatureState::learning;
  double confidence = 0;  ///< probability of being visible and near x,y: 0…1
  bool fresh = true;      ///< false: the frame budget made this feature wait
};

/// A point that brings its id along.
struct StartPoint {
  FeatureId id = 0;
  cv::Point2d position;  ///< pixels of the picture
};

/// The result of one frame, features by ascending id.
struct Tracks {
  std::uint64_t frame = 0;  ///< frames since the tracker was made
  int width = 0, height = 0;
  std::vector<Feature> features;
  bool too_small = false;  ///< the picture is smaller than a patch or Pyramid::smallest: there can be no features
  bool changed = false;    ///< some feature's state is not what it was in the frame before, or a feature is new
};

enum class AlgorithmKind : std::uint8_t { csd, csd_2012, lk, ms1, ms2, sift, csd_forest };
std::string_view algorithm_name(AlgorithmKind kind);  ///< "csd", "csd-2012", …: as the element's property says it

enum class ContentArea : std::uint8_t { automatic, full };

inline constexpr std::int64_t second = 1000000000;  ///< all times are nanoseconds
inline constexpr std::int64_t no_time = -1;

/// All that a tracker is told when it is made. Pixels are the picture's.
struct Settings {
  AlgorithmKind algorithm = AlgorithmKind::csd;
  unsigned max_features = 50;
  std::vector<cv::Point2d> points;  ///< not empty: track exactly these, no detection
  bool points_from_start = false;   ///< track exactly what Tracker::offer_start() brings, no detection
  bool replenish = true;
  std::int64_t forget_after = 10 * second;  ///< 0: never
  cv::Rect region;                          ///< where detection may look; empty: everywhere
  ContentArea content_area = ContentArea::automatic;
  unsigned patch_size = 0;     ///< 0: from the picture's height
  unsigned search_radius = 0;  ///< 0: from the picture's height
  std::int64_t training_time = second / 2;
  bool learn_synchronously = false;
  std::int64_t frame_budget = 0;  ///< ns; past it, the least urgent features of a frame wait (csd); 0: none
  std::uint64_t seed = 1;

  // For experiments and tests: no property sets these.
  std::function<std::int64_t()> clock;  ///< ns, what frame_budget is measured by; empty: the steady clock
  SpecularOptions specular;             ///< near what detection puts no feature
};

struct Stats {
  std::uint64_t frames = 0;
  std::array<std::uint64_t, feature_states> features{};  ///< of the last frame, by state
  std::uint64_t detected = 0;                            ///< features that ever began
  std::int64_t learning_time = 0;                        ///< ns inside learning jobs, all threads together
  std::uint64_t learned = 0;                             ///< descriptors that took over from the recursive tracker
  std::uint64_t retrainings = 0;                         ///< leaves retrained (§2.2.2)
  std::uint64_t false_correspondences = 0;               ///< patches wrongly called the feature (§2.2.2)
  std::uint64_t queue = 0;                               ///< learning jobs that wait
  std::uint64_t waited = 0;                              ///< reports with Feature::fresh false
};

}  // namespace csd
