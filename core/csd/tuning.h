// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "base/named_number.h"
#include "base/types.h"
#include "content/glare_weights.h"
#include "patch/align.h"

namespace csd {

/// All constants of `csd`'s decisions. (Those of a single alignment are in core/patch.)
///
/// Units: "px" are pixels of a 480-line picture, "samples" those of a patch, 21 to a side. Rates are per frame of 40
/// ms; times are in seconds. All fields have one type, so that ablation, fit and experiments can set any by name;
/// counts are integers, switches 0 or 1. Where no reason is given, the value comes from the study that preceded this
/// code.
struct Tuning {
  // Alignment: point_alignment.cpp.
  double shape_deviation = 0.03;    ///< sd of each element of A₀⁻¹A − 1, in a frame
  double shape_pull = 0.3;          ///< towards the neighbours' shape before alignment, in a frame
  double coarse_information = 0.6;  ///< share of the coarser level's in the finer one's prior: both see the same pixels
  double levels_first = 1;          ///< coarser levels of the first alignment
  double levels_second = 2;         ///< of the second, which may start farther away
  double levels_inner = 1;          ///< of the inner disc's
  double second_alignments = 2;     ///< mode: 2: the patch, then its inner disc; 1: the patch alone; 0: none
  double affine = 1;                ///< 1: affine at the finest level; 0: rotation and zoom only
  double query_precision = fine_precision;  ///< samples, where a user's point converges: below, noise dominates
  double support_precision =
      csd::support_precision;  ///< of a supporting point: one of many in a map, whose spread is at least .5 px
  double coarse_precision = csd::coarse_precision;  ///< of a coarser level: the finer one continues from there
  double inner_reach = 5;     ///< samples, radius of the inner disc, for a tool or its shadow nearby
  double min_anchor = 0.4;    ///< share of the level that is aligned last that lay in the picture
  double calm_miss = 1.5;     ///< px that the finest level converges over by itself
  double faded = -0.3;        ///< change of ln gain below which the coarser level is aligned too: blur()
  double blurred_zncc = 0.5;  ///< below, the patch shows something else, not the same tissue blurred

  // What counts as reliable: judgement.cpp.
  double reliable_zncc = 0.6;      ///< of points that maps may use
  double reliable_inliers = 0.5;   ///< the same
  double reliable_unmasked = 0.3;  ///< the same
  double alone_zncc = 0.8;         ///< to be found again without neighbours
  double min_unmasked = 0.1;       ///< to be reported at all

  // Distinctive patches: without a similar place near the prediction, a patch needs no support from its neighbours.
  double distinctive_zncc = 0.8;              ///< of both levels
  double distinctive_inliers = 0.6;           ///< of the fine one
  double distinctive_margin = 0.1;            ///< ZNCC above the best look-alike's
  double self_similarity_reach = 4;           ///< samples about the position in which a similar place counts,
  double self_similarity_per_spread = 0.5;    ///< plus this for each px of the map's spread,
  double self_similarity_per_distance = 0.2;  ///< plus this for each sample of distance between point and prediction
  double self_similarity_nearest = 4;         ///< samples, radius of the innermost of five rings
  double self_similarity_step = 2.5;          ///< samples from ring to ring
  double self_similarity_far = 9;             ///< samples, from which a similar place is a different one
  double self_similarity_pixels = 40;         ///< pixels: a mostly masked place is not measured
  /// Limit for detection: LookAlikes. Points on an edge slide along it: on cholecystectomy.mp4 12 % of the claims that
  /// forward-backward tracking compares were apart, with this 3 %; on smoke.mp4 80 % of the samples are claimed instead
  /// of 72 %.
  double max_look_alike = 0.9;

  // The neighbours' veto, and the fusion with their map: judgement.cpp.
  double min_judges = 5;                 ///< neighbours that may veto a point
  double gate_floor = 1;                 ///< px of disagreement that are always allowed,
  double gate_deviations = 2;            ///< plus this for each px of the offset's sd,
  double gate_spreads = 1;               ///< plus this for each px of the map's spread
  double max_distortion = 0.3;           ///< of the shape, relative to the neighbours'
  double min_own_motion = 0.2;           ///< px, sd of a point's motion relative to its neighbours, frame to frame,
  double own_motion_of_deviation = 0.3;  ///< plus this share of its offset's sd,
  double own_motion_of_spread = 0.2;     ///< plus this share of the map's spread
  /// sd of the predicted position, as a share of the sum of the point's and the map's deviations. With 1, faint patches
  /// slid away from correct predictions.
  double expected_share = 0.7;

