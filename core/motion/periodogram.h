// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace csd::motion {

/// Positions of features in a window of time. Rows are moments, columns features.
struct Samples {
  Eigen::VectorXd times;    ///< s, relative to the window's middle
  double length = 0;        ///< s, length of the window
  Eigen::MatrixXd x, y;     ///< px; any finite value where the weight is 0
  Eigen::MatrixXd weights;  ///< ≥ 0: the taper; 0 where no position is claimed
};

/// Hann's taper in a window of `length` seconds, at `time` from its middle: 1 in the middle, 0 at and beyond the ends.
double taper(double time, double length);

/// Frequencies at equal steps: `step` · (`first` + i) for i < `count`, Hz.
struct Grid {
  double step = 0;
  std::size_t first = 0, count = 0;

  double frequency(double i) const { return step * (static_cast<double>(first) + i); }
};

/// An elliptical motion at one frequency: x = a·cos + b·sin, y = c·cos + d·sin (of 2πft, t from the window's middle).
struct Ellipse {
  double a = 0, b = 0, c = 0, d = 0;  ///< px

  double semi_major() const;                                               ///< px: half its length
  double variance() const { return (a * a + b * b + c * c + d * d) / 2; }  ///< px²
};

/// px²: weighted, over a column's x and y.
double sum_of_squares(const Samples &samples, Eigen::Index column);

/// Removes from `samples`' columns `begin` to `end`, by weighted least squares, a parabola over time (drift) fitted
/// jointly with sinusoids of the given frequencies (Hz). Returns the sinusoids, [frequency][column − begin]. A column
/// needs at least 3 + 2·frequencies moments with weight.
std::vector<std::vector<Ellipse>> take_out(Samples &samples, Eigen::Index begin, Eigen::Index end,
                                           std::span<const double> frequencies);

/// The generalised Lomb–Scargle periodogram (Zechmeister and Kürster 2009, Eq. 5) of each column, x and y together: the
/// share, 0…1, of the weighted sum of squares about the mean that an ellipse of a frequency explains. [column][i of the
/// grid]. The weighted means of x and y must be 0, as after take_out(). 0 for a column without variance.
Eigen::MatrixXf periodogram(const Samples &samples, const Grid &grid);

}  // namespace csd::motion
