// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "patch/anchor.h"

namespace csd {

/// A patch in 16 bit: a third of a PatchSample, because each new feature stores a dozen per level. In PatchPlane's
/// order; the padding has weight 0.
struct CompactPatch {
  static constexpr std::size_t size = 544;                ///< PatchPlane::size in whole vectors of 32
  alignas(64) std::array<std::int16_t, size> value{};     ///< 1/128 of a grey level, ±255.98
  alignas(64) std::array<std::uint8_t, size> weight{};    ///< as in GlareWeights
  static constexpr std::uint8_t unmasked = 192;           ///< weight from which a pixel counts: half of it is tissue
  static constexpr float unit = 1 / 128.F, most = 32766;  ///< 32767 marks masked values
};

/// Per-pixel median of a level's samples over the first half second, each matched robustly to the first one's gain and
/// bias. It removes highlights and noise of the first frame. A pixel that is masked in more than two thirds of the
/// samples counts as nothing, or as bright texture if it is masked in each. add() does most of the work, which spreads
/// it over the training time.
class AnchorMedian {
 public:
  static constexpr std::size_t most = 16;
  void add(const PatchSample &sample);  ///< size() < most
  std::size_t size() const { return samples_.size(); }
  AnchorLevel make() const;  ///< size() ≥ 1

 private:
  std::vector<CompactPatch> samples_;
};

/// Converts the sample to 16 bit, rounded to nearest. This and the two functions below run on the machine's best SIMD
/// target.
CompactPatch compact(const PatchSample &sample);

/// Matches `patch` to the brightness of `first`. Where both are unmasked, patch ≈ gain·first + bias: gain is the ratio
/// of the deviations, bias the difference of the means, under weights 1/(1+(r/c)²)² that follow the residuals, with c =
/// 3 max(1.48 median |r|, 1 grey level). Starts from medians, because a highlight in both patches has more leverage
/// than all the texture. Ends when a round changes less than .01 grey levels. Gain .1 to 10.
void bring_to(const CompactPatch &first, CompactPatch &patch);

/// Per pixel, the median of the unmasked samples and their mean weight. If fewer than a third are unmasked, a highlight
/// came or went: the weight is 0. If none is, the pixel is bright texture: its weight is the mean, each at most
/// GlareWeights::highlight, and the median is of all samples. 1 to AnchorMedian::most samples.
PatchSample median_of(std::span<const CompactPatch> samples);

/// The same without SIMD. bring_to_scalar() always takes ten rounds.
CompactPatch compact_scalar(const PatchSample &sample);
void bring_to_scalar(const CompactPatch &first, CompactPatch &patch);
PatchSample median_of_scalar(std::span<const CompactPatch> samples);

}  // namespace csd
