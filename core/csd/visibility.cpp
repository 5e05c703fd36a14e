// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/visibility.h"

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

/// A term of the regression: its value and weight.
struct Term {
  std::string_view name;
  double Tuning::*weight;
  double (*value)(const Evidence &, const Tuning &);
};

double log_odds_of(double zncc) {
  return std::atanh(std::clamp(zncc, -0.2, 0.995));  // Fisher's z: constant variance
}

constexpr Term terms[] = {
    {"one", &Tuning::weigh_one, [](const Evidence &, const Tuning &) { return 1.0; }},
    {"fine", &Tuning::weigh_fine, [](const Evidence &e, const Tuning &) { return log_odds_of(e.zncc_fine); }},
    {"coarse", &Tuning::weigh_coarse, [](const Evidence &e, const Tuning &) { return log_odds_of(e.zncc_coarse); }},
    {"unmasked", &Tuning::weigh_unmasked, [](const Evidence &e, const Tuning &) { return e.unmasked; }},
    {"centre", &Tuning::weigh_centre, [](const Evidence &e, const Tuning &) { return e.centre; }},
    // Loss of the anchor's contrast, beyond what light and distance explain.
    {"dim", &Tuning::weigh_dim,
     [](const Evidence &e, const Tuning &t) { return std::max(0.0, -std::log(e.gain) - t.dim_from); }},
    {"noise", &Tuning::weigh_noise,
     [](const Evidence &e, const Tuning &t) { return std::min(1.0, e.noise * e.gain / t.noisy); }},
    {"brighter", &Tuning::weigh_brighter,
     [](const Evidence &e, const Tuning &t) { return std::clamp(e.brightness_change / t.other_light, 0.0, 1.0); }},
    {"darker", &Tuning::weigh_darker,
     [](const Evidence &e, const Tuning &t) { return std::clamp(-e.brightness_change / t.other_light, 0.0, 1.0); }},
    {"self_similarity", &Tuning::weigh_self_similarity,
     [](const Evidence &e, const Tuning &t) {
       return e.self_similarity ? std::max(t.min_self_similarity, *e.self_similarity) : 0.0;
     }},
    {"unknown", &Tuning::weigh_unknown,
     [](const Evidence &e, const Tuning &) { return e.self_similarity ? 0.0 : 1.0; }},
    {"contrast", &Tuning::weigh_contrast,
     [](const Evidence &e, const Tuning &) { return e.self_similarity ? std::log(std::max(0.1, e.contrast)) : 0.0; }},
    {"disagreement", &Tuning::weigh_disagreement,
     [](const Evidence &e, const Tuning &t) { return std::min(t.max_disagreement, e.disagreement); }},
};
static_assert(std::size(terms) == visibility_terms);

}  // namespace

std::array<double, visibility_terms> visibility_values(const Evidence &evidence, const Tuning &tuning) {
  std::array<double, visibility_terms> values{};
  for (std::size_t i = 0; i < visibility_terms; ++i) values[i] = terms[i].value(evidence, tuning);
  return values;
}

std::string_view visibility_name(std::size_t term) {
  return terms[term].name;
}

double visibility(const Evidence &evidence, const Tuning &tuning) {
  double sum = 0;
  for (const auto &term : terms) sum += tuning.*term.weight * term.value(evidence, tuning);
  return 1 / (1 + std::exp(-sum));
}

}  // namespace csd
