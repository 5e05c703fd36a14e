// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/patch_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "track/patch_kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "track/patch_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace csd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR  // a machine with less than SSSE3

void Interleave(const std::uint16_t *a, const std::uint16_t *b, std::size_t n, std::uint32_t *out) {
  for (std::size_t i = 0; i < n; ++i) out[i] = a[i] | static_cast<std::uint32_t>(b[i]) << 16;
}

void SampleTile(const std::uint32_t *tile, const float *map, float scale, float *out) {
  for (std::size_t i = 0; i < PatchPlane::size; ++i) {
    const auto k = static_cast<float>(i / patch_lanes::period);
    const float vx = patch_lanes::x[i % patch_lanes::period], vy = patch_lanes::y[i % patch_lanes::period] + 2 * k;
    const float x = map[0] + map[2] * vx + map[3] * vy, y = map[1] + map[4] * vx + map[5] * vy;
    const auto ix = static_cast<int>(x), iy = static_cast<int>(y);
    const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
    const std::uint32_t *p = tile + iy * PatchTile::side + ix;
    const auto column = [&](std::uint32_t word) {
      const auto above = static_cast<float>(word & 0xffff), below = static_cast<float>(word >> 16);
      return above + fy * (below - above);
    };
    out[i] = scale * (column(p[0]) + fx * (column(p[1]) - column(p[0])));
  }
}

void FitPatch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
              PatchFit &fit) {
  scalar::fit_patch(anchor, value, weight, robust, fit);
}

PatchMoments Moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight) {
  return scalar::patch_moments(anchor, value, weight);
}

#else

using patch_lanes::period;
using Floats = hn::CappedTag<float, 16>;
using V = hn::Vec<Floats>;

// n a multiple of 16.
void Interleave(const std::uint16_t *HWY_RESTRICT a, const std::uint16_t *HWY_RESTRICT b, std::size_t n,
                std::uint32_t *HWY_RESTRICT out) {
  const hn::CappedTag<std::uint32_t, 16> d;
  const hn::Rebind<std::uint16_t, decltype(d)> d16;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const auto above = hn::PromoteTo(d, hn::LoadU(d16, a + i)), below = hn::PromoteTo(d, hn::LoadU(d16, b + i));
    hn::Store(hn::Or(above, hn::ShiftLeft<16>(below)), d, out + i);
  }
}

// What a column of two pixels, one 32-bit word, has at `f` of the way down.
HWY_INLINE V Column(Floats d, hn::Vec<hn::RebindToSigned<Floats>> word, V f) {
  const hn::RebindToSigned<Floats> di;
  const auto above = hn::ConvertTo(d, hn::And(word, hn::Set(di, 0xffff)));
  const hn::RebindToUnsigned<Floats> du;
  const auto below = hn::ConvertTo(d, hn::BitCast(di, hn::ShiftRight<16>(hn::BitCast(du, word))));
  return hn::MulAdd(f, hn::Sub(below, above), above);
}

