// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

#include "track/types.h"

/// Where the paper gives no number, csd-2012 uses these (docs/method.md lists them with their reasons; A.. are the rows
/// of that list). Pixels are working pixels of a picture of 480 to 576 lines; for fewer lines they shrink with the
/// patch.
namespace csd::csd2012 {

// The recursive start (§2.1).
inline constexpr int most_lessons = 32;  ///< of a long training-time, evenly spread: the training set stays bounded
inline constexpr int least_training_frames = 8;  ///< A7: at low frame rates half a second holds too few

// The training set of one frame (§2.1.2.1).
inline constexpr int random_per_lesson = 40;     ///< A8
inline constexpr int similar_per_lesson = 20;    ///< A8
inline constexpr double least_similarity = 0.5;  ///< A9
inline constexpr int similarity_radius = 40;     ///< A9: 101 pixels with the patch
inline constexpr double ignore_radius = 4;       ///< A10
inline constexpr double near_radius = 12;        ///< A10

// Evaluation while learning (§2.2.2).
inline constexpr int learning_rounds = 8;    ///< A34
inline constexpr int evaluation_grid = 4;    ///< A34: every 4th position of every 4th line of the whole picture
inline constexpr int errors_per_round = 32;  ///< of all false correspondences of a round, so many are learnt from

// Tracking (§2.1.4).
inline constexpr int search_radius = 20;            ///< A27
inline constexpr double sigma_of_width = 1.0 / 64;  ///< A26: the Gaussian's sigma as a share of the picture's width
inline constexpr double widening =
    second / 25.0;                          ///< A26: ns of absence after which the Gaussian's variance has doubled
inline constexpr double widest_search = 2;  ///< A27: of the search radius, while a feature is hidden
inline constexpr std::int64_t anywhere_after = second;  ///< A26, A27: then a feature is looked for in the whole picture
inline constexpr int coarse_step = 2;                   ///< A27: every 2nd position, then all around those found
inline constexpr int whole_pictures_per_frame = 2;  ///< lost features take turns: 50 of them would cost 100 ms a frame

// The adaptive update (§2.1.5).
inline constexpr int random_updates = 10;           ///< A32: random negatives each frame
inline constexpr int false_updates = 10;            ///< A32: at most so many of the false correspondences in the window
inline constexpr int recent_positives = 200;        ///< A31: ring
inline constexpr int negative_reservoir = 3000;     ///< A31
inline constexpr std::size_t waiting_updates = 4;   ///< of one feature; with learning=async more are skipped
inline constexpr std::size_t waiting_lessons = 32;  ///< training frames of one feature that may wait

}  // namespace csd::csd2012
