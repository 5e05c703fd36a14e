// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/patch_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "patch/patch_fit.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "patch/median-inl.h"

HWY_BEFORE_NAMESPACE();
namespace csd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR  // below SSSE3

void FitPatch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
              PatchFit &fit) {
  fit_patch_scalar(anchor, value, weight, robust, fit);
}

PatchMoments Moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight) {
  return patch_moments_scalar(anchor, value, weight);
}

#else

using patch_lanes::period;
using Floats = hn::CappedTag<float, 16>;
using V = hn::Vec<Floats>;

HWY_INLINE double Sum(Floats d, V v) {
  return hn::GetLane(hn::SumOfLanes(d, v));
}

#if HWY_HAVE_SCALABLE
template <class D>
HWY_INLINE void Sums(D d, V a, V b, V c, V e, float *out) {
  out[0] = hn::GetLane(hn::SumOfLanes(d, a)), out[1] = hn::GetLane(hn::SumOfLanes(d, b));
  out[2] = hn::GetLane(hn::SumOfLanes(d, c)), out[3] = hn::GetLane(hn::SumOfLanes(d, e));
}
#else
// Sums blocks of four lanes.
template <class D>
HWY_INLINE hn::Vec<hn::CappedTag<float, 4>> AddBlocks(D, hn::Vec<D> v) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return v;
  } else {
    const hn::Half<D> half;
    return AddBlocks(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

// Four sums at once, at a third of the cost of four separate ones.
HWY_INLINE void Sums(Floats d, V a, V b, V c, V e, float *out) {
  const hn::Repartition<double, Floats> d64;
  const V ab = hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));  // a b a b
  const V ce = hn::Add(hn::InterleaveLower(d, c, e), hn::InterleaveUpper(d, c, e));
  const auto ab64 = hn::BitCast(d64, ab), ce64 = hn::BitCast(d64, ce);
  const V lower = hn::BitCast(d, hn::InterleaveLower(d64, ab64, ce64));  // a b c e
  const V upper = hn::BitCast(d, hn::InterleaveUpper(d64, ab64, ce64));
  hn::StoreU(AddBlocks(d, hn::Add(lower, upper)), hn::CappedTag<float, 4>(), out);
}
#endif

