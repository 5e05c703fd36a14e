// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/align.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/patch/warped_picture.h"
#include "core/simd_targets.h"
#include "core/track/moving_scene.h"
#include "image/work_frame.h"

namespace csd {
namespace {

using test::render;
using test::similarity;
using test::View;
using test::Waves;

constexpr int radius = PatchPlane::radius;
const GlareWeights no_glare;

Pyramid pyramid(const cv::Mat &luma) {
  Pyramid p;
  p.build(luma);
  return p;
}

AnchorLevel anchor(const Waves &texture, int level, double noise = 0) {
  View first;
  first.state.position = {64, 64};
  first.noise = noise;
  first.seed = 99;
  return make_anchor_level(sample(pyramid(render(texture, first)), no_glare, first.state, level));
}

double distance(const AffineState &a, const AffineState &b) {
  return std::hypot(a.position.x - b.position.x, a.position.y - b.position.y);
}

AlignPrior vague() {
  AlignPrior p;
  p.shape = .3;
  return p;
}

bool finite(const Alignment &a) {
  for (const double v : {a.state.position.x, a.state.position.y, cv::norm(a.state.shape), a.zncc, a.inliers, a.unmasked,
                         a.gain, a.bias, a.noise, cv::norm(a.information)})
    if (!std::isfinite(v)) return false;
  return true;
}

double error_of(std::uint64_t seed, const cv::Matx22d &shape, double noise, const AlignPrior &prior) {
  cv::RNG rng(seed);
  const Waves texture(seed, 9, 30, 20);
  const AnchorLevel level0 = anchor(texture, 0);
  View view;
  view.state = {{64 + rng.uniform(-5., 5.), 64 + rng.uniform(-5., 5.)}, shape};
  view.noise = noise;
  view.seed = seed;
  const Pyramid frame = pyramid(render(texture, view));
  const AffineState start{view.state.position + cv::Point2d(rng.uniform(-.7, .7), rng.uniform(-.7, .7))};
  double worst = 0;
  for (const auto run : {align, align_scalar}) {
    const Alignment a = run(frame, no_glare, level0, 0, start, prior, AlignModel::affine, fine_precision);
    EXPECT_TRUE(a.usable);
    EXPECT_LT(cv::norm(a.state.shape - shape), noise > 0 ? .03 : .01) << seed;
    worst = std::max(worst, distance(a.state, view.state));
  }
  return worst;
}

// The start has a wrong shape, and an offset of up to a pixel. Without noise, only bilinear sampling errs: half-way
// between pixels it weakens short waves by cos(π/λ), and a patch of several waves moves with their shares.
TEST(Align, FindsPositionAndShape) {
  cv::RNG rng(4);
  constexpr int textures = 24;
  double mean = 0, mean_with_noise = 0;
  for (std::uint64_t k = 1; k <= textures; ++k) {
    const double exact = error_of(k, cv::Matx22d::eye(), 0, {}), noisy = error_of(k, cv::Matx22d::eye(), 2, {});
    EXPECT_LT(exact, .03) << k;
    EXPECT_LT(noisy, .1) << k;
    mean += exact / textures;
    mean_with_noise += noisy / textures;
    // A stretched picture was smoothed less, too.
    const auto some = [&] { return rng.uniform(-.05, .05); };
    const cv::Matx22d other = similarity(rng.uniform(-3., 3.)) * cv::Matx22d(1 + some(), some(), 0, 1 + some());
    EXPECT_LT(error_of(k, other, 0, vague()), .04) << k;
    EXPECT_LT(error_of(k, other, 2, vague()), .1) << k;
  }
  RecordProperty("mean", std::to_string(mean));
  RecordProperty("mean_with_noise", std::to_string(mean_with_noise));
  EXPECT_LT(mean, .02);
  EXPECT_LT(mean_with_noise, .05);
}

TEST(Align, ACoarsePassEndsSoonerWithinItsBound) {
  const Waves texture(3, 9, 30, 20);
  const AnchorLevel known = anchor(texture, 0);
  const Pyramid frame = pyramid(render(texture, {.state = {{65.4, 63.3}}}));
  const Alignment fine = align(frame, no_glare, known, 0, {{64, 64}}, {}, AlignModel::affine);
  const Alignment coarse = align(frame, no_glare, known, 0, {{64, 64}}, {}, AlignModel::affine, coarse_precision);
  EXPECT_LT(coarse.iterations, fine.iterations);
  EXPECT_LT(distance(coarse.state, fine.state), coarse_precision);
}

TEST(Align, FollowsGainBiasRotationAndScale) {
  const Waves texture(2, 14, 50, 20);
  Anchor known;
  for (int l = 0; l <= 2; ++l) known.set(l, anchor(texture, l));
  for (const double degrees : {0., 30., 180., -75.})
    for (const double scale : {.4, .6, 1., 1.6, 3.}) {
      View view;
      view.state = {{93.2, 95.1}, similarity(degrees, scale)};
      view.gain = .6, view.bias = 100, view.size = {190, 190};
      const AffineState start{view.state.position + cv::Point2d(.5, -.4) * scale,
                              similarity(degrees + 1, scale * 1.02)};
      const int level = known.fine_level(scale);
      const Alignment a =
          align(pyramid(render(texture, view)), no_glare, known.level(level), level, start, {}, AlignModel::similarity);
      ASSERT_TRUE(a.usable);
      // A picture at another scale was smoothed to another degree (FindsPositionAndShape): worst at .4.
      EXPECT_LT(distance(a.state, view.state), .06 * std::ldexp(scale, level)) << degrees << ' ' << scale;
      // A similarity stays a similarity.
      EXPECT_NEAR(a.state.shape(0, 0), a.state.shape(1, 1), 1e-9);
      EXPECT_NEAR(a.state.shape(0, 1), -a.state.shape(1, 0), 1e-9);
      EXPECT_NEAR(a.state.scale(), scale, .01 * scale) << degrees << ' ' << scale;
      EXPECT_GT(a.zncc, .98) << degrees << ' ' << scale;
    }
}

/// Paints every pixel of the view for which `where` holds, in offsets from the feature.
template <class Where>
void paint(cv::Mat &luma, const AffineState &state, int value, Where where) {
  for (int y = 0; y < luma.rows; ++y)
    for (int x = 0; x < luma.cols; ++x)
      if (where(x - state.position.x, y - state.position.y)) luma.ptr(y)[x] = static_cast<std::uint8_t>(value);
}

TEST(Align, DoesNotFollowOutliers) {
  const Waves texture(5, 6, 25, 20);
  const AnchorLevel level0 = anchor(texture, 0);
  View view;
  view.state.position = {66.3, 61.8};
  cv::Mat luma = render(texture, view);
  paint(luma, view.state, 230, [](double x, double y) { return x > 4 && y > -4; });  // 6 of 21 columns, 14 of 21 rows
  const Alignment a =
      align(pyramid(luma), no_glare, level0, 0, {view.state.position + cv::Point2d(.5, .4)}, {}, AlignModel::affine);
  ASSERT_TRUE(a.usable);
  EXPECT_LT(distance(a.state, view.state), .1);
  // At the truth, the weights of the painted pixels' differences.
  const PatchSample clean = sample(pyramid(render(texture, view)), no_glare, view.state, 0);
  const PatchSample painted = sample(pyramid(luma), no_glare, view.state, 0);
  double inliers = 0;
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x)
      inliers += 1 / std::pow(1 + std::pow((painted.value.at(x, y) - clean.value.at(x, y)) / 6, 2), 2);
  EXPECT_NEAR(a.inliers, inliers / PatchPlane::pixels, .03);
  EXPECT_EQ(a.unmasked, 1);
}

TEST(Align, MaskedHighlightsDoNotCount) {
  const Waves texture(6, 6, 25, 8);
  const AnchorLevel level0 = anchor(texture, 0);
  View view;
  view.state.position = {66.3, 61.8};
  view.bias = 110;
  cv::Mat luma = render(texture, view);
  const auto where = [](double x, double y) { return std::hypot(x - 5, y + 2) < 6; };
  paint(luma, view.state, 240, where);
  WorkFrame frame;
  frame.load(MovingScene::gray_view(luma));
  GlareWeights glare;
  glare.build(frame, {});
  const AffineState start{view.state.position + cv::Point2d(.5, .4)};
  const Pyramid p = pyramid(luma);
  const double share = [&] {
    const PatchSample s = sample(p, glare, view.state, 0);
    double sum = 0;
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x) sum += GlareWeights::tissue_share(s.weight.at(x, y));
    return sum / PatchPlane::pixels;
  }();
  ASSERT_GT(share, .3);
  ASSERT_LT(share, .8);
  for (const auto run : {align, align_scalar}) {
    const Alignment a = run(p, glare, level0, 0, start, {}, AlignModel::affine, fine_precision);
    ASSERT_TRUE(a.usable);
    EXPECT_LT(distance(a.state, view.state), .05);
    EXPECT_NEAR(a.unmasked, share, .01);
    EXPECT_GT(a.inliers, .9);
    EXPECT_GT(a.zncc, .95);
    // Without its mask, the highlight lowers the correlation.
    EXPECT_LT(run(p, no_glare, level0, 0, start, {}, AlignModel::affine, fine_precision).zncc, .5);
  }
}

