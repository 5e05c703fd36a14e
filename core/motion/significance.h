// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <span>

namespace csd::motion {

/// How high a spectrum is around a frequency, were there no peak.
struct Background {
  double level = 0;  ///< as if the mean of noise there
  double width = 0;  ///< how many independent frequencies it was taken from
};

/// The background at `spectrum[at]`. Its frequencies are `step` times `first`, `first` + 1, …; values that correlate
/// are no more than `correlated` places apart. Taken from what is half the frequency to both sides, at least 10
/// correlation lengths, without what is less than `own` places away.
///
/// The level is a median (a few other peaks don't raise it), divided by that of the χ² distribution with `dof` degrees
/// of freedom to estimate the mean. Noise in tissue is red: it falls with the frequency. So the greater of two medians
/// counts, of the spectrum and of the spectrum times the frequency squared (the velocity's), as where one of them is
/// too low, at an end of the band, the other is not.
Background background_at(std::span<const double> spectrum, std::size_t first, std::size_t at, std::size_t own,
                         double correlated, double dof);

/// P(F ≥ ratio) of the F distribution with `a` and `b` degrees of freedom; 1 for a ratio ≤ 0.
double f_tail(double ratio, double a, double b);

/// The false-alarm probability: that noise alone shows, at the highest of `trials` frequencies, a mean power (with
/// `dof` degrees of freedom) that is `power` or more above `background`. By Bonferroni, so at most too large.
double false_alarm(double power, const Background &background, double dof, double trials);

}  // namespace csd::motion