// Σ w J Jᵀ from sums of products of the gradients and T with 1, y and y². The factor x is constant within a column of
// vectors and applied at its end.
void Matrix(const AnchorLevel &anchor, const PatchPlane &weight, const PatchPlane &robust, PatchFit &fit) {
  const Floats d;
  const V zero = hn::Zero(d);
  const float *T = anchor.patch.data.data(), *Tx = anchor.gradient_x.data.data(), *Ty = anchor.gradient_y.data.data();
  const float *m = weight.data.data(), *rho = robust.data.data();
  struct Moments6 {
    V one, x, y, xx, xy, yy;
  } A{zero, zero, zero, zero, zero, zero}, B = A, C = A;
  struct Moments3 {
    V one, x, y;
  } D{zero, zero, zero}, E = D, F = D, G = D;
  V tt = zero, t = zero, w1 = zero;
  const V row = hn::Set(d, .2F);
  for (std::size_t j = 0; j < period; j += hn::Lanes(d)) {
    const V x = hn::Mul(hn::Set(d, .1F), hn::Load(d, patch_lanes::x + j));
    const V first_y = hn::Mul(hn::Set(d, .1F), hn::Load(d, patch_lanes::y + j));
    {
      V a0 = zero, a1 = zero, a2 = zero, b0 = zero, b1 = zero, b2 = zero, c0 = zero, c1 = zero, c2 = zero;
      V y = first_y;
      for (std::size_t i = j; i < PatchPlane::size; i += period) {
        const V w = hn::Mul(hn::Load(d, m + i), hn::Load(d, rho + i));
        const V tx = hn::Load(d, Tx + i), ty = hn::Load(d, Ty + i);
        const V p = hn::Mul(w, tx), q = hn::Mul(w, ty);
        const V yp = hn::Mul(y, p), yq = hn::Mul(y, q);
        const V ytx = hn::Mul(y, tx), yty = hn::Mul(y, ty);
        a0 = hn::MulAdd(p, tx, a0), a1 = hn::MulAdd(yp, tx, a1), a2 = hn::MulAdd(yp, ytx, a2);
        b0 = hn::MulAdd(p, ty, b0), b1 = hn::MulAdd(yp, ty, b1), b2 = hn::MulAdd(yp, yty, b2);
        c0 = hn::MulAdd(q, ty, c0), c1 = hn::MulAdd(yq, ty, c1), c2 = hn::MulAdd(yq, yty, c2);
        y = hn::Add(y, row);
      }
      const auto add = [&](Moments6 &s, V s0, V s1, V s2) {
        s.one = hn::Add(s.one, s0), s.y = hn::Add(s.y, s1), s.yy = hn::Add(s.yy, s2);
        s.x = hn::MulAdd(x, s0, s.x), s.xy = hn::MulAdd(x, s1, s.xy), s.xx = hn::MulAdd(hn::Mul(x, x), s0, s.xx);
      };
      add(A, a0, a1, a2), add(B, b0, b1, b2), add(C, c0, c1, c2);
    }
    V d0 = zero, d1 = zero, e0 = zero, e1 = zero, f0 = zero, f1 = zero, g0 = zero, g1 = zero;
    V y = first_y;
    for (std::size_t i = j; i < PatchPlane::size; i += period) {
      const V w = hn::Mul(hn::Load(d, m + i), hn::Load(d, rho + i));
      const V vt = hn::Load(d, T + i), p = hn::Mul(w, hn::Load(d, Tx + i)), q = hn::Mul(w, hn::Load(d, Ty + i));
      const V yp = hn::Mul(y, p), yq = hn::Mul(y, q), wt = hn::Mul(w, vt);
      d0 = hn::MulAdd(p, vt, d0), d1 = hn::MulAdd(yp, vt, d1), e0 = hn::MulAdd(q, vt, e0), e1 = hn::MulAdd(yq, vt, e1);
      f0 = hn::Add(f0, p), f1 = hn::Add(f1, yp), g0 = hn::Add(g0, q), g1 = hn::Add(g1, yq);
      tt = hn::MulAdd(wt, vt, tt), t = hn::Add(t, wt), w1 = hn::Add(w1, w);
      y = hn::Add(y, row);
    }
    const auto add = [&](Moments3 &s, V s0, V s1) {
      s.one = hn::Add(s.one, s0), s.y = hn::Add(s.y, s1), s.x = hn::MulAdd(x, s0, s.x);
    };
    add(D, d0, d1), add(E, e0, e1), add(F, f0, f1), add(G, g0, g1);
  }
  alignas(16) float a6[8], b6[8], c6[8], d3[4], e3[4], f3[4], g3[4];
  Sums(d, A.one, A.x, A.y, A.xx, a6), Sums(d, A.xy, A.yy, tt, t, a6 + 4);
  Sums(d, B.one, B.x, B.y, B.xx, b6), Sums(d, B.xy, B.yy, w1, zero, b6 + 4);
  Sums(d, C.one, C.x, C.y, C.xx, c6), Sums(d, C.xy, C.yy, zero, zero, c6 + 4);
  Sums(d, D.one, D.x, D.y, zero, d3), Sums(d, E.one, E.x, E.y, zero, e3);
  Sums(d, F.one, F.x, F.y, zero, f3), Sums(d, G.one, G.x, G.y, zero, g3);
  auto &H = fit.matrix;
  H[0][0] = a6[6], H[0][1] = a6[7], H[1][1] = b6[6];
  H[0][2] = d3[1], H[0][3] = d3[2], H[0][4] = e3[1], H[0][5] = e3[2], H[0][6] = d3[0], H[0][7] = e3[0];
  H[1][2] = f3[1], H[1][3] = f3[2], H[1][4] = g3[1], H[1][5] = g3[2], H[1][6] = f3[0], H[1][7] = g3[0];
  H[2][2] = a6[3], H[2][3] = a6[4], H[3][3] = a6[5];
  H[2][4] = b6[3], H[2][5] = H[3][4] = b6[4], H[3][5] = b6[5];
  H[4][4] = c6[3], H[4][5] = c6[4], H[5][5] = c6[5];
  H[2][6] = a6[1], H[3][6] = a6[2], H[6][6] = a6[0];
  H[2][7] = H[4][6] = b6[1], H[3][7] = H[5][6] = b6[2], H[6][7] = b6[0];
  H[4][7] = c6[1], H[5][7] = c6[2], H[7][7] = c6[0];
}