TEST(Align, StrongPriorsHold) {
  const Waves texture(7, 6, 25, 20);
  const AnchorLevel level0 = anchor(texture, 0);
  View view;
  view.state = {{65, 64}, similarity(1.5)};
  const Pyramid p = pyramid(render(texture, view));
  const AffineState start{{64.8, 64.3}};
  AlignPrior prior = vague();
  prior.position = cv::Matx22d::eye() * 1e6;
  const Alignment held = align(p, no_glare, level0, 0, start, prior, AlignModel::affine);
  EXPECT_LT(distance(held.state, start), .01);
  prior = {};
  prior.shape = 1e-4;
  const Alignment stiff = align(p, no_glare, level0, 0, start, prior, AlignModel::affine);
  EXPECT_LT(cv::norm(stiff.state.shape - cv::Matx22d::eye()), 1e-3);
  EXPECT_LT(distance(stiff.state, view.state), .15);
  // One direction is known, the other is not.
  prior = vague();
  prior.position = {1e6, 0, 0, 0};
  const Alignment along = align(p, no_glare, level0, 0, start, prior, AlignModel::affine);
  EXPECT_NEAR(along.state.position.x, start.position.x, .01);
  EXPECT_LT(std::abs(along.state.position.y - 64), .2);
}

struct Linear {
  cv::Vec2d shift;
  cv::Matx22d shear, information;
};

