// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/periodogram.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <random>

namespace csd::motion {
namespace {

constexpr double turn = 2 * std::numbers::pi;

/// `columns` features of noise in a window of 20 s, at uneven times. All but the last two have a gap of their own.
Samples samples_of_noise(Eigen::Index columns, Eigen::Index moments = 400) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-.4, .4);
  std::normal_distribution<double> normal;
  Samples samples;
  samples.length = 20;
  samples.times.resize(moments);
  samples.x.resize(moments, columns);
  samples.y.resize(moments, columns);
  samples.weights.resize(moments, columns);
  for (Eigen::Index i = 0; i < moments; ++i) {
    samples.times[i] = (static_cast<double>(i) + .5 + uniform(random)) * 20 / static_cast<double>(moments) - 10;
    for (Eigen::Index c = 0; c < columns; ++c) {
      samples.x(i, c) = normal(random);
      samples.y(i, c) = normal(random);
      const double from = -8. + static_cast<double>(std::min(c, columns - 2));
      const bool hidden = samples.times[i] > from && samples.times[i] < from + 3;
      samples.weights(i, c) = hidden ? 0 : taper(samples.times[i], 20);
    }
  }
  return samples;
}

/// The weighted sum of squares that the best combination of `terms` leaves.
double left(const Eigen::MatrixXd &terms, const Eigen::VectorXd &values, const Eigen::VectorXd &weights) {
  const Eigen::VectorXd root = weights.cwiseSqrt();
  const Eigen::MatrixXd a = root.asDiagonal() * terms;
  const Eigen::VectorXd b = root.asDiagonal() * values;
  return (b - a * a.colPivHouseholderQr().solve(b)).squaredNorm();
}

TEST(Taper, IsHann) {
  EXPECT_DOUBLE_EQ(taper(0, 8), 1);
  EXPECT_DOUBLE_EQ(taper(2, 8), .5);
  EXPECT_DOUBLE_EQ(taper(-2, 8), .5);
  EXPECT_DOUBLE_EQ(taper(4, 8), 0);
  EXPECT_EQ(taper(5, 8), 0);
}

TEST(Ellipse, SemiMajorAxisIsRight) {
  EXPECT_DOUBLE_EQ((Ellipse{3, 0, 4, 0}.semi_major()), 5) << "a line";
  EXPECT_DOUBLE_EQ((Ellipse{2, 0, 0, 2}.semi_major()), 2) << "a circle";
  EXPECT_DOUBLE_EQ((Ellipse{0, 3, -7, 0}.semi_major()), 7);
  EXPECT_DOUBLE_EQ((Ellipse{3, 0, 4, 0}.variance()), 12.5);
}

TEST(Periodogram, IsTheShareExplainedByLeastSquares) {
  // Against a QR least-squares fit of a constant, a cosine and a sine. 5000 moments need more than one table.
  for (const Eigen::Index moments : {400, 5000}) {
    Samples samples = samples_of_noise(4, moments);
    take_out(samples, 0, 4, {});
    const Grid grid{1. / 40, 4, 90};
    const Eigen::MatrixXf power = periodogram(samples, grid);
    ASSERT_EQ(power.rows(), 4);
    ASSERT_EQ(power.cols(), 90);
    for (Eigen::Index c = 0; c < 4; ++c)
      for (Eigen::Index i = 0; i < 90; i += 7) {
        const double f = static_cast<double>(4 + i) / 40;
        EXPECT_DOUBLE_EQ(grid.frequency(static_cast<double>(i)), f);
        Eigen::MatrixXd terms(moments, 3);
        terms << Eigen::VectorXd::Ones(moments), (turn * f * samples.times.array()).cos().matrix(),
            (turn * f * samples.times.array()).sin().matrix();
        const Eigen::VectorXd w = samples.weights.col(c);
        const double all = left(terms.leftCols(1), samples.x.col(c), w) + left(terms.leftCols(1), samples.y.col(c), w),
                     rest = left(terms, samples.x.col(c), w) + left(terms, samples.y.col(c), w);
        EXPECT_NEAR(power(c, i), 1 - rest / all, 2e-5) << c << " " << f;
      }
  }
}

TEST(Periodogram, OfAStillFeatureIsZero) {
  Samples samples = samples_of_noise(2);
  samples.x.col(0).setZero();
  samples.y.col(0).setZero();
  const Eigen::MatrixXf power = periodogram(samples, {1. / 40, 4, 20});
  EXPECT_EQ(power.row(0).maxCoeff(), 0);
  EXPECT_GT(power.row(1).maxCoeff(), 0);
}

TEST(TakeOut, FindsWhatWasPutIn) {
  Samples samples = samples_of_noise(3);
  const Eigen::ArrayXd t = samples.times.array();
  for (Eigen::Index c = 0; c < 3; ++c) {
    const double drift = static_cast<double>(c);
    samples.x.col(c) = 5 + drift * t - .3 * t.square() + 2 * (turn * .31 * t).cos() - 3 * (turn * 1.27 * t).sin();
    samples.y.col(c) = -2 + t + 4 * (turn * .31 * t).sin() + .5 * (turn * 1.27 * t).cos();
  }
  samples.x(200, 1) = 1e6;
  samples.weights(200, 1) = 0;  // without weight it doesn't count
  const double frequencies[] = {.31, 1.27};
  const auto ellipses = take_out(samples, 1, 3, frequencies);
  ASSERT_EQ(ellipses.size(), 2u);
  ASSERT_EQ(ellipses[0].size(), 2u);
  for (const std::size_t c : {0, 1}) {
    EXPECT_NEAR(ellipses[0][c].a, 2, 1e-5);
    EXPECT_NEAR(ellipses[0][c].b, 0, 1e-5);
    EXPECT_NEAR(ellipses[0][c].c, 0, 1e-5);
    EXPECT_NEAR(ellipses[0][c].d, 4, 1e-5);
    EXPECT_NEAR(ellipses[1][c].b, -3, 1e-5);
    EXPECT_NEAR(ellipses[1][c].c, .5, 1e-5);
    EXPECT_NEAR(sum_of_squares(samples, static_cast<Eigen::Index>(c) + 1), 0, 1e-6);
  }
  EXPECT_GT(sum_of_squares(samples, 0), 100) << "another column is unchanged";
}

}  // namespace
}  // namespace csd::motion
