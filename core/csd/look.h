// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "csd/frame.h"
#include "patch/align.h"

namespace csd {

class Memory;

/// What a look at a frame has seen of a point: a value.
struct Look {
  Alignment fine;          ///< of the finest level; not usable: nobody looked, or nothing is there
  double zncc_coarse = 0;  ///< of the next coarser level; where none was looked at, of the finest
  double gain_coarse = 0;  ///< the same level's gain; 0: none was looked at
  bool again = false;      ///< from where the neighbours put it, not from where its own motion does
};

/// Where a look begins, and what it takes.
struct LookPlan {
  AffineState start;
  double position_sd = 0;  ///< working pixels, of `start`; 0: nothing is known
  int levels = 0;          ///< coarser levels before the finest
  bool inner = false;      ///< with the patch's inner disc alone
  double precision = fine_precision;
};

/// Aligns a point's anchor with the frame, from coarse to fine. Each level's information about the place is part of the
/// next one's prior.
Look look_at(const CsdFrame &frame, const Memory &memory, const LookPlan &plan);

/// Where contrast has faded, a coarser level tells why: gives the look its gain. What was seen stays as it is: with the
/// coarser level in it, cutting.mp4 was claimed 2 % less.
void weigh_coarser(const CsdFrame &frame, const Memory &memory, Look &look);

}  // namespace csd
