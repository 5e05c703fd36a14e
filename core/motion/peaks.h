// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "motion/periodogram.h"

namespace csd::motion {

inline constexpr double oversampling = 2;  ///< frequencies per 1/window: Hann's peak is 4/window wide

/// A detected sinusoid.
struct Peak {
  double frequency = 0;  ///< Hz; the median over the windows in which it stands out, if at least three
  std::size_t at = 0;    ///< position of the mean spectrum's peak in the grid
  double false_alarm = 1;
  bool confirmed = false;
  std::vector<double> by_window;  ///< Hz, the rate in each window
  std::vector<bool> stands_out;   ///< whether it was seen in that window itself; otherwise the rate is the neighbour's
};

/// What one window shows of some features.
struct View {
  std::vector<std::size_t> members;            ///< the features with enough data in it
  std::vector<double> missing;                 ///< 0…1, of each: the share of the window that is missing, by weight
  std::vector<double> whole;                   ///< px², the variance of each without drift
  std::vector<double> dimensions;              ///< 1…2, of each: the dimensions of the remaining motion
  std::vector<double> remainder;               ///< px², without the peaks too
  std::vector<std::vector<Ellipse>> ellipses;  ///< [peak][member]
  /// The remaining power as a share of `whole`: upper quartile over the members. Empty: no members.
  std::vector<float> spectrum;
};

/// Finds the common peaks of some features. In each round, fill in each window's view() with frequencies() removed,
/// then call search(), until it is done.
class PeakSearch {
 public:
  PeakSearch(std::size_t windows, const Grid &grid, double false_alarm)
      : views_(windows), grid_(grid), false_alarm_(false_alarm) {}

  bool active() const { return active_; }
  View &view(std::size_t window) { return views_[window]; }
  const std::vector<View> &views() const { return views_; }
  const std::vector<Peak> &peaks() const { return peaks_; }

  /// The frequency of each peak in a window, Hz.
  std::vector<double> frequencies(std::size_t window) const;

  /// Computes View::spectrum from its members' periodograms, which start in row `row`.
  void combine(std::size_t window, const Eigen::MatrixXf &periodogram, Eigen::Index row);

  /// Judges the proposed peaks and proposes new ones.
  void search();

 private:
  struct Seen {
    double frequency = 0, false_alarm = 1;
  };

  std::vector<double> mean_spectrum() const;
  double fitted_power(std::size_t peak) const;
  double sidelobes() const;
  void judge(const std::vector<double> &remaining);
  void propose(const std::vector<double> &mean);
  bool add(const std::vector<double> &mean, std::size_t at);
  bool known_already(const Peak &peak) const;
  bool taken(double frequency) const;
  std::size_t own(std::size_t at) const;
  Seen look_near(const std::vector<float> &spectrum, double frequency, double share) const;
  void follow(Peak &peak, std::size_t from, int step) const;

  std::vector<View> views_;
  std::vector<Peak> peaks_;
  std::vector<double> rejected_;  // Hz
  Grid grid_;
  double false_alarm_;
  double windows_ = 0;  // windows with data
  double dof_ = 0;      // of the mean spectrum: 2 or more per window
  bool active_ = true;
};

}  // namespace csd::motion
