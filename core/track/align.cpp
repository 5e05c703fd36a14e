// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/align.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "track/patch_kernels.h"
#include "track/patch_map.h"

namespace csd {

namespace {

constexpr int most_iterations = 8;
constexpr double small_step = .03;    // samples
constexpr double longest_step = 3;    // samples
constexpr double largest_shear = .3;  // of one step
constexpr double least_inside = .3;
constexpr int least_counted = PatchPlane::pixels / 10;
constexpr double least_variance = .01;  // grey levels²; below, there is nothing to see

/// A symmetric system whose unknowns are eliminated in order, the two of the position last.
struct System {
  int n = 0;
  std::array<std::array<double, unknowns>, unknowns> matrix{};  // upper triangle
  std::array<double, unknowns> gradient{}, step{};

  /// Eliminates unknowns `begin` … `end`: what is left in the matrix beyond `end` is information about the others with
  /// these unknown. One that nothing is known of stays as it is.
  void eliminate(int begin, int end) {
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
      auto &row = matrix[k];
      if (!(row[k] > 1e-9)) {
        row.fill(0);
        gradient[k] = 0;
        continue;
      }
      for (std::size_t i = k + 1; i < static_cast<std::size_t>(n); ++i) {
        const double f = row[i] / row[k];
        for (std::size_t j = i; j < static_cast<std::size_t>(n); ++j) matrix[i][j] -= f * row[j];
        gradient[i] -= f * gradient[k];
      }
    }
  }