/// The step from `start` to the MAP estimate, straight from its definition: a dense solution of all eight unknowns.
/// Takes the robust weights at `found`, the end: there, weighted least squares and the robust estimate agree.
Linear dense_step(const Pyramid &frame, const AnchorLevel &a, const AffineState &start, int level,
                  const AlignPrior &prior, const Alignment &found) {
  const PatchSample before = sample(frame, no_glare, start, level), after = sample(frame, no_glare, found.state, level);
  const double c = 3 * std::max(found.noise, 2.), sigma = 3 * std::max(found.noise, 1.);
  cv::Matx<double, 8, 8> H = cv::Matx<double, 8, 8>::zeros();
  cv::Vec<double, 8> g = cv::Vec<double, 8>::all(0);
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) {
      const auto residual = [&](const PatchSample &s) {
        return (s.value.at(x, y) - found.bias) / found.gain - a.patch.at(x, y);
      };
      const double w = 1 / std::pow(1 + std::pow(residual(after) / c, 2), 2) / (sigma * sigma);
      const double tx = a.gradient_x.at(x, y), ty = a.gradient_y.at(x, y);
      // Unknowns: shift, shear by rows, gain, bias.
      const cv::Vec<double, 8> J(tx, ty, x * tx, y * tx, x * ty, y * ty, a.patch.at(x, y), 1);
      H += w * J * J.t();
      g += w * residual(before) * J;
    }
  for (int i = 2; i < 6; ++i) H(i, i) += 1 / (prior.shape * prior.shape);
  // The information on the shift if all the rest is unknown: the inverse of its covariance.
  const cv::Matx<double, 8, 8> covariance = H.inv();
  const cv::Matx22d B = start.shape * std::ldexp(1., level), back = B.inv();
  Linear out;
  out.information =
      back.t() * cv::Matx22d(covariance(0, 0), covariance(0, 1), covariance(1, 0), covariance(1, 1)).inv() * back;
  const cv::Matx22d about = B.t() * prior.position * B;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) H(i, j) += about(i, j);
  const cv::Vec<double, 8> step = H.inv() * g;
  out.shift = {step[0], step[1]};
  out.shear = {step[2], step[3], step[4], step[5]};
  return out;
}

