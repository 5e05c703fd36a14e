// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <vector>

#include "track/algorithm.h"
#include "track/recursive.h"

namespace csd {

/// The baseline LK (with template update) of §3: each feature is tracked from frame to frame and, once lost, stays
/// lost.
class LucasKanade final : public Algorithm {
 public:
  explicit LucasKanade(const Settings &settings) : settings_(settings) {}

  void track(const FrameContext &context, std::vector<Claim> &claims) override;
  Claim::Kind begin(FeatureId id, cv::Point2d position, const FrameContext &context) override;
  void end(FeatureId id) override;
  void finish(const FrameContext &context) override;
  void forget() override;
  void add_to(Stats &) const override {}

 private:
  struct Point {
    FeatureId id;
    cv::Point2f work;  ///< working pixels
  };
  Settings settings_;
  RecursiveTracker recursive_;
  std::vector<Point> points_;  ///< those not lost, by ascending id
};

}  // namespace csd
