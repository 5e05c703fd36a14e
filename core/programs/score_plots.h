// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "programs/score_report.h"

namespace csd::programs {

/// Draws over-time, over-threshold and reliability, each as .svg and .png, into a folder, which it makes; plots.gp
/// there is what gnuplot was told. Curves are told apart by dashes and marks too, so that grey will do. Throws
/// std::runtime_error if gnuplot is not there or fails.
void draw_plots(const ScoreReport &report, const std::string &folder);

}  // namespace csd::programs