// Strong priors keep the step so small that it is linear.
TEST(Align, TheStepIsTheMapEstimate) {
  const Waves texture(8, 9, 30, 20);
  for (const int level : {0, 1})
    for (const double noise : {0., 8.}) {
      const AnchorLevel a = anchor(texture, level);
      View view;
      view.state = {{64.12, 63.93}, similarity(20.2, 1.004)};
      view.noise = noise;
      const Pyramid p = pyramid(render(texture, view));
      const AffineState start{{64, 64}, similarity(20)};
      AlignPrior prior;
      prior.shape = .004;
      prior.position = noise > 0 ? cv::Matx22d(60, 20, 20, 40) : cv::Matx22d(600, 200, 200, 400);
      const Alignment found = align(p, no_glare, a, level, start, prior, AlignModel::affine);
      const Linear expected = dense_step(p, a, start, level, prior, found);
      const cv::Vec2d moved = start.shape * expected.shift * -std::ldexp(1., level);
      ASSERT_GT(cv::norm(moved), .02);
      EXPECT_NEAR(found.state.position.x - 64, moved[0], .08 * cv::norm(moved));
      EXPECT_NEAR(found.state.position.y - 64, moved[1], .08 * cv::norm(moved));
      const cv::Matx22d shape = start.shape * (cv::Matx22d::eye() - expected.shear);
      EXPECT_LT(cv::norm(found.state.shape - shape), .1 * cv::norm(expected.shear));
      EXPECT_LT(cv::norm(found.information - expected.information), .1 * cv::norm(expected.information));
    }
}

TEST(Align, ReportsTheQualityOfTheFit) {
  const Waves texture(9, 6, 25, 20);
  const AnchorLevel a = anchor(texture, 0);
  View view;
  view.state.position = {64, 64};
  view.gain = .7, view.bias = 90, view.noise = 6;
  cv::Mat luma = render(texture, view);
  paint(luma, view.state, 20, [](double x, double) { return x > 6.5; });
  const Pyramid p = pyramid(luma);
  AlignPrior fixed;
  fixed.position = cv::Matx22d::eye() * 1e9;
  fixed.shape = 1e-6;
  const Alignment found = align(p, no_glare, a, 0, view.state, fixed, AlignModel::affine);
  ASSERT_TRUE(found.usable);
  // When nothing can move, the state is the start's, from which all results follow.
  const PatchSample s = sample(p, no_glare, view.state, 0);
  double t = 0, i = 0, tt = 0, ii = 0, it = 0;
  std::vector<double> sizes;
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) {
      const double T = a.patch.at(x, y), I = s.value.at(x, y);
      t += T, i += I, tt += T * T, ii += I * I, it += I * T;
      sizes.push_back(std::abs((I - found.bias) / found.gain - T));
    }
  const double n = PatchPlane::pixels;
  EXPECT_NEAR(found.zncc, (it - i * t / n) / std::sqrt((ii - i * i / n) * (tt - t * t / n)), 1e-3);
  std::sort(sizes.begin(), sizes.end());
  EXPECT_NEAR(found.noise, 1.48 * sizes[220], .03 * found.noise);
  double inliers = 0;
  for (const double r : sizes) inliers += 1 / std::pow(1 + std::pow(r / (3 * std::max(found.noise, 2.)), 2), 2);
  EXPECT_NEAR(found.inliers, inliers / n, .01);
  EXPECT_EQ(found.unmasked, 1);
}

