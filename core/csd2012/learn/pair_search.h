// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/random.h"
#include "csd2012/learn/pair_count.h"
#include "csd2012/learn/pixel_ranking.h"

namespace csd {

/// How a node's test is searched for (§2.2.1).
enum class PairSearch : std::uint8_t {
  ranked,     ///< among the pixels of highest variance ratio, and some random pairs
  exhaustive  ///< all pairs
};

struct PairSearchOptions {
  PairSearch search = PairSearch::ranked;
  std::size_t top_pixels = 64;     ///< ranked: this many pixels, paired with each other
  std::size_t random_pairs = 512;  ///< ranked: in addition; V rates intensity, not order, and may miss a pair
  bool stop_at_zero = true;        ///< ranked: take the first test of entropy 0, by rank
};

/// A node's test and how it divides the node's samples.
struct PairChoice {
  PixelPair pair;
  double entropy = 0;  ///< Σ of Eq. 3 over the three subsets
  SplitCounts counts;
};

/// Finds the test of least entropy; among equals the one of larger Σ|P1−P2|, then of smaller (p1,p2). Reuses its memory
/// from node to node; not thread safe.
class PairFinder {
 public:
  explicit PairFinder(const PairSearchOptions &options) : options_(options) {}

  /// `random` draws the random pairs. `entropy` and `log` must cover node.size().
  PairChoice find(const NodeSamples &node, const Entropy &entropy, const LogTable &log, Random &random);

 private:
  void list_ranked(const NodeSamples &node, const LogTable &log, Random &random);
  /// Evaluates pairs_ and updates best_.
  void evaluate(const NodeSamples &node, const Entropy &entropy, bool stop_at_zero);

  PairSearchOptions options_;
  std::vector<double> v_;
  std::vector<std::uint16_t> ranked_;
  std::vector<PixelPair> pairs_;
  std::vector<SplitCounts> counts_;
  std::optional<PairChoice> best_;
  std::optional<std::uint64_t> best_difference_;  ///< Σ|P1−P2| of best_, computed on demand
};

}  // namespace csd
