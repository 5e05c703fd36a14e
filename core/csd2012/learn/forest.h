// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <memory>
#include <vector>

#include "csd2012/learn/tree.h"

namespace csd {

/// Descriptors of one feature that vote (§5, "multiple decision trees"). The paper's is a forest of one. Immutable,
/// like its trees.
class Forest {
 public:
  /// At least one tree; all with one patch size and colour space. Throws cv::Exception otherwise.
  explicit Forest(std::vector<std::shared_ptr<const Tree>> trees);

  int patch_size() const { return trees_.front()->patch_size(); }
  const ColourSpace &space() const { return trees_.front()->space(); }
  const std::vector<std::shared_ptr<const Tree>> &trees() const { return trees_; }

  /// Classifies the patches around each `step`-th pixel of each `step`-th row of `centres`. `probability` becomes
  /// CV_32FC1: where more than half of the trees say feature, the mean of their P(N) (§2.1.4; a tree that disagrees
  /// counts as 0), each times its leaf's likeness to the power of `likeness_power` (0: not); else 0. `channel` as in
  /// Tree::scan().
  void scan(const cv::Mat &channel, const cv::Rect &centres, int step, cv::Mat &probability,
            double likeness_power = 0) const;
  /// The same for one patch of patch_size², CV_8UC1.
  double probability(const cv::Mat &patch) const;

 private:
  std::vector<std::shared_ptr<const Tree>> trees_;
};

}  // namespace csd
