// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <memory>
#include <vector>

#include "csd2012/learn/leaf_patches.h"
#include "image/colour_space.h"

namespace csd {

/// The context specific descriptor of §2.1.3 for tracking: a decision tree whose nodes compare two pixels of a patch
/// (Eq. 2) and whose leaves have a label and a distribution. Immutable, so any thread may read it.
///
/// The node table is in breadth-first order, root first. An inner node's three children (P1 > P2, P1 = P2, P1 < P2) are
/// consecutive. A leaf compares pixel 0 with itself and is its own "equal" child, so evaluation needs no branch.
class Tree {
 public:
  struct Node {
    std::uint16_t p1 = 0, p2 = 0;   ///< pixel indices, row by row in the patch
    std::int32_t first_child = -1;  ///< leaf i: i − 1
    std::uint32_t feature = 0;      ///< leaf: its samples labelled feature, |a|
    std::uint32_t not_feature = 0;  ///< leaf: its samples labelled not a feature
  };

  /// The leaves' own patches, by node; null for an inner node and for a leaf labelled not a feature.
  using LeavesPatches = std::vector<std::shared_ptr<const LeafPatches>>;

  /// `nodes` as described above. `depth`: comparisons on the longest path from the root to a leaf. `own`: one for each
  /// node, or none at all.
  Tree(int patch_size, const ColourSpace &space, std::vector<Node> nodes, int depth, LeavesPatches own = {});

  int patch_size() const { return patch_size_; }
  /// Colour space of the channel that the tree was learnt on (§2.2.1: one for the whole tree).
  const ColourSpace &space() const { return space_; }
  const std::vector<Node> &nodes() const { return nodes_; }
  int depth() const { return depth_; }
  /// |b|: samples labelled feature in all leaves.
  std::uint32_t features() const { return features_; }

  /// The leaf of a patch_size × patch_size CV_8UC1 patch. Throws cv::Exception on another size or type.
  std::int32_t leaf(const cv::Mat &patch) const;

  /// A leaf's label: its majority; not a feature if it is empty or tied.
  bool is_feature(std::int32_t leaf) const {
    const Node &n = nodes_[static_cast<std::size_t>(leaf)];
    return n.feature > n.not_feature;
  }
  /// P(N) = |a|·|b|⁻¹ (§2.1.4); 0 if |b| is 0.
  double probability(std::int32_t leaf) const {
    return features_ ? static_cast<double>(nodes_[static_cast<std::size_t>(leaf)].feature) / features_ : 0.0;
  }

  /// How alike a patch (row by row without gaps) is to the leaf's own patches; 0 if it has none.
  double likeness(std::int32_t leaf, const std::uint8_t *patch) const {
    const auto at = static_cast<std::size_t>(leaf);
    return at < own_.size() && own_[at] ? own_[at]->likeness(patch) : 0;
  }

  /// The leaves of the patches around each `step`-th pixel of each `step`-th row of `centres`, row by row, into
  /// `leaves` (resized to their number). `channel`: CV_8UC1 in the tree's colour space; it must contain the patches
  /// (throws cv::Exception). 16 patches descend the tree in lock-step: 1.8 times as fast as one by one.
  void scan(const cv::Mat &channel, const cv::Rect &centres, std::vector<std::int32_t> &leaves, int step = 1) const;
  /// The same one by one, for tests to compare with.
  void scan_plain(const cv::Mat &channel, const cv::Rect &centres, std::vector<std::int32_t> &leaves) const;

 private:
  int patch_size_;
  ColourSpace space_;
  std::vector<Node> nodes_;
  int depth_;
  LeavesPatches own_;
  std::uint32_t features_ = 0;
};

}  // namespace csd
