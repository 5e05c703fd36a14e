// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "csd/point_alignment.h"
#include "csd/self_similarity.h"
#include "patch/anchor_median.h"

namespace csd {

/// A point's appearance model: its frozen anchor, the anchor's self-similarity, and the usual gain, noise and
/// brightness.
class Memory {
 public:
  /// `state`: of the point in this frame.
  Memory(const CsdFrame &frame, const AffineState &state);

  /// During the training time the anchor is the first frame's, and samples for the final one are collected.
  bool learning() const { return !medians_.empty(); }
  /// The training time is over: freeze_anchor() computes the anchor from the samples.
  bool training_over(const CsdFrame &frame) const { return learning() && frame.time - begun_ >= frame.training_time; }
  void freeze_anchor();

  /// Adds an anchor sample if one is due.
  void sample_at(const CsdFrame &frame, const AffineState &state);
  /// Updates the usual gain, noise and brightness from a good alignment.
  void learn_usual(const CsdFrame &frame, const Alignment &seen);
  /// Measures the frozen anchor's self-similarity, once.
  void measure_self_similarity(const CsdFrame &frame, const AffineState &state);
  /// Adds a finer anchor level once a zoom resolves it.
  void refine(const CsdFrame &frame, const AffineState &state, double scale, const Alignment &seen);

  const Anchor &anchor() const { return anchor_; }
  /// The finest level that the picture resolves and that is not mostly masked: naturally pale tissue is masked as a
  /// highlight, and a coarser patch reaches beyond it. `zoom`: scale of the shape relative to the point's start.
  int finest_level(double zoom, const Tuning &tuning) const;
  const std::optional<SelfSimilarity> &self_similarity() const { return self_similarity_; }
  double contrast() const { return contrast_; }  ///< of the finest level, sd in grey levels; 0 if unknown
  double usual_noise() const;                    ///< sd of the residual, grey levels of the picture; 0: unknown
  /// Change of ln gain from the usual gain; empty if that is unknown.
  std::optional<double> gain_change(const Alignment &seen) const;
  std::optional<double> brightness_change(const Alignment &seen) const;  ///< the same for the patch's mean, grey levels

 private:
  AnchorMedian &median_of_level(int level) { return medians_[static_cast<std::size_t>(level)]; }

  Anchor anchor_;
  std::vector<AnchorMedian> medians_;  ///< while learning: levels 0…2
  std::int64_t begun_, last_sample_;
  std::optional<SelfSimilarity> self_similarity_;
  double contrast_ = 0;
  struct Usual {
    double log_gain, log_noise, brightness;
  };
  std::optional<Usual> usual_;  ///< running means
};

}  // namespace csd
