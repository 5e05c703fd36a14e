// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include "content/glare_weights.h"
#include "image/pyramid.h"
#include "patch/align.h"
#include "patch/anchor.h"

namespace csd {

/// The other view of a feature that a descriptor is trained together with (§5, co-training): its patch as it was at the
/// start, aligned with the frame. The descriptor says where to align it, its fit says whether the descriptor is right.
class AlignedPatch {
 public:
  /// From the frame in which the feature begins at `position` (working pixels). `pixel`: working pixels of a sample of
  /// the patch, which has 21 × 21.
  AlignedPatch(const Pyramid &pyramid, const GlareWeights &weights, cv::Point2d position, double pixel);

  struct Fit {
    AffineState state;
    double zncc = 0;  ///< −1…1; 0: nothing to see
  };
  /// Aligned from `position` on, in the shape of the last fit that was accepted.
  Fit fit(const Pyramid &pyramid, const GlareWeights &weights, cv::Point2d position) const;
  void accept(const Fit &fit) { shape_ = fit.state.shape; }

 private:
  Anchor anchor_;
  cv::Matx22d shape_;
  double pixel_;
};

}  // namespace csd
