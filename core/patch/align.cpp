// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/align.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "patch/centre.h"
#include "patch/patch_fit.h"
#include "patch/patch_map.h"
#include "patch/patch_tile.h"

namespace csd {

namespace {

constexpr int max_iterations = 8;
constexpr double longest_step = 3;    // samples
constexpr double largest_shear = .3;  // largest element of one step's shear
constexpr double min_inside = .3;
constexpr int min_counted = PatchPlane::pixels / 10;
constexpr double min_variance = .01;  // grey levels²; below, there is no texture

/// A symmetric linear system. Unknowns are eliminated in order, the two of the position last.
struct System {
  std::size_t n = unknowns;
  std::array<std::array<double, unknowns>, unknowns> matrix;  // upper triangle
  std::array<double, unknowns> gradient, per_pivot, step;

  /// Eliminates unknowns `begin` … `end`. The rest of the matrix is then the information about the others, marginalised
  /// over them. An unknown without information is skipped.
  void eliminate(std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      auto &row = matrix[k];
      per_pivot[k] = row[k] > 1e-9 ? 1 / row[k] : 0;
      for (std::size_t i = k + 1; i < n; ++i) {
        const double f = row[i] * per_pivot[k];
        for (std::size_t j = i; j < n; ++j) matrix[i][j] -= f * row[j];
        gradient[i] -= f * gradient[k];
      }
    }
  }

