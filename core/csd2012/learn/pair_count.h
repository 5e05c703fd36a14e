// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "csd2012/learn/entropy.h"
#include "csd2012/learn/node_samples.h"
#include "csd2012/learn/pixel_pair.h"

namespace csd {

/// Divides the node's samples by each of `pairs` (Eq. 2) and counts both classes; counts.size() ≥ pairs.size(). Runs on
/// the machine's best SIMD target; the result is the same on every target.
void count_pairs(const NodeSamples &node, std::span<const PixelPair> pairs, std::span<SplitCounts> counts);
/// The same without SIMD.
void count_pairs_scalar(const NodeSamples &node, std::span<const PixelPair> pairs, std::span<SplitCounts> counts);

/// Σ |P1 − P2| over the node's samples: how far a test is from a tie.
std::uint64_t sum_of_differences(const NodeSamples &node, PixelPair pair);

}  // namespace csd
