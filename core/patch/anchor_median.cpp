// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/anchor_median.h"

#include <algorithm>
#include <cmath>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "patch/anchor_median.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "patch/median-inl.h"

#ifndef CSDTRACK_ANCHOR_MEDIAN_ONCE
#define CSDTRACK_ANCHOR_MEDIAN_ONCE
namespace csd {
namespace {

constexpr int max_rounds = 10;
constexpr double close_enough = .01;  // grey levels, change in a round
constexpr double min_gain = .1, max_gain = 10;
constexpr double min_spread = .1;  // grey levels; below, the gain is undetermined

/// value ≈ gain·first + bias, grey levels.
struct Brightness {
  double gain = 1, bias = 0;
};

/// Gain and bias from weighted sums. The gain is the ratio of the deviations: both patches are noisy, and least squares
/// would take the noise of one for lower contrast. If the gain is undetermined, only the means are matched.
Brightness regress(double s1, double sF, double sFF, double sV, double sVV) {
  Brightness b;
  const double spread = s1 * sVV - sV * sV, spread_of_first = s1 * sFF - sF * sF;
  if (spread_of_first > 1e-3 * s1 * s1)
    b.gain = std::clamp(std::sqrt(std::max(spread, 0.) / spread_of_first), min_gain, max_gain);
  b.bias = (sV - b.gain * sF) / s1;
  return b;
}

double first_gain(double spread, double spread_of_first) {
  return spread_of_first > min_spread ? std::clamp(spread / spread_of_first, min_gain, max_gain) : 1;
}

double scale_of(double median_residual) {
  return 3 * std::max(1.48 * median_residual, 1.);
}

}  // namespace
}  // namespace csd
#endif

HWY_BEFORE_NAMESPACE();
namespace csd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

static_assert(kQuantised == CompactPatch::size);

#if HWY_TARGET == HWY_SCALAR  // below SSSE3

void Compact(const PatchSample &sample, CompactPatch &out) {
  out = compact_scalar(sample);
}
void BringTo(const CompactPatch &first, CompactPatch &patch) {
  bring_to_scalar(first, patch);
}
void MedianOf(const CompactPatch *samples, std::size_t n, PatchSample &out) {
  out = median_of_scalar({samples, n});
}

#else

using Floats = hn::CappedTag<float, 16>;
using V = hn::Vec<Floats>;
using Shorts = hn::CappedTag<std::int16_t, 32>;

void Compact(const PatchSample &sample, CompactPatch &out) {
  const Floats d;
  const hn::Rebind<std::int16_t, Floats> d16;
  const hn::Rebind<std::uint8_t, Floats> d8;
  const V unit = hn::Set(d, 1 / CompactPatch::unit), most = hn::Set(d, CompactPatch::most), full = hn::Set(d, 255.F);
  for (std::size_t i = 0; i < PatchPlane::size; i += hn::Lanes(d)) {
    const V value = hn::Mul(hn::Load(d, sample.value.data.data() + i), unit);
    const V weight = hn::Mul(hn::Load(d, sample.weight.data.data() + i), full);
    hn::Store(hn::DemoteTo(d16, hn::NearestInt(hn::Clamp(value, hn::Zero(d), most))), d16, out.value.data() + i);
    hn::Store(hn::DemoteTo(d8, hn::NearestInt(hn::Clamp(weight, hn::Zero(d), full))), d8, out.weight.data() + i);
  }
}

HWY_INLINE double Sum(Floats d, V v) {
  return hn::GetLane(hn::SumOfLanes(d, v));
}

