// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <vector>

#include "motion/rhythms.h"
#include "motion/series.h"

namespace csd::motion {

/// A rhythm of the scene and how many features agree with it.
struct SceneRhythm {
  Rhythm rhythm;
  std::size_t agreeing = 0;  ///< features that show it on their own, as a rhythm or a harmonic of one
  std::size_t judged = 0;    ///< features tracked long enough to tell
};

/// All results of csd-motion.
struct Motion {
  Series series;
  SceneMotion scene;
  std::vector<SceneRhythm> scene_rhythms;  ///< the largest share of the variance first
  std::vector<Rhythms> rhythms;            ///< one for each of Series::paths
};

/// Analyses tracks. Throws score::InputError, see series_of().
Motion analyse(Series series, const SearchOptions &options = {});

}  // namespace csd::motion
