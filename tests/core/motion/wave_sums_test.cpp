// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/wave_sums.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace csd::motion {
namespace {

using Complex = std::complex<double>;

TEST(WaveSums, AreTheSums) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const int last : {1, 7, 480}) {
    const double length = 20, step = 1 / (2 * length);
    Eigen::VectorXd times(300);
    Eigen::MatrixXcd values(300, 3);
    for (Eigen::Index i = 0; i < times.size(); ++i) {
      times[i] = length / 2 * uniform(random);
      for (Eigen::Index c = 0; c < 3; ++c) values(i, c) = Complex(uniform(random), uniform(random));
    }
    times[0] = -length / 2;
    times[1] = length / 2;
    times[2] = 0;
    const WaveSums sums(times, step, static_cast<std::size_t>(last));
    const auto found = sums.of(values);
    for (Eigen::Index c = 0; c < 3; ++c)
      for (const int k : {-last, 1 - last, -1, 0, 1, last / 2, last}) {
        Complex sum = 0;
        for (Eigen::Index i = 0; i < times.size(); ++i)
          sum += values(i, c) * std::polar(1.0, -2 * std::numbers::pi * k * step * times[i]);
        const Complex got = found(c, k < 0 ? sums.size() + k : k);
        EXPECT_NEAR(std::abs(got - sum), 0, 1e-8 * values.col(c).cwiseAbs().sum()) << last << " " << k;
      }
  }
}

TEST(WaveSums, TimesBeyondTheirReachAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double time : {5.1, -5.1, 1e300, nan})
    EXPECT_THROW(WaveSums(Eigen::VectorXd::Constant(1, time), 0.05, 10), std::invalid_argument) << time;
  EXPECT_NO_THROW(WaveSums(Eigen::VectorXd::Constant(1, -5), 0.05, 10));
}

}  // namespace
}  // namespace csd::motion
