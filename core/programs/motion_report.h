// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "motion/motion.h"

namespace csd::programs {

/// All that csd-motion writes. docs/motion.md describes it.
struct MotionReport {
  std::string tracks;  ///< the file
  double window = 0;   ///< s, as asked for
  motion::Motion motion;
  std::vector<std::string> notes;
};

/// Takes the next piece of a text: an hour's series is hundreds of megabytes.
using Sink = std::function<void(std::string_view)>;

/// Tables of the rhythms.
std::string as_text(const MotionReport &report);
/// The rhythms, a row each; `feature` is empty for the scene's. What is unknown is empty.
std::string as_csv(const MotionReport &report);
/// Displacement and velocity, a row for the scene (`feature` is empty) and for each feature that is claimed, by frame.
void write_series_csv(const MotionReport &report, const Sink &write);
/// The rhythms, and with `series` displacement and velocity. What is unknown is null.
void write_json(const MotionReport &report, bool series, const Sink &write);

}  // namespace csd::programs
