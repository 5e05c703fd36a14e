// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace csd::motion {

/// Where features were during a window of time. Rows are moments, columns features.
struct Samples {
  Eigen::VectorXd times;    ///< s, from the window's middle
  double length = 0;        ///< s, the window's
  Eigen::MatrixXd x, y;     ///< px; any finite value where the weight is 0
  Eigen::MatrixXd weights;  ///< ≥ 0: the taper, and 0 where nothing is claimed
};

/// Hann's taper in a window `length` seconds long, `time` from its middle: 1 there, 0 from its ends on.
double taper(double time, double length);

/// Frequencies at equal steps: `step` · (`first` + i) for i < `count`, Hz.
struct Grid {
  double step = 0;
  std::size_t first = 0, count = 0;

  double frequency(double i) const { return step * (static_cast<double>(first) + i); }
};

/// The motion of one frequency: x = a·cos + b·sin, y = c·cos + d·sin (of 2πft, t from the window's middle): an ellipse.
struct Ellipse {
  double a = 0, b = 0, c = 0, d = 0;  ///< px

  double semi_major() const;                                               ///< px: half its length
  double variance() const { return (a * a + b * b + c * c + d * d) / 2; }  ///< px²
};

/// px²: of a column's x and y, weighted.
double sum_of_squares(const Samples &samples, Eigen::Index column);

/// Takes out of `samples`' columns from `begin` to `end`, by weighted least squares, what a parabola over time (drift)
/// and sinusoids of the given frequencies (Hz) explain together. Gives the sinusoids, [frequency][column − begin].
/// A column needs at least 3 + 2·frequencies moments with weight.
std::vector<std::vector<Ellipse>> take_out(Samples &samples, Eigen::Index begin, Eigen::Index end,
                                           std::span<const double> frequencies);

/// The generalised Lomb–Scargle periodogram (Zechmeister and Kürster 2009, Eq. 5) of each column, x and y together: the
/// share, 0…1, of their weighted sum of squares about the mean that an ellipse of a frequency explains. [column][i of
/// the grid]. The weighted means of x and y must be 0, as after take_out(). A column without any variance has 0.
Eigen::MatrixXf periodogram(const Samples &samples, const Grid &grid);

}  // namespace csd::motion
