// SPDX-License-Identifier: LGPL-2.1-or-later
// Included once per SIMD target, like Highway's -inl.h files.
#if defined(CSDTRACK_MEDIAN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef CSDTRACK_MEDIAN_INL_H
#undef CSDTRACK_MEDIAN_INL_H
#else
#define CSDTRACK_MEDIAN_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace csd {
namespace HWY_NAMESPACE {

// Number of a patch's 16-bit values in whole vectors of 32: PatchPlane::size, rounded up.
constexpr std::size_t kQuantised = 544;

#if HWY_TARGET != HWY_SCALAR

// The median of n values among kQuantised; masked ones are 32767. By bisection, which needs only compare and count.
// Values are not negative, and the median is at most `high`. Interpolated within `resolution` units.
inline double Median(const std::int16_t *HWY_RESTRICT values, int n, int high, int resolution = 1) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<std::int16_t, 32> d;
  const int rank = n / 2;
  int low = -1, below = 0, upto = n;  // below: number of values ≤ low; upto: ≤ high
  while (high - low > resolution) {
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

#endif

}  // namespace HWY_NAMESPACE
}  // namespace csd
HWY_AFTER_NAMESPACE();

#endif
