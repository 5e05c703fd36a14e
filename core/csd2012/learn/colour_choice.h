// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/random.h"
#include "csd2012/learn/sample_set.h"
#include "image/colour_space.h"

namespace csd {

/// Patches in colour, until the colour space is chosen.
class ColourPatches {
 public:
  /// `patch_size`: side in pixels; see check_patch_size().
  explicit ColourPatches(int patch_size);

  int patch_size() const { return patch_size_; }
  std::size_t size() const { return labels_.size(); }
  Label label(std::size_t i) const { return labels_[i]; }
  const std::vector<Label> &labels() const { return labels_; }

  /// Copies a patch_size × patch_size CV_8UC3 patch, B G R. Throws cv::Exception on another size or type.
  void add(const cv::Mat &patch, Label label);
  /// A view of patch i (CV_8UC3), valid until the next add().
  cv::Mat patch(std::size_t i) const;
  /// A view of all patches, one below the other (CV_8UC3), valid until the next add().
  cv::Mat stack() const;
  /// Converts all patches to one colour space, one below the other, into `out`: CV_8UC1, size() * patch_size rows of
  /// patch_size. Throws cv::Exception on another size or type.
  void convert(const ColourSpace &space, cv::Mat out) const;

 private:
  int patch_size_;
  std::vector<std::uint8_t> bytes_;  ///< [patch][pixel][B G R]
  std::vector<Label> labels_;
};

/// Number of pixels whose V is averaged for a colour space's score.
inline constexpr std::size_t colour_choice_pixels = 16;

/// Each space's score on all patches, the tree's root set: the mean of the 16 highest variance ratios of single pixels
/// (Eq. 5; the paper's text refers to Eq. 4, the likelihood ratio in it).
std::array<double, 49> colour_scores(const ColourPatches &patches);

/// Each space's score by what the tests of Eq. 2 compare: the mean of the 16 highest variance ratios (Eq. 5) of the
/// differences P1 − P2 of 256 pairs of pixels, the same pairs for all spaces.
std::array<double, 49> colour_scores_of_pairs(const ColourPatches &patches, Random &random);

/// The most discriminative of the 49 colour spaces (Eq. 7, §2.2.1): the one of highest score, among equals the first in
/// colour_spaces(). Intensity if a class is empty.
ColourSpace choose_colour(const ColourPatches &patches);
/// The same by colour_scores_of_pairs().
ColourSpace choose_colour_of_pairs(const ColourPatches &patches, Random &random);

}  // namespace csd
