// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "content/glare_weights.h"
#include "patch/align.h"
#include "track/named_number.h"
#include "track/types.h"

namespace csd {

/// Every number that `csd` decides by. (What bounds the arithmetic of one alignment is core/patch's own.)
///
/// Units: "px" are pixels of a 480-line picture; "samples" those of a patch, 21 to a side; rates are those of a frame
/// of 40 ms; times are in seconds. All fields are of one type, so that ablation, fit and experiments set any by its
/// name; counts are whole numbers, and a switch is 0 or 1. Where no reason is given, it comes from the study
/// that preceded this code.
struct Tuning {
  // Looking for a patch: look.cpp.
  double shape_deviation = 0.03;    ///< sd of each element of A₀⁻¹A − 1, in a frame
  double shape_pull = 0.3;          ///< towards the neighbours' shape before looking, in a frame
  double coarse_information = 0.6;  ///< of the coarser level's, as the finer level's prior: they see the same pixels
  double levels_first = 1;          ///< coarser levels of the first look
  double levels_again = 2;          ///< of the second, which may have farther to go
  double levels_inner = 1;          ///< of the look at the inner disc
  double looks_again = 2;           ///< second looks: 2: the patch, then its inner disc; 1: the patch alone; 0: none
  double affine = 1;                ///< 1: the finest level may shear; 0: turn and zoom alone
  double query_precision = fine_precision;  ///< samples left when a user's point is found: below, noise decides
  double support_precision =
      csd::support_precision;  ///< of a supporting point: one of many in a map, whose spread is .5 px at least
  double coarse_precision = csd::coarse_precision;  ///< of a coarser level: the finer one goes on from there
  double inner_reach = 5;     ///< samples, radius of the inner disc: where a tool or its shadow has come near
  double min_anchor = 0.4;    ///< unmasked share of the level that is aligned last
  double calm_miss = 1.5;     ///< px that the finest level finds its way over by itself
  double faded = -0.3;        ///< change of ln gain from which the coarser level is asked too: blur()
  double blurred_zncc = 0.5;  ///< below, what is seen is something else, not the same blurred

  // What is seen well: judgement.cpp.
  double sure_zncc = 0.6;      ///< of what maps may stand on
  double sure_inliers = 0.5;   ///< the same
  double sure_unmasked = 0.3;  ///< the same
  double alone_zncc = 0.8;     ///< to be found again without neighbours
  double min_unmasked = 0.1;   ///< of what is reported at all

  // Told apart: what has no look-alike where the neighbours point needs not their word.
  double apart_zncc = 0.8;          ///< of both levels
  double apart_inliers = 0.6;       ///< of the fine one
  double apart_margin = 0.1;        ///< ZNCC above the best look-alike's
  double alike_reach = 4;           ///< samples about the place in which a look-alike counts: as much,
  double alike_per_spread = 0.5;    ///< so much for each px of the neighbours' disagreement with each other,
  double alike_per_distance = 0.2;  ///< and so much for each of theirs with the point
  double likeness_nearest = 4;      ///< samples, radius of the innermost of five rings
  double likeness_step = 2.5;       ///< samples from ring to ring
  double likeness_far = 9;          ///< samples, from which a look-alike is another place
  double likeness_weight = 40;      ///< pixels: of what is mostly masked nothing is known
  /// Of what detection begins: LookAlikes. Points on an edge slide along it: on cholecystectomy.mp4 12 % of the claims
  /// that a palindrome compares were apart, with this 3 %; on smoke.mp4 80 % of the samples are claimed, not 72 %.
  double max_likeness = 0.9;