  void back_substitute() {
    for (auto k = static_cast<std::size_t>(n); k-- > 0;) {
      double s = gradient[k];
      for (std::size_t j = k + 1; j < static_cast<std::size_t>(n); ++j) s -= matrix[k][j] * step[j];
      step[k] = matrix[k][k] > 0 ? s / matrix[k][k] : 0;
    }
  }
};

/// A similarity's step has two unknowns, θ2 = θ5 and θ4 = −θ3.
System reduce(const System &full) {
  static constexpr double basis[6][unknowns] = {{1, 0, 0, 0, 0, 0, 0, 0}, {0, 1, 0, 0, 0, 0, 0, 0},
                                                {0, 0, 1, 0, 0, 1, 0, 0}, {0, 0, 0, -1, 1, 0, 0, 0},
                                                {0, 0, 0, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 0, 0, 0, 1}};
  System s;
  s.n = 6;
  for (std::size_t a = 0; a < 6; ++a)
    for (std::size_t i = 0; i < unknowns; ++i) {
      s.gradient[a] += basis[a][i] * full.gradient[i];
      for (std::size_t b = a; b < 6; ++b)
        for (std::size_t j = 0; j < unknowns; ++j)
          s.matrix[a][b] += basis[a][i] * basis[b][j] * full.matrix[std::min(i, j)][std::max(i, j)];
    }
  return s;
}

struct Step {
  cv::Vec2d shift;    // of the anchor's coordinates v
  cv::Matx22d shear;  // v → v + shear·v + shift
  double size() const {
    // The root mean square of shear·v over the patch is ‖shear‖ · 10.5/√3.
    return std::sqrt(shift.dot(shift) + 36.7 * shear.dot(shear));
  }
};

/// One step towards the maximum of the posterior: data, prior about `start`. Gives the data's information on the
/// position too, gain, bias and shape being unknown (the shape within its prior).
Step solve(const PatchFit &fit, const AffineState &at, const AffineState &start, int level, const AlignPrior &prior,
           AlignModel model, cv::Matx22d &information) {
  System s;
  s.n = unknowns;
  // Blurred noise is correlated: 3σ, not σ.
  const double sigma = 3 * std::max(fit.noise, 1.), precision = 1 / (sigma * sigma);
  for (std::size_t i = 0; i < unknowns; ++i) {
    s.gradient[i] = fit.gradient[i] * precision;
    for (std::size_t j = i; j < unknowns; ++j) s.matrix[i][j] = fit.matrix[i][j] * precision;
  }
  // E = shape₀⁻¹·shape becomes E·(1 + D)⁻¹ ≈ E − E·D: the prior wants E·D = E − 1. D is in tenths, as x = v/10.
  const cv::Matx22d E = start.shape.inv() * at.shape, EtE = E.t() * E, Ete = E.t() * (E - cv::Matx22d::eye());
  const double belief = 1 / (prior.shape * prior.shape);
  for (int column = 0; column < 2; ++column)
    for (int row = 0; row < 2; ++row) {
      const std::size_t a = first_shape + static_cast<std::size_t>(2 * row + column);
      s.gradient[a] += belief * Ete(row, column) / 10;
      for (int other = row; other < 2; ++other)
        s.matrix[a][first_shape + static_cast<std::size_t>(2 * other + column)] += belief * EtE(row, other) / 100;
    }
  if (model == AlignModel::similarity) s = reduce(s);
  const int position = s.n - 2;
  s.eliminate(0, position);

  const auto p = static_cast<std::size_t>(position);
  const cv::Matx22d B = at.shape * std::ldexp(1., level), back = B.inv();
  const cv::Matx22d data{s.matrix[p][p], s.matrix[p][p + 1], s.matrix[p][p + 1], s.matrix[p + 1][p + 1]};
  information = back.t() * data * back;
  const cv::Matx22d about = B.t() * prior.position * B;
  const cv::Point2d off = at.position - start.position;
  const cv::Vec2d pull = B.t() * prior.position * cv::Vec2d(off.x, off.y);
  s.matrix[p][p] += about(0, 0), s.matrix[p][p + 1] += about(0, 1), s.matrix[p + 1][p + 1] += about(1, 1);
  s.gradient[p] += pull[0], s.gradient[p + 1] += pull[1];
  s.eliminate(position, s.n);
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
  const double scale = state.scale();
  return std::isfinite(state.position.x) && std::isfinite(state.position.y) && scale > 1e-2 && scale < 1e2;
}

/// The kernels of one twin.
struct Simd {
  PatchTile tile;
  double sample(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchPlane &value,
                PatchPlane &weight, bool &plain) {
    plain = false;
    if (!prepare_tile(level, weights, map, tile)) return scalar::sample_patch(level, weights, map, value, weight);
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
    return scalar::sample_patch(level, weights, map, value, weight);
  }
  static constexpr auto fit = scalar::fit_patch;
  static constexpr auto moments = scalar::patch_moments;
};

template <class Twin>
Alignment align_with(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                     const AffineState &start, const AlignPrior &prior, AlignModel model) {
  Alignment out;
  out.state = start;
  if (!sane(start)) return out;
  const int frame_level = matching_level(start, level);
  Twin twin;
  PatchPlane value, weight, robust;
  robust.data.fill(1);
  const PatchPlane *m = &weight;
  PatchFit fit;
  AffineState state = start;
  for (;;) {
    bool plain = false;
    const double inside = twin.sample(pyramid.level(frame_level), weights.level(frame_level),
                                      patch_map(state, level, frame_level), value, weight, plain);
    m = plain ? &anchor.weight : &weight;
    if (!plain) multiply(anchor.weight, weight, weight);
    Twin::fit(anchor, value, *m, robust, fit);
    out.unmasked = fit.weight / PatchPlane::pixels;
    if (inside < least_inside || fit.counted < least_counted) return out;
    const Step step = solve(fit, state, start, level, prior, model, out.information);
    apply(step, level, state);
    ++out.iterations;
    if (!sane(state)) return out;
    if (step.size() < small_step || out.iterations == most_iterations) break;
  }
  // Of the last residuals, which the last step made a little smaller: sampling once more would tell nothing new.
  const PatchMoments moments = Twin::moments(anchor, value, *m);
  out.gain = fit.gain, out.bias = fit.bias, out.noise = fit.noise;
  out.inliers = fit.inliers / fit.weight;
  if (moments.anchor_variance < least_variance || moments.frame_variance < least_variance) return out;
  out.zncc = moments.covariance / std::sqrt(moments.frame_variance * moments.anchor_variance);
  out.state = state;
  out.usable = true;
  return out;
}

}  // namespace

Alignment align(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                const AffineState &start, const AlignPrior &prior, AlignModel model) {
  return align_with<Simd>(pyramid, weights, anchor, level, start, prior, model);
}

Alignment align_scalar(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                       const AffineState &start, const AlignPrior &prior, AlignModel model) {
  return align_with<Scalar>(pyramid, weights, anchor, level, start, prior, model);
}

}  // namespace csd
