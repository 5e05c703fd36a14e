// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/tree.h"

#include <algorithm>
#include <array>
#include <utility>

#include "csd2012/learn/pixel_pair.h"

namespace csd {

namespace {

/// A node whose pixels are byte offsets from the patch's first pixel in the scanned image.
struct Step {
  std::int32_t offset1, offset2, first_child;
};

std::int32_t descend(const Step &step, const std::uint8_t *patch) {
  return step.first_child + child_of(patch[step.offset1], patch[step.offset2]);
}

std::vector<Step> resolve(const std::vector<Tree::Node> &nodes, int patch_size, std::size_t row_stride) {
  std::vector<Step> steps(nodes.size());
  const auto offset = [&](int pixel) {
    return static_cast<std::int32_t>(static_cast<std::size_t>(pixel / patch_size) * row_stride) + pixel % patch_size;
  };
  for (std::size_t i = 0; i < nodes.size(); ++i)
    steps[i] = {offset(nodes[i].p1), offset(nodes[i].p2), nodes[i].first_child};
  return steps;
}

void check_scan(const cv::Mat &channel, const cv::Rect &centres, int patch_size) {
  const int half = patch_size / 2;
  CV_Assert(channel.type() == CV_8UC1);
  CV_Assert(centres.width >= 0 && centres.height >= 0);
  CV_Assert(centres.x >= half && centres.y >= half && centres.x + centres.width + half <= channel.cols &&
            centres.y + centres.height + half <= channel.rows);
}

}  // namespace

Tree::Tree(int patch_size, const ColourSpace &space, std::vector<Node> nodes, int depth, LeavesPatches own)
    : patch_size_(patch_size), space_(space), nodes_(std::move(nodes)), depth_(depth), own_(std::move(own)) {
  CV_Assert(!nodes_.empty() && (own_.empty() || own_.size() == nodes_.size()));
  for (const Node &n : nodes_) features_ += n.feature;
}

std::int32_t Tree::leaf(const cv::Mat &patch) const {
  CV_Assert(patch.type() == CV_8UC1 && patch.rows == patch_size_ && patch.cols == patch_size_);
  std::int32_t at = 0;
  for (;;) {
    const Node &n = nodes_[static_cast<std::size_t>(at)];
    if (n.first_child < at) return at;
    const auto pixel = [&](int i) { return patch.at<std::uint8_t>(i / patch_size_, i % patch_size_); };
    at = n.first_child + child_of(pixel(n.p1), pixel(n.p2));
  }
}

void Tree::scan(const cv::Mat &channel, const cv::Rect &centres, std::vector<std::int32_t> &leaves, int step) const {
  check_scan(channel, centres, patch_size_);
  const int columns = (centres.width + step - 1) / step, rows = (centres.height + step - 1) / step;
  leaves.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const std::vector<Step> steps = resolve(nodes_, patch_size_, channel.step[0]);
  const int half = patch_size_ / 2;
  constexpr int lanes = 16;
  std::int32_t *out = leaves.data();
  for (int y = centres.y; y < centres.y + centres.height; y += step) {
    const std::uint8_t *first = channel.ptr(y - half) + centres.x - half;
    int x = 0;
    for (; x + lanes <= columns; x += lanes, out += lanes) {
      std::array<std::int32_t, lanes> at{};
      for (int d = 0; d < depth_; ++d) {
        std::int32_t moved = 0;
        for (int k = 0; k < lanes; ++k) {
          const auto i = static_cast<std::size_t>(k);
          const std::int32_t next = descend(steps[static_cast<std::size_t>(at[i])], first + (x + k) * step);
          moved |= next ^ at[i];
          at[i] = next;
        }
        if (!moved) break;
      }
      std::copy(at.begin(), at.end(), out);
    }
    for (; x < columns; ++x) {
      std::int32_t at = 0;
      for (int d = 0; d < depth_; ++d) at = descend(steps[static_cast<std::size_t>(at)], first + x * step);
      *out++ = at;
    }
  }
}

void Tree::scan_plain(const cv::Mat &channel, const cv::Rect &centres, std::vector<std::int32_t> &leaves) const {
  check_scan(channel, centres, patch_size_);
  leaves.clear();
  const int half = patch_size_ / 2;
  for (int y = centres.y; y < centres.y + centres.height; ++y)
    for (int x = centres.x; x < centres.x + centres.width; ++x)
      leaves.push_back(leaf(channel(cv::Rect(x - half, y - half, patch_size_, patch_size_))));
}

}  // namespace csd
