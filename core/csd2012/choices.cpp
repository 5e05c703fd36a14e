// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/choices.h"

#include <iterator>

namespace csd::csd2012 {
namespace {

#define FIELD(name) \
  { #name, &Choices::name }
constexpr NamedNumber<Choices> fields[] = {
    FIELD(colour),
    FIELD(smoothing),
    FIELD(exhaustive),
    FIELD(smoke_as_printed),
    FIELD(most_lessons),
    FIELD(least_training_frames),
    FIELD(random_per_lesson),
    FIELD(similar_per_lesson),
    FIELD(least_similarity),
    FIELD(similarity_radius),
    FIELD(ignore_radius),
    FIELD(near_radius),
    FIELD(max_depth),
    FIELD(min_samples),
    FIELD(learning_rounds),
    FIELD(evaluation_grid),
    FIELD(errors_per_round),
    FIELD(search_radius),
    FIELD(sigma_of_width),
    FIELD(widening),
    FIELD(widest_search),
    FIELD(anywhere_after),
    FIELD(coarse_step),
    FIELD(whole_pictures_per_frame),
    FIELD(cluster_radius),
    FIELD(least_cluster),
    FIELD(least_share),
    FIELD(update_share),
    FIELD(random_updates),
    FIELD(false_updates),
    FIELD(update_warps),
    FIELD(recent_positives),
    FIELD(negative_reservoir),
    FIELD(waiting_updates),
    FIELD(waiting_lessons),
};
#undef FIELD
static_assert(std::size(fields) * sizeof(double) == sizeof(Choices), "a field has no name");

}  // namespace

std::span<const NamedNumber<Choices>> choice_fields() {
  return fields;
}

void set(Choices &choices, std::string_view assignment) {
  set_number(choices, choice_fields(), assignment, "csd-2012");
}

}  // namespace csd::csd2012
