// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/pair_search.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace csd {

PairChoice PairFinder::find(const NodeSamples &node, const Entropy &entropy, const LogTable &log, Random &random) {
  best_.reset();
  best_difference_.reset();
  if (options_.search == PairSearch::ranked) {
    list_ranked(node, log, random);
    evaluate(node, entropy, options_.stop_at_zero);
  } else {
    const auto pixels = static_cast<std::uint16_t>(node.pixels());
    for (std::uint16_t i = 0; i + 1 < pixels; ++i) {
      pairs_.clear();
      for (auto j = static_cast<std::uint16_t>(i + 1); j < pixels; ++j) pairs_.push_back({i, j});
      evaluate(node, entropy, false);
    }
  }
  return best_.value_or(PairChoice{});
}

void PairFinder::list_ranked(const NodeSamples &node, const LogTable &log, Random &random) {
  variance_ratios(node, log, v_);
  rank_pixels(v_, options_.top_pixels, ranked_);
  pairs_.clear();
  for (std::size_t j = 1; j < ranked_.size(); ++j)
    for (std::size_t i = 0; i < j; ++i)
      pairs_.push_back({std::min(ranked_[i], ranked_[j]), std::max(ranked_[i], ranked_[j])});
  const auto pixels = static_cast<std::uint32_t>(node.pixels());
  for (std::size_t k = 0; k < options_.random_pairs; ++k) {
    // Uniform over pairs of two different pixels.
    const std::uint32_t a = random.below(pixels), other = random.below(pixels - 1);
    const std::uint32_t b = other < a ? other : other + 1;
    pairs_.push_back({static_cast<std::uint16_t>(std::min(a, b)), static_cast<std::uint16_t>(std::max(a, b))});
  }
}

void PairFinder::evaluate(const NodeSamples &node, const Entropy &entropy, bool stop_at_zero) {
  constexpr std::size_t block = 64;  // pairs counted between checks for an early exit
  counts_.resize(block);
  for (std::size_t first = 0; first < pairs_.size(); first += block) {
    const auto some = std::span(pairs_).subspan(first, std::min(block, pairs_.size() - first));
    count_pairs(node, some, counts_);
    for (std::size_t i = 0; i < some.size(); ++i) {
      const double h = entropy.of(counts_[i]);
      if (best_ && h > best_->entropy) continue;
      const PairChoice candidate{some[i], h, counts_[i]};
      if (!best_ || h < best_->entropy) {
        best_ = candidate;
        best_difference_.reset();
        if (stop_at_zero && h == 0) return;
        continue;
      }
      if (!best_difference_) best_difference_ = sum_of_differences(node, best_->pair);
      const std::uint64_t difference = sum_of_differences(node, candidate.pair);
      const bool smaller = std::tie(candidate.pair.p1, candidate.pair.p2) < std::tie(best_->pair.p1, best_->pair.p2);
      if (difference > *best_difference_ || (difference == *best_difference_ && smaller)) {
        best_ = candidate;
        best_difference_ = difference;
      }
    }
  }
}

}  // namespace csd
