// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/periodogram.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace csd::motion {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

/// Groups columns with the same weights: features claimed at the same moments, as most are, share everything that
/// depends only on the weights.
std::vector<std::vector<Eigen::Index>> alike(const Samples &samples, Eigen::Index begin, Eigen::Index end) {
  std::vector<std::vector<Eigen::Index>> groups;
  for (Eigen::Index column = begin; column < end; ++column) {
    const auto same = [&](const std::vector<Eigen::Index> &group) {
      return samples.weights.col(group.front()) == samples.weights.col(column);
    };
    const auto found = std::find_if(groups.begin(), groups.end(), same);
    if (found == groups.end())
      groups.push_back({column});
    else
      found->push_back(column);
  }
  return groups;
}

/// 1, t, t², then a cosine and a sine for each frequency. t is scaled to −1…1.
Eigen::MatrixXd design(const Samples &samples, std::span<const double> frequencies) {
  const auto count = static_cast<Eigen::Index>(frequencies.size());
  Eigen::MatrixXd terms(samples.times.size(), 3 + 2 * count);
  const Eigen::ArrayXd t = samples.times.array() * (2 / samples.length);
  terms.col(0).setOnes();
  terms.col(1) = t;
  terms.col(2) = t.square();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::ArrayXd phase = samples.times.array() * (two_pi * frequencies[static_cast<std::size_t>(i)]);
    terms.col(3 + 2 * i) = phase.cos();
    terms.col(4 + 2 * i) = phase.sin();
  }
  return terms;
}

/// Cosines (even columns) and sines (odd) of 0, 1, … `last` steps.
Eigen::MatrixXf waves(const Eigen::Ref<const Eigen::VectorXd> &times, double step, std::size_t last) {
  Eigen::MatrixXf table(times.size(), 2 * static_cast<Eigen::Index>(last + 1));
  Eigen::ArrayXcd turn(times.size()), now = Eigen::ArrayXcd::Ones(times.size());
  for (Eigen::Index i = 0; i < turn.size(); ++i) turn[i] = std::polar(1.0, two_pi * step * times[i]);
  for (Eigen::Index k = 0; k <= static_cast<Eigen::Index>(last); ++k) {
    table.col(2 * k) = now.real().cast<float>();
    table.col(2 * k + 1) = now.imag().cast<float>();
    now *= turn;
  }
  return table;
}

/// The sums for the periodogram, a row for each column of the samples, or each set of weights.
struct Sums {
  Eigen::MatrixXf x, y;     // weighted positions times the waves of the grid
  Eigen::MatrixXf weights;  // weights times the waves of 0, 1, … to twice the grid's end
};

Sums sums_of(const Samples &samples, const std::vector<std::vector<Eigen::Index>> &kinds, const Grid &grid) {
  constexpr Eigen::Index max_moments = 2048;  // at a time: limits the table of waves, so that it fits into a cache
  const std::size_t last = 2 * (grid.first + grid.count - 1);
  const auto searched = static_cast<Eigen::Index>(2 * grid.count);
  Sums sums;
  sums.x.setZero(samples.x.cols(), searched);
  sums.y.setZero(samples.x.cols(), searched);
  sums.weights.setZero(static_cast<Eigen::Index>(kinds.size()), static_cast<Eigen::Index>(2 * (last + 1)));
  for (Eigen::Index begin = 0; begin < samples.times.size(); begin += max_moments) {
    const Eigen::Index count = std::min(max_moments, samples.times.size() - begin);
    const Eigen::MatrixXf table = waves(samples.times.segment(begin, count), grid.step, last);
    const auto here = table.middleCols(static_cast<Eigen::Index>(2 * grid.first), searched);
    const auto w = samples.weights.middleRows(begin, count).array();
    const Eigen::MatrixXf x = (samples.x.middleRows(begin, count).array() * w).cast<float>(),
                          y = (samples.y.middleRows(begin, count).array() * w).cast<float>();
    Eigen::MatrixXf weights(count, sums.weights.rows());
    for (std::size_t k = 0; k < kinds.size(); ++k)
      weights.col(static_cast<Eigen::Index>(k)) = w.col(kinds[k].front()).cast<float>();
    sums.x.noalias() += x.transpose() * here;
    sums.y.noalias() += y.transpose() * here;
    sums.weights.noalias() += weights.transpose() * table;
  }
  return sums;
}

}  // namespace

