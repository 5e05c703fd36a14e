// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <optional>
#include <vector>

#include "baselines/colour_weights.h"
#include "track/algorithm.h"

namespace csd {

/// The ranking of colour spaces: the baselines MS1 and MS2 of §3.
enum class ColourRanking : std::uint8_t {
  variance_ratio,  ///< MS1: how well they separate object and background pixels (Eq. 5)
  peak_difference  ///< MS2: how far the object's peak exceeds those of distractors beside it
};

/// The mean-shift trackers of Collins, Liu & Leordeanu (2005), "Online selection of discriminative tracking features",
/// IEEE PAMI 27(10). They choose the five of the 49 colour spaces that best separate the patch from the ring around it,
/// run mean shift on the weight image of each from the last position, and take the median of the five
/// (docs/baselines.md).
///
/// A feature whose colours are not found is hidden and searched for again where it was; one that crosses the edge is
/// out for good.
class CollinsMeanShift final : public Algorithm {
 public:
  CollinsMeanShift(const Settings &settings, ColourRanking ranking);
  ~CollinsMeanShift() override;

  void track(const FrameContext &context, std::vector<Claim> &claims) override;
  Claim::Kind begin(FeatureId id, cv::Point2d position, const FrameContext &context) override;
  void end(FeatureId id) override;
  void finish(const FrameContext &) override {}
  void forget() override;
  void add_to(Stats &) const override {}

 private:
  struct Target;
  struct Planes;

  std::optional<cv::Point2d> look(const WorkFrame &frame, Target &target);
  void rank(const WorkFrame &frame, Target &target);
  void update(const WorkFrame &frame, Target &target);
  void set_side(int side);

  Settings settings_;
  ColourRanking ranking_;
  int side_ = 0;                 ///< of the patch, working pixels
  std::optional<LogTable> log_;  ///< for patches of that side
  std::vector<Target> targets_;  ///< by ascending id
};

}  // namespace csd
