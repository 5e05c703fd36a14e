// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "csd2012/learn/pair_search.h"
#include "csd2012/learn/sample_set.h"
#include "csd2012/learn/tree.h"
#include "image/colour_space.h"

namespace csd {

/// When a node with both classes becomes a leaf. (A pure or empty one always does, §2.2.1; these rules are for
/// contradictory samples.)
struct StopRules {
  int max_depth = 16;           ///< the root has depth 0
  std::size_t min_samples = 4;  ///< a node with fewer is not divided
  double min_gain = 1e-6;       ///< of entropy (Eq. 3, bits times samples)
};

struct GrowthOptions {
  PairSearchOptions search;
  StopRules stop;
  std::size_t own_patches = 0;      ///< the newest patches labelled feature that each leaf shows to others; 0: none
  std::size_t max_nodes = 1 << 14;  ///< with more, and with more than four per sample, retrain() rebuilds the tree
  std::uint64_t seed = 1;           ///< of the random pairs
  std::uint64_t stream = 0;         ///< also of them, e.g. the feature's id
};

/// A context specific descriptor while it learns (§2.2): the training set S, its ID3 tree, and the samples in each
/// leaf. Belongs to one thread; any thread may read the published trees.
///
/// At first the tree is one leaf. Usual sequence: add() samples, build(), then repeatedly publish(), evaluate the
/// published tree on the current frame, add() the misclassified patches, retrain() (§2.2.2).
class GrowingTree {
 public:
  /// `space`: of the patches' channel; passed on to the published trees.
  GrowingTree(int patch_size, const ColourSpace &space, const GrowthOptions &options);

  const ColourSpace &space() const { return space_; }
  const SampleSet &samples() const { return set_; }

  /// Adds a patch (patch_size², CV_8UC1) to S and to the distribution of its leaf; no test changes (§2.1.5). Throws
  /// cv::Exception on a patch of another size or type.
  SampleId add(const cv::Mat &patch, Label label);
  /// Removes a sample from S and from its leaf's distribution, and puts another into its slot.
  void replace(SampleId id, const cv::Mat &patch, Label label);
  void remove(SampleId id);

  /// Whether the sample's leaf has the other label.
  bool misclassified(SampleId id) const;
  /// The label that the tree gives a patch.
  Label classify(const cv::Mat &patch) const;

  /// Rebuilds the whole tree from S by ID3.
  void build();
  /// Replaces each leaf that holds one of `samples` and errs by a subtree grown on all its samples (§2.2.2: "only the
  /// leaf nodes responsible"). A leaf with both classes misclassifies its minority, which may be the feature itself,
  /// outnumbered by the patches just added. Returns the number of leaves replaced. A leaf that the stop rules keep
  /// whole stays. Removed samples leave their nodes behind: above the limit it calls build(). (A feature tracked at 25
  /// Hz had 2100 nodes at first, 4000 after half an hour, then 30 more a minute.)
  int retrain(std::span<const SampleId> samples);
  /// Number of leaves that retrain() has replaced.
  std::uint64_t retrainings() const { return retrainings_; }

  std::size_t node_count() const { return nodes_.size(); }

  /// A copy of the current tree.
  std::shared_ptr<const Tree> publish() const;

 private:
  struct Node {
    PixelPair test;
    std::int32_t first_child = -1;  ///< −1: leaf
    int depth = 0;
    std::uint32_t feature = 0;                            ///< leaf: number of `samples` labelled feature
    std::vector<SampleId> samples;                        ///< leaf: unordered
    mutable std::shared_ptr<const LeafPatches> own = {};  ///< made by publish(); null when its samples have changed
  };
  struct Place {
    std::int32_t leaf = -1;
    std::uint32_t index = 0;  ///< in the leaf's samples
  };

  bool leaf_says_feature(const Node &leaf) const { return 2 * std::size_t{leaf.feature} > leaf.samples.size(); }
  std::int32_t drop(const std::uint8_t *patch) const;
  void put(SampleId id, std::int32_t leaf);
  void take(SampleId id);
  bool grow(std::int32_t leaf);
  std::shared_ptr<const LeafPatches> own_patches(const Node &leaf) const;

  SampleSet set_;
  ColourSpace space_;
  GrowthOptions options_;
  std::vector<Node> nodes_;
  std::vector<Place> places_;       ///< by sample
  std::vector<std::uint64_t> age_;  ///< by sample: how many were added before it
  std::uint64_t added_ = 0;
  std::uint64_t growths_ = 0;
  std::uint64_t retrainings_ = 0;
};

}  // namespace csd
