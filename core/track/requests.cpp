// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/requests.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace csd {

Requests::Requests(const Settings &settings) {
  for (const auto &point : settings.points) known_.push_back({next_id_++, point, true});
  if (settings.points_from_start) next_id_ = static_cast<FeatureId>(max_points);
}

FeatureId Requests::add(cv::Point2d position) {
  const std::lock_guard lock(mutex_);
  if (known_.size() + added_.size() >= max_points) return no_feature;
  added_.push_back({next_id_, position});
  return next_id_++;
}

bool Requests::remove(FeatureId id) {
  const auto is_it = [id](const auto &point) { return point.id == id; };
  const std::lock_guard lock(mutex_);
  if (std::none_of(known_.begin(), known_.end(), is_it) && std::none_of(added_.begin(), added_.end(), is_it))
    return false;
  if (std::find(removed_.begin(), removed_.end(), id) != removed_.end()) return false;
  removed_.push_back(id);
  return true;
}

FeatureId Requests::remove_nearest(cv::Point2d position) {
  const std::lock_guard lock(mutex_);
  auto nearest = no_feature;
  double nearest_distance = std::numeric_limits<double>::infinity();
  for (const auto &k : known_) {
    const double distance = std::hypot(k.position.x - position.x, k.position.y - position.y);
    if (!k.in_picture || distance >= nearest_distance ||
        std::find(removed_.begin(), removed_.end(), k.id) != removed_.end())
      continue;
    nearest_distance = distance;
    nearest = k.id;
  }
  if (nearest != no_feature) removed_.push_back(nearest);
  return nearest;
}

void Requests::reset() {
  const std::lock_guard lock(mutex_);
  reset_ = true;
  added_.clear();
  removed_.clear();
}

FeatureId Requests::take_ids(std::size_t count) {
  const std::lock_guard lock(mutex_);
  return std::exchange(next_id_, next_id_ + static_cast<FeatureId>(count));
}

void Requests::take(Taken &taken) {
  const std::lock_guard lock(mutex_);
  taken.added.reserve(taken.added.size() + added_.size());
  taken.removed.reserve(taken.removed.size() + removed_.size());
  known_.reserve(known_.size() + added_.size());
  if (std::exchange(reset_, false)) {
    taken.reset = true;
    taken.added.clear();
  }
  // A new point can be removed while its first frame is still being tracked.
  for (const auto &point : added_) known_.push_back({point.id, point.position, false});
  std::sort(removed_.begin(), removed_.end());
  std::erase_if(known_, [this](const Known &k) { return std::binary_search(removed_.begin(), removed_.end(), k.id); });
  taken.added.insert(taken.added.end(), added_.begin(), added_.end());
  taken.removed.insert(taken.removed.end(), removed_.begin(), removed_.end());
  added_.clear();
  removed_.clear();
}

void Requests::report(std::vector<Known> known) {
  const std::lock_guard lock(mutex_);
  known_.swap(known);
}

}  // namespace csd
