// SPDX-License-Identifier: LGPL-2.1-or-later
// csd-motion: motion of tracked tissue. docs/motion.md has the definitions.
#include <glib.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "programs/command_line.h"
#include "programs/motion_report.h"
#include "programs/read_input.h"

namespace csd::programs {
namespace {

struct Options {
  std::string file;
  motion::Span span;
  motion::SearchOptions search;
  bool json = false, csv = false, series = false, progress = false;
};

constexpr gdouble absent = -INFINITY;  // the option wasn't given

Options parse(int argc, char **argv) {
  Options options;
  gchar **files = nullptr;
  gdouble from = absent, to = absent, fps = absent, window = options.search.window, lowest = options.search.lowest,
          highest = options.search.highest, alarm = options.search.false_alarm;
  gboolean json = FALSE, csv = FALSE, series = FALSE, progress = isatty(STDERR_FILENO) != 0;
  const GOptionEntry entries[] = {
      {"json", 0, 0, G_OPTION_ARG_NONE, &json, "Write JSON instead of tables", nullptr},
      {"csv", 0, 0, G_OPTION_ARG_NONE, &csv, "Write CSV instead of tables, a row per rhythm", nullptr},
      {"series", 0, 0, G_OPTION_ARG_NONE, &series,
       "Displacement and velocity in each frame: with --json also, with --csv instead", nullptr},
      {"from", 0, 0, G_OPTION_ARG_DOUBLE, &from, "Begin at this time of the tracks, seconds", "S"},
      {"to", 0, 0, G_OPTION_ARG_DOUBLE, &to, "End at this time", "S"},
      {"window", 0, 0, G_OPTION_ARG_DOUBLE, &window, "Look for rhythms in windows of so many seconds (60)", "S"},
      {"lowest", 0, 0, G_OPTION_ARG_DOUBLE, &lowest, "The slowest rhythm to look for (0.05)", "HZ"},
      {"highest", 0, 0, G_OPTION_ARG_DOUBLE, &highest, "The fastest rhythm to look for (4)", "HZ"},
      {"false-alarm", 0, 0, G_OPTION_ARG_DOUBLE, &alarm,
       "Report what noise alone would show with at most this probability (0.01; up to 1)", "P"},
      {"fps", 0, 0, G_OPTION_ARG_DOUBLE, &fps, "Frames a second, where the tracks have no pts", "N"},
      {"progress", 'P', 0, G_OPTION_ARG_NONE, &progress, "Say on stderr how far it is (default on a terminal)",
       nullptr},
      {G_OPTION_REMAINING, 0, 0, G_OPTION_ARG_FILENAME_ARRAY, &files, nullptr, nullptr},
      {nullptr, 0, 0, G_OPTION_ARG_NONE, nullptr, nullptr, nullptr}};
  parse_options(
      argc, argv, entries, "TRACKS  - displacement, velocity and rhythms of tracked tissue",
      "TRACKS is csdtrackenc's .jsonl or .csv, of tracks or of truth, known by what it holds. Rhythms (heart,\n"
      "breath) are found as peaks of a periodogram, of each feature and of the scene: rate, amplitude in\n"
      "pixels, harmonics, and the probability that noise alone would show them. Exit code: 0 analysed,\n"
      "1 wrong input, 2 wrong usage. docs/motion.md defines every number.");
  const bool one = files && files[0] && !files[1];
  if (one) options.file = files[0];
  g_strfreev(files);
  if (!one) throw UsageError("takes one file of TRACKS; csd-motion --help tells more");
  if (json && csv) throw UsageError("one of --json and --csv");
  if (series && !json && !csv) throw UsageError("--series goes with --json or --csv");
  for (const gdouble time : {from, to})
    if (time != absent && !std::isfinite(time)) throw UsageError("--from, --to: seconds");
  if (to != absent && from > to) throw UsageError("--from is after --to");
  if (!(window >= 5 && window <= 120)) throw UsageError("--window: from 5 to 120 seconds");
  if (!(lowest > 0 && lowest < highest && highest <= 10))
    throw UsageError("--lowest, --highest: above 0, the lowest below the highest, that at most 10 Hz");
  if (!(alarm > 0 && alarm <= 1)) throw UsageError("--false-alarm: above 0, at most 1");
  if (fps != absent && !(fps > 0 && fps <= 100000)) throw UsageError("--fps: above 0, at most 100000");
  if (from != absent) options.span.from = from;
  if (to != absent) options.span.to = to;
  if (fps != absent) options.span.fps = fps;
  options.search.window = window;
  options.search.lowest = lowest;
  options.search.highest = highest;
  options.search.false_alarm = alarm;
  options.json = json;
  options.csv = csv;
  options.series = series;
  options.progress = progress;
  return options;
}

/// Converts truth to tracks: visible points are claimed.
score::Recording as_tracks(const score::Truth &truth) {
  score::Recording tracks;
  tracks.file = truth.file;
  for (const score::TruthFrame &frame : truth.frames) {
    score::TrackFrame &added = tracks.frames.emplace_back();
    added.frame = frame.frame;
    added.pts = frame.pts;
    added.line = frame.line;
    for (std::size_t i = 0; i < truth.ids.size(); ++i)
      if (frame.points[i].presence == score::Presence::visible)
        added.features.push_back(
            {truth.ids[i], frame.points[i].position.x, frame.points[i].position.y, FeatureState::tracked, 1, true});
  }
  return tracks;
}

motion::Series read_series(const Options &options, std::vector<std::string> &notes) {
  if (std::filesystem::is_directory(options.file))
    throw score::InputError(options.file, 0, "is a folder: give a file of tracks");
  Input input = read_input(options.file, notes);
  const auto *truth = std::get_if<score::Truth>(&input);
  motion::Series series = series_of(truth ? as_tracks(*truth) : std::get<score::Recording>(input), options.span);
  if (!series.clock.empty() && series.clock != "pts")
    notes.push_back(options.file + ": pts go back, so the times are " + series.clock);
  if (series.left_out)
    notes.insert(notes.begin(), options.file + ":" + std::to_string(series.other_line) + ": " + left_out(series));
  return series;
}

/// Prints at most one line per second.
class Progress {
 public:
  void say(const std::string &what) {
    const auto now = Clock::now();
    if (now - said_ < std::chrono::seconds(1)) return;
    said_ = now;
    std::fprintf(stderr, "csd-motion: %s\n", what.c_str());
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point said_ = Clock::now();
};

void write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) throw_unwritten();
}

void run(Options options, std::vector<std::string> &notes) {
  Progress progress;
  if (options.progress) {
    std::fprintf(stderr, "csd-motion: reading %s\n", options.file.c_str());
    options.search.progress = [&](unsigned round, double share) {
      progress.say("round " + std::to_string(round + 1) + " of looking for rhythms, " +
                   std::to_string(static_cast<int>(100 * share)) + " %");
    };
  }
  MotionReport report{options.file, options.search.window, {}, {}};
  report.motion = motion::analyse(read_series(options, notes), options.search);
  if (std::none_of(report.motion.rhythms.begin(), report.motion.rhythms.end(),
                   [](const motion::Rhythms &rhythms) { return rhythms.windows > 0; }))
    notes.push_back(options.file + ": no feature is claimed long enough for rhythms");
  report.notes = notes;
  if (options.json)
    write_json(report, options.series, write);
  else if (options.series)
    write_series_csv(report, write);
  else
    write(options.csv ? as_csv(report) : as_text(report));
  if (std::fflush(stdout) != 0) throw_unwritten();
}

int main(int argc, char **argv) {
  return run_command("csd-motion", [&](std::vector<std::string> &notes) { run(parse(argc, argv), notes); });
}

}  // namespace
}  // namespace csd::programs

int main(int argc, char **argv) {
  return csd::programs::main(argc, argv);
}
