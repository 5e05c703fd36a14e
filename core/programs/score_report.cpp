// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/score_report.h"

#include "programs/decimal.h"
#include "score/tap_vid.h"

namespace csd::programs {
namespace {

/// Fixed, so that every run gives the same intervals.
constexpr std::uint64_t bootstrap_seed = 1;

/// A field of CSV (RFC 4180).
std::string field(const std::string &text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

class Rows {
 public:
  void tracker(const std::string &name) { tracker_ = field(name); }
  void clip(const std::string &name) { clip_ = field(name); }
  void add(const std::string &metric, double value, double threshold = score::unknown, score::Interval interval = {}) {
    text_ += tracker_ + "," + clip_ + "," + metric + "," + decimal(threshold, 0, "") + "," + decimal(value, 6, "") +
             "," + decimal(interval.low, 6, "") + "," + decimal(interval.high, 6, "") + "\n";
  }
  void add(const std::string &metric, std::uint64_t count) {
    text_ += tracker_ + "," + clip_ + "," + metric + ",," + std::to_string(count) + ",,\n";
  }
  void add(const score::Counts &counts) {
    add("correct", counts.correct);
    add("wrong", counts.wrong);
    add("missed", counts.missed);
    add("hidden_claimed", counts.on_hidden);
    add("hidden_quiet", counts.quiet);
  }
  const std::string &text() const { return text_; }

 private:
  std::string text_ = "tracker,clip,metric,threshold,value,low,high\n", tracker_, clip_;
};

}  // namespace

ScoreReport make_report(const std::vector<std::string> &names, const std::vector<std::vector<score::Clip>> &clips,
                        std::vector<std::string> notes, unsigned resamples) {
  ScoreReport report;
  report.notes = std::move(notes);
  report.resamples = resamples;
  for (std::size_t c = 0; c < clips.front().size(); ++c) {
    const score::Clip &clip = clips.front()[c];
    report.clips.push_back({clip.truth, clip.width, clip.height, clip.ids.size(), clip.moments, {}});
    for (const auto &tracker : clips) report.clips.back().tracks.push_back(tracker[c].tracks);
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    report.trackers.push_back(score::score(names[i], clips[i], resamples, bootstrap_seed));
  std::size_t features = 0;
  for (const auto &clip : report.clips) features += clip.features;
  for (std::size_t i = 1; i < names.size(); ++i) {
    const score::TrackerScore &first = report.trackers.front(), &other = report.trackers[i];
    report.pairs.push_back({i, {}});
    for (std::size_t h = 0; h < score::headline_count; ++h)
      report.pairs.back().comparisons[h] =
          score::compare(other.headline[h], other.draws, first.headline[h], first.draws, h, features);
  }
  return report;
}

std::string as_csv(const ScoreReport &report) {
  Rows rows;
  for (const score::TrackerScore &tracker : report.trackers) {
    rows.tracker(tracker.name);
    rows.clip("");
    for (std::size_t h = 0; h < score::headline_count; ++h)
      rows.add(std::string(score::headline_name(h)), tracker.headline[h], score::unknown, tracker.intervals[h]);
    rows.add("k_visible", tracker.k_visible);
    rows.add("hidden_claimed_share", tracker.total.hidden_claimed());
    rows.add(tracker.total);
    for (const score::CurvePoint &point : tracker.curve) {
      rows.add("sensitivity_at", point.paper.sensitivity, point.pixels);
      rows.add("k_at", point.paper.k, point.pixels);
    }
    const auto at = [&](const char *metric, const score::Thresholds &pixels, const score::Thresholds &values) {
      for (std::size_t i = 0; i < score::jaccard_thresholds; ++i) rows.add(metric, values[i], pixels[i]);
    };

    at("pts_within", score::tap_vid_pixels, tracker.tap_vid_within);
    at("jaccard", score::tap_vid_pixels, tracker.tap_vid_jaccard);
    rows.add("stir_2026_aj", tracker.stir_2026.aj);
    rows.add("stir_2026_ata", tracker.stir_2026.delta_avg);
    rows.add("stir_2026_oa", tracker.stir_2026.oa);
    rows.add("stir_2024_delta_avg", tracker.stir_2024.delta_avg);
    at("stir_2024_within", score::stir_2024_pixels, tracker.stir_2024.within);
    rows.add("stir_2024_control_delta_avg", tracker.stir_2024_control.delta_avg);
    rows.add("stir_2024_end_error_median", tracker.stir_2024_median);
    rows.add("error_median", tracker.error_median);
    rows.add("error_95", tracker.error_95);
    rows.add("error_first_fifth", tracker.error_first_fifth);
    rows.add("error_last_fifth", tracker.error_last_fifth);
    rows.add("drift", tracker.drift());
    rows.add("returns", tracker.returns);
    rows.add("recovered", tracker.recovered);
    rows.add("recovery_median_frames", tracker.recovery_median_frames);
    rows.add("recovery_median_seconds", tracker.recovery_median_seconds);
    rows.add("ece", tracker.reliability.ece());
    for (std::size_t c = 0; c < report.clips.size(); ++c) {
      rows.clip(report.clips[c].truth);
      rows.add("tau", tracker.clips[c].tau);
      rows.add("sensitivity", tracker.clips[c].paper.sensitivity);
      rows.add("k", tracker.clips[c].paper.k);
      rows.add("k_visible", tracker.clips[c].paper.k_visible);
      rows.add(tracker.clips[c].total);
    }
  }
  return rows.text();
}

}  // namespace csd::programs
