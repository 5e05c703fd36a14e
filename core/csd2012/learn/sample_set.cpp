// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/sample_set.h"

#include <cstring>

namespace csd {

SampleSet::SampleSet(int patch_size)
    : patch_size_(patch_size),
      row_bytes_((static_cast<std::size_t>(patch_size) * static_cast<std::size_t>(patch_size) + 15) / 16 * 16) {
  check_patch_size(patch_size);
}

SampleId SampleSet::add(const cv::Mat &patch, Label label) {
  if (free_.empty()) {
    const auto id = static_cast<SampleId>(labels_.size());
    bytes_.resize(bytes_.size() + row_bytes_, 0);
    labels_.push_back(label);
    used_.push_back(0);
    free_.push_back(id);
  }
  const SampleId id = free_.back();
  store(id, patch);
  free_.pop_back();
  labels_[id] = label;
  used_[id] = 1;
  return id;
}

void SampleSet::replace(SampleId id, const cv::Mat &patch, Label label) {
  CV_Assert(contains(id));
  store(id, patch);
  labels_[id] = label;
}

void SampleSet::remove(SampleId id) {
  CV_Assert(contains(id));
  free_.push_back(id);
  used_[id] = 0;
}

void SampleSet::check(const cv::Mat &patch) const {
  CV_Assert(patch.type() == CV_8UC1 && patch.rows == patch_size_ && patch.cols == patch_size_);
}

void SampleSet::store(SampleId id, const cv::Mat &patch) {
  check(patch);
  const auto side = static_cast<std::size_t>(patch_size_);
  std::uint8_t *row = bytes_.data() + id * row_bytes_;
  for (int y = 0; y < patch_size_; ++y) std::memcpy(row + static_cast<std::size_t>(y) * side, patch.ptr(y), side);
}

}  // namespace csd
