// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace csd {

/// What a patch shows (§2.1.2).
enum class Label : std::uint8_t { not_feature, feature };

/// A sample's slot in its set: stable until the sample is removed, then reused.
using SampleId = std::uint32_t;

/// Throws cv::Exception unless a patch's side is odd, 3…255 pixels.
inline void check_patch_size(int patch_size) {
  CV_Assert(patch_size >= 3 && patch_size <= 255 && patch_size % 2 == 1);
}

/// The training set S of §2.1.2: square patches of one channel with their labels.
///
/// A patch is contiguous ([sample][pixel], each row padded to 16 bytes), because samples are added, replaced and
/// classified one at a time. Learning needs [pixel][sample]; NodeSamples transposes the samples of one node.
class SampleSet {
 public:
  /// `patch_size`: side in pixels; see check_patch_size().
  explicit SampleSet(int patch_size);

  int patch_size() const { return patch_size_; }
  int pixels() const { return patch_size_ * patch_size_; }
  /// Number of samples.
  std::size_t size() const { return labels_.size() - free_.size(); }
  /// Upper bound of the ids.
  std::size_t slots() const { return labels_.size(); }

  /// Throws cv::Exception unless this is a patch_size × patch_size CV_8UC1 patch.
  void check(const cv::Mat &patch) const;
  /// Copies a patch, see check(). A slot freed by remove() is used first.
  SampleId add(const cv::Mat &patch, Label label);
  void replace(SampleId id, const cv::Mat &patch, Label label);
  void remove(SampleId id);

  bool contains(SampleId id) const { return id < labels_.size() && used_[id]; }
  Label label(SampleId id) const { return labels_[id]; }
  /// The patch's pixels, row by row without gaps, readable up to row_bytes(). Valid until the next add().
  const std::uint8_t *patch(SampleId id) const { return bytes_.data() + id * row_bytes_; }
  /// pixels() rounded up to 16; the padding is 0.
  std::size_t row_bytes() const { return row_bytes_; }

 private:
  void store(SampleId id, const cv::Mat &patch);

  int patch_size_;
  std::size_t row_bytes_;
  std::vector<std::uint8_t> bytes_;
  std::vector<Label> labels_;
  std::vector<std::uint8_t> used_;
  std::vector<SampleId> free_;
};

}  // namespace csd
