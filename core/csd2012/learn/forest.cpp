// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/forest.h"

#include <utility>

namespace csd {

Forest::Forest(std::vector<std::shared_ptr<const Tree>> trees) : trees_(std::move(trees)) {
  CV_Assert(!trees_.empty());
  for (const auto &tree : trees_) CV_Assert(tree->patch_size() == patch_size() && tree->space() == space());
}

void Forest::scan(const cv::Mat &channel, const cv::Rect &centres, int step, cv::Mat &probability) const {
  const auto steps = [step](int length) { return (length + step - 1) / step; };
  probability.create(steps(centres.height), steps(centres.width), CV_32FC1);
  probability = 0;
  cv::Mat votes(probability.size(), CV_32SC1, cv::Scalar(0));
  std::vector<std::int32_t> leaves;
  auto *p = probability.ptr<float>();
  auto *v = votes.ptr<std::int32_t>();
  for (const auto &tree : trees_) {
    tree->scan(channel, centres, leaves, step);
    for (std::size_t i = 0; i < leaves.size(); ++i)
      if (tree->is_feature(leaves[i])) {
        ++v[i];
        p[i] += static_cast<float>(tree->probability(leaves[i]));
      }
  }
  const auto n = static_cast<std::int32_t>(trees_.size());
  for (std::size_t i = 0; i < probability.total(); ++i) p[i] = 2 * v[i] > n ? p[i] / static_cast<float>(n) : 0;
}

double Forest::probability(const cv::Mat &patch) const {
  cv::Mat one;
  scan(patch, {patch.cols / 2, patch.rows / 2, 1, 1}, 1, one);
  return one.at<float>(0, 0);
}

}  // namespace csd
