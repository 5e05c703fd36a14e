// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/life.h"

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

constexpr std::int64_t occluded_for = second;  // a feature that is hidden for longer is lost
constexpr double max_hidden = 0.499;  // highest confidence without a claim: rounds to less than .5 in three decimals

}  // namespace

bool Life::started_falsely() const {
  return !given && reported && reported_as == FeatureState::learning && feature.fresh && surrounded &&
         (feature.state == FeatureState::occluded || feature.state == FeatureState::lost);
}

void Life::end() {
  feature.state = FeatureState::ended;
  feature.confidence = 0;
  feature.x = claimed.x;
  feature.y = claimed.y;
}

void Life::apply(const Claim &claim, std::int64_t time) {
  const auto state = feature.state;
  const bool finite = std::isfinite(claim.position.x) && std::isfinite(claim.position.y);
  feature.confidence = 0;
  feature.fresh = claim.fresh;
  surrounded = claim.surrounded;
  switch (claim.kind) {
    case Claim::Kind::learning:
    case Claim::Kind::tracked:
      feature.state = claim.kind == Claim::Kind::learning ? FeatureState::learning : FeatureState::tracked;
      feature.confidence = claim.confidence;
      last_claim = time;
      if (finite) claimed = claim.position;
      break;
    case Claim::Kind::out:
      feature.state = FeatureState::out;
      break;
    case Claim::Kind::hidden:
    case Claim::Kind::lost:
      // A feature that left the picture is out until it is visible again.
      if (state == FeatureState::out) break;
      feature.state = claim.kind == Claim::Kind::hidden && time - last_claim < occluded_for ? FeatureState::occluded
                                                                                            : FeatureState::lost;
      // An algorithm without probabilities leaves 1, which holds only for claims.
      if (feature.state == FeatureState::occluded && claim.confidence < 0.5)
        feature.confidence = std::min(claim.confidence, max_hidden);
      break;
  }
  const auto gone = [](FeatureState s) { return s == FeatureState::lost || s == FeatureState::out; };
  if (gone(feature.state) && !gone(state)) gone_since = time;
  // Only occluded features report a prediction; lost and out ones keep the last claimed position.
  const bool predicted = feature.state == FeatureState::occluded && finite;
  feature.x = predicted ? claim.position.x : claimed.x;
  feature.y = predicted ? claim.position.y : claimed.y;
}

}  // namespace csd
