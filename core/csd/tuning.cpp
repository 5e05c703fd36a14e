// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/tuning.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace csd {
namespace {

#define FIELD(name) \
  { #name, &Tuning::name }
constexpr TuningField fields[] = {
    FIELD(shape_deviation),
    FIELD(shape_pull),
    FIELD(coarse_information),
    FIELD(levels_first),
    FIELD(levels_again),
    FIELD(levels_inner),
    FIELD(looks_again),
    FIELD(affine),
    FIELD(query_precision),
    FIELD(support_precision),
    FIELD(coarse_precision),
    FIELD(inner_reach),
    FIELD(least_anchor),
    FIELD(calm_miss),
    FIELD(faded),
    FIELD(blurred_zncc),
    FIELD(sure_zncc),
    FIELD(sure_inliers),
    FIELD(sure_unmasked),
    FIELD(alone_zncc),
    FIELD(least_unmasked),
    FIELD(apart_zncc),
    FIELD(apart_inliers),
    FIELD(apart_margin),
    FIELD(alike_reach),
    FIELD(alike_per_spread),
    FIELD(alike_per_distance),
    FIELD(likeness_nearest),
    FIELD(likeness_step),
    FIELD(likeness_far),
    FIELD(likeness_weight),
    FIELD(most_alike),
    FIELD(least_judges),
    FIELD(gate_floor),
    FIELD(gate_deviations),
    FIELD(gate_spreads),
    FIELD(most_distortion),
    FIELD(least_own_motion),
    FIELD(own_motion_of_deviation),
    FIELD(own_motion_of_spread),
    FIELD(expected_share),
    FIELD(anchor_samples),
    FIELD(good_zncc),
    FIELD(usual_rate),
    FIELD(finer_scale),
    FIELD(finer_zncc),
    FIELD(finer_inliers),
    FIELD(half_life),
    FIELD(fast),
    FIELD(rest_miss),
    FIELD(rest_spread),
    FIELD(least_reach),
    FIELD(reach_per_fifth),
    FIELD(floor_weight),
    FIELD(ridge),
    FIELD(least_spread),
    FIELD(spread_per_median),
    FIELD(most_spread),
    FIELD(outlier),
    FIELD(settled),
    FIELD(nearby_margin),
    FIELD(slowest),
    FIELD(least_deviation),
    FIELD(most_deviation),
    FIELD(usual_offset),
    FIELD(most_offset),
    FIELD(cell_side),
    FIELD(most_cells),
    FIELD(most_in_cell),
    FIELD(most_points),
    FIELD(least_distance),
    FIELD(gap),
    FIELD(edge),
    FIELD(quality),
    FIELD(least_eigenvalue),
    FIELD(corner_window),
    FIELD(clear_weight),
    FIELD(avoid_tools),
    FIELD(least_agreeing),
    FIELD(replenish_every),
    FIELD(new_chart_after),
    FIELD(trial),
    FIELD(trial_deviation),
    FIELD(young_lost_for),
    FIELD(lost_for),
    FIELD(search_every),
    FIELD(least_looks),
    FIELD(least_at_visible),
    FIELD(more_looks),
    FIELD(support_share),
    FIELD(query_share),
    FIELD(first_looks),
    FIELD(most_steps),
    FIELD(most_scenes),
    FIELD(usual_share),
    FIELD(scene_rate),
    FIELD(try_every),
    FIELD(try_at_least_every),
    FIELD(tries_while_gone),
    FIELD(settles),
    FIELD(handful),
    FIELD(least_contrast),
    FIELD(recalled_spread),
    FIELD(most_keypoints),
    FIELD(stretched),
    FIELD(keypoint_contrast),
    FIELD(match_ratio),
    FIELD(least_matches),
    FIELD(match_tolerance),
    FIELD(most_zoom),
    FIELD(weigh_one),
    FIELD(weigh_fine),
    FIELD(weigh_coarse),
    FIELD(weigh_unmasked),
    FIELD(weigh_centre),
    FIELD(weigh_dim),
    FIELD(weigh_noise),
    FIELD(weigh_brighter),
    FIELD(weigh_darker),
    FIELD(weigh_likeness),
    FIELD(weigh_unknown),
    FIELD(weigh_contrast),
    FIELD(weigh_disagreement),
    FIELD(dim_from),
    FIELD(noisy),
    FIELD(other_light),
    FIELD(least_likeness),
    FIELD(most_disagreement),
    FIELD(probability),
    FIELD(most_blur),
    FIELD(highlight),
    FIELD(claim_all),
};
#undef FIELD
static_assert(std::size(fields) * sizeof(double) == sizeof(Tuning), "a field has no name");

}  // namespace

std::span<const TuningField> tuning_fields() {
  return fields;
}

void set(Tuning &tuning, std::string_view assignment) {
  const auto sign = assignment.find('=');
  const auto name = assignment.substr(0, sign);
  if (sign == std::string_view::npos)
    throw std::invalid_argument("\"" + std::string(assignment) + "\" is not NAME=VALUE");
  const auto field = std::find_if(std::begin(fields), std::end(fields), [name](auto &f) { return f.name == name; });
  if (field == std::end(fields))
    throw std::invalid_argument("no number of csd is called \"" + std::string(name) + "\"");
  const std::string text(assignment.substr(sign + 1));
  char *end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value))
    throw std::invalid_argument("\"" + text + "\" is not a number, for " + std::string(name));
  tuning.*field->field = value;
}

}  // namespace csd