// map: x and y of the patch's centre, then the columns of `step` by rows, in the tile: no coordinate is negative.
void SampleTile(const std::uint32_t *HWY_RESTRICT tile, const float *HWY_RESTRICT map, float scale,
                float *HWY_RESTRICT out) {
  const Floats d;
  const hn::RebindToSigned<Floats> di;
  const auto *words = reinterpret_cast<const std::int32_t *>(tile);
  const V xx = hn::Set(d, map[2]), xy = hn::Set(d, map[3]), yx = hn::Set(d, map[4]), yy = hn::Set(d, map[5]);
  const V next_x = hn::Set(d, 2 * map[3]), next_y = hn::Set(d, 2 * map[5]), vscale = hn::Set(d, scale);
  for (std::size_t j = 0; j < period; j += hn::Lanes(d)) {
    const V vx = hn::Load(d, patch_lanes::x + j), vy = hn::Load(d, patch_lanes::y + j);
    V x = hn::MulAdd(xx, vx, hn::MulAdd(xy, vy, hn::Set(d, map[0])));
    V y = hn::MulAdd(yx, vx, hn::MulAdd(yy, vy, hn::Set(d, map[1])));
    for (std::size_t i = j; i < PatchPlane::size; i += period) {
      const auto ix = hn::ConvertTo(di, x), iy = hn::ConvertTo(di, y);
      const V fx = hn::Sub(x, hn::ConvertTo(d, ix)), fy = hn::Sub(y, hn::ConvertTo(d, iy));
      const auto at = hn::Add(hn::ShiftLeft<6>(iy), ix);
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
      // One 64-bit gather fetches both columns of a sample: half the loads.
      const hn::Repartition<std::int64_t, Floats> d64;
      const auto bytes = hn::BitCast(d64, hn::ShiftLeft<2>(at));
      const auto *base = reinterpret_cast<const std::int64_t *>(tile);
      const auto even = hn::GatherOffset(d64, base, hn::And(bytes, hn::Set(d64, 0xffffffff)));
      const auto odd = hn::GatherOffset(d64, base, hn::ShiftRight<32>(bytes));
      const auto left = hn::OddEven(hn::BitCast(di, hn::ShiftLeft<32>(odd)), hn::BitCast(di, even));
      const auto right = hn::OddEven(hn::BitCast(di, odd), hn::BitCast(di, hn::ShiftRight<32>(even)));
#else
      const auto left = hn::GatherIndex(di, words, at);
      const auto right = hn::GatherIndex(di, words + 1, at);
#endif
      const V a = Column(d, left, fy), b = Column(d, right, fy);
      hn::Store(hn::Mul(vscale, hn::MulAdd(fx, hn::Sub(b, a), a)), d, out + i);
      x = hn::Add(x, next_x);
      y = hn::Add(y, next_y);
    }
  }
  static_cast<void>(words);
}

HWY_INLINE double Sum(Floats d, V v) {
  return hn::GetLane(hn::SumOfLanes(d, v));
}

constexpr std::size_t kQuantised = 544;  // PatchPlane::size in whole vectors of 32

// The median of n values among kQuantised, of which those that don't count are 32767: by bisection, which needs no more
// than compare and count. Not above `high` (inclusive); interpolated within the last bracket.
double Median(const std::int16_t *HWY_RESTRICT values, int n, int high) {
  const hn::CappedTag<std::int16_t, 32> d;
  const int rank = n / 2;
  int low = -1, below = 0, upto = n;  // below: how many are ≤ low; upto: ≤ high
  while (high - low > 1 + low / 32) {
    const int middle = low + (high - low) / 2;
    const auto bound = hn::Set(d, static_cast<std::int16_t>(middle + 1));
    std::size_t count = 0;
    for (std::size_t i = 0; i < kQuantised; i += hn::Lanes(d))
      count += hn::CountTrue(d, hn::Lt(hn::Load(d, values + i), bound));
    if (static_cast<int>(count) > rank)
      high = middle, upto = static_cast<int>(count);
    else
      low = middle, below = static_cast<int>(count);
  }
  return low + 1 + (high - low) * (rank + .5 - below) / (upto - below);
}

