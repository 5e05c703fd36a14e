// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "patch/anchor.h"

namespace csd {

/// A patch in 16 bit: a third of a PatchSample, for a dozen of them for each level are kept for each new feature.
/// In PatchPlane's order; what is beyond its samples has weight 0.
struct CompactPatch {
  static constexpr std::size_t size = 544;                ///< PatchPlane::size in whole vectors of 32
  alignas(64) std::array<std::int16_t, size> value{};     ///< 1/128 of a grey level, ±255.98
  alignas(64) std::array<std::uint8_t, size> weight{};    ///< 1/255
  static constexpr std::uint8_t unmasked = 128;           ///< weight from which a pixel counts
  static constexpr float unit = 1 / 128.F, most = 32766;  ///< 32767 is what doesn't count
};

/// The samples of a level over the first half second, each brought to the first one's gain and bias (robustly), and
/// their median per pixel: what a passing highlight or noise did to the first frame goes out. A pixel that is masked in
/// more than two thirds of the samples gets weight 0. Most of the work is add()'s: it spreads over the training time.
class AnchorMedian {
 public:
  static constexpr std::size_t most = 16;
  void add(const PatchSample &sample);  ///< size() < most
  std::size_t size() const { return samples_.size(); }
  AnchorLevel make() const;  ///< size() ≥ 1

 private:
  std::vector<CompactPatch> samples_;
};

/// The sample in 16 bit, to the nearest step. On the best SIMD target of the machine, as the two below.
CompactPatch compact(const PatchSample &sample);

/// Brings `patch` to the brightness of `first`: where both are unmasked, patch ≈ gain·first + bias with the ratio of
/// their deviations and the difference of their means, under weights 1/(1+(r/c)²)² that follow the residuals,
/// c = 3 max(1.48 median |r|, 1 grey level). It begins with medians, for a highlight in both has more leverage than all
/// the texture, and ends when a round changes less than .01 grey levels. Gain .1 to 10.
void bring_to(const CompactPatch &first, CompactPatch &patch);

/// The median per pixel of where it is unmasked (of all where it never is, with weight 0), and the mean weight there;
/// 0 if that is in less than a third. 1 to AnchorMedian::most samples.
PatchSample median_of(std::span<const CompactPatch> samples);

/// Their plain twins: bring_to_scalar() takes ten rounds, whatever they change.
CompactPatch compact_scalar(const PatchSample &sample);
void bring_to_scalar(const CompactPatch &first, CompactPatch &patch);
PatchSample median_of_scalar(std::span<const CompactPatch> samples);

}  // namespace csd
