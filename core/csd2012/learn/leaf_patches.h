// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace csd {

/// Some of the patches labelled feature in one leaf, to compare others with. Immutable once it is made.
///
/// P(N) tells how often the feature reached a leaf, not how alike a patch is to what reached it. After a turn beyond
/// the warps' range few samples have reached the feature's leaf, and more have reached others, by chance.
class LeafPatches {
 public:
  /// `pixels`: of a patch.
  explicit LeafPatches(std::size_t pixels) : pixels_(pixels) {}

  /// Copies a patch, row by row without gaps.
  void add(const std::uint8_t *patch);
  std::size_t size() const { return sums_.size(); }

  /// The largest zero-mean normalised cross correlation (ZNCC) with one of them, 0…1: 0 if none correlates positively.
  /// A patch without contrast correlates with none. `patch`: row by row without gaps.
  double likeness(const std::uint8_t *patch) const;

 private:
  std::size_t pixels_;
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint32_t> sums_;     ///< of the pixels of each
  std::vector<double> inverse_spread_;  ///< 1/√(n Σp² − (Σp)²) of each; 0 without contrast
};

}  // namespace csd