  // The neighbours' veto, and their pull: judgement.cpp.
  double min_judges = 5;        ///< neighbours that may overrule a point
  double gate_floor = 1;        ///< px of disagreement that are always allowed,
  double gate_deviations = 2;   ///< so much for each px of the offset's own sd,
  double gate_spreads = 1;      ///< and for each px of the map's spread
  double max_distortion = 0.3;  ///< of the shape, against the neighbours'
  double min_own_motion = 0.2;  ///< px, sd of a point beside its neighbours from one frame to another: as much,
  double own_motion_of_deviation = 0.3;  ///< so much of its usual deviation,
  double own_motion_of_spread = 0.2;     ///< and so much of the neighbours' disagreement
  /// sd of where the neighbours put a point, of the sum of its and their deviations. With all of it faint patches slid
  /// away from where the neighbours had put them rightly.
  double expected_share = 0.7;

  // What a point keeps: memory.cpp, tracked_point.cpp.
  double anchor_samples = 14;  ///< of the training time, at most 16, the first one among them
  double good_zncc = 0.75;     ///< of a frame that offsets and gains learn from
  double usual_rate = 0.1;     ///< of the running means of gain, noise and brightness
  double finer_scale = 0.8;    ///< scale of a finer level when it is taken
  double finer_zncc = 0.85;    ///< and how well the point must be seen then
  double finer_inliers = 0.7;  ///< the same
  double half_life = 100;      ///< frames, of belief in what nobody looks at
  double fast = 1;             ///< px in a frame: faster points are looked at first
  double rest_miss = 1;        ///< px: where a supporting point goes as expected
  double rest_spread = 1;      ///< px: and its neighbours agree, half of a map's points are as good as all of them

  // The neighbours' map: neighbour_map.cpp.
  double min_reach = 45;           ///< px, sd of the weights by distance,
  double reach_per_fifth = 0.7;    ///< or so much of the distance of the fifth nearest
  double floor_weight = 0.01;      ///< of the farthest, lest a map stand on one point
  double ridge = 60;               ///< px², towards the similarity
  double min_spread = 0.5;         ///< px: what points' own places are worth
  double spread_per_median = 1.5;  ///< spread, of the residuals' median
  double max_spread = 8;           ///< px: points that don't agree on anything make no map
  double outlier = 2.5;            ///< spreads at which a point counts a quarter
  double settled = 0.005;          ///< change of a weight, of at most 1: the next round would change nothing
  double nearby_margin = 1.3;      ///< of a squared distance: some points will not be sure in the next frame
  // A point's offset from it.
  double slowest = 0.02;       ///< of what a frame adds to the running means
  double min_deviation = 0.3;  ///< px, of the offset
  double max_deviation = 2;    ///< px
  double usual_offset = 1;     ///< px, sd of what tissue has beside its neighbours' motion
  double max_offset = 6;       ///< px

  // Supporting points: support_points.cpp.
  double cell_side = 32;         ///< px: 20 × 15 cells at 640 × 480, one point in each
  double max_cells = 1200;       ///< of a picture that is very wide or very high
  double max_in_cell = 2;        ///< when a zoom out has crowded them
  double max_points = 1200;      ///< out of the picture
  double min_distance = 14.4;    ///< px, of a new point from the others
  double gap = 30;               ///< px, the same when others have been there for a while
  double edge = 8;               ///< px, of a new point from the picture's edge
  double quality = 0.003;        ///< of the picture's best corner
  double min_eigenvalue = 0.05;  ///< a mean slope of .1 grey levels a pixel; less is noise
  double corner_window = 7;      ///< pixels of level 1
  double clear_weight = 230;     ///< of 255: no highlight near
  double avoid_tools = 1;        ///< 1: none begins on what colour says is a tool
  double min_agreeing = 5;       ///< points that make a motion believed after none was known
  double replenish_every = 0.5;  ///< s
  double new_chart_after = 1;    ///< s without any point: the scene is another
  double trial = 0.5;            ///< s: a new point's, before its neighbours believe it: it may lie on a tool
  double trial_deviation = 1.5;  ///< px, of its offset, at most
  double young_lost_for = 0.5;   ///< s, until one on trial is dropped
  double lost_for = 10;          ///< s, until another is
  /// Frames, for what is hidden while enough others are seen. With 2 the six real clips take a sixth less time, and
  /// .003 less is claimed and .002 less apart; with 4 a fifth, and .008.
  double search_every = 2;