// The values where both are unmasked, 32767 elsewhere.
HWY_INLINE int Unmasked(const CompactPatch &patch, const CompactPatch &first, std::int16_t *HWY_RESTRICT a,
                        std::int16_t *HWY_RESTRICT b) {
  const Shorts d;
  const hn::Rebind<std::uint8_t, Shorts> d8;
  const auto masked = hn::Set(d, std::int16_t{32767}), least = hn::Set(d, std::int16_t{CompactPatch::unmasked - 1});
  std::size_t n = 0;
  for (std::size_t i = 0; i < kQuantised; i += hn::Lanes(d)) {
    const auto weight = hn::Min(hn::PromoteTo(d, hn::Load(d8, patch.weight.data() + i)),
                                hn::PromoteTo(d, hn::Load(d8, first.weight.data() + i)));
    const auto both = hn::Gt(weight, least);
    n += hn::CountTrue(d, both);
    hn::Store(hn::IfThenElse(both, hn::Load(d, patch.value.data() + i), masked), d, a + i);
    hn::Store(hn::IfThenElse(both, hn::Load(d, first.value.data() + i), masked), d, b + i);
  }
  return static_cast<int>(n);
}

// Median and median absolute deviation, grey levels, to a quarter of one: the start of IRLS.
HWY_INLINE std::pair<double, double> MiddleAndSpread(const std::int16_t *HWY_RESTRICT values, int n) {
  constexpr int coarse = 32;
  const Shorts d;
  const double middle = Median(values, n, 32766, coarse);
  const auto at = hn::Set(d, static_cast<std::int16_t>(middle)), masked = hn::Set(d, std::int16_t{32767});
  alignas(64) std::int16_t sizes[kQuantised];
  for (std::size_t i = 0; i < kQuantised; i += hn::Lanes(d)) {
    const auto v = hn::Load(d, values + i);
    hn::Store(hn::IfThenElse(hn::Eq(v, masked), v, hn::Abs(hn::Sub(v, at))), d, sizes + i);
  }
  return {middle * CompactPatch::unit, Median(sizes, n, 32766, coarse) * CompactPatch::unit};
}

