// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/significance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "score/quantile.h"

namespace csd::motion {
namespace {

constexpr double min_lengths = 10;  ///< correlation lengths on each side
constexpr double median_efficiency =
    0.4;  // of the median's variance, by the mean's: 0.48 of an exponential; to be safe

/// χ²'s median over its mean (Wilson and Hilferty 1931).
double median_of_chi2(double dof) {
  const double root = 1 - 2 / (9 * dof);
  return root * root * root;
}

/// The continued fraction of the incomplete beta function (DLMF 8.17.22), by Lentz's method. For x < (a+1)/(a+b+2).
double beta_fraction(double x, double a, double b) {
  constexpr double tiny = 1e-300;
  constexpr int max_terms = 10000;
  double c = 1, d = 1 - (a + b) * x / (a + 1);
  d = 1 / (std::abs(d) < tiny ? tiny : d);
  double value = d;
  for (int m = 1; m < max_terms; ++m) {
    for (const double term : {m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                              -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))}) {
      d = 1 + term * d;
      d = 1 / (std::abs(d) < tiny ? tiny : d);
      c = 1 + term / c;
      if (std::abs(c) < tiny) c = tiny;
      value *= c * d;
    }
    if (std::abs(c * d - 1) < 1e-14) break;
  }
  return value;
}

/// I_x(a, b), regularised.
double incomplete_beta(double x, double a, double b) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front =
      // NOLINTNEXTLINE(concurrency-mt-unsafe): what isn't is the sign that it leaves, which nobody reads
      std::exp(a * std::log(x) + b * std::log1p(-x) + std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(x, a, b) / a;
  return 1 - front * beta_fraction(1 - x, b, a) / b;
}

}  // namespace

Background background_at(std::span<const double> spectrum, std::size_t first, std::size_t at, std::size_t own,
                         double correlated, double dof) {
  const auto here = static_cast<double>(first + at);
  const auto reach = static_cast<std::size_t>(std::max(0.5 * here, min_lengths * correlated));
  const std::size_t begin = at > reach ? at - reach : 0, end = std::min(spectrum.size(), at + reach + 1);
  std::vector<double> plain, red;
  for (std::size_t i = begin; i < end; ++i) {
    if ((i > at ? i - at : at - i) < own) continue;
    const double frequency = static_cast<double>(first + i) / here;
    plain.push_back(spectrum[i]);
    red.push_back(spectrum[i] * frequency * frequency);
  }
  Background background;
  if (plain.empty()) return background;
  background.width = static_cast<double>(plain.size()) / correlated;
  background.level =
      std::max(score::quantile(std::move(plain), 0.5), score::quantile(std::move(red), 0.5)) / median_of_chi2(dof);
  return background;
}

double f_tail(double ratio, double a, double b) {
  if (!(ratio > 0)) return 1;
  return incomplete_beta(b / (b + a * ratio), b / 2, a / 2);
}

double false_alarm(double power, const Background &background, double dof, double trials) {
  if (!(background.level > 0) || background.width < 1) return 1;
  const double one = f_tail(power / background.level, dof, median_efficiency * background.width * dof);
  return std::min(1.0, trials * one);
}

}  // namespace csd::motion