// Σ w J Jᵀ: sums of products of the gradients and T with 1, y, y² as they come, with x, which is the same for a whole
// column of vectors, at its end.
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
  auto &H = fit.matrix;
  H[0][0] = Sum(d, tt), H[0][1] = Sum(d, t), H[1][1] = Sum(d, w1);
  H[0][2] = Sum(d, D.x), H[0][3] = Sum(d, D.y), H[0][6] = Sum(d, D.one);
  H[0][4] = Sum(d, E.x), H[0][5] = Sum(d, E.y), H[0][7] = Sum(d, E.one);
  H[1][2] = Sum(d, F.x), H[1][3] = Sum(d, F.y), H[1][6] = Sum(d, F.one);
  H[1][4] = Sum(d, G.x), H[1][5] = Sum(d, G.y), H[1][7] = Sum(d, G.one);
  H[2][2] = Sum(d, A.xx), H[2][3] = Sum(d, A.xy), H[3][3] = Sum(d, A.yy);
  H[2][4] = Sum(d, B.xx), H[2][5] = H[3][4] = Sum(d, B.xy), H[3][5] = Sum(d, B.yy);
  H[4][4] = Sum(d, C.xx), H[4][5] = Sum(d, C.xy), H[5][5] = Sum(d, C.yy);
  H[2][6] = Sum(d, A.x), H[3][6] = Sum(d, A.y), H[6][6] = Sum(d, A.one);
  H[2][7] = H[4][6] = Sum(d, B.x), H[3][7] = H[5][6] = Sum(d, B.y), H[6][7] = Sum(d, B.one);
  H[4][7] = Sum(d, C.x), H[5][7] = Sum(d, C.y), H[7][7] = Sum(d, C.one);
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
  const double s1 = Sum(d, v1), sT = Sum(d, vT), sTT = Sum(d, vTT), sI = Sum(d, vI), sIT = Sum(d, vIT);
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
  const V unit = hn::Set(d, 128.F), most = hn::Set(d, 32767.F), counts = hn::Set(d, counted_weight);
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
  // No more than half of them are above twice their mean.
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
      inverse = hn::Mul(inverse, hn::NegMulAdd(inverse, q, two));  // Newton: all digits, the same on any machine
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
  fit.gradient = {Sum(d, gT), Sum(d, g1), Sum(d, g2), Sum(d, g3), Sum(d, g4), Sum(d, g5), Sum(d, g6), Sum(d, g7)};
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
  // Grey levels about that of the middle: no digits are lost where contrast is faint.
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

HWY_EXPORT(Interleave);
HWY_EXPORT(SampleTile);
HWY_EXPORT(FitPatch);
HWY_EXPORT(Moments);

namespace {

// Rows y and y+1 of the tile as one row of words, in `read`'s pixels.
template <class Read>
void fill_tile(const PatchTile &tile, Read read, std::uint32_t *out) {
  const auto interleave = HWY_DYNAMIC_DISPATCH(Interleave);
  alignas(64) std::uint16_t buffer[2][PatchTile::side];
  const auto n = static_cast<std::size_t>((tile.width + 15) / 16 * 16);
  const std::uint16_t *above = read(0, n, buffer[0]);
  for (int y = 0; y < tile.height; ++y) {
    const std::uint16_t *below = read(y + 1, n, buffer[(y + 1) & 1]);
    interleave(above, below, n, out + y * PatchTile::side);
    above = below;
  }
}

}  // namespace

