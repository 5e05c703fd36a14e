// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/visibility.h"

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

/// One term of the sum: its weight, and what it weighs.
struct Term {
  double weight;
  double (*value)(const Evidence &);
};

double log_odds_of(double zncc) {
  return std::atanh(std::clamp(zncc, -0.2, 0.995));  // Fisher's z: evenly noisy
}

// Fitted on simulated sequences (prototype.md I.2).
constexpr Term terms[] = {
    {-1.29, [](const Evidence &) { return 1.0; }},
    {1.98, [](const Evidence &e) { return log_odds_of(e.zncc_fine); }},
    {1.29, [](const Evidence &e) { return log_odds_of(e.zncc_coarse); }},
    {2.11, [](const Evidence &e) { return e.inliers; }},
    {3.18, [](const Evidence &e) { return e.unmasked; }},
    {-1.28, [](const Evidence &e) { return std::log(e.gain); }},
    {-1.99, [](const Evidence &e) { return std::min(6.0, e.disagreement); }},
    {0.05, [](const Evidence &e) { return e.seen_before ? 1.0 : 0.0; }},
    {-2.69, [](const Evidence &e) { return std::min(1.0, e.noise * e.gain / 8); }},
    {-3.09, [](const Evidence &e) { return std::min(1.5, e.gain_change); }},
};

}  // namespace

double visibility(const Evidence &evidence) {
  double sum = 0;
  for (const auto &term : terms) sum += term.weight * term.value(evidence);
  return 1 / (1 + std::exp(-sum));
}

}  // namespace csd
