// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "motion/motion.h"

namespace csd::programs {

/// All output of csd-motion. docs/motion.md describes it.
struct MotionReport {
  std::string tracks;  ///< the file
  double window = 0;   ///< s, requested
  motion::Motion motion;
  std::vector<std::string> notes;
};

/// What is left out, as the picture's size changes. Series::left_out must not be 0.
std::string left_out(const motion::Series &series);

/// Takes the next piece of a text: an hour's series is hundreds of megabytes.
using Sink = std::function<void(std::string_view)>;

/// The rhythms as tables.
std::string as_text(const MotionReport &report);
/// The rhythms, one row each; `feature` is empty for the scene's. Unknown values are empty.
std::string as_csv(const MotionReport &report);
/// Displacement and velocity, one row per frame for the scene (`feature` is empty) and for each claimed feature.
void write_series_csv(const MotionReport &report, const Sink &write);
/// The rhythms and, with `series`, displacement and velocity. Unknown values are null.
void write_json(const MotionReport &report, bool series, const Sink &write);

}  // namespace csd::programs
