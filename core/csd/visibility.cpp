// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/visibility.h"

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

/// One term of the sum: its weight, and what it weighs.
struct Term {
  std::string_view name;
  double weight;
  double (*value)(const Evidence &);
};

double log_odds_of(double zncc) {
  return std::atanh(std::clamp(zncc, -0.2, 0.995));  // Fisher's z: evenly noisy
}

// Fitted by tests/bench/fit to real tissue as textures: docs/method.md, "Evidence".
constexpr Term terms[] = {
    {"one", 2.01, [](const Evidence &) { return 1.0; }},
    {"fine", 0.69, [](const Evidence &e) { return log_odds_of(e.zncc_fine); }},
    {"coarse", 0.97, [](const Evidence &e) { return log_odds_of(e.zncc_coarse); }},
    {"unmasked", 2.85, [](const Evidence &e) { return e.unmasked; }},
    {"centre", 0.45, [](const Evidence &e) { return e.centre; }},
    // How much of the anchor's contrast is gone, beyond what light and distance do.
    {"dim", -0.61, [](const Evidence &e) { return std::max(0.0, -std::log(e.gain) - 0.7); }},
    {"noise", -1.86, [](const Evidence &e) { return std::min(1.0, e.noise * e.gain / 8); }},
    {"brighter", -3.29, [](const Evidence &e) { return std::clamp(e.brightness_change / 64, 0.0, 1.0); }},
    {"darker", -1.50, [](const Evidence &e) { return std::clamp(-e.brightness_change / 64, 0.0, 1.0); }},
    {"likeness", -2.43, [](const Evidence &e) { return e.likeness ? std::max(0.5, *e.likeness) : 0.0; }},
    {"unknown", -1.73, [](const Evidence &e) { return e.likeness ? 0.0 : 1.0; }},
    {"contrast", -0.42, [](const Evidence &e) { return e.likeness ? std::log(std::max(0.1, e.contrast)) : 0.0; }},
    {"disagreement", -1.39, [](const Evidence &e) { return std::min(6.0, e.disagreement); }},
};
static_assert(std::size(terms) == visibility_terms);

}  // namespace

std::array<double, visibility_terms> visibility_values(const Evidence &evidence) {
  std::array<double, visibility_terms> values{};
  for (std::size_t i = 0; i < visibility_terms; ++i) values[i] = terms[i].value(evidence);
  return values;
}

std::string_view visibility_name(std::size_t term) {
  return terms[term].name;
}

double visibility_weight(std::size_t term) {
  return terms[term].weight;
}

double visibility(const Evidence &evidence) {
  double sum = 0;
  for (const auto &term : terms) sum += term.weight * term.value(evidence);
  return 1 / (1 + std::exp(-sum));
}

}  // namespace csd
