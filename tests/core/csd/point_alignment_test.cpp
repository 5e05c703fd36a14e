// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/point_alignment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/csd/scene.h"
#include "csd/memory.h"

namespace csd {
namespace {

const AffineState start{{160, 120}};

double miss(const PointAlignment &alignment, cv::Point2d shift) {
  return cv::norm(alignment.fine.state.position - start.position - shift);
}

TEST(PointAlignment, GoesFromCoarseToFineAsFarAsItsLevelsReach) {
  Scene scene;
  const Memory memory(scene.frame({}), start);
  const cv::Point2d shift(11, -7);
  const auto frame = scene.frame(shift);
  const auto near = align_point(frame, memory, {start}), far = align_point(frame, memory, {start, 0, 2});
  EXPECT_GT(miss(near, shift), 2) << "the finest level alone can't bridge thirteen samples";
  EXPECT_LT(miss(far, shift), 0.1);
  EXPECT_GT(far.fine.zncc, 0.98);
  EXPECT_EQ(near.gain_coarse, 0) << "no coarser level was used";
  EXPECT_EQ(near.zncc_coarse, near.fine.zncc);
  EXPECT_NEAR(far.gain_coarse, 1, 0.1);
}

TEST(PointAlignment, StaysAtAConfidentPrediction) {
  Scene scene;
  const Memory memory(scene.frame({}), start);
  const cv::Point2d shift(1.5, 1);
  const auto frame = scene.frame(shift);
  EXPECT_LT(miss(align_point(frame, memory, {start}), shift), 0.1);
  EXPECT_GT(miss(align_point(frame, memory, {start, 1e-3}), shift), 1) << "predicted to a thousandth of a pixel";
}

TEST(PointAlignment, TheInnerDiscIgnoresItsSurroundings) {
  Scene scene;
  const Memory memory(scene.frame({}), start);
  // Bright matter has closed in from all sides, up to eight pixels away.
  cv::Mat mask(240, 320, CV_8UC1, cv::Scalar(255));
  cv::circle(mask, {160, 120}, 8, cv::Scalar(0), cv::FILLED);
  auto covered = scene.picture({});
  covered.setTo(230, mask);
  const auto frame = scene.show(covered);
  const auto whole = align_point(frame, memory, {start}), inner = align_point(frame, memory, {start, 0, 0, true});
  EXPECT_LT(whole.fine.zncc, 0.8);
  EXPECT_GT(inner.fine.zncc, 0.95);
  EXPECT_LT(miss(inner, {}), 0.3);
  EXPECT_NEAR(inner.fine.unmasked, 1, 1e-6) << "share of the disc, not of the patch";
}

TEST(PointAlignment, ACoarserLevelTellsBlurFromDimLight) {
  Scene scene;
  const Memory memory(scene.frame({}), start);
  const auto loss = [&](const cv::Mat &picture) {
    const auto frame = scene.show(picture);
    auto seen = align_point(frame, memory, {start});
    EXPECT_EQ(seen.gain_coarse, 0);
    const auto fine = seen.fine.gain;
    align_coarser(frame, memory, seen);
    EXPECT_EQ(seen.fine.gain, fine) << "what was seen is kept";
    return std::log(seen.gain_coarse / fine);
  };
  cv::Mat dim, blurred;
  scene.picture({}).convertTo(dim, CV_8U, 0.5, 60);
  cv::GaussianBlur(scene.picture({}), blurred, {}, 2);
  EXPECT_NEAR(loss(dim), 0, 0.02) << "both levels lose half";
  EXPECT_GT(loss(blurred), 0.05) << "the finer one loses more";
}

TEST(PointAlignment, WithoutShearFindsOnlyRotationAndZoom) {
  Scene scene;
  const Memory memory(scene.frame({}), start);
  cv::Mat sheared;
  const cv::Matx23d shear(1, 0.12, -0.12 * 120, 0, 1, 0);  // about (160, 120)
  cv::warpAffine(scene.picture({}), sheared, shear, {320, 240});
  auto frame = scene.show(sheared);
  frame.steps = 9;  // as after some time: the shape may have changed
  const auto affine = align_point(frame, memory, {start});
  EXPECT_NEAR(affine.fine.state.shape(0, 1), 0.12, 0.03);
  Tuning stiff;
  stiff.affine = 0;
  auto same = scene.show(sheared, stiff);
  same.steps = frame.steps;
  const auto similar = align_point(same, memory, {start});
  EXPECT_NEAR(similar.fine.state.shape(0, 1), -similar.fine.state.shape(1, 0), 1e-9);
  EXPECT_LT(similar.fine.zncc, affine.fine.zncc);
}

}  // namespace
}  // namespace csd
