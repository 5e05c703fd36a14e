// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace csd {

using FeatureId = std::uint32_t;
inline constexpr FeatureId no_feature = 0xffffffffu;  ///< "failed", never an id
inline constexpr std::size_t max_points = 10000;      ///< limit of the points that a user may give

/// A feature's state in a frame. `learning` and `tracked` claim that it is visible at its x and y.
enum class FeatureState : std::uint8_t { learning, tracked, occluded, lost, out, ended };
/// The states' names in the metadata schema, in their order. Each ends with a zero byte.
inline constexpr std::array<std::string_view, 6> state_names{"learning", "tracked", "occluded", "lost", "out", "ended"};
inline constexpr std::size_t feature_states = state_names.size();
constexpr std::string_view state_name(FeatureState state) {
  return state_names[static_cast<std::size_t>(state)];
}
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

/// A point with a given id.
struct StartPoint {
  FeatureId id = 0;
  cv::Point2d position;  ///< pixels of the picture
};

/// The result of one frame, features sorted by ascending id.
struct Tracks {
  std::uint64_t frame = 0;  ///< frames since the tracker was created
  int width = 0, height = 0;
  std::vector<Feature> features;
  bool too_small = false;  ///< the picture is smaller than a patch or Pyramid::smallest: no features are possible
  bool changed = false;    ///< some feature is new, or its state has changed since the last frame
};

inline constexpr std::int64_t second = 1000000000;  ///< all times are nanoseconds
inline constexpr std::int64_t no_time = -1;

}  // namespace csd