void BringTo(const CompactPatch &first, CompactPatch &patch) {
  const Floats d;
  const hn::RebindToSigned<Floats> di;
  const hn::Rebind<std::int16_t, Floats> d16;
  const std::size_t lanes = hn::Lanes(d);
  alignas(64) std::int16_t values[kQuantised], firsts[kQuantised], sizes[kQuantised];
  const int n = Unmasked(patch, first, values, firsts);
  if (n == 0) return;
  const auto [middle, spread] = MiddleAndSpread(values, n);
  const auto [first_middle, first_spread] = MiddleAndSpread(firsts, n);

  // Grey levels relative to the medians, so that single precision suffices for the sums.
  const V zero = hn::Zero(d), one = hn::Set(d, 1.F), two = hn::Set(d, 2.F), unit = hn::Set(d, CompactPatch::unit);
  const V per_unit = hn::Set(d, 1 / CompactPatch::unit), most = hn::Set(d, CompactPatch::most);
  const auto masked = hn::Set(di, 32767);
  const V minus_middle = hn::Set(d, static_cast<float>(-middle)),
          minus_first = hn::Set(d, static_cast<float>(-first_middle));
  alignas(64) float v[kQuantised], f[kQuantised], r[kQuantised];
  Brightness b{first_gain(spread, first_spread), 0};
  for (int round = 0; round < max_rounds; ++round) {
    const V inverse = hn::Set(d, static_cast<float>(1 / b.gain)), bias = hn::Set(d, static_cast<float>(b.bias));
    V total = zero;
    for (std::size_t i = 0; i < kQuantised; i += lanes) {
      const auto value = hn::PromoteTo(di, hn::Load(d16, values + i));
      const auto counts = hn::RebindMask(d, hn::Ne(value, masked));
      if (round == 0) {
        hn::Store(hn::MulAdd(hn::ConvertTo(d, value), unit, minus_middle), d, v + i);
        hn::Store(hn::MulAdd(hn::ConvertTo(d, hn::PromoteTo(di, hn::Load(d16, firsts + i))), unit, minus_first), d,
                  f + i);
      }
      const V residual = hn::MulSub(hn::Sub(hn::Load(d, v + i), bias), inverse, hn::Load(d, f + i));
      const V size = hn::Min(hn::Mul(hn::Abs(residual), per_unit), most);
      total = hn::Add(total, hn::IfThenElseZero(counts, size));
      hn::Store(residual, d, r + i);
      const auto whole = hn::IfThenElse(hn::RebindMask(di, counts), hn::ConvertTo(di, size), masked);
      hn::Store(hn::DemoteTo(d16, whole), d16, sizes + i);
    }
    // The median is at most twice the mean; a resolution of a sixteenth of a grey level suffices.
    const int high = static_cast<int>(std::min(2 * Sum(d, total) / n + 1, 32766.));
    const V per_c = hn::Set(d, static_cast<float>(1 / scale_of(Median(sizes, n, high, 8) * CompactPatch::unit)));
    V s1 = zero, sF = zero, sFF = zero, sV = zero, sVV = zero;
    for (std::size_t i = 0; i < kQuantised; i += lanes) {
      const auto counts = hn::RebindMask(d, hn::Ne(hn::PromoteTo(di, hn::Load(d16, values + i)), masked));
      const V u = hn::Mul(hn::Load(d, r + i), per_c), q = hn::MulAdd(u, u, one);
      V per_q = hn::ApproximateReciprocal(q);
      per_q = hn::Mul(per_q, hn::NegMulAdd(per_q, q, two));  // a Newton step makes it the same on any machine
      const V w = hn::IfThenElseZero(counts, hn::Mul(per_q, per_q));
      const V first_value = hn::Load(d, f + i), wf = hn::Mul(w, first_value);
      const V value = hn::Load(d, v + i), wv = hn::Mul(w, value);
      s1 = hn::Add(s1, w), sF = hn::Add(sF, wf), sFF = hn::MulAdd(wf, first_value, sFF);
      sV = hn::Add(sV, wv), sVV = hn::MulAdd(wv, value, sVV);
    }
    const Brightness before = b;
    b = regress(Sum(d, s1), Sum(d, sF), Sum(d, sFF), Sum(d, sV), Sum(d, sVV));
    // At the middle, and at strong texture.
    const double change = std::abs(b.bias - before.bias) + 3 * first_spread * std::abs(b.gain - before.gain);
    if (change < close_enough * b.gain) break;
  }

  const V inverse = hn::Set(d, static_cast<float>(1 / b.gain));
  const V shift = hn::Set(d, static_cast<float>((first_middle - (middle + b.bias) / b.gain) / CompactPatch::unit));
  for (std::size_t i = 0; i < kQuantised; i += lanes) {
    const auto value = hn::PromoteTo(di, hn::Load(d16, patch.value.data() + i));
    const V brought = hn::Clamp(hn::MulAdd(hn::ConvertTo(d, value), inverse, shift), hn::Neg(most), most);
    hn::Store(hn::DemoteTo(d16, hn::NearestInt(brought)), d16, patch.value.data() + i);
  }
}

