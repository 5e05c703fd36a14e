// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/forest.h"

#include <cmath>
#include <utility>

namespace csd {

namespace {

/// Row by row without gaps, as LeafPatches takes it.
void copy_patch(const cv::Mat &channel, cv::Point corner, int side, std::vector<std::uint8_t> &out) {
  out.clear();
  for (int row = 0; row < side; ++row) {
    const std::uint8_t *pixels = channel.ptr(corner.y + row) + corner.x;
    out.insert(out.end(), pixels, pixels + side);
  }
}

}  // namespace

Forest::Forest(std::vector<std::shared_ptr<const Tree>> trees) : trees_(std::move(trees)) {
  CV_Assert(!trees_.empty());
  for (const auto &tree : trees_) CV_Assert(tree->patch_size() == patch_size() && tree->space() == space());
}

void Forest::scan(const cv::Mat &channel, const cv::Rect &centres, int step, cv::Mat &probability,
                  double likeness_power) const {
  const auto steps = [step](int length) { return (length + step - 1) / step; };
  probability.create(steps(centres.height), steps(centres.width), CV_32FC1);
  probability = 0;
  std::vector<std::vector<std::int32_t>> leaves(trees_.size());
  std::vector<std::size_t> votes(probability.total(), 0);
  for (std::size_t t = 0; t < trees_.size(); ++t) {
    trees_[t]->scan(channel, centres, leaves[t], step);
    for (std::size_t i = 0; i < votes.size(); ++i) votes[i] += trees_[t]->is_feature(leaves[t][i]);
  }
  const int half = patch_size() / 2;
  std::vector<std::uint8_t> patch;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (2 * votes[i] <= trees_.size()) continue;
    if (likeness_power > 0) {
      const auto width = static_cast<std::size_t>(probability.cols);
      const cv::Point at(static_cast<int>(i % width), static_cast<int>(i / width));
      copy_patch(channel, centres.tl() + step * at - cv::Point(half, half), patch_size(), patch);
    }
    double sum = 0;
    for (std::size_t t = 0; t < trees_.size(); ++t) {
      const Tree &tree = *trees_[t];
      const std::int32_t leaf = leaves[t][i];
      if (!tree.is_feature(leaf)) continue;
      const double alike = likeness_power > 0 ? std::pow(tree.likeness(leaf, patch.data()), likeness_power) : 1;
      sum += tree.probability(leaf) * alike;
    }
    probability.ptr<float>()[i] = static_cast<float>(sum / static_cast<double>(trees_.size()));
  }
}

double Forest::probability(const cv::Mat &patch) const {
  cv::Mat one;
  scan(patch, {patch.cols / 2, patch.rows / 2, 1, 1}, 1, one);
  return one.at<float>(0, 0);
}

}  // namespace csd