void FitPatch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
              PatchFit &fit) {
  const Floats d;
  const V zero = hn::Zero(d);
  const std::size_t lanes = hn::Lanes(d);
  const float *T = anchor.patch.data.data(), *Tx = anchor.gradient_x.data.data(), *Ty = anchor.gradient_y.data.data();
  const float *I = value.data.data(), *m = weight.data.data();
  float *rho = robust.data.data();

  V v1 = zero, vT = zero, vTT = zero, vI = zero, vIT = zero;
  for (std::size_t i = 0; i < PatchPlane::size; i += lanes) {
    const V w = hn::Mul(hn::Load(d, m + i), hn::Load(d, rho + i)), t = hn::Load(d, T + i), v = hn::Load(d, I + i);
    const V wt = hn::Mul(w, t);
    v1 = hn::Add(v1, w), vT = hn::Add(vT, wt), vTT = hn::MulAdd(wt, t, vTT);
    vI = hn::MulAdd(w, v, vI), vIT = hn::MulAdd(wt, v, vIT);
  }
  alignas(16) float sums[4];
  Sums(d, v1, vT, vTT, vI, sums);
  const double s1 = sums[0], sT = sums[1], sTT = sums[2], sI = sums[3], sIT = Sum(d, vIT);
  const double spread = s1 * sTT - sT * sT;
  fit.gain = std::max<double>(spread > 0 ? (s1 * sIT - sI * sT) / spread : 0, smallest_gain);
  fit.bias = s1 > 0 ? (sI - fit.gain * sT) / s1 : 0;

  // r, and |r| in 1/128 of a grey level for the median.
  alignas(64) float r[PatchPlane::size];
  alignas(64) std::int16_t sizes[kQuantised];
  std::fill(sizes + PatchPlane::size, sizes + kQuantised, std::int16_t{32767});
  const hn::RebindToSigned<Floats> di;
  const hn::Rebind<std::int16_t, Floats> d16;
  const V slope = hn::Set(d, static_cast<float>(1 / fit.gain)),
          offset = hn::Set(d, static_cast<float>(-fit.bias / fit.gain));
  const V unit = hn::Set(d, 128.F), most = hn::Set(d, 128 * largest_residual), counts = hn::Set(d, counted_weight);
  V total = zero, weights = zero;
  std::size_t counted = 0;
  for (std::size_t i = 0; i < PatchPlane::size; i += lanes) {
    const V w = hn::Load(d, m + i), v = hn::Sub(hn::MulAdd(slope, hn::Load(d, I + i), offset), hn::Load(d, T + i));
    hn::Store(v, d, r + i);
    const V size = hn::Min(hn::Mul(unit, hn::Abs(v)), most);
    const auto is_counted = hn::Gt(w, counts);
    counted += hn::CountTrue(d, is_counted);
    total = hn::Add(total, hn::IfThenElseZero(is_counted, size));
    weights = hn::Add(weights, w);
    hn::Store(hn::DemoteTo(d16, hn::ConvertTo(di, hn::IfThenElse(is_counted, size, most))), d16, sizes + i);
  }
  fit.counted = static_cast<int>(counted);
  fit.weight = Sum(d, weights);
  // The median is at most twice the mean.
  fit.noise = counted == 0 ? 0
                           : 1.48 / 128 *
                                 Median(sizes, fit.counted,
                                        static_cast<int>(std::min(2 * Sum(d, total) / fit.counted + 1, 32766.)));

  const V per_c = hn::Set(d, static_cast<float>(1 / (3 * std::max(fit.noise, 2.)))), one = hn::Set(d, 1.F),
          two = hn::Set(d, 2.F);
  V gT = zero, g1 = zero, g2 = zero, g3 = zero, g4 = zero, g5 = zero, g6 = zero, g7 = zero;
  V inliers = zero, change = zero;
  const V row = hn::Set(d, .2F);
  for (std::size_t j = 0; j < period; j += lanes) {
    const V x = hn::Mul(hn::Set(d, .1F), hn::Load(d, patch_lanes::x + j));
    V y = hn::Mul(hn::Set(d, .1F), hn::Load(d, patch_lanes::y + j));
    V p0 = zero, p1 = zero, q0 = zero, q1 = zero;
    for (std::size_t i = j; i < PatchPlane::size; i += period) {
      const V v = hn::Load(d, r + i), w = hn::Load(d, m + i), u = hn::Mul(v, per_c);
      const V q = hn::MulAdd(u, u, one);
      V inverse = hn::ApproximateReciprocal(q);
      inverse = hn::Mul(inverse, hn::NegMulAdd(inverse, q, two));  // a Newton step gives full precision on any machine
      const V robust_now = hn::Mul(inverse, inverse), wr = hn::Mul(w, robust_now);
      change = hn::MulAdd(w, hn::AbsDiff(robust_now, hn::Load(d, rho + i)), change);
      hn::Store(robust_now, d, rho + i);
      inliers = hn::Add(inliers, wr);
      const V e = hn::Mul(wr, v), p = hn::Mul(e, hn::Load(d, Tx + i)), s = hn::Mul(e, hn::Load(d, Ty + i));
      gT = hn::MulAdd(e, hn::Load(d, T + i), gT), g1 = hn::Add(g1, e);
      p0 = hn::Add(p0, p), q0 = hn::Add(q0, s);
      p1 = hn::MulAdd(y, p, p1), q1 = hn::MulAdd(y, s, q1);
      y = hn::Add(y, row);
    }
    g2 = hn::MulAdd(x, p0, g2), g3 = hn::Add(g3, p1), g4 = hn::MulAdd(x, q0, g4), g5 = hn::Add(g5, q1);
    g6 = hn::Add(g6, p0), g7 = hn::Add(g7, q0);
  }
  alignas(16) float g[8];
  Sums(d, gT, g1, g2, g3, g), Sums(d, g4, g5, g6, g7, g + 4);
  std::copy_n(g, unknowns, fit.gradient.begin());
  fit.inliers = Sum(d, inliers);
  if (fit.drift >= 0) fit.drift += Sum(d, change);
  if (fit.drift >= 0 && fit.drift < largest_drift * fit.inliers) return;
  fit.drift = 0;
  Matrix(anchor, weight, robust, fit);
}