bool prepare_tile(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchTile &tile) {
  constexpr double rx = PatchPlane::radius, ry = PatchPlane::rows - 1 - PatchPlane::radius;  // padding lies there too
  const double ex = rx * std::abs(map.step(0, 0)) + ry * std::abs(map.step(0, 1));
  const double ey = rx * std::abs(map.step(1, 0)) + ry * std::abs(map.step(1, 1));
  if (!(ex < PatchTile::side && ey < PatchTile::side)) return false;
  int left = static_cast<int>(std::floor(map.origin.x - ex)),
      right = static_cast<int>(std::floor(map.origin.x + ex)) + 2;
  int top = static_cast<int>(std::floor(map.origin.y - ey)), low = static_cast<int>(std::floor(map.origin.y + ey)) + 2;
  if (tile.width && left >= tile.x0 && top >= tile.y0 && right <= tile.x0 + tile.width && low <= tile.y0 + tile.height)
    return true;
  constexpr int margin = 2;
  if (right - left > PatchTile::side || low - top > PatchTile::side) return false;
  if (right - left + 2 * margin <= PatchTile::side) left -= margin, right += margin;
  if (low - top + 2 * margin <= PatchTile::side) top -= margin, low += margin;
  tile.x0 = left, tile.y0 = top, tile.width = right - left, tile.height = low - top;
  tile.right = level.cols - 1 - left, tile.bottom = level.rows - 1 - top;

  const auto row_of = [&](int y) { return std::clamp(top + y, 0, level.rows - 1); };
  fill_tile(
      tile,
      [&](int y, std::size_t n, std::uint16_t *buffer) -> const std::uint16_t * {
        const auto *row = level.ptr<std::uint16_t>(row_of(y));
        if (left >= 0 && left + static_cast<int>(n) <= level.cols) return row + left;
        for (int x = 0; x < static_cast<int>(n); ++x) buffer[x] = row[std::clamp(left + x, 0, level.cols - 1)];
        return buffer;
      },
      tile.pixels);

  tile.plain = left >= 0 && top >= 0 && right <= level.cols && low <= level.rows;
  if (tile.plain && !weights.empty())
    for (int y = top; tile.plain && y < low; ++y) {
      const std::uint8_t *row = weights.ptr(y) + left;
      std::uint8_t all = 255;
      for (int x = 0; x < tile.width; ++x) all &= row[x];
      tile.plain = all == 255;
    }
  if (!tile.plain)
    fill_tile(
        tile,
        [&](int y, std::size_t n, std::uint16_t *buffer) -> const std::uint16_t * {
          const std::uint8_t *row = weights.empty() ? nullptr : weights.ptr(row_of(y));
          for (int x = 0; x < static_cast<int>(n); ++x)
            buffer[x] = row ? row[std::clamp(left + x, 0, level.cols - 1)] : 255;
          return buffer;
        },
        tile.weights);
  return true;
}

double sample_tile(const PatchTile &tile, const PatchMap &map, PatchPlane &value, PatchPlane &weight) {
  const auto run = HWY_DYNAMIC_DISPATCH(SampleTile);
  const float m[6] = {static_cast<float>(map.origin.x - tile.x0), static_cast<float>(map.origin.y - tile.y0),
                      static_cast<float>(map.step(0, 0)),         static_cast<float>(map.step(0, 1)),
                      static_cast<float>(map.step(1, 0)),         static_cast<float>(map.step(1, 1))};
  run(tile.pixels, m, 1.F / 256, value.data.data());
  if (tile.plain) return 1;
  run(tile.weights, m, 1.F / 255, weight.data.data());
  int inside = 0;
  for (int vy = -PatchPlane::radius; vy <= PatchPlane::radius; ++vy)
    for (int vx = -PatchPlane::radius; vx <= PatchPlane::radius; ++vx) {
      const double x = map.origin.x - tile.x0 + map.step(0, 0) * vx + map.step(0, 1) * vy;
      const double y = map.origin.y - tile.y0 + map.step(1, 0) * vx + map.step(1, 1) * vy;
      const bool in = x >= -tile.x0 - inside_tolerance && y >= -tile.y0 - inside_tolerance &&
                      x <= tile.right + inside_tolerance && y <= tile.bottom + inside_tolerance;
      if (!in) weight.at(vx, vy) = 0;
      inside += in;
    }
  return static_cast<double>(inside) / PatchPlane::pixels;
}

void fit_patch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
               PatchFit &fit) {
  HWY_DYNAMIC_DISPATCH(FitPatch)(anchor, value, weight, robust, fit);
}

PatchMoments patch_moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight) {
  return HWY_DYNAMIC_DISPATCH(Moments)(anchor, value, weight);
}

void multiply(const PatchPlane &a, const PatchPlane &b, PatchPlane &out) {
  for (std::size_t i = 0; i < PatchPlane::size; ++i) out.data[i] = a.data[i] * b.data[i];
}

}  // namespace csd
#endif  // HWY_ONCE
