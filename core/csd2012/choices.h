// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "base/named_number.h"

namespace csd::csd2012 {

/// What the paper leaves open, and what was chosen; docs/method.md has the reasons. What the paper prints (the ranges
/// of the warps, Eq. 1 and its densities) is not here.
///
/// Pixels are working pixels of a picture of 480 to 576 lines; below 480 lines they shrink with the patch. All fields
/// have one type, so that experiments can set any by name; counts are integers, switches 0 or 1.
struct Choices {
  // What the tests compare (§2.1.3, §2.2.1).
  double colour = 2;  ///< 0: intensity; 1: the space of Eq. 7 ranked first by Eq. 5 on pixels; 2: on their differences
  double smoothing = 2;         ///< σ of a Gaussian before the pixels are compared; 0: none
  double exhaustive = 0;        ///< 1: each node tries all pairs (§2.2.1)
  double smoke_as_printed = 0;  ///< 1: Eq. 1 with d and 1 − d as printed: more density is less smoke

  // The recursive start (§2.1).
  double max_lessons = 32;         ///< of a long training-time, evenly spaced: bounds the training set
  double min_training_frames = 8;  ///< at low frame rates half a second has too few

  // The training set of one frame (§2.1.2.1).
  double random_per_lesson = 40;
  double similar_per_lesson = 20;
  double min_similarity = 0.5;    ///< of the normalised cross correlation
  double similarity_radius = 40;  ///< 101 pixels with the patch
  double ignore_radius = 4;       ///< negatives keep this distance from the feature
  double near_radius = 12;        ///< a third of the random negatives lie within it

  // Growing the tree (§2.2.1).
  double widest_test = 1;     ///< among tests of entropy 0: 0: the first by rank, 1: the one of largest Σ|P1 − P2|
  double top_pixels = 64;     ///< of the ranking, paired with each other
  double random_pairs = 512;  ///< in addition
  double max_depth = 64;      ///< of a tree; samples may contradict each other
  double min_samples = 2;     ///< a node with fewer is not divided

  // The paper's future work (§5): several trees,
  double trees = 1;
  double sample_share = 0.5;  ///< of the training set, for each tree if there are several

  // other appearance models, each with this many copies of a patch of the training set (csd2012/learn/appearance.h),
  double highlights = 0;
  double blurs = 0;
  double compressions = 0;

  // and co-training with the aligned first patch.
  double co_training = 0;  ///< 1: where the patch fits, it corrects the positions of LK and of the descriptor
  double fits = 0.8;       ///< least ZNCC
  double fit_reach = 6;    ///< greatest distance from the start of the alignment

  // Evaluation while learning (§2.2.2).
  double learning_rounds = 8;
  double evaluation_grid = 4;    ///< every 4th position of every 4th line of the whole picture
  double errors_per_round = 32;  ///< of the false correspondences of a round, learned from

  // Tracking (§2.1.4).
  double search_radius = 20;
  double sigma_of_width = 1.0 / 128;  ///< the Gaussian's sigma as a share of the picture's width
  double widening = 0.04;             ///< s of absence that double the Gaussian's variance
  double widest_search = 2;           ///< times the search radius, while a feature is hidden
  /// Half the side of a square cluster of patches: the position is the centre of the best cluster. 0: the patch with
  /// the largest weighted probability, among equals the nearest to the last position.
  double cluster_radius = 2;
  double own_patches = 16;     ///< the newest of a leaf, with which a patch that reaches it is compared
  double likeness_power = 32;  ///< P(N) counts times the likeness to these, to this power; 0: alone
  /// Weighted P(N) of the best patch, or sum over the best cluster; below, the feature is hidden.
  double min_probability = 0.0001;
  double refind_probability = 0.05;  ///< the same of a feature that was hidden in the frame before

  // The adaptive update (§2.1.5).
  double random_updates = 10;        ///< random negatives per frame
  double false_updates = 10;         ///< patches of the window wrongly labelled feature, at most
  double update_warps = 8;           ///< random warps of the feature's patch
  double recent_positives = 200;     ///< of the updates' positives, kept by each tree
  double negative_reservoir = 3000;  ///< of the updates' negatives
  double waiting_updates = 4;        ///< of one feature; with learning=async any more are skipped
  double waiting_lessons = 32;       ///< training frames of one feature in the queue
};

/// csd-forest's, chosen on seed 1 with three pictures of real tissue as texture. docs/results/choices.md tests most of
/// them on other pictures.
Choices forest_choices();

std::span<const NamedNumber<Choices>> choice_fields();
/// Sets a field by "name=value". Throws std::invalid_argument whose text names the error.
void set(Choices &choices, std::string_view assignment);

}  // namespace csd::csd2012
