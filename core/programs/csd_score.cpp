// SPDX-License-Identifier: LGPL-2.1-or-later
// csd-score: scores tracks against ground truth. docs/metrics.md has the definitions.
#include <glib.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "programs/command_line.h"
#include "programs/decimal.h"
#include "programs/palindrome_report.h"
#include "programs/read_input.h"
#include "programs/score_plots.h"
#include "programs/score_report.h"
#include "score/align.h"
#include "text/read_line.h"

namespace csd::programs {
namespace {

struct Options {
  std::vector<std::string> files, names;
  std::string plots;
  score::AlignOptions align;
  unsigned resamples = 10000;
  bool json = false, csv = false, markdown = false, print_points = false, palindrome = false;
};

template <typename Number>
Number whole(std::string_view text, const char *option) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size())
    throw UsageError(std::string(option) + ": '" + std::string(text) + "' is no whole number");
  return number;
}

std::vector<std::string> split(const std::string &text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return parts;
    begin = end + 1;
  }
}

/// "0,3,5-9"
std::vector<FeatureId> parse_ids(const std::string &text) {
  std::vector<FeatureId> ids;
  for (const std::string &part : split(text, ',')) {
    const std::size_t dash = part.find('-');
    const auto first = whole<FeatureId>(part.substr(0, dash), "--ids");
    const auto last = dash == std::string::npos ? first : whole<FeatureId>(part.substr(dash + 1), "--ids");
    if (last < first || last - first >= max_points) throw UsageError("--ids: '" + part + "' is no range");
    for (FeatureId id = first; id <= last; ++id) ids.push_back(id);
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

Options parse(int argc, char **argv) {
  Options options;
  gchar **files = nullptr, *names = nullptr, *size = nullptr, *ids = nullptr, *plots = nullptr;
  gint resamples = static_cast<gint>(options.resamples);
  gboolean json = FALSE, csv = FALSE, markdown = FALSE, by_frame = FALSE, points = FALSE, palindrome = FALSE;
  const GOptionEntry entries[] = {
      {"json", 0, 0, G_OPTION_ARG_NONE, &json, "Write JSON, with the scores of each frame, instead of tables", nullptr},
      {"csv", 0, 0, G_OPTION_ARG_NONE, &csv, "Write CSV instead of tables, a row per number", nullptr},
      {"markdown", 0, 0, G_OPTION_ARG_NONE, &markdown, "Write Markdown tables", nullptr},
      {"plots", 0, 0, G_OPTION_ARG_FILENAME, &plots, "Also draw curves into DIR, as SVG and PNG (runs gnuplot)", "DIR"},
      {"names", 0, 0, G_OPTION_ARG_FILENAME, &names, "What to call the trackers, in the order of TRACKS", "A,B,..."},
      {"ids", 0, 0, G_OPTION_ARG_STRING, &ids, "Score these features of the truth only", "0,3,5-9"},
      {"size", 0, 0, G_OPTION_ARG_STRING, &size, "The picture's size, where the files don't say", "WxH"},
      {"by-frame", 0, 0, G_OPTION_ARG_NONE, &by_frame, "Match by frame number even where the truth has pts", nullptr},
      {"resamples", 0, 0, G_OPTION_ARG_INT, &resamples, "Draws of the bootstrap (10000); 0: no intervals", "N"},
      {"print-points", 0, 0, G_OPTION_ARG_NONE, &points,
       "Print the first frame's points for csdtrack's property `points`, and end", nullptr},
      {"palindrome", 0, 0, G_OPTION_ARG_NONE, &palindrome,
       "No TRUTH: each of TRACKS is of a video that was played forward and then backward", nullptr},
      {G_OPTION_REMAINING, 0, 0, G_OPTION_ARG_FILENAME_ARRAY, &files, nullptr, nullptr},
      {nullptr, 0, 0, G_OPTION_ARG_NONE, nullptr, nullptr, nullptr}};
  parse_options(
      argc, argv, entries,
      "TRUTH TRACKS... [TRUTH TRACKS...]... | --palindrome TRACKS...  - score tracks against ground truth",
      "TRUTH is csdtrackenc's .jsonl with role=truth, CSV with the columns frame,id,x,y,visible, VL-SurgPT's\n"
      "labels.json or a folder of STIR; TRACKS are csdtrackenc's .jsonl or .csv. A file is known by what it holds,\n"
      "whatever its name. Each TRUTH begins another clip, with tracks of the same trackers in the same order.\n"
      "Comparisons are with the first tracker. Exit code: 0 scored, 1 wrong or mismatched input, 2 wrong usage.\n"
      "docs/metrics.md defines every number.");
  const auto take = [](gchar *text) {
    std::string string = text ? text : "";
    g_free(text);
    return string;
  };
  for (gchar **file = files; file && *file; ++file) options.files.emplace_back(*file);
  g_strfreev(files);
  options.plots = take(plots);
  const std::string name_list = take(names), id_list = take(ids), size_text = take(size);
  if (!name_list.empty()) options.names = split(name_list, ',');
  if (!id_list.empty()) options.align.ids = parse_ids(id_list);
  if (!size_text.empty()) {
    const auto parts = split(size_text, 'x');
    if (parts.size() != 2) throw UsageError("--size: '" + size_text + "' is not WxH");
    options.align.width = whole<int>(parts[0], "--size");
    options.align.height = whole<int>(parts[1], "--size");
    if (options.align.width < 1 || options.align.height < 1) throw UsageError("--size: both are at least 1");
  }
  if (resamples < 0 || resamples > 10000000) throw UsageError("--resamples: from 0 to 10000000");
  options.resamples = static_cast<unsigned>(resamples);
  options.align.by_frame = by_frame;
  options.json = json;
  options.csv = csv;
  options.markdown = markdown;
  options.print_points = points;
  if (options.json + options.csv + options.markdown > 1) throw UsageError("one of --json, --csv and --markdown");
  options.palindrome = palindrome;
  if (palindrome && (csv || points || by_frame || !options.names.empty() || !options.align.ids.empty() ||
                     !size_text.empty() || !options.plots.empty()))
    throw UsageError("--palindrome goes with --json or --markdown, and with no other option");
  if (options.files.empty()) throw UsageError("no files; csd-score --help tells what it takes");
  return options;
}

void print_points(const score::Truth &truth) {
  std::string text;
  for (std::size_t i = 0; i < truth.ids.size(); ++i) {
    const score::TruthPoint &point = truth.frames.front().points[i];
    if (truth.ids[i] != i || point.presence != score::Presence::visible)
      throw score::InputError(truth.file, truth.frames.front().line,
                              "feature " + std::to_string(truth.ids[i]) +
                                  ": csdtrack's points have the ids 0, 1, 2…, and are visible in the first frame");
    text += (i ? ";" : "") + decimal(point.position.x, 3, "") + "," + decimal(point.position.y, 3, "");
  }
  std::printf("%s\n", text.c_str());
}

std::string name_of(const score::Recording &tracks) {
  return printable(tracks.algorithm.empty() ? std::filesystem::path(tracks.file).stem().string() : tracks.algorithm);
}

/// Reads the files and aligns each clip's tracks with its truth.
class Reader {
 public:
  explicit Reader(const Options &options) : options_(options) {}

  void read(std::vector<std::string> &notes) {
    for (const std::string &file : options_.files) {
      Input input = read_input(file, notes);
      if (auto *truth = std::get_if<score::Truth>(&input)) {
        end_clip();
        truth_ = std::move(*truth);
        place_ = 0;
      } else {
        add(std::get<score::Recording>(input), notes);
      }
    }
    end_clip();
    disambiguate();
  }

  std::vector<std::string> names;
  std::vector<std::vector<score::Clip>> clips;  ///< [tracker][clip]

 private:
  void add(const score::Recording &tracks, std::vector<std::string> &notes) {
    if (truth_.frames.empty()) throw score::InputError(tracks.file, 0, "is tracks; the truth comes first");
    if (first_clip_) {
      names.push_back(name_of(tracks));
      algorithms_.push_back(tracks.algorithm);
      files_.push_back(tracks.file);
      clips.emplace_back();
    } else if (place_ >= clips.size()) {
      throw score::InputError(tracks.file, 0, "is one more than the tracks of the clip before");
    } else if (tracks.algorithm != algorithms_[place_]) {
      throw score::InputError(tracks.file, 0,
                              "is by '" + printable(tracks.algorithm) + "', in the clip before '" +
                                  printable(algorithms_[place_]) + "' is in its place");
    }
    clips[place_++].push_back(align(truth_, tracks, options_.align, notes));
  }

  void end_clip() {
    if (truth_.frames.empty()) return;
    if (place_ == 0) throw score::InputError(truth_.file, 0, "is truth, and no tracks follow");
    if (place_ < clips.size())
      throw score::InputError(
          truth_.file, 0,
          "has tracks of " + std::to_string(place_) + " trackers, the clip before of " + std::to_string(clips.size()));
    first_clip_ = false;
  }

  /// Names two runs of one algorithm after their files.
  void disambiguate() {
    if (!options_.names.empty()) {
      if (options_.names.size() != names.size())
        throw UsageError("--names: " + std::to_string(options_.names.size()) + " names for " +
                         std::to_string(names.size()) + " trackers");
      std::transform(options_.names.begin(), options_.names.end(), names.begin(), printable);
      return;
    }
    const std::vector<std::string> plain = names;
    for (std::size_t i = 0; i < names.size(); ++i)
      if (std::count(plain.begin(), plain.end(), plain[i]) > 1)
        names[i] += " (" + printable(std::filesystem::path(files_[i]).stem().string()) + ")";
  }

  const Options &options_;
  score::Truth truth_;
  std::vector<std::string> algorithms_, files_;
  std::size_t place_ = 0;
  bool first_clip_ = true;
};

PalindromeReport palindromes(const Options &options, std::vector<std::string> &notes) {
  PalindromeReport report;
  for (const std::string &file : options.files) {
    const Input input = read_input(file, notes);
    const auto *tracks = std::get_if<score::Recording>(&input);
    if (!tracks) throw score::InputError(file, 0, "is truth, and a palindrome needs none");
    if (!notes.empty()) throw score::InputError(file, 0, "isn't whole, so nobody knows where the video turned");
    report.push_back({file, name_of(*tracks), score::score_palindrome(*tracks)});
  }
  return report;
}

void write(const std::string &text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) throw_unwritten();
}

void run(const Options &options, std::vector<std::string> &notes) {
  if (options.palindrome) {
    const PalindromeReport report = palindromes(options, notes);
    return write(options.json ? as_json(report) : options.markdown ? as_markdown(report) : as_text(report));
  }
  if (options.print_points) {
    if (options.files.size() != 1) throw UsageError("--print-points takes one TRUTH");
    const Input input = read_input(options.files.front(), notes);
    const auto *truth = std::get_if<score::Truth>(&input);
    if (!truth) throw score::InputError(options.files.front(), 0, "is tracks, not truth");
    return print_points(*truth);
  }
  Reader reader(options);
  reader.read(notes);
  const ScoreReport report = make_report(reader.names, reader.clips, notes, options.resamples);
  if (!options.plots.empty()) draw_plots(report, options.plots);
  write(options.json       ? as_json(report)
        : options.csv      ? as_csv(report)
        : options.markdown ? as_markdown(report)
                           : as_text(report));
}

int main(int argc, char **argv) {
  return run_command("csd-score", [&](std::vector<std::string> &notes) { run(parse(argc, argv), notes); });
}

}  // namespace
}  // namespace csd::programs

int main(int argc, char **argv) {
  return csd::programs::main(argc, argv);
}
