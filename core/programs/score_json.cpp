// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/json_writer.h"
#include "programs/score_report.h"
#include "score/tap_vid.h"

namespace csd::programs {
namespace {

void add_interval(JsonWriter &out, const score::Interval &interval) {
  out.key("low").value(interval.low).key("high").value(interval.high);
}

void add_paper(JsonWriter &out, const score::PaperScore &paper) {
  out.key("sensitivity").value(paper.sensitivity).key("k").value(paper.k).key("k_visible").value(paper.k_visible);
}

void add_counts(JsonWriter &out, const score::Counts &counts) {
  out.key("counts").begin_object();
  out.key("correct").whole(counts.correct).key("wrong").whole(counts.wrong).key("missed").whole(counts.missed);
  out.key("hidden_claimed").whole(counts.on_hidden).key("hidden_quiet").whole(counts.quiet);
  out.end_object();
}

void add_clips(JsonWriter &out, const ScoreReport &report) {
  out.key("clips").begin_array();
  for (const auto &clip : report.clips) {
    out.begin_object().key("truth").text(clip.truth);
    out.key("width").whole(static_cast<std::uint64_t>(clip.width));
    out.key("height").whole(static_cast<std::uint64_t>(clip.height));
    out.key("tau").value(score::tolerance(clip.height, score::headline_pixels));
    out.key("features").whole(clip.features).key("frames").begin_array();
    for (const score::Moment &moment : clip.moments) out.whole(moment.frame);
    out.end_array().key("tracks").begin_array();
    for (const std::string &tracks : clip.tracks) out.text(tracks);
    out.end_array().end_object();
  }
  out.end_array();
}

void add_curve(JsonWriter &out, const score::TrackerScore &tracker) {
  out.key("curve").begin_array();
  for (const score::CurvePoint &point : tracker.curve) {
    out.begin_object().key("pixels").value(point.pixels);
    add_paper(out, point.paper);
    out.end_object();
  }
  out.end_array();
}

void add_stir(JsonWriter &out, const score::TrackerScore &tracker) {
  out.key("stir_2026").begin_object();
  out.key("aj").value(tracker.stir_2026.aj).key("ata").value(tracker.stir_2026.delta_avg);
  out.key("oa").value(tracker.stir_2026.oa).key("pixels").values(score::stir_2026_pixels);
  out.key("jaccard").values(tracker.stir_2026.jaccard).key("within").values(tracker.stir_2026.within).end_object();
  out.key("stir_2024").begin_object();
  out.key("delta_avg").value(tracker.stir_2024.delta_avg).key("pixels").values(score::stir_2024_pixels);
  out.key("within").values(tracker.stir_2024.within).key("end_error_median").value(tracker.stir_2024_median);
  out.key("control_delta_avg").value(tracker.stir_2024_control.delta_avg);
  out.key("control_within").values(tracker.stir_2024_control.within).end_object();
}

void add_reliability(JsonWriter &out, const score::Reliability &reliability) {
  out.key("calibration").begin_object().key("ece").value(reliability.ece()).key("bins").begin_array();
  for (const score::Reliability::Bin &bin : reliability.bins)
    out.begin_object()
        .key("reports")
        .whole(bin.reports)
        .key("confidence")
        .value(bin.mean_confidence())
        .key("frequency")
        .value(bin.frequency())
        .end_object();
  out.end_array().end_object();
}

void add_tracker_clips(JsonWriter &out, const score::TrackerScore &tracker) {
  out.key("clips").begin_array();
  for (const score::ClipScore &clip : tracker.clips) {
    out.begin_object();
    add_paper(out, clip.paper);
    add_counts(out, clip.total);
    out.key("sensitivity_by_frame").begin_array();
    for (const score::Counts &frame : clip.frames) out.value(frame.sensitivity());
    out.end_array().key("k_by_frame").begin_array();
    for (const score::Counts &frame : clip.frames) out.value(frame.k());
    out.end_array().end_object();
  }
  out.end_array();
}

void add_tracker(JsonWriter &out, const score::TrackerScore &tracker) {
  out.begin_object().key("name").text(tracker.name);
  for (std::size_t h = 0; h < score::headline_count; ++h) {
    out.key(score::headline_name(h)).begin_object().key("value").value(tracker.headline[h]);
    add_interval(out, tracker.intervals[h]);
    out.end_object();
  }
  out.key("k_visible").value(tracker.k_visible);
  out.key("hidden_claimed").value(tracker.total.hidden_claimed());
  add_counts(out, tracker.total);
  add_curve(out, tracker);
  out.key("tap_vid").begin_object().key("pixels").values(score::tap_vid_pixels);
  out.key("within").values(tracker.tap_vid_within).key("jaccard").values(tracker.tap_vid_jaccard).end_object();
  add_stir(out, tracker);
  out.key("error").begin_object();
  out.key("median").value(tracker.error_median).key("percentile_95").value(tracker.error_95);
  out.key("first_fifth").value(tracker.error_first_fifth).key("last_fifth").value(tracker.error_last_fifth);
  out.key("drift").value(tracker.drift()).end_object();
  out.key("recovery").begin_object();
  out.key("returns").whole(tracker.returns).key("recovered").whole(tracker.recovered);
  out.key("median_frames").value(tracker.recovery_median_frames);
  out.key("median_seconds").value(tracker.recovery_median_seconds).end_object();
  add_reliability(out, tracker.reliability);
  add_tracker_clips(out, tracker);
  out.end_object();
}

}  // namespace

std::string as_json(const ScoreReport &report) {
  JsonWriter out;
  out.begin_object().key("schema").whole(1).key("resamples").whole(report.resamples);
  add_clips(out, report);
  out.key("trackers").begin_array();
  for (const score::TrackerScore &tracker : report.trackers) add_tracker(out, tracker);
  out.end_array().key("comparisons").begin_array();
  for (const ScoreReport::Pair &pair : report.pairs) {
    out.begin_object().key("a").text(report.trackers[pair.tracker].name);
    out.key("b").text(report.trackers.front().name);
    for (std::size_t h = 0; h < score::headline_count; ++h) {
      const score::Comparison &comparison = pair.comparisons[h];
      out.key(score::headline_name(h)).begin_object().key("difference").value(comparison.difference);
      add_interval(out, comparison.confidence);
      out.key("p").value(comparison.p).end_object();
    }
    out.end_object();
  }
  out.end_array().key("notes").begin_array();
  for (const std::string &note : report.notes) out.text(note);
  out.end_array().end_object();
  return out.finish();
}

}  // namespace csd::programs
