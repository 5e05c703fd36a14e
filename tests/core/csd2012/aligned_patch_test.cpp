// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/aligned_patch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/patch/warped_picture.h"

namespace csd {
namespace {

using test::render;
using test::similarity;
using test::View;
using test::Waves;

class AligningAPatch : public testing::Test {
 protected:
  static Pyramid pyramid(const Waves &texture, const AffineState &state) {
    View view;
    view.state = state;
    view.noise = 2;
    view.seed = ++seed_;
    Pyramid p;
    p.build(render(texture, view));
    return p;
  }
  static double apart(cv::Point2d a, cv::Point2d b) { return std::hypot(a.x - b.x, a.y - b.y); }

  static inline std::uint64_t seed_ = 0;
  const Waves texture_{3, 9, 30, 20};
  const GlareWeights no_glare_{};
  const cv::Point2d start_{64, 64};
  AlignedPatch patch_{pyramid(texture_, {start_}), no_glare_, start_, 1};
};

TEST_F(AligningAPatch, FitsAtTheFeature) {
  const cv::Point2d now{67, 61};
  const auto fit = patch_.fit(pyramid(texture_, {now}), no_glare_, start_);
  EXPECT_GT(fit.zncc, 0.95);
  EXPECT_LT(apart(fit.state.position, now), 0.3);
}

TEST_F(AligningAPatch, DoesNotFitOtherTissue) {
  const Waves other(4, 9, 30, 20);
  EXPECT_LT(patch_.fit(pyramid(other, {start_}), no_glare_, start_).zncc, 0.8);
}

// Each frame starts with the shape of the last fit: 4° and 2 % a step, which add up to more than one fit can bridge.
TEST_F(AligningAPatch, FollowsRotationAndZoomStepByStep) {
  for (int i = 1; i <= 30; ++i) {
    const AffineState now{start_, similarity(4. * i, std::pow(1.02, i))};
    const auto fit = patch_.fit(pyramid(texture_, now), no_glare_, start_);
    ASSERT_GT(fit.zncc, 0.9) << i;
    ASSERT_LT(apart(fit.state.position, start_), 0.5) << i;
    patch_.accept(fit);
  }
  const AffineState turned{start_, similarity(120, std::pow(1.02, 30))};
  const AlignedPatch anew(pyramid(texture_, {start_}), no_glare_, start_, 1);
  EXPECT_LT(anew.fit(pyramid(texture_, turned), no_glare_, start_).zncc, 0.8) << "too far for one step";
}

TEST_F(AligningAPatch, SeesNothingOutsideThePicture) {
  EXPECT_EQ(patch_.fit(pyramid(texture_, {start_}), no_glare_, {-40, -40}).zncc, 0);
}

}  // namespace
}  // namespace csd
