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

/// When a node becomes a leaf though it holds both classes. (A pure or empty one always does, §2.2.1; these are for
/// samples that contradict each other.)
struct StopRules {
  int max_depth = 16;           ///< the root has depth 0
  std::size_t min_samples = 4;  ///< fewer are not divided
  double min_gain = 1e-6;       ///< of entropy (Eq. 3, bits times samples)
};

struct GrowthOptions {
  PairSearchOptions search;
  StopRules stop;
  std::size_t max_nodes = 1 << 14;  ///< with more, and more than four a sample, retrain() learns the whole tree anew
  std::uint64_t seed = 1;           ///< of the random pairs
  std::uint64_t stream = 0;         ///< the same, e.g. the feature's id
};

/// A context specific descriptor while it learns (§2.2): the training set S, the ID3 tree on it, and in each leaf the
/// samples that ended there. Belongs to one thread; what it publishes may be read by all.
///
/// At first the tree is one leaf. The usual course: add() samples, build(), then again and again publish(), evaluate
/// the published tree on the current frame, add() what it got wrong, retrain() (§2.2.2).
class GrowingTree {
 public:
  /// `space`: what the patches' channel is; only passed on to what is published.
  GrowingTree(int patch_size, const ColourSpace &space, const GrowthOptions &options);

  const ColourSpace &space() const { return space_; }
  const SampleSet &samples() const { return set_; }

  /// Puts a patch (patch_size², CV_8UC1) into S and drops it down the tree: it counts in its leaf's distribution; no
  /// test changes (§2.1.5). Throws cv::Exception on a patch of another size or type.
  SampleId add(const cv::Mat &patch, Label label);
  /// Takes a sample out of S and of its leaf's distribution, and puts another into its slot.
  void replace(SampleId id, const cv::Mat &patch, Label label);
  void remove(SampleId id);

  /// Whether the sample's leaf has the other label.
  bool misclassified(SampleId id) const;
  /// What the tree calls a patch.
  Label classify(const cv::Mat &patch) const;

  /// Learns the whole tree anew from S by ID3.
  void build();
  /// Grows a subtree, on all samples that it holds, in the place of each leaf that one of `samples` ended in and that
  /// errs (§2.2.2: "only the leaf nodes responsible"): one that holds both classes calls the fewer by the wrong name,
  /// and be they the feature itself, outnumbered by the patches just added. Returns how many leaves it replaced. A leaf
  /// that the stop rules do not let divide stays. Samples go in time, nodes don't: with too many it is build() in the
  /// end. (Of a feature followed at 25 Hz there were 2100 at first, 4000 after half an hour, then 30 more a minute.)
  int retrain(std::span<const SampleId> samples);
  /// Leaves that retrain() has replaced since the beginning.
  std::uint64_t retrainings() const { return retrainings_; }

  std::size_t node_count() const { return nodes_.size(); }

  /// The tree as it is now.
  std::shared_ptr<const Tree> publish() const;

 private:
  struct Node {
    PixelPair test;
    std::int32_t first_child = -1;  ///< −1: leaf
    int depth = 0;
    std::uint32_t feature = 0;      ///< leaf: how many of `samples` are labelled feature
    std::vector<SampleId> samples;  ///< leaf: in no particular order
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

  SampleSet set_;
  ColourSpace space_;
  GrowthOptions options_;
  std::vector<Node> nodes_;
  std::vector<Place> places_;  ///< by sample
  std::uint64_t growths_ = 0;
  std::uint64_t retrainings_ = 0;
};

}  // namespace csd
