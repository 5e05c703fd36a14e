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

/// The training set S of §2.1.2: square patches of one channel with their labels.
///
/// A patch is contiguous ([sample][pixel], each row padded to 16 bytes), because samples are added, replaced and
/// classified one at a time. Learning needs [pixel][sample]; NodeSamples transposes the samples of one node.
class SampleSet {
 public:
  /// `patch_size`: side in pixels, odd, 3…255. Throws cv::Exception otherwise.
  explicit SampleSet(int patch_size);

  int patch_size() const { return patch_size_; }
  int pixels() const { return patch_size_ * patch_size_; }
  /// Number of samples.
  std::size_t size() const { return labels_.size() - free_.size(); }
  /// Upper bound of the ids.
  std::size_t slots() const { return labels_.size(); }

  /// Copies a patch_size × patch_size CV_8UC1 patch. A slot freed by remove() is used first. Throws cv::Exception on a
  /// patch of another size or type.
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
