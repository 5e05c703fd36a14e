// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "csd/frame.h"
#include "patch/align.h"

namespace csd {

class Memory;

/// The result of aligning a point with a frame. A value type.
struct PointAlignment {
  Alignment fine;          ///< of the finest level; not usable: not aligned, or nothing found
  double zncc_coarse = 0;  ///< of the next coarser level; if that was not aligned, of the finest
  double gain_coarse = 0;  ///< gain of that level; 0: not aligned
  bool second = false;     ///< started from the neighbours' prediction, not the point's own motion
};

/// Start and settings of an alignment.
struct AlignmentPlan {
  AffineState start;
  double position_sd = 0;  ///< working pixels, of `start`; 0: no prior
  int levels = 0;          ///< number of coarser levels before the finest
  bool inner = false;      ///< uses the patch's inner disc only
  double precision = fine_precision;
};

/// Aligns a point's anchor with the frame, coarse to fine. Each level's position information becomes part of the next
/// level's prior.
PointAlignment align_point(const CsdFrame &frame, const Memory &memory, const AlignmentPlan &plan);

/// When contrast has dropped, aligns a coarser level to find out why and stores its gain in `alignment`. The rest
/// is unchanged: including the coarser level cost 2 % of the claims on cutting.mp4.
void align_coarser(const CsdFrame &frame, const Memory &memory, PointAlignment &alignment);

}  // namespace csd
