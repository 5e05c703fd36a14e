// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <vector>

namespace csd::motion {

/// Fourier sums of values at uneven times: each value is spread over some places of an even grid, which is transformed
/// (Dutt and Rokhlin 1993, with the kernel of Barnett, Magland and af Klinteberg 2019). For a window of a minute that
/// takes a sixth of the time of the sums as a product of matrices, and errs by less than 1e−8 of the sum of the values'
/// magnitudes.
class WaveSums {
 public:
  /// A row for each column of the values; of frequency k·step is column k, of −k·step column size() − k.
  using Rows = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// For the frequencies −`last`·`step` … `last`·`step`, Hz. Times in s, none beyond ±1/(4·step), else
  /// std::invalid_argument.
  WaveSums(const Eigen::VectorXd &times, double step, std::size_t last);

  /// Σ value·exp(−2πi·k·step·time) over the moments, the rows of `values`.
  Rows of(const Eigen::MatrixXcd &values) const;
  Eigen::Index size() const { return size_; }

 private:
  static constexpr Eigen::Index taps = 10;

  Eigen::Index size_;
  std::vector<Eigen::Index> begins_;                   ///< by moment: the first place that it is spread over
  Eigen::Array<double, taps, Eigen::Dynamic> kernel_;  ///< by moment: how much of it comes to each place
  Eigen::ArrayXd correction_;                          ///< by k: for the kernel's own transform
};

}  // namespace csd::motion
