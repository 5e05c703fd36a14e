// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/score.h"

#include "score/errors.h"
#include "score/quantile.h"
#include "score/recovery.h"
#include "score/tap_vid.h"

namespace csd::score {
namespace {

PaperScore paper_at(std::span<const Clip> clips, double pixels) {
  std::vector<PaperScore> scores;
  for (const Clip &clip : clips) {
    const std::vector<Counts> frames = count_frames(Outcomes(clip, tolerance(clip.height, pixels)));
    scores.push_back(paper_score(frames));
  }
  const auto mean = [&](double PaperScore::*member) {
    std::vector<double> values;
    values.reserve(scores.size());
    for (const PaperScore &score : scores) values.push_back(score.*member);
    return mean_of_known(values);
  };
  return {mean(&PaperScore::sensitivity), mean(&PaperScore::k), mean(&PaperScore::k_visible)};
}

void score_paper(TrackerScore &score, std::span<const Clip> clips) {
  for (const Clip &clip : clips) {
    ClipScore of_clip;
    of_clip.tau = tolerance(clip.height, headline_pixels);
    of_clip.frames = count_frames(Outcomes(clip, of_clip.tau));
    of_clip.paper = paper_score(of_clip.frames);
    for (const Counts &frame : of_clip.frames) of_clip.total += frame;
    score.total += of_clip.total;
    score.clips.push_back(std::move(of_clip));
  }
  for (const double pixels : curve_pixels) {
    score.curve.push_back({pixels, paper_at(clips, pixels)});
    if (pixels == headline_pixels) score.k_visible = score.curve.back().paper.k_visible;
  }
}

void score_tap_vid(TrackerScore &score, std::span<const Clip> clips) {
  std::vector<JaccardScore> scores;
  for (const Clip &clip : clips) {
    JaccardSums sums;
    for (const JaccardSums &feature : tap_vid_sums(clip)) sums.add(feature);
    scores.push_back(jaccard_score(sums));
  }
  for (std::size_t i = 0; i < jaccard_thresholds; ++i) {
    std::vector<double> within, jaccard;
    for (const JaccardScore &of_clip : scores) {
      within.push_back(of_clip.within[i]);
      jaccard.push_back(of_clip.jaccard[i]);
    }
    score.tap_vid_within[i] = mean_of_known(within);
    score.tap_vid_jaccard[i] = mean_of_known(jaccard);
  }
}

void score_stir(TrackerScore &score, std::span<const Clip> clips) {
  JaccardSums sums;
  std::vector<double> distances, control;
  const auto append = [](std::vector<double> &to, const std::vector<double> &from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (const Clip &clip : clips) {
    sums.add(stir_2026_sums(clip));
    append(distances, end_distances(clip, clip.reports_last));
    append(control, end_distances(clip, clip.starts));
  }
  score.stir_2026 = jaccard_score(sums);
  score.stir_2024 = stir_2024_score(distances);
  score.stir_2024_control = stir_2024_score(control);
  score.stir_2024_median = quantile(std::move(distances), 0.5);
}

void score_errors(TrackerScore &score, std::span<const Clip> clips) {
  std::vector<double> all, first, last;
  for (const Clip &clip : clips) {
    const std::vector<double> errors = claimed_errors(clip);
    const DriftErrors drift = drift_errors(clip);
    all.insert(all.end(), errors.begin(), errors.end());
    first.insert(first.end(), drift.first.begin(), drift.first.end());
    last.insert(last.end(), drift.last.begin(), drift.last.end());
  }
  score.error_median = quantile(all, 0.5);
  score.error_95 = quantile(std::move(all), 0.95);
  score.error_first_fifth = quantile(std::move(first), 0.5);
  score.error_last_fifth = quantile(std::move(last), 0.5);
}

void score_recovery(TrackerScore &score, std::span<const Clip> clips) {
  constexpr double never = std::numeric_limits<double>::infinity();
  std::vector<double> frames, seconds;
  bool timed = true;
  for (const Clip &clip : clips) {
    for (const Moment &moment : clip.moments) timed = timed && moment.pts != no_time;
    for (const Recovery &recovery : recoveries(clip, tolerance(clip.height, headline_pixels))) {
      score.recovered += recovery.recovered;
      frames.push_back(recovery.recovered ? static_cast<double>(recovery.frames) : never);
      seconds.push_back(recovery.recovered ? static_cast<double>(recovery.time) / second : never);
    }
  }
  score.returns = frames.size();
  score.recovery_median_frames = quantile(std::move(frames), 0.5);
  if (timed) score.recovery_median_seconds = quantile(std::move(seconds), 0.5);
}

}  // namespace

TrackerScore score(std::string name, std::span<const Clip> clips, unsigned resamples, std::uint64_t seed) {
  TrackerScore result;
  result.name = std::move(name);
  {
    std::vector<ClipStatistics> statistics;
    for (const Clip &clip : clips) statistics.emplace_back(clip);
    result.headline = headlines(statistics);
    result.draws = bootstrap(statistics, resamples, seed);
  }
  for (std::size_t h = 0; h < headline_count; ++h) result.intervals[h] = interval(result.draws, h);
  score_paper(result, clips);
  score_tap_vid(result, clips);
  score_stir(result, clips);
  score_errors(result, clips);
  score_recovery(result, clips);
  for (const Clip &clip : clips) result.reliability.add(clip, tolerance(clip.height, headline_pixels));
  return result;
}

}  // namespace csd::score
