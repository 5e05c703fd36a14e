// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/choices.h"

#include <iterator>

namespace csd::csd2012 {
namespace {

#define FIELD(name) named(#name, &Choices::name)
constexpr NamedNumber<Choices> fields[] = {
    FIELD(colour),
    FIELD(smoothing),
    FIELD(exhaustive),
    FIELD(smoke_as_printed),
    FIELD(max_lessons),
    FIELD(min_training_frames),
    FIELD(random_per_lesson),
    FIELD(similar_per_lesson),
    FIELD(min_similarity),
    FIELD(similarity_radius),
    FIELD(ignore_radius),
    FIELD(near_radius),
    FIELD(widest_test),
    FIELD(top_pixels),
    FIELD(random_pairs),
    FIELD(max_depth),
    FIELD(min_samples),
    FIELD(trees),
    FIELD(sample_share),
    FIELD(highlights),
    FIELD(blurs),
    FIELD(compressions),
    FIELD(co_training),
    FIELD(fits),
    FIELD(fit_reach),
    FIELD(learning_rounds),
    FIELD(evaluation_grid),
    FIELD(errors_per_round),
    FIELD(search_radius),
    FIELD(sigma_of_width),
    FIELD(widening),
    FIELD(widest_search),
    FIELD(cluster_radius),
    FIELD(own_patches),
    FIELD(likeness_power),
    FIELD(min_probability),
    FIELD(refind_probability),
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

Choices forest_choices() {
  Choices c;
  c.trees = 5;
  c.highlights = 1;
  c.blurs = 1;
  c.co_training = 1;
  c.refind_probability = 0.01;
  c.update_warps = 0;
  return c;
}

std::span<const NamedNumber<Choices>> choice_fields() {
  return fields;
}

void set(Choices &choices, std::string_view assignment) {
  set_number(choices, choice_fields(), assignment, "csd-2012");
}

}  // namespace csd::csd2012