TEST(Align, AcceptsAPatchOverThePicturesEdge) {
  const Waves texture(10, 6, 25, 20);
  const AnchorLevel a = anchor(texture, 0);
  for (const auto run : {align, align_scalar}) {
    View view;
    view.state.position = {4.3, 70.6};  // 15 of 21 columns are inside
    const Pyramid p = pyramid(render(texture, view));
    const Alignment most =
        run(p, no_glare, a, 0, {view.state.position + cv::Point2d(.4, -.3)}, {}, AlignModel::affine, fine_precision);
    ASSERT_TRUE(most.usable);
    // The pyramid mirrors the picture's edge, which smooths its last two columns.
    EXPECT_LT(distance(most.state, view.state), .05);
    EXPECT_NEAR(most.unmasked, 15. / 21, 1e-6);
    // 6 of 21 columns: 29 %.
    const Alignment little = run(p, no_glare, a, 0, {{-5, 70}}, {}, AlignModel::affine, fine_precision);
    EXPECT_FALSE(little.usable);
    EXPECT_EQ(little.state.position, cv::Point2d(-5, 70));
    for (const cv::Point2d far : {cv::Point2d(-4000, 64), {1e9, 1e9}, {64, -1e300}}) {
      const Alignment none = run(p, no_glare, a, 0, {far}, {}, AlignModel::affine, fine_precision);
      EXPECT_FALSE(none.usable);
      EXPECT_TRUE(finite(none));
    }
  }
}

TEST(Align, WithoutTextureItIsNotUsable) {
  const Waves texture(3, 6, 25, 20);
  const AnchorLevel a = anchor(texture, 0);
  const Pyramid flat = pyramid(cv::Mat(128, 128, CV_8UC1, 90)), textured = pyramid(render(texture, {}));
  const AnchorLevel blank = make_anchor_level(sample(flat, no_glare, {{64, 64}}, 0));
  const AffineState start{{64, 64}};
  AnchorLevel masked = a;
  masked.weight = {};
  AffineState folded = start, undefined = start;
  folded.shape = {1, 0, 0, -1};
  undefined.position.x = std::nan("");
  for (const auto run : {align, align_scalar})
    for (const AlignModel model : {AlignModel::affine, AlignModel::similarity}) {
      for (const Alignment &r : {run(flat, no_glare, a, 0, start, {}, model, fine_precision),
                                 run(textured, no_glare, blank, 0, start, {}, model, fine_precision),
                                 run(flat, no_glare, blank, 0, start, {}, model, fine_precision),
                                 run(textured, no_glare, masked, 0, start, {}, model, fine_precision),
                                 run(textured, no_glare, a, 0, folded, {}, model, fine_precision)}) {
        EXPECT_FALSE(r.usable);
        EXPECT_TRUE(finite(r));
      }
      EXPECT_FALSE(run(textured, no_glare, a, 0, undefined, {}, model, fine_precision).usable);
    }
}

