// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/periodogram.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "motion/wave_sums.h"

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
    const double speed = two_pi * frequencies[static_cast<std::size_t>(i)];
    for (Eigen::Index row = 0; row < terms.rows(); ++row) {
      const auto turned = std::polar(1.0, speed * samples.times[row]);  // both at once take half the time
      terms(row, 3 + 2 * i) = turned.real();
      terms(row, 4 + 2 * i) = turned.imag();
    }
  }
  return terms;
}

/// What of the periodogram depends on the weights alone, by place of the grid.
struct Kind {
  std::vector<Eigen::Index> columns;
  double whole = 0;  // sum of the weights
  Eigen::ArrayXd cc, ss, cs, scale;
};

std::vector<Kind> kinds_of(const Samples &samples, const Grid &grid) {
  std::vector<Kind> kinds;
  for (auto &columns : alike(samples, 0, samples.x.cols())) kinds.push_back({std::move(columns), 0, {}, {}, {}, {}});
  Eigen::MatrixXcd weights(samples.times.size(), static_cast<Eigen::Index>(kinds.size()));
  for (std::size_t i = 0; i < kinds.size(); ++i)
    weights.col(static_cast<Eigen::Index>(i)) =
        samples.weights.col(kinds[i].columns.front()).cast<std::complex<double>>();
  const auto first = static_cast<Eigen::Index>(grid.first), count = static_cast<Eigen::Index>(grid.count);
  const auto sums = WaveSums(samples.times, grid.step, 2 * (grid.first + grid.count - 1)).of(weights);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    Kind &kind = kinds[i];
    const auto of_kind = sums.row(static_cast<Eigen::Index>(i));
    kind.whole = of_kind[0].real();
    const auto at = [&](Eigen::Index k) { return of_kind[k] / kind.whole; };
    for (auto *const values : {&kind.cc, &kind.ss, &kind.cs, &kind.scale}) values->resize(count);
    for (Eigen::Index g = 0; g < count; ++g) {
      const Eigen::Index k = first + g;
      // CC, SS, CS and D, from the double angle.
      const double c = at(k).real(), s = -at(k).imag();
      kind.cc[g] = (1 + at(2 * k).real()) / 2 - c * c;
      kind.ss[g] = (1 - at(2 * k).real()) / 2 - s * s;
      kind.cs[g] = -at(2 * k).imag() / 2 - c * s;
      const double determinant = kind.cc[g] * kind.ss[g] - kind.cs[g] * kind.cs[g];
      kind.scale[g] = determinant > 1e-9 ? 1 / (kind.whole * determinant) : 0;
    }
  }
  return kinds;
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
  constexpr std::size_t at_once = 16;  // columns, so that what is transformed fits into a cache
  const auto first = static_cast<Eigen::Index>(grid.first), count = static_cast<Eigen::Index>(grid.count);
  const WaveSums waves(samples.times, grid.step, grid.first + grid.count - 1);
  Eigen::MatrixXf power(samples.x.cols(), count);
  for (const Kind &kind : kinds_of(samples, grid))
    for (std::size_t begin = 0; begin < kind.columns.size(); begin += at_once) {
      const std::span columns(kind.columns.data() + begin, std::min(at_once, kind.columns.size() - begin));
      Eigen::MatrixXcd values(samples.times.size(), static_cast<Eigen::Index>(columns.size()));
      for (std::size_t i = 0; i < columns.size(); ++i) {
        const auto w = samples.weights.col(columns[i]);
        values.col(static_cast<Eigen::Index>(i)).real() = w.cwiseProduct(samples.x.col(columns[i]));
        values.col(static_cast<Eigen::Index>(i)).imag() = w.cwiseProduct(samples.y.col(columns[i]));
      }
      const auto sums = waves.of(values);
      for (std::size_t i = 0; i < columns.size(); ++i) {
        const double squares = sum_of_squares(samples, columns[i]);
        for (Eigen::Index g = 0; g < count; ++g) {
          // One transform gives x and y, from frequencies of both signs.
          const auto row = static_cast<Eigen::Index>(i);
          const std::complex<double> above = sums(row, first + g), below = sums(row, waves.size() - first - g);
          const double xc = (above.real() + below.real()) / 2, xs = (below.imag() - above.imag()) / 2,
                       yc = (above.imag() + below.imag()) / 2, ys = (above.real() - below.real()) / 2;
          const double explained = kind.ss[g] * (xc * xc + yc * yc) + kind.cc[g] * (xs * xs + ys * ys) -
                                   2 * kind.cs[g] * (xc * xs + yc * ys);
          power(columns[i], g) =
              squares > 0 ? static_cast<float>(std::min(1.0, explained * kind.scale[g] / squares)) : 0.0F;
        }
      }
    }
  return power;
}

}  // namespace csd::motion