double taper(double time, double length) {
  return std::abs(time) < length / 2 ? 0.5 + 0.5 * std::cos(two_pi * time / length) : 0;
}

double Ellipse::semi_major() const {
  // The larger singular value of [a b; c d].
  const double p = std::hypot(a + d, c - b), q = std::hypot(a - d, c + b);
  return (p + q) / 2;
}

double sum_of_squares(const Samples &samples, Eigen::Index column) {
  return (samples.weights.col(column).array() *
          (samples.x.col(column).array().square() + samples.y.col(column).array().square()))
      .sum();
}

std::vector<std::vector<Ellipse>> take_out(Samples &samples, Eigen::Index begin, Eigen::Index end,
                                           std::span<const double> frequencies) {
  std::vector<std::vector<Ellipse>> ellipses(frequencies.size(),
                                             std::vector<Ellipse>(static_cast<std::size_t>(end - begin)));
  const Eigen::MatrixXd terms = design(samples, frequencies);
  for (const auto &columns : alike(samples, begin, end)) {
    const auto count = static_cast<Eigen::Index>(columns.size());
    const Eigen::MatrixXd weighted = samples.weights.col(columns.front()).asDiagonal() * terms;
    Eigen::MatrixXd normal = weighted.transpose() * terms;
    // Regularises what a gap leaves undetermined; changes the rest by 1e−9.
    normal.diagonal() *= 1 + 1e-9;
    Eigen::MatrixXd values(samples.times.size(), 2 * count);
    for (Eigen::Index i = 0; i < count; ++i) {
      values.col(2 * i) = samples.x.col(columns[static_cast<std::size_t>(i)]);
      values.col(2 * i + 1) = samples.y.col(columns[static_cast<std::size_t>(i)]);
    }
    const Eigen::MatrixXd fitted = normal.ldlt().solve(weighted.transpose() * values);
    values.noalias() -= terms * fitted;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Index column = columns[static_cast<std::size_t>(i)];
      samples.x.col(column) = values.col(2 * i);
      samples.y.col(column) = values.col(2 * i + 1);
      for (std::size_t f = 0; f < frequencies.size(); ++f) {
        const auto row = static_cast<Eigen::Index>(3 + 2 * f);
        ellipses[f][static_cast<std::size_t>(column - begin)] = {fitted(row, 2 * i), fitted(row + 1, 2 * i),
                                                                 fitted(row, 2 * i + 1), fitted(row + 1, 2 * i + 1)};
      }
    }
  }
  return ellipses;
}

Eigen::MatrixXf periodogram(const Samples &samples, const Grid &grid) {
  const Eigen::Index columns = samples.x.cols(), first = static_cast<Eigen::Index>(grid.first),
                     count = static_cast<Eigen::Index>(grid.count);
  const auto kinds = alike(samples, 0, columns);
  const Sums sums = sums_of(samples, kinds, grid);
  Eigen::MatrixXf power(columns, count);
  for (std::size_t g = 0; g < kinds.size(); ++g) {
    const Eigen::RowVectorXd w = sums.weights.row(static_cast<Eigen::Index>(g)).cast<double>();
    const double whole = w[0];
    for (const Eigen::Index column : kinds[g]) {
      const double squares = sum_of_squares(samples, column);
      if (!(squares > 0)) {
        power.row(column).setZero();
        continue;
      }
      for (Eigen::Index i = 0; i < count; ++i) {
        const Eigen::Index k = 2 * (first + i);
        // CC, SS, CS and D, from the double angle.
        const double c = w[k] / whole, s = w[k + 1] / whole;
        const double cc = (1 + w[2 * k] / whole) / 2 - c * c, ss = (1 - w[2 * k] / whole) / 2 - s * s,
                     cs = w[2 * k + 1] / whole / 2 - c * s, determinant = cc * ss - cs * cs;
        double explained = 0;
        for (const Eigen::MatrixXf *const one : {&sums.x, &sums.y}) {
          const double yc = (*one)(column, 2 * i), ys = (*one)(column, 2 * i + 1);
          explained += ss * yc * yc + cc * ys * ys - 2 * cs * yc * ys;
        }
        power(column, i) =
            determinant > 1e-9 ? static_cast<float>(std::min(1.0, explained / (whole * determinant * squares))) : 0.0F;
      }
    }
  }
  return power;
}

}  // namespace csd::motion
