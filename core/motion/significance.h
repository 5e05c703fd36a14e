// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <span>

namespace csd::motion {

/// The level of a spectrum around a frequency, without the peak.
struct Background {
  double level = 0;  ///< the estimated mean of the noise there
  double width = 0;  ///< number of independent frequencies used
};

/// The background at `spectrum[at]`. Its frequencies are `step` times `first`, `first` + 1, …; correlated values are at
/// most `correlated` places apart. Uses half the frequency to both sides, at least 10 correlation lengths, without
/// places less than `own` away.
///
/// The level is a median (a few other peaks don't raise it), divided by that of the χ² distribution with `dof` degrees
/// of freedom to estimate the mean. Noise in tissue is red: it falls with the frequency. So this takes the greater of
/// two medians, of the spectrum and of the spectrum times the frequency squared (the velocity's): where one of them is
/// too low, at an end of the band, the other is not.
Background background_at(std::span<const double> spectrum, std::size_t first, std::size_t at, std::size_t own,
                         double correlated, double dof);

/// P(F ≥ ratio) of the F distribution with `a` and `b` degrees of freedom; 1 for a ratio ≤ 0.
double f_tail(double ratio, double a, double b);

/// The false-alarm probability: that noise alone has, at the highest of `trials` frequencies, a mean power (with `dof`
/// degrees of freedom) of at least `power` above `background`. By Bonferroni, so never too small.
double false_alarm(double power, const Background &background, double dof, double trials);

}  // namespace csd::motion
