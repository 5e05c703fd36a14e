// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/decimal.h"
#include "programs/score_report.h"
#include "programs/table.h"

namespace csd::programs {
namespace {

using score::Headline;
using score::TrackerScore;

std::string number(double value, int digits = 3) {
  return decimal(value, digits, "—");
}

std::string with_interval(const TrackerScore &tracker, Headline which) {
  const auto h = static_cast<std::size_t>(which);
  const std::string value = number(tracker.headline[h]);
  const score::Interval &interval = tracker.intervals[h];
  return std::isnan(interval.low) ? value : value + " (" + number(interval.low) + "–" + number(interval.high) + ")";
}

std::string share(std::size_t part, std::size_t whole) {
  return std::to_string(part) + " of " + std::to_string(whole);
}

/// "5" at 576 lines or less, else the value in each clip.
std::string tau_text(const ScoreReport &report) {
  std::string text;
  for (const auto &clip : report.clips) {
    const std::string tau = number(score::tolerance(clip.height, score::headline_pixels), 2);
    if (text.find(tau) == std::string::npos) text += (text.empty() ? "" : ", ") + tau;
  }
  return text;
}

Table paper_table(const ScoreReport &report) {
  Table table{"Sensitivity and 1 − precision, τ = " + tau_text(report) + " px",
              {{"tracker", "sensitivity", "1 − precision", "of visible only", "correct", "wrong", "missed",
                "claimed while hidden"}}};
  for (const TrackerScore &tracker : report.trackers) {
    const score::Counts &total = tracker.total;
    table.rows.push_back({tracker.name, with_interval(tracker, Headline::sensitivity),
                          with_interval(tracker, Headline::k), number(tracker.k_visible), std::to_string(total.correct),
                          std::to_string(total.wrong), std::to_string(total.missed),
                          share(total.on_hidden, total.on_hidden + total.quiet)});
  }
  return table;
}

Table curve_table(const ScoreReport &report) {
  Table table{"Sensitivity / 1 − precision by τ, px at 576 lines or less", {{"tracker"}}};
  for (const double pixels : score::curve_pixels) table.rows.front().push_back(number(pixels, 0));
  for (const TrackerScore &tracker : report.trackers) {
    table.rows.push_back({tracker.name});
    for (const score::CurvePoint &point : tracker.curve)
      table.rows.back().push_back(number(point.paper.sensitivity) + " / " + number(point.paper.k));
  }
  return table;
}

Table tap_vid_table(const ScoreReport &report) {
  Table table{"TAP-Vid (256×256) and survival", {{"tracker", "δavg", "AJ", "OA", "survival"}}};
  for (const TrackerScore &tracker : report.trackers)
    table.rows.push_back({tracker.name, with_interval(tracker, Headline::delta_avg),
                          with_interval(tracker, Headline::aj), with_interval(tracker, Headline::oa),
                          with_interval(tracker, Headline::survival)});
  return table;
}

Table stir_table(const ScoreReport &report) {
  Table table{"STIR", {{"tracker", "2026 AJ", "2026 ATA", "2026 OA", "2024 δavg", "2024 median, px"}}};
  for (const TrackerScore &tracker : report.trackers)
    table.rows.push_back({tracker.name, number(tracker.stir_2026.aj), number(tracker.stir_2026.delta_avg),
                          number(tracker.stir_2026.oa), number(tracker.stir_2024.delta_avg),
                          number(tracker.stir_2024_median, 2)});
  if (!report.trackers.empty())
    table.rows.push_back(
        {"(never moves)", "", "", "", number(report.trackers.front().stir_2024_control.delta_avg), ""});
  return table;
}

Table error_table(const ScoreReport &report) {
  Table table{"Error of what is claimed, px; return after being hidden; calibration of confidence",
              {{"tracker", "median", "95 %", "median, last fifth", "drift", "returned", "frames until", "seconds until",
                "ECE"}}};
  for (const TrackerScore &tracker : report.trackers)
    table.rows.push_back(
        {tracker.name, number(tracker.error_median, 2), number(tracker.error_95, 2),
         number(tracker.error_last_fifth, 2), number(tracker.drift(), 2), share(tracker.recovered, tracker.returns),
         tracker.returns > 0 && std::isinf(tracker.recovery_median_frames) ? "never"
                                                                           : number(tracker.recovery_median_frames, 1),
         number(tracker.recovery_median_seconds, 2), number(tracker.reliability.ece())});
  return table;
}

Table pair_table(const ScoreReport &report) {
  Table table{"Difference from " + report.trackers.front().name + ", and p",
              {{"tracker", "sensitivity", "1 − precision", "δavg", "AJ", "OA", "survival"}}};
  for (const ScoreReport::Pair &pair : report.pairs) {
    table.rows.push_back({report.trackers[pair.tracker].name});
    for (const score::Comparison &comparison : pair.comparisons) {
      const std::string sign = comparison.difference >= 0.0005 ? "+" : "";
      table.rows.back().push_back(
          sign + number(comparison.difference) +
          (std::isnan(comparison.p) ? ""
                                    : (comparison.p < 0.001 ? " (p < .001)" : " (p = " + number(comparison.p) + ")")));
    }
  }
  return table;
}

std::vector<Table> tables(const ScoreReport &report) {
  std::vector<Table> all{paper_table(report), curve_table(report), tap_vid_table(report), stir_table(report),
                         error_table(report)};
  if (!report.pairs.empty()) all.push_back(pair_table(report));
  return all;
}

std::vector<std::string> head(const ScoreReport &report) {
  std::vector<std::string> lines;
  for (const auto &clip : report.clips)
    lines.push_back(clip.truth + ": " + std::to_string(clip.features) + " features, " +
                    std::to_string(clip.moments.size()) + " labelled frames, " + std::to_string(clip.width) + "×" +
                    std::to_string(clip.height));
  if (report.resamples && !std::isnan(report.trackers.front().intervals.front().low))
    lines.push_back("In brackets: 95 % intervals from " + std::to_string(report.resamples) + " draws of " +
                    (report.clips.size() > 1 ? "clips and their features" : "the features"));
  return lines;
}

}  // namespace

std::string as_text(const ScoreReport &report) {
  std::string text;
  for (const std::string &line : head(report)) text += line + "\n";
  for (const Table &table : tables(report)) text += "\n" + as_text(table);
  return text;
}

std::string as_markdown(const ScoreReport &report) {
  std::string text;
  for (const std::string &line : head(report)) text += "* " + line + "\n";
  text += "\n";
  for (const Table &table : tables(report)) text += as_markdown(table) + "\n";
  return text;
}

}  // namespace csd::programs
