// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <vector>

#include "motion/rhythms.h"
#include "motion/series.h"

namespace csd::motion {

/// A rhythm of the scene, and what the features say to it.
struct SceneRhythm {
  Rhythm rhythm;
  std::size_t agreeing = 0;  ///< features that show it by themselves, as a rhythm or as a harmonic of one
  std::size_t judged = 0;    ///< features long enough for that
};

/// All that csd-motion finds out.
struct Motion {
  Series series;
  SceneMotion scene;
  std::vector<SceneRhythm> scene_rhythms;  ///< the greatest share of the variance first
  std::vector<Rhythms> rhythms;            ///< one for each of Series::paths
};

/// Analyses tracks. Throws score::InputError, see series_of().
Motion analyse(Series series, const SearchOptions &options = {});

}  // namespace csd::motion