PatchMoments Moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight) {
  const Floats d;
  const float *T = anchor.patch.data.data(), *I = value.data.data(), *m = weight.data.data();
  V v1 = hn::Zero(d), vT = v1, vTT = v1, vI = v1, vII = v1, vIT = v1;
  // Grey levels relative to the centre pixel's, to keep precision at faint contrast.
  const V middle = hn::Set(d, value.at(0, 0));
  for (std::size_t i = 0; i < PatchPlane::size; i += hn::Lanes(d)) {
    const V w = hn::Load(d, m + i), t = hn::Load(d, T + i), v = hn::Sub(hn::Load(d, I + i), middle);
    const V wt = hn::Mul(w, t), wv = hn::Mul(w, v);
    v1 = hn::Add(v1, w), vT = hn::Add(vT, wt), vTT = hn::MulAdd(wt, t, vTT);
    vI = hn::Add(vI, wv), vII = hn::MulAdd(wv, v, vII), vIT = hn::MulAdd(wt, v, vIT);
  }
  PatchMoments out;
  const double s1 = out.weight = Sum(d, v1);
  if (s1 > 0) {
    const double meanT = Sum(d, vT) / s1, meanI = Sum(d, vI) / s1;
    out.frame_variance = std::max(Sum(d, vII) / s1 - meanI * meanI, 0.);
    out.anchor_variance = std::max(Sum(d, vTT) / s1 - meanT * meanT, 0.);
    out.covariance = Sum(d, vIT) / s1 - meanI * meanT;
  }
  return out;
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace csd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd {

HWY_EXPORT(FitPatch);
HWY_EXPORT(Moments);

double correlation(const PatchMoments &all, const PatchMoments &of_tissue) {
  constexpr double least = min_tissue * PatchPlane::pixels, deviation = 3;
  const auto zncc = [](const PatchMoments &m) {
    const double scale = m.frame_variance * m.anchor_variance;
    return scale > 0 ? m.covariance / std::sqrt(scale) : 0;
  };
  const bool textured = of_tissue.weight >= least && of_tissue.anchor_variance >= deviation * deviation;
  return textured ? std::min(zncc(all), zncc(of_tissue)) : zncc(all);
}

void fit_patch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
               PatchFit &fit) {
  HWY_DYNAMIC_DISPATCH(FitPatch)(anchor, value, weight, robust, fit);
}

PatchMoments patch_moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight) {
  return HWY_DYNAMIC_DISPATCH(Moments)(anchor, value, weight);
}