// Many pixels in parallel. Masked values sort to the end; a selection sort runs until the median is known.
void MedianOf(const CompactPatch *samples, std::size_t n, PatchSample &out) {
  const Shorts d;
  const hn::Rebind<std::uint8_t, Shorts> d8;
  const auto zero = hn::Zero(d), one = hn::Set(d, std::int16_t{1}), masked = hn::Set(d, std::int16_t{32767});
  const auto least = hn::Set(d, std::int16_t{CompactPatch::unmasked - 1});
  const auto most_masked = hn::Set(d, std::int16_t{GlareWeights::highlight});
  alignas(64) std::int16_t sorted[AnchorMedian::most * 32], weights[kQuantised], masked_weights[kQuantised],
      counts[kQuantised], lower[kQuantised], upper[kQuantised];
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t i = 0; i < kQuantised; i += lanes) {
    auto count = zero, weight = zero, dim = zero;
    for (std::size_t k = 0; k < n; ++k) {
      const auto w = hn::PromoteTo(d, hn::Load(d8, samples[k].weight.data() + i));
      const auto is_unmasked = hn::Gt(w, least);
      count = hn::Sub(count, hn::VecFromMask(d, is_unmasked));
      weight = hn::Add(weight, hn::IfThenElseZero(is_unmasked, w));
      dim = hn::Add(dim, hn::Min(w, most_masked));
      hn::Store(hn::IfThenElse(is_unmasked, hn::Load(d, samples[k].value.data() + i), masked), d, sorted + k * lanes);
    }
    hn::Store(count, d, counts + i);
    hn::Store(weight, d, weights + i);
    hn::Store(dim, d, masked_weights + i);
    if (const auto never = hn::Eq(count, zero); !hn::AllFalse(d, never)) {
      for (std::size_t k = 0; k < n; ++k)
        hn::Store(hn::IfThenElse(never, hn::Load(d, samples[k].value.data() + i), hn::Load(d, sorted + k * lanes)), d,
                  sorted + k * lanes);
      count = hn::IfThenElse(never, hn::Set(d, static_cast<std::int16_t>(n)), count);
    }
    const auto a = hn::ShiftRight<1>(hn::Sub(count, one)), b = hn::ShiftRight<1>(count);
    auto low = zero, high = zero;
    for (std::size_t k = 0; k <= n / 2 && k < n; ++k) {
      auto smallest = hn::Load(d, sorted + k * lanes);
      for (std::size_t j = k + 1; j < n; ++j) {
        const auto other = hn::Load(d, sorted + j * lanes);
        hn::Store(hn::Max(smallest, other), d, sorted + j * lanes);
        smallest = hn::Min(smallest, other);
      }
      const auto rank = hn::Set(d, static_cast<std::int16_t>(k));
      low = hn::IfThenElse(hn::Eq(a, rank), smallest, low);
      high = hn::IfThenElse(hn::Eq(b, rank), smallest, high);
    }
    hn::Store(low, d, lower + i);
    hn::Store(high, d, upper + i);
  }
  for (std::size_t i = 0; i < PatchPlane::size; ++i) {
    out.value.data[i] = static_cast<float>(lower[i] + upper[i]) * (CompactPatch::unit / 2);
    const bool seen = 3 * counts[i] >= static_cast<int>(n), never = counts[i] == 0;
    out.weight.data[i] = seen    ? static_cast<float>(weights[i]) / static_cast<float>(255 * counts[i])
                         : never ? static_cast<float>(masked_weights[i]) / static_cast<float>(255 * n)
                                 : 0.F;
  }
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace csd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd {

HWY_EXPORT(Compact);
HWY_EXPORT(BringTo);
HWY_EXPORT(MedianOf);

CompactPatch compact(const PatchSample &sample) {
  CompactPatch out;
  HWY_DYNAMIC_DISPATCH(Compact)(sample, out);
  return out;
}

void bring_to(const CompactPatch &first, CompactPatch &patch) {
  HWY_DYNAMIC_DISPATCH(BringTo)(first, patch);
}

PatchSample median_of(std::span<const CompactPatch> samples) {
  PatchSample out;
  HWY_DYNAMIC_DISPATCH(MedianOf)(samples.data(), samples.size(), out);
  return out;
}

CompactPatch compact_scalar(const PatchSample &sample) {
  CompactPatch out;
  for (std::size_t i = 0; i < PatchPlane::size; ++i) {
    const float value = std::clamp(sample.value.data[i] / CompactPatch::unit, 0.F, CompactPatch::most);
    out.value[i] = static_cast<std::int16_t>(std::nearbyint(value));
    out.weight[i] = static_cast<std::uint8_t>(std::nearbyint(std::clamp(sample.weight.data[i] * 255, 0.F, 255.F)));
  }
  return out;
}

namespace {

double median(std::vector<double> &values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Brightness compare(const std::vector<double> &value, const std::vector<double> &first) {
  const std::size_t n = value.size();
  std::vector<double> size;
  const auto middle_and_spread = [&size](const std::vector<double> &v) {
    size = v;
    const double middle = median(size);
    for (double &s : size) s = std::abs(s - middle);
    return std::pair(middle, median(size));
  };
  const auto [middle, spread] = middle_and_spread(value);
  const auto [first_middle, spread_of_first] = middle_and_spread(first);
  Brightness b{first_gain(spread, spread_of_first), 0};
  b.bias = middle - b.gain * first_middle;
  for (int round = 0; round < max_rounds; ++round) {
    const auto residual = [&](std::size_t i) { return (value[i] - b.bias) / b.gain - first[i]; };
    for (std::size_t i = 0; i < n; ++i) size[i] = std::abs(residual(i));
    const double c = scale_of(median(size));
    double s1 = 0, sF = 0, sFF = 0, sV = 0, sVV = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double q = residual(i) / c, w = 1 / ((1 + q * q) * (1 + q * q)), f = first[i], v = value[i];
      s1 += w, sF += w * f, sFF += w * f * f, sV += w * v, sVV += w * v * v;
    }
    b = regress(s1, sF, sFF, sV, sVV);
  }
  return b;
}

}  // namespace

void bring_to_scalar(const CompactPatch &first, CompactPatch &patch) {
  std::vector<double> both[2];
  for (std::size_t i = 0; i < CompactPatch::size; ++i)
    if (std::min(patch.weight[i], first.weight[i]) >= CompactPatch::unmasked) {
      both[0].push_back(patch.value[i] * CompactPatch::unit);
      both[1].push_back(first.value[i] * CompactPatch::unit);
    }
  if (both[0].empty()) return;
  const auto b = compare(both[0], both[1]);
  for (auto &v : patch.value) {
    const double brought = (v - b.bias / CompactPatch::unit) / b.gain;
    v = static_cast<std::int16_t>(
        std::nearbyint(std::clamp(brought, -double{CompactPatch::most}, double{CompactPatch::most})));
  }
}

PatchSample median_of_scalar(std::span<const CompactPatch> samples) {
  PatchSample out;
  std::vector<int> values;
  for (std::size_t i = 0; i < PatchPlane::size; ++i) {
    values.clear();
    int weight = 0, masked = 0;
    for (const auto &s : samples) {
      masked += std::min(s.weight[i], GlareWeights::highlight);
      if (s.weight[i] >= CompactPatch::unmasked) {
        values.push_back(s.value[i]);
        weight += s.weight[i];
      }
    }
    if (3 * values.size() >= samples.size())
      out.weight.data[i] = static_cast<float>(weight) / static_cast<float>(255 * values.size());
    else if (values.empty())
      out.weight.data[i] = static_cast<float>(masked) / static_cast<float>(255 * samples.size());
    if (values.empty())  // values for the neighbours' gradients
      for (const auto &s : samples) values.push_back(s.value[i]);
    std::sort(values.begin(), values.end());
    const std::size_t m = values.size();
    out.value.data[i] = static_cast<float>(values[(m - 1) / 2] + values[m / 2]) * (CompactPatch::unit / 2);
  }
  return out;
}

void AnchorMedian::add(const PatchSample &sample) {
  // Reserves at once: small vectors that grow, some thousand at a time, fragment the heap. Not for a single sample:
  // with a training time of 0 there are no more.
  if (samples_.size() == 1) samples_.reserve(most);
  auto &patch = samples_.emplace_back(compact(sample));
  if (samples_.size() > 1) bring_to(samples_.front(), patch);
}

AnchorLevel AnchorMedian::make() const {
  return make_anchor_level(median_of(samples_));
}

}  // namespace csd
#endif  // HWY_ONCE