  // Models of a point: memory.cpp, tracked_point.cpp.
  double anchor_samples = 14;  ///< during the training time, at most 16, including the first
  double good_zncc = 0.75;     ///< of a frame that updates offsets and gains
  double usual_rate = 0.1;     ///< of the running means of gain, noise and brightness
  double finer_scale = 0.8;    ///< scale at which a finer level is added
  double finer_zncc = 0.85;    ///< of the alignment at which it is added
  double finer_inliers = 0.7;  ///< the same
  double half_life = 100;      ///< frames, of the confidence of a point that is not aligned
  double fast = 1;             ///< px in a frame: faster points are aligned first
  double rest_miss = 1;        ///< px: limit of a resting supporting point's prediction error
  double rest_spread = 1;      ///< px: limit of its map's spread; then half of a map's points are as good as all

  // The neighbours' map: neighbour_map.cpp.
  double min_reach = 45;           ///< px, sd of the weights by distance, at least
  double reach_per_fifth = 0.7;    ///< share of the distance of the fifth nearest, if that is more
  double floor_weight = 0.01;      ///< of the farthest point: no map rests on one point
  double ridge = 60;               ///< px², regularisation towards the similarity
  double min_spread = 0.5;         ///< px: accuracy of single points
  double spread_per_median = 1.5;  ///< of the residuals' median
  double max_spread = 8;           ///< px: with more, the points do not agree, and only a piece can give a map
  double outlier = 2.5;            ///< spreads at which a point's weight is a quarter
  /// px: with more, the points may move in pieces. Of the visible points on 12 tissues that slide, .889 are found
  /// instead of .861 (K .092 instead of .075); with 2, a blurred zoom suffers.
  double common_spread = 3;
  double piece_spread = 2;     ///< px, of a piece, at most
  double piece_gain = 0.8;     ///< a piece counts if its cost is less than this share of the common map's
  double piece_pairs = 6;      ///< nearest points, each pair of which proposes a piece's motion
  double piece_base = 10;      ///< px between such two points, at least
  double min_piece = 4;        ///< points of a piece: in another scene three often agree by chance
  double own_vote = 0.3;       ///< weight of the point's own alignment in a piece's cost; a neighbour there has 1
  double settled = 0.005;      ///< change of a weight (at most 1) below which the iteration ends
  double nearby_margin = 1.3;  ///< on the squared distance: some points will not be reliable in the next frame
  // A point's offset from its map.
  double slowest = 0.02;       ///< smallest rate of the running means
  double min_deviation = 0.3;  ///< px, of the offset
  double max_deviation = 2;    ///< px
  double usual_offset = 1;     ///< px, prior sd of tissue motion relative to its neighbours
  double max_offset = 6;       ///< px

  // Supporting points: support_points.cpp.
  double cell_side = 32;         ///< px: 20 × 15 cells at 640 × 480, one point in each
  double max_cells = 1200;       ///< for very wide or very high pictures
  double max_in_cell = 2;        ///< when a zoom out crowds them
  double max_points = 1200;      ///< outside the picture
  double min_distance = 14.4;    ///< px, from a new point to the others
  double gap = 30;               ///< px, the same once a chart has points
  double edge = 8;               ///< px, of a new point from the picture's edge
  double quality = 0.003;        ///< of the picture's best corner
  double min_eigenvalue = 0.05;  ///< a mean slope of .1 grey levels a pixel; less is noise
  double corner_window = 7;      ///< pixels of level 1
  double clear_weight = 243;     ///< of GlareWeights' 255: no highlight nearby
  double avoid_tools = 1;        ///< 1: no point starts on a tool, as colour shows it
  double min_agreeing = 5;       ///< points that make a motion reliable after none was known
  double replenish_every = 0.5;  ///< s
  double new_chart_after = 1;    ///< s without any reliable point: another scene
  double trial = 0.5;            ///< s, before the neighbours' maps use a new point: it may lie on a tool
  double trial_deviation = 1.5;  ///< px, of its offset after that time, at most
  double young_lost_for = 0.5;   ///< s, until a new point is dropped
  double lost_for = 10;          ///< s, until an established one is
  /// Frames between searches for a hidden point while enough others are visible. With 2, the running time of the six
  /// real clips drops by a sixth, claims by .003 and claims apart by .002; with 4, by a fifth, and claims by .008.
  double search_every = 2;

