// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "programs/score_report.h"

namespace csd::programs {

/// Creates a folder and draws over-time, over-threshold and reliability into it, each as .svg and .png; plots.gp is the
/// gnuplot script. Dashes and marks keep curves distinct in greyscale. Throws std::runtime_error if gnuplot is missing
/// or fails.
void draw_plots(const ScoreReport &report, const std::string &folder);

}  // namespace csd::programs
