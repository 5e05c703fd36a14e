// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/bootstrap.h"

#include "base/random.h"
#include "score/quantile.h"
#include "score/tap_vid.h"

namespace csd::score {
namespace {

Headlines clip_headlines(const ClipStatistics &clip, std::span<const std::uint32_t> weights) {
  const PaperScore paper = paper_score(clip.outcomes, weights);
  JaccardSums sums;
  SurvivalSums survival;
  for (std::size_t f = 0; f < weights.size(); ++f) {
    if (!weights[f]) continue;
    sums.add(clip.tap_vid[f], weights[f]);
    survival.alive += weights[f] * clip.survival[f].alive;
    survival.labelled += weights[f] * clip.survival[f].labelled;
  }
  const JaccardScore tap_vid = jaccard_score(sums);
  return {paper.sensitivity,
          paper.k,
          tap_vid.delta_avg,
          tap_vid.aj,
          tap_vid.oa,
          survival.labelled ? static_cast<double>(survival.alive) / static_cast<double>(survival.labelled) : unknown};
}

Headlines mean_over_clips(const std::vector<Headlines> &clips) {
  Headlines mean;
  std::vector<double> values(clips.size());
  for (std::size_t h = 0; h < headline_count; ++h) {
    std::transform(clips.begin(), clips.end(), values.begin(), [h](const Headlines &clip) { return clip[h]; });
    mean[h] = mean_of_known(values);
  }
  return mean;
}

Interval percentiles(const std::vector<double> &values) {
  return {quantile(values, 0.025), quantile(values, 0.975)};
}

}  // namespace

std::string_view headline_name(std::size_t headline) {
  constexpr std::array<std::string_view, headline_count> names{"sensitivity", "k", "delta_avg", "aj", "oa", "survival"};
  return names[headline];
}

ClipStatistics::ClipStatistics(const Clip &clip)
    : outcomes(clip, tolerance(clip.height, headline_pixels)),
      tap_vid(tap_vid_sums(clip)),
      survival(survival_sums(clip)) {}

Headlines headlines(std::span<const ClipStatistics> clips) {
  std::vector<Headlines> all;
  for (const ClipStatistics &clip : clips)
    all.push_back(clip_headlines(clip, std::vector<std::uint32_t>(clip.outcomes.features, 1)));
  return mean_over_clips(all);
}

std::vector<Headlines> bootstrap(std::span<const ClipStatistics> clips, unsigned resamples, std::uint64_t seed) {
  std::vector<Headlines> draws;
  if (clips.size() == 1 && clips.front().outcomes.features == 1) return draws;
  std::vector<std::uint32_t> weights;
  for (unsigned r = 0; r < resamples; ++r) {
    Random random(seed, r);
    std::vector<Headlines> drawn;
    for (std::size_t i = 0; i < clips.size(); ++i) {
      const ClipStatistics &clip = clips[random.below(static_cast<std::uint32_t>(clips.size()))];
      const auto features = static_cast<std::uint32_t>(clip.outcomes.features);
      weights.assign(features, 0);
      for (std::uint32_t f = 0; f < features; ++f) ++weights[random.below(features)];
      drawn.push_back(clip_headlines(clip, weights));
    }
    draws.push_back(mean_over_clips(drawn));
  }
  return draws;
}

Interval interval(std::span<const Headlines> draws, std::size_t headline) {
  std::vector<double> values;
  for (const Headlines &draw : draws)
    if (!std::isnan(draw[headline])) values.push_back(draw[headline]);
  return percentiles(values);
}

Comparison compare(double a, std::span<const Headlines> draws_a, double b, std::span<const Headlines> draws_b,
                   std::size_t headline, std::size_t features) {
  std::vector<double> differences;
  std::size_t at_most_0 = 0, at_least_0 = 0;
  for (std::size_t r = 0; r < std::min(draws_a.size(), draws_b.size()); ++r) {
    const double difference = draws_a[r][headline] - draws_b[r][headline];
    if (std::isnan(difference)) continue;
    differences.push_back(difference);
    at_most_0 += difference <= 0;
    at_least_0 += difference >= 0;
  }
  Comparison comparison{a - b, {}, unknown};
  if (differences.empty()) return comparison;
  // Adds one to both, so that no p is 0: the data themselves are one of the draws (Davison and Hinkley 1997, §4.2).
  const double count = static_cast<double>(differences.size());
  const double least_p = std::exp2(1 - static_cast<double>(features));
  comparison.p = std::clamp(2 * (1 + static_cast<double>(std::min(at_most_0, at_least_0))) / (1 + count),
                            std::min(1.0, least_p), 1.0);
  comparison.confidence = percentiles(differences);
  return comparison;
}

}  // namespace csd::score