// Across stripes the position is known. Along them it is not: it stays, and the information says so.
TEST(Align, StripesFixOneDirectionOnly) {
  cv::Mat first(128, 128, CV_8UC1), second = first.clone();
  for (int x = 0; x < 128; ++x) {
    first.col(x).setTo(std::lround(128 + 40 * std::sin(x * .5)));
    second.col(x).setTo(std::lround(128 + 40 * std::sin((x - .6) * .5)));
  }
  const AnchorLevel a = make_anchor_level(sample(pyramid(first), no_glare, {{64, 64}}, 0));
  const Alignment r = align(pyramid(second), no_glare, a, 0, {{64, 64}}, {}, AlignModel::affine);
  ASSERT_TRUE(r.usable);
  EXPECT_NEAR(r.state.position.x, 64.6, .05);
  EXPECT_NEAR(r.state.position.y, 64, .05);
  EXPECT_GT(r.information(0, 0), 100 * std::abs(r.information(1, 1)));
}

// The bound is a hundredth of a sample: of a pixel of the pyramid's level (√2 of it at most) or, where a level is
// magnified, of the picture. The twins differ by rounding (1e-4), except where one takes a step more.
TEST(Align, SimdMatchesItsPlainTwin) {
  const auto targets = hwy::SupportedAndGeneratedTargets();
  ASSERT_FALSE(targets.empty());
  cv::RNG rng(5);
  int compared = 0, usable = 0;
  for (std::uint64_t k = 0; k < 24; ++k) {
    const Waves texture(k + 50, 6, 40, k % 4 ? 20 : 4);
    View view;
    view.noise = k % 2 ? 2 : 0, view.seed = k + 1, view.gain = rng.uniform(.3, 1.2);
    view.state.position = {64 + rng.uniform(-10., 10.), 64 + rng.uniform(-10., 10.)};
    view.state.shape = similarity(rng.uniform(-180., 180.), std::exp(rng.uniform(-.9, 1.1))) *
                       cv::Matx22d(1 + rng.uniform(-.1, .1), rng.uniform(-.1, .1), 0, 1);
    if (k % 5 == 0) view.state.position.x = rng.uniform(2., 8.);  // partly outside
    cv::Mat luma = render(texture, view);
    GlareWeights glare;
    if (k % 3 == 0) {
      paint(luma, view.state, 245, [](double x, double y) { return std::hypot(x - 7, y + 3) < 4; });
      WorkFrame frame;
      frame.load(MovingScene::gray_view(luma));
      glare.build(frame, {});
    }
    const Pyramid p = pyramid(luma);
    for (const int level : {0, 1}) {
      const AnchorLevel a = anchor(texture, level, 2);
      for (int n = 0; n < 25; ++n) {
        AffineState start = view.state;
        const double size = std::ldexp(view.state.scale(), level), off = .7 * size;
        start.position += cv::Point2d(rng.uniform(-off, off), rng.uniform(-off, off));
        start.shape = start.shape * similarity(rng.uniform(-2., 2.), 1 + rng.uniform(-.02, .02));
        AlignPrior prior;
        if (n % 3 == 0) prior.position = cv::Matx22d::eye() * 4;
        const AlignModel model = n % 2 ? AlignModel::affine : AlignModel::similarity;
        const Alignment plain = align_scalar(p, glare, a, level, start, prior, model);
        for (const std::int64_t target : targets) {
          SCOPED_TRACE(hwy::TargetName(target));
          const test::OnTarget scope(target);
          const Alignment simd = align(p, glare, a, level, start, prior, model);
          ++compared;
          usable += simd.usable;
          ASSERT_EQ(simd.usable, plain.usable);
          EXPECT_LT(distance(simd.state, plain.state), .01 * std::max(1., size)) << k << ' ' << level << ' ' << n;
          ASSERT_LT(cv::norm(simd.state.shape - plain.state.shape), .005 * plain.state.scale());
          ASSERT_NEAR(simd.zncc, plain.zncc, .01);
          ASSERT_NEAR(simd.inliers, plain.inliers, .02);
          ASSERT_NEAR(simd.unmasked, plain.unmasked, .01);
          ASSERT_NEAR(simd.noise, plain.noise, .05 * plain.noise + .05);
        }
      }
    }
  }
  EXPECT_GT(compared, 1000 * static_cast<int>(targets.size()));
  EXPECT_GT(usable, compared * 3 / 4);
}

}  // namespace
}  // namespace csd
