// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include "content/glare_weights.h"
#include "image/pyramid.h"
#include "patch/align.h"
#include "patch/anchor.h"

namespace csd {

/// The second view of a feature in co-training (§5): its first patch, aligned with the frame. The descriptor predicts
/// where to align it; its fit tells whether the descriptor is right.
class AlignedPatch {
 public:
  /// From the frame in which the feature begins at `position` (working pixels). `pixel`: working pixels per sample of
  /// the 21 × 21 patch.
  AlignedPatch(const Pyramid &pyramid, const GlareWeights &weights, cv::Point2d position, double pixel);

  struct Fit {
    AffineState state;
    double zncc = 0;  ///< −1…1; 0: no texture
  };
  /// Aligns from `position`, with the shape of the last accepted fit.
  Fit fit(const Pyramid &pyramid, const GlareWeights &weights, cv::Point2d position) const;
  void accept(const Fit &fit) { shape_ = fit.state.shape; }

 private:
  Anchor anchor_;
  cv::Matx22d shape_;
  double pixel_;
};

}  // namespace csd