  void back_substitute() {
    for (std::size_t k = n; k-- > 0;) {
      double s = gradient[k];
      for (std::size_t j = k + 1; j < n; ++j) s -= matrix[k][j] * step[j];
      step[k] = s * per_pivot[k];
    }
  }
};

/// Reduces to a similarity, whose shape has two unknowns instead of four: θ2 = θ5 and θ4 = −θ3.
void reduce(System &s) {
  auto &H = s.matrix;
  auto &g = s.gradient;
  for (const std::size_t i : {0, 1}) {
    H[i][2] += H[i][5];
    H[i][3] = H[i][4] - H[i][3];
    H[i][4] = H[i][6], H[i][5] = H[i][7];
  }
  const double turn = H[3][3] + H[4][4] - 2 * H[3][4], both = H[2][4] + H[4][5] - H[2][3] - H[3][5];
  H[2][2] += H[5][5] + 2 * H[2][5], H[2][3] = both;
  H[2][4] = H[2][6] + H[5][6], H[2][5] = H[2][7] + H[5][7];
  H[3][3] = turn, H[3][4] = H[4][6] - H[3][6], H[3][5] = H[4][7] - H[3][7];
  H[4][4] = H[6][6], H[4][5] = H[6][7], H[5][5] = H[7][7];
  g[2] += g[5], g[3] = g[4] - g[3], g[4] = g[6], g[5] = g[7];
  s.n = unknowns - 2;
}

struct Step {
  cv::Vec2d shift;    // of the anchor's coordinates v
  cv::Matx22d shear;  // v → v + shear·v + shift
  double size() const {
    // The root mean square of shear·v over the patch is ‖shear‖ · 10.5/√3.
    return std::sqrt(shift.dot(shift) + 36.7 * shear.dot(shear));
  }
};

/// One Gauss–Newton step to the maximum of the posterior of the data and the prior about `start`. Also computes the
/// data's information about the position, marginalised over gain, bias and shape (the shape with its prior).
Step solve(const PatchFit &fit, const AffineState &at, const AffineState &start, int level, const AlignPrior &prior,
           AlignModel model, cv::Matx22d &information) {
  System s;
  // Smoothed noise is correlated: 3σ instead of σ.
  const double sigma = 3 * std::max(fit.noise, 1.), precision = 1 / (sigma * sigma);
  for (std::size_t i = 0; i < unknowns; ++i) {
    s.gradient[i] = fit.gradient[i] * precision;
    for (std::size_t j = i; j < unknowns; ++j) s.matrix[i][j] = fit.matrix[i][j] * precision;
  }
  // E = shape₀⁻¹·shape becomes E·(1 + D)⁻¹ ≈ E − E·D: the prior pulls to E·D = E − 1. D is in tenths, as x = v/10.
  const cv::Matx22d E = start.shape.inv() * at.shape, EtE = E.t() * E, Ete = E.t() * (E - cv::Matx22d::eye());
  const double belief = 1 / (prior.shape * prior.shape);
  for (int column = 0; column < 2; ++column)
    for (int row = 0; row < 2; ++row) {
      const std::size_t a = first_shape + static_cast<std::size_t>(2 * row + column);
      s.gradient[a] += belief * Ete(row, column) / 10;
      for (int other = row; other < 2; ++other)
        s.matrix[a][first_shape + static_cast<std::size_t>(2 * other + column)] += belief * EtE(row, other) / 100;
    }
  if (model == AlignModel::similarity) reduce(s);
  const std::size_t p = s.n - 2;
  s.eliminate(0, p);

  const cv::Matx22d B = at.shape * std::ldexp(1., level), back = B.inv();
  const cv::Matx22d data{s.matrix[p][p], s.matrix[p][p + 1], s.matrix[p][p + 1], s.matrix[p + 1][p + 1]};
  information = back.t() * data * back;
  const cv::Matx22d about = B.t() * prior.position * B;
  const cv::Point2d off = at.position - start.position;
  const cv::Vec2d pull = B.t() * prior.position * cv::Vec2d(off.x, off.y);
  s.matrix[p][p] += about(0, 0), s.matrix[p][p + 1] += about(0, 1), s.matrix[p + 1][p + 1] += about(1, 1);
  s.gradient[p] += pull[0], s.gradient[p + 1] += pull[1];
  s.eliminate(p, s.n);
  s.back_substitute();

  Step step;
  step.shift = {s.step[p], s.step[p + 1]};
  step.shear = model == AlignModel::similarity ? cv::Matx22d(s.step[2], -s.step[3], s.step[3], s.step[2])
                                               : cv::Matx22d(s.step[2], s.step[3], s.step[4], s.step[5]);
  step.shear *= .1;
  double shrink = std::min(1., longest_step / std::max(cv::norm(step.shift), 1e-12));
  for (const double d : step.shear.val) shrink = std::min(shrink, largest_shear / std::max(std::abs(d), 1e-12));
  step.shift *= shrink, step.shear *= shrink;
  return step;
}

void apply(const Step &step, int level, AffineState &state) {
  state.shape = state.shape * (cv::Matx22d::eye() + step.shear).inv();
  const cv::Vec2d moved = state.shape * step.shift * std::ldexp(1., level);
  state.position -= cv::Point2d(moved[0], moved[1]);
}

bool sane(const AffineState &state) {
  constexpr double far = 1e6;  // beyond any picture
  const double scale = state.scale();
  return std::abs(state.position.x) < far && std::abs(state.position.y) < far && scale > 1e-2 && scale < 1e2;
}

/// Sum of the remaining steps if they keep shrinking at the same rate.
double remaining(double size, double previous) {
  const double rate = previous > 0 ? std::clamp(size / previous, .2, .9) : .3;
  return size * rate / (1 - rate);
}

/// The kernels, with and without SIMD.
struct Simd {
  PatchTile tile;
  double sample(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchPlane &value,
                PatchPlane &weight, bool &plain) {
    plain = false;
    if (!prepare_tile(level, weights, map, tile)) return sample_scalar(level, weights, map, value, weight);
    plain = tile.plain;
    return sample_tile(tile, map, value, weight);
  }
  static constexpr auto fit = fit_patch;
  static constexpr auto moments = patch_moments;
};
struct Scalar {
  double sample(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchPlane &value,
                PatchPlane &weight, bool &plain) {
    plain = false;
    return sample_scalar(level, weights, map, value, weight);
  }
  static constexpr auto fit = fit_patch_scalar;
  static constexpr auto moments = patch_moments_scalar;
};

template <class Twin>
Alignment align_with(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                     const AffineState &start, const AlignPrior &prior, AlignModel model, double precision) {
  Alignment out;
  out.state = start;
  if (!sane(start)) return out;
  const int frame_level = matching_level(start, level);
  Twin twin;
  PatchPlane value, weight, tissue, robust;
  robust.data.fill(1);
  const PatchPlane *m = &weight;
  PatchFit fit;
  AffineState state = start;
  double previous = 0;
  for (;;) {
    bool plain = false;
    const double inside = twin.sample(pyramid.level(frame_level), weights.level(frame_level),
                                      patch_map(state, level, frame_level), value, weight, plain);
    m = plain ? &anchor.weight : &weight;
    if (!plain) weigh_agreement(anchor, weight, tissue);
    Twin::fit(anchor, value, *m, robust, fit);
    out.unmasked = fit.weight / PatchPlane::pixels;
    if (inside < min_inside || fit.counted < min_counted) return out;
    const Step step = solve(fit, state, start, level, prior, model, out.information);
    apply(step, level, state);
    ++out.iterations;
    if (!sane(state)) return out;
    if (remaining(step.size(), previous) < precision || out.iterations == max_iterations) break;
    previous = step.size();
  }
  // Of the last residuals: the last step changes them little, so the patch is not sampled again.
  const PatchMoments moments = Twin::moments(anchor, value, *m);
  const PatchMoments of_tissue = m == &weight ? Twin::moments(anchor, value, tissue) : moments;
  out.gain = fit.gain, out.bias = fit.bias, out.noise = fit.noise;
  out.inliers = fit.inliers / fit.weight;
  out.centre = centre_inliers(anchor, value, *m, fit.gain, fit.bias, prior.noise / fit.gain).value_or(out.inliers);
  if (moments.anchor_variance < min_variance || moments.frame_variance < min_variance) return out;
  out.zncc = correlation(moments, of_tissue);
  out.state = state;
  out.usable = true;
  return out;
}

}  // namespace

Alignment align(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                const AffineState &start, const AlignPrior &prior, AlignModel model, double precision) {
  return align_with<Simd>(pyramid, weights, anchor, level, start, prior, model, precision);
}

Alignment align_scalar(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                       const AffineState &start, const AlignPrior &prior, AlignModel model, double precision) {
  return align_with<Scalar>(pyramid, weights, anchor, level, start, prior, model, precision);
}

}  // namespace csd
