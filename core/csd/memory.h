// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "csd/likeness.h"
#include "csd/look.h"
#include "patch/anchor_median.h"

namespace csd {

/// What a point knows of how it looks: its frozen anchor, what tells that apart from its surroundings, and its usual
/// gain, noise and brightness.
class Memory {
 public:
  /// `state`: where the point is in this frame.
  Memory(const CsdFrame &frame, const AffineState &state);

  /// While the training time lasts the anchor is the first frame's, and its samples are gathered.
  bool learning() const { return !medians_.empty(); }
  /// The training time is over: freeze() makes the anchor of its samples.
  bool ripe(const CsdFrame &frame) const { return learning() && frame.time - begun_ >= frame.training_time; }
  void freeze();

  /// Takes a sample for the anchor, if it is time for one.
  void sample_at(const CsdFrame &frame, const AffineState &state);
  /// Learns the usual gain, noise and brightness from a point that was seen well.
  void learn_usual(const CsdFrame &frame, const Alignment &seen);
  /// Once, of the frozen anchor: what tells it apart.
  void measure_likeness(const CsdFrame &frame, const AffineState &state);
  /// A finer level of the anchor, once a zoom shows it.
  void refine(const CsdFrame &frame, const AffineState &state, double scale, const Alignment &seen);

  const Anchor &anchor() const { return anchor_; }
  /// The finest level that the picture shows and that isn't mostly masked: what is pale by nature passes for a
  /// highlight, and a coarser patch reaches beyond it. `zoom`: scale of the shape, of that where the point began.
  int finest_level(double zoom, const Tuning &tuning) const;
  const std::optional<Likeness> &likeness() const { return likeness_; }
  double contrast() const { return contrast_; }  ///< of the finest level, sd in grey levels; 0 until likeness is known
  double usual_noise() const;                    ///< sd of the residual, grey levels of the picture; 0: not known
  /// Change of ln gain against the usual; nothing if none is known.
  std::optional<double> gain_change(const Alignment &seen) const;
  std::optional<double> brightness_change(const Alignment &seen) const;  ///< the same of the patch's mean, grey levels

 private:
  void set_anchor(int level, const AnchorLevel &anchor);

  Anchor anchor_;
  std::array<double, Anchor::coarsest - Anchor::finest + 1> unmasked_{};  ///< share of the anchor's levels
  std::vector<AnchorMedian> medians_;                                     ///< while it is learning: levels 0…2
  std::int64_t begun_, last_sample_;
  std::optional<Likeness> likeness_;
  double contrast_ = 0;
  struct Usual {
    double log_gain, log_noise, brightness;
  };
  std::optional<Usual> usual_;  ///< running means
};

}  // namespace csd