  // The frame budget: steps.cpp, csd.cpp.
  double min_looks = 24;       ///< at supporting points, whatever the budget
  double min_at_visible = 18;  ///< of them at such as were visible; the others find again what comes back
  double more_looks = 96;      ///< where fewer than a map stands on are seen, lest the scene seem to be gone
  double support_share = 0.5;  ///< of the budget, from its begin, for supporting points
  double query_share = 0.85;   ///< until users' points have been looked at; the rest is for anchors
  double first_looks = 0.6;    ///< of a part: first looks
  double max_steps = 10;       ///< frames: after a longer gap nothing is known ahead

  // Finding a scene again: recall.cpp.
  double max_scenes = 4;            ///< that are kept
  double usual_share = 0.7;         ///< of the usual points and contrast, from which a frame is kept
  double scene_rate = 0.02;         ///< of that running mean
  double try_every = 0.12;          ///< s
  double try_at_least_every = 5;    ///< s
  double tries_while_gone = 0.01;   ///< the next try comes after this share of the time since it was seen
  double settles = 10;              ///< s: what is seen then is another scene for good, and is left alone
  double handful = 0.1;             ///< of the points of a scene: that few may be chance likenesses
  double min_contrast = 3;          ///< grey levels, sd of the coarsest level: black and a covered lens have less
  double recalled_spread = 8;       ///< px, of what a similarity of the whole picture puts somewhere
  double max_keypoints = 500;       ///< of half the picture
  double stretched = 40;            ///< grey levels, sd of the picture that keypoints are looked for in
  double keypoint_contrast = 0.01;  ///< at Lowe's threshold tissue has few keypoints
  double match_ratio = 0.8;         ///< Lowe's
  double min_matches = 8;           ///< that agree on a similarity
  double match_tolerance = 6;       ///< px of half the picture: a heart moves as far
  double max_zoom = 4;              ///< nobody zooms as far in a cut

  // Whom to believe: visibility.cpp. The weights are fitted by tests/bench/fit to real tissue: docs/method.md,
  // "Evidence".
  double weigh_one = 2.01;
  double weigh_fine = 0.69;
  double weigh_coarse = 0.97;
  double weigh_unmasked = 2.85;
  double weigh_centre = 0.45;
  double weigh_dim = -0.61;
  double weigh_noise = -1.86;
  double weigh_brighter = -3.29;
  double weigh_darker = -1.50;
  double weigh_likeness = -2.43;
  double weigh_unknown = -1.73;
  double weigh_contrast = -0.42;
  double weigh_disagreement = -1.39;
  double dim_from = 0.7;        ///< loss of ln contrast that light and distance bring
  double noisy = 8;             ///< grey levels: more noise says no more
  double other_light = 64;      ///< grey levels: more of a change says no more
  double min_likeness = 0.5;    ///< less says no more
  double max_disagreement = 6;  ///< more says no more
  double probability = 1;       ///< 1: the regression; 0: what is sure is believed
  double max_blur = 0.15;       ///< ln of contrast, of which a lens is too wet: patches fit, and all is hidden
  double highlight =
      GlareWeights::usual_highlight;  ///< of the room above its surroundings that makes a highlight; 2: none
  double claim_all = 0;               ///< 1: claims every point in every frame: a bound for the ablation, no tracker
};

/// All fields, in the struct's order.
std::span<const NamedNumber<Tuning>> tuning_fields();
/// Sets a field by "name=value". Throws std::invalid_argument with a text that names what is wrong.
void set(Tuning &tuning, std::string_view assignment);

inline constexpr Tuning default_tuning{};

/// A count, and a time in ns.
constexpr std::size_t count(double field) {
  return static_cast<std::size_t>(field);
}
constexpr std::int64_t nanoseconds(double seconds) {
  return static_cast<std::int64_t>(seconds * static_cast<double>(second));
}

}  // namespace csd