  // The frame budget: steps.cpp, csd.cpp.
  double min_aligned = 24;     ///< supporting points aligned whatever the budget
  double min_at_visible = 18;  ///< of these, points that were visible; the others may return from hiding
  double more_aligned = 96;    ///< the same while fewer are reliable than a map uses: else the scene seems gone
  double support_share = 0.5;  ///< of the budget, from its start, for supporting points
  double query_share = 0.85;   ///< until users' points are aligned; the rest is for anchors
  double first_share = 0.6;    ///< of the supporting points' part: first alignments
  double max_steps = 10;       ///< frames: after a longer gap nothing can be predicted

  // Finding a scene again: recall.cpp.
  double max_scenes = 4;            ///< that are stored
  double usual_share = 0.7;         ///< of the usual number of points times contrast, from which a frame is stored
  double scene_rate = 0.02;         ///< of that running mean
  double try_every = 0.12;          ///< s
  double try_at_least_every = 5;    ///< s
  double tries_while_gone = 0.01;   ///< tries are this share of the absence apart
  double settles = 10;              ///< s: by then another scene is permanent, and the search ends
  double handful = 0.1;             ///< of a scene's points: as few may be chance matches
  double min_contrast = 3;          ///< grey levels, sd of the coarsest level: black and a covered lens are below
  double recalled_spread = 8;       ///< px, of positions predicted by a similarity of the whole picture
  double max_keypoints = 500;       ///< of the half-size picture
  double stretched = 40;            ///< grey levels, sd to which that picture is stretched for SIFT
  double keypoint_contrast = 0.01;  ///< at Lowe's threshold, tissue has few keypoints
  double match_ratio = 0.8;         ///< Lowe's
  double min_matches = 8;           ///< inliers of a similarity
  double match_tolerance = 6;       ///< px of the half-size picture: a heart moves as far
  double max_zoom = 4;              ///< more than any zoom during a cut

  // Visibility: visibility.cpp. tests/bench/fit fits the weights to real tissue: docs/method.md, "Evidence".
  double weigh_one = 2.01;
  double weigh_fine = 0.69;
  double weigh_coarse = 0.97;
  double weigh_unmasked = 2.85;
  double weigh_centre = 0.45;
  double weigh_dim = -0.61;
  double weigh_noise = -1.86;
  double weigh_brighter = -3.29;
  double weigh_darker = -1.50;
  double weigh_self_similarity = -2.43;
  double weigh_unknown = -1.73;
  double weigh_contrast = -0.42;
  double weigh_disagreement = -1.39;
  double dim_from = 0.7;             ///< loss of ln contrast explained by light and distance
  double noisy = 8;                  ///< grey levels: values are clamped here
  double other_light = 64;           ///< grey levels: changes are clamped here
  double min_self_similarity = 0.5;  ///< values are clamped here from below
  double max_disagreement = 6;       ///< values are clamped here
  double probability = 1;            ///< 1: the regression; 0: reliable points are visible
  double max_blur = 0.15;  ///< ln of contrast: from here the lens is wet; patches fit, but all features are hidden
  double highlight =
      GlareWeights::usual_highlight;  ///< of the room above its surroundings that makes a pixel a highlight; 2: none
  double claim_all = 0;               ///< 1: claims every point in every frame: a bound for the ablation, not a tracker
};

/// All fields, in the struct's order.
std::span<const NamedNumber<Tuning>> tuning_fields();
/// Sets a field by "name=value". Throws std::invalid_argument whose text names the error.
void set(Tuning &tuning, std::string_view assignment);

inline constexpr Tuning default_tuning{};

/// Converts a field to a count, and seconds to ns.
constexpr std::size_t count(double field) {
  return static_cast<std::size_t>(field);
}
constexpr std::int64_t nanoseconds(double seconds) {
  return static_cast<std::int64_t>(seconds * static_cast<double>(second));
}

}  // namespace csd
