// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "content/glare_weights.h"
#include "csd/support_points.h"
#include "csd/tracked_point.h"
#include "image/pyramid.h"
#include "track/algorithm.h"

namespace csd {

/// The project's own tracker. Each feature has an affine state and a frozen anchor. Each frame aligns it as one MAP
/// estimate and checks the result against the motion of the tissue around it. docs/method.md maps the formulas to the
/// code.
class Csd final : public Algorithm {
 public:
  /// Independent points are tracked in parallel if `workers` has threads.
  explicit Csd(const Settings &settings, SideBySide workers = {}, const Tuning &tuning = {})
      : settings_(settings), tuning_(tuning), workers_(workers) {}

  bool replenishes() const override { return true; }
  bool avoids_tools() const override { return true; }
  double max_look_alike() const override { return tuning_.max_look_alike; }
  void track(const FrameContext &context, std::vector<Claim> &claims) override;
  Claim::Kind begin(FeatureId id, cv::Point2d position, const FrameContext &context) override;
  void end(FeatureId id) override;
  void finish(const FrameContext &) override {}
  void forget() override;
  void add_to(Stats &) const override {}

  /// The evidence behind the last frame's visibility decision, and the aligned position, picture pixels.
  struct Judged {
    Evidence evidence;
    cv::Point2d position;
  };
  /// Empty if the feature was not judged in the last frame.
  std::optional<Judged> judged(FeatureId id) const;

 private:
  struct Query : Followed {
    cv::Point2d judged_at = {};  ///< picture pixels
  };
  CsdFrame load(const FrameContext &context);
  void hide_until_found(const CsdFrame &frame);
  void drop_ended();
  void follow_queries(const CsdFrame &frame);
  void report(const Query &query, const CsdFrame &frame, const WorkFrame &work, Claim &claim) const;

  Settings settings_;
  Tuning tuning_;
  SideBySide workers_;
  Pyramid pyramid_;
  GlareWeights weights_;
  SupportPoints support_;
  std::vector<Query> queries_;  // by ascending id
  std::vector<FeatureId> ended_;
  Points turns_;  // scratch
  std::int64_t last_time_ = no_time;
  double steps_ = 1;  // of this frame
};

}  // namespace csd