void fit_patch_scalar(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
                      PatchFit &fit) {
  const auto &T = anchor.patch.data, &I = value.data, &m = weight.data;
  double s1 = 0, sT = 0, sTT = 0, sI = 0, sIT = 0;
  PatchPlane::for_each_sample([&](int, int, std::size_t i) {
    const double w = m[i] * robust.data[i], t = T[i], v = I[i];
    s1 += w, sT += w * t, sTT += w * t * t, sI += w * v, sIT += w * v * t;
  });
  const double spread = s1 * sTT - sT * sT;
  fit.gain = std::max<double>(spread > 0 ? (s1 * sIT - sI * sT) / spread : 0, smallest_gain);
  fit.bias = s1 > 0 ? (sI - fit.gain * sT) / s1 : 0;

  PatchPlane r;
  std::vector<float> sizes;
  PatchPlane::for_each_sample([&](int, int, std::size_t i) {
    r.data[i] = static_cast<float>((I[i] - fit.bias) / fit.gain - T[i]);
    if (m[i] > counted_weight) sizes.push_back(std::min(std::abs(r.data[i]), largest_residual));
  });
  fit.counted = static_cast<int>(sizes.size());
  fit.noise = 0;
  if (!sizes.empty()) {
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    fit.noise = 1.48 * *middle;
  }

  const double c = 3 * std::max(fit.noise, 2.);
  fit.weight = fit.inliers = 0;
  fit.gradient.fill(0);
  double change = 0;
  const auto jacobian = [&](int vx, int vy, std::size_t i) {
    const double x = vx / 10., y = vy / 10., tx = anchor.gradient_x.data[i], ty = anchor.gradient_y.data[i];
    return std::array<double, unknowns>{T[i], 1, x * tx, y * tx, x * ty, y * ty, tx, ty};
  };
  PatchPlane::for_each_sample([&](int vx, int vy, std::size_t i) {
    const double q = 1 + (r.data[i] / c) * (r.data[i] / c), w = m[i] / (q * q);
    change += std::abs(w - double{m[i]} * robust.data[i]);
    robust.data[i] = static_cast<float>(1 / (q * q));
    fit.weight += m[i];
    fit.inliers += w;
    const auto J = jacobian(vx, vy, i);
    for (std::size_t a = 0; a < unknowns; ++a) fit.gradient[a] += w * J[a] * r.data[i];
  });
  if (fit.drift >= 0) fit.drift += change;
  if (fit.drift >= 0 && fit.drift < largest_drift * fit.inliers) return;
  fit.drift = 0;
  fit.matrix = {};
  PatchPlane::for_each_sample([&](int vx, int vy, std::size_t i) {
    const auto J = jacobian(vx, vy, i);
    for (std::size_t a = 0; a < unknowns; ++a)
      for (std::size_t b = a; b < unknowns; ++b) fit.matrix[a][b] += double{m[i]} * robust.data[i] * J[a] * J[b];
  });
}

PatchMoments patch_moments_scalar(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight) {
  double s1 = 0, sT = 0, sTT = 0, sI = 0, sII = 0, sIT = 0;
  PatchPlane::for_each_sample([&](int, int, std::size_t i) {
    const double w = weight.data[i], t = anchor.patch.data[i], v = value.data[i];
    s1 += w, sT += w * t, sTT += w * t * t, sI += w * v, sII += w * v * v, sIT += w * v * t;
  });
  PatchMoments out;
  out.weight = s1;
  if (s1 > 0) {
    out.frame_variance = std::max(sII / s1 - (sI / s1) * (sI / s1), 0.);
    out.anchor_variance = std::max(sTT / s1 - (sT / s1) * (sT / s1), 0.);
    out.covariance = sIT / s1 - (sI / s1) * (sT / s1);
  }
  return out;
}

}  // namespace csd
#endif  // HWY_ONCE
