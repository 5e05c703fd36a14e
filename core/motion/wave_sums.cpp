// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/wave_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <stdexcept>

namespace csd::motion {
namespace {

constexpr double half = 5;          // places: half the kernel's width
constexpr double steep = 2.3 * 10;  // for a grid of twice as many places as frequencies

/// The "exponential of semicircle" at a distance in places.
double kernel(double distance) {
  const double x = distance / half;
  return std::abs(x) < 1 ? std::exp(steep * (std::sqrt(1 - x * x) - 1)) : 0;
}

}  // namespace

WaveSums::WaveSums(const Eigen::VectorXd &times, double step, std::size_t last)
    : size_(cv::getOptimalDFTSize(std::max(64, 4 * static_cast<int>(last + 1)))),
      begins_(static_cast<std::size_t>(times.size())),
      kernel_(taps, times.size()),
      correction_(static_cast<Eigen::Index>(last + 1)) {
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    const double turns = step * times[i];
    if (!(std::abs(turns) < 0.25 + 1e-6)) throw std::invalid_argument("WaveSums: a time beyond a quarter of a turn");
    // Time 0 is in the middle, so that no moment is spread over both ends.
    const double place = (turns + 0.5) * static_cast<double>(size_), begin = std::ceil(place - half);
    begins_[static_cast<std::size_t>(i)] = static_cast<Eigen::Index>(begin);
    for (Eigen::Index tap = 0; tap < taps; ++tap) kernel_(tap, i) = kernel(begin + static_cast<double>(tap) - place);
  }
  // Its transform by the trapezoidal rule, in halves of a place.
  std::array<double, 2 * static_cast<std::size_t>(half)> halves{};
  for (std::size_t i = 0; i < halves.size(); ++i) halves[i] = kernel(0.5 * static_cast<double>(i));
  for (Eigen::Index k = 0; k < correction_.size(); ++k) {
    const double turn = std::numbers::pi * static_cast<double>(k) / static_cast<double>(size_);
    double transform = 0.5 * halves[0];
    for (std::size_t i = 1; i < halves.size(); ++i) transform += halves[i] * std::cos(turn * static_cast<double>(i));
    correction_[k] = (k % 2 == 0 ? 1 : -1) / transform;  // the sign: for time 0 in the middle
  }
}

WaveSums::Rows WaveSums::of(const Eigen::MatrixXcd &values) const {
  Rows rows = Rows::Zero(values.cols(), size_);
  for (Eigen::Index column = 0; column < values.cols(); ++column)
    for (Eigen::Index i = 0; i < values.rows(); ++i)
      rows.row(column).segment<taps>(begins_[static_cast<std::size_t>(i)]) +=
          (kernel_.col(i) * values(i, column)).matrix().transpose();
  cv::Mat all(static_cast<int>(rows.rows()), static_cast<int>(size_), CV_64FC2, rows.data());
  cv::dft(all, all, cv::DFT_ROWS);
  for (Eigen::Index k = 0; k < correction_.size(); ++k) {
    rows.col(k) *= correction_[k];
    if (k > 0) rows.col(size_ - k) *= correction_[k];
  }
  return rows;
}

}  // namespace csd::motion
