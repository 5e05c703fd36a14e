// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/jaccard.h"

#include <numeric>

namespace csd::score {

void JaccardSums::add(const JaccardSums &other, std::uint64_t times) {
  evaluated += times * other.evaluated;
  agreed += times * other.agreed;
  visible += times * other.visible;
  for (std::size_t i = 0; i < jaccard_thresholds; ++i) {
    within[i] += times * other.within[i];
    true_positive[i] += times * other.true_positive[i];
    false_positive[i] += times * other.false_positive[i];
  }
}

void JaccardSums::add(const Sample &sample, double distance, const Thresholds &thresholds) {
  ++evaluated;
  agreed += sample.claimed == sample.visible();
  visible += sample.visible();
  for (std::size_t i = 0; i < jaccard_thresholds; ++i) {
    const bool near = sample.visible() && distance < thresholds[i];
    within[i] += near;
    true_positive[i] += near && sample.claimed;
    false_positive[i] += !near && sample.claimed;
  }
}

JaccardScore jaccard_score(const JaccardSums &sums) {
  const auto ratio = [](std::uint64_t part, std::uint64_t whole) {
    return whole ? static_cast<double>(part) / static_cast<double>(whole) : unknown;
  };
  JaccardScore score;
  for (std::size_t i = 0; i < jaccard_thresholds; ++i) {
    score.within[i] = ratio(sums.within[i], sums.visible);
    score.jaccard[i] = ratio(sums.true_positive[i], sums.visible + sums.false_positive[i]);
  }
  score.delta_avg = std::accumulate(score.within.begin(), score.within.end(), 0.0) / jaccard_thresholds;
  score.aj = std::accumulate(score.jaccard.begin(), score.jaccard.end(), 0.0) / jaccard_thresholds;
  score.oa = ratio(sums.agreed, sums.evaluated);
  return score;
}

}  // namespace csd::score
