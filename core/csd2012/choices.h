// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "track/named_number.h"

namespace csd::csd2012 {

/// What the paper leaves open, and what was chosen; docs/method.md has the reasons. What the paper prints (the ranges
/// of the warps, Eq. 1 and its densities) is not here.
///
/// Pixels are working pixels of a picture of 480 to 576 lines; for fewer lines they shrink with the patch. All fields
/// are of one type, so that experiments set any by its name; counts are whole numbers, and a switch is 0 or 1.
struct Choices {
  // What the tests compare (§2.1.3, §2.2.1).
  double colour = 2;            ///< 0: intensity; the space of Eq. 7 that Eq. 5 puts first by its pixels: 1, by their
                                ///< differences: 2
  double smoothing = 2;         ///< σ of a Gaussian before the pixels are compared; 0: none
  double exhaustive = 0;        ///< 1: all pairs are tried at a node (§2.2.1)
  double smoke_as_printed = 0;  ///< 1: Eq. 1 with d and 1 − d as printed: more density is less smoke

  // The recursive start (§2.1).
  double max_lessons = 32;         ///< of a long training-time, evenly spread: the training set stays bounded
  double min_training_frames = 8;  ///< at low frame rates half a second holds too few

  // The training set of one frame (§2.1.2.1).
  double random_per_lesson = 40;
  double similar_per_lesson = 20;
  double min_similarity = 0.5;    ///< of the normalised cross correlation
  double similarity_radius = 40;  ///< 101 pixels with the patch
  double ignore_radius = 4;       ///< nothing nearer to the feature is a negative
  double near_radius = 12;        ///< a third of the random negatives come from within

  // Growing the tree (§2.2.1).
  double widest_test = 1;     ///< of tests of entropy 0: 0: the first by rank, 1: that of the largest Σ|P1 − P2|
  double top_pixels = 64;     ///< of the ranking, each with each
  double random_pairs = 512;  ///< and so many others
  double max_depth = 16;      ///< of a tree; samples may contradict each other
  double min_samples = 4;     ///< fewer are not divided

  // The paper's future work (§5): several trees,
  double trees = 1;
  double sample_share = 0.5;  ///< of the training set, for each of several trees

  // other appearance models, each with so many copies of a patch of the training set (csd2012/learn/appearance.h),
  double highlights = 0;
  double blurs = 0;
  double compressions = 0;

  // and co-training with the patch of the start, aligned.
  double co_training = 0;  ///< 1: where the patch fits, it corrects LK's place and the descriptor's
  double fits = 0.8;       ///< a ZNCC of at least so much
  double fit_reach = 6;    ///< and no farther from where it was aligned from

  // Evaluation while learning (§2.2.2).
  double learning_rounds = 8;
  double evaluation_grid = 4;    ///< every 4th position of every 4th line of the whole picture
  double errors_per_round = 32;  ///< of all false correspondences of a round, so many are learnt from

  // Tracking (§2.1.4).
  double search_radius = 20;
  double sigma_of_width = 1.0 / 128;  ///< the Gaussian's sigma as a share of the picture's width
  double widening = 0.04;             ///< s of absence after which the Gaussian's variance has doubled
  double widest_search = 2;           ///< of the search radius, while a feature is hidden
  /// Half the side of the square whose patches are taken together: the place is the middle of the best such cluster. 0:
  /// the patch with the largest weighted probability, of equal ones the nearest to the last place.
  double cluster_radius = 2;
  double min_probability = 0.05;  ///< weighted P(N) of the best patch, or their sum in the best cluster: less is hidden

  // The adaptive update (§2.1.5).
  double random_updates = 10;        ///< random negatives of a frame
  double false_updates = 10;         ///< at most so many of the patches of the window that are wrongly labelled feature
  double update_warps = 8;           ///< warps, drawn at random, of the feature's patch
  double recent_positives = 200;     ///< of the updates' positives, kept by each tree
  double negative_reservoir = 3000;  ///< of the updates' negatives
  double waiting_updates = 4;        ///< of one feature; with learning=async more are skipped
  double waiting_lessons = 32;       ///< training frames of one feature that may wait
};

/// csd-forest's, found on seed 1 with three pictures of real tissue as texture. docs/results/choices.md has what most
/// of them are worth on others.
Choices forest_choices();

std::span<const NamedNumber<Choices>> choice_fields();
/// Sets a field by "name=value". Throws std::invalid_argument with a text that names what is wrong.
void set(Choices &choices, std::string_view assignment);

}  // namespace csd::csd2012
