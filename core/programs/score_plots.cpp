// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/score_plots.h"

#include <glib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>

#include "programs/decimal.h"
#include "score/quantile.h"

namespace csd::programs {
namespace {

/// Lines with more points are drawn as means of neighbours.
constexpr std::size_t max_points = 200;

/// A gnuplot string: '' is a quotation mark. A newline would end it and start a command, so names must be printable().
std::string quoted(const std::string &text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

/// A literal title, without gnuplot's enhanced text.
std::string titled(const std::string &name) {
  return "title " + quoted(name) + " noenhanced";
}

std::string style(std::size_t i) {
  // Colour-blind safe colours (Okabe and Ito) of different lightness; dashes and marks for greyscale.
  constexpr const char *colours[] = {"#000000", "#0072b2", "#d55e00", "#56b4e9",
                                     "#009e73", "#e69f00", "#cc79a7", "#777777"};
  return "dt " + std::to_string(1 + i % 5) + " pt " + std::to_string(4 + i % 10) + " lc rgb '" +
         colours[i % std::size(colours)] + "'";
}

using Points = std::vector<std::pair<double, double>>;

std::string block(const std::string &name, const Points &points) {
  std::string text = "$" + name + " << EOD\n";
  for (const auto &[x, y] : points) text += decimal(x, 3, "NaN") + " " + decimal(y, 6, "NaN") + "\n";
  return text + "EOD\n";
}

/// One curve for each tracker, drawn into the panel that was set up before.
std::string curves(const ScoreReport &report, const std::string &panel, const std::vector<Points> &points) {
  std::string data, plot;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // gnuplot fails on a panel without points.
    if (std::none_of(points[i].begin(), points[i].end(), [](const auto &p) { return std::isfinite(p.second); }))
      continue;
    const std::string name = panel + std::to_string(i);
    const std::size_t interval = std::max<std::size_t>(1, points[i].size() / 8);
    data += block(name, points[i]);
    plot += (plot.empty() ? "plot $" : ", $") + name + " using 1:2 with linespoints pi " + std::to_string(interval) +
            " " + style(i) + " lw 2 " + titled(report.trackers[i].name);
  }
  return plot.empty() ? "" : data + plot + "\n";
}

/// The number of frames per point of a curve over time.
std::size_t frames_a_point(const ScoreReport &report) {
  std::set<std::uint64_t> frames;
  for (const auto &clip : report.clips)
    for (const score::Moment &moment : clip.moments) frames.insert(moment.frame);
  return std::max<std::size_t>(1, (frames.size() + max_points - 1) / max_points);
}

/// A per-frame score against the frame number: the mean over clips.
Points over_time(const ScoreReport &report, const score::TrackerScore &tracker, double (score::Counts::*of)() const) {
  std::map<std::uint64_t, std::vector<double>> frames;
  for (std::size_t c = 0; c < report.clips.size(); ++c)
    for (std::size_t t = 0; t < report.clips[c].moments.size(); ++t)
      frames[report.clips[c].moments[t].frame].push_back((tracker.clips[c].frames[t].*of)());
  const std::size_t together = frames_a_point(report);
  Points points;
  std::vector<double> x, y;
  for (const auto &[frame, values] : frames) {
    x.push_back(static_cast<double>(frame));
    y.push_back(score::mean_of_known(values));
    if (x.size() < together && frame != frames.rbegin()->first) continue;
    points.emplace_back(score::mean_of_known(x), score::mean_of_known(y));
    x.clear();
    y.clear();
  }
  return points;
}

template <typename Of>
std::vector<Points> of_each(const ScoreReport &report, Of of) {
  std::vector<Points> all;
  for (const score::TrackerScore &tracker : report.trackers) all.push_back(of(tracker));
  return all;
}

std::string time_script(const ScoreReport &report) {
  const auto panel = [&](const char *name, double (score::Counts::*of)() const) {
    return curves(report, name, of_each(report, [&](const auto &tracker) { return over_time(report, tracker, of); }));
  };
  const std::size_t together = frames_a_point(report);
  const std::string label = together > 1 ? "frame (means of " + std::to_string(together) + ")" : "frame";
  return "set multiplot layout 2,1\nset yrange [0:1]\nset xlabel " + quoted(label) + "\nset ylabel 'sensitivity'\n" +
         panel("s", &score::Counts::sensitivity) + "set ylabel '1 − precision'\n" + panel("k", &score::Counts::k) +
         "unset multiplot\n";
}

std::string threshold_script(const ScoreReport &report) {
  const auto panel = [&](const char *name, double score::PaperScore::*of) {
    return curves(report, name, of_each(report, [&](const score::TrackerScore &tracker) {
                    Points points;
                    for (const score::CurvePoint &point : tracker.curve)
                      points.emplace_back(point.pixels, point.paper.*of);
                    return points;
                  }));
  };
  std::string ticks;
  for (const double pixels : score::curve_pixels) ticks += (ticks.empty() ? "" : ",") + decimal(pixels, 0, "");
  return "set multiplot layout 2,1\nset logscale x 2\nset xrange [1:32]\nset yrange [0:1]\nset xtics (" + ticks +
         ")\nset xlabel 'τ, px at 576 lines or less'\nset ylabel 'sensitivity'\n" +
         panel("s", &score::PaperScore::sensitivity) + "set ylabel '1 − precision'\n" +
         panel("k", &score::PaperScore::k) + "unset multiplot\n";
}

std::string reliability_script(const ScoreReport &report) {
  return "set xrange [0:1]\nset yrange [0:1]\nset size ratio 1\nset xlabel 'confidence'\n"
         "set ylabel 'share visible and within τ'\nset arrow 1 from 0,0 to 1,1 nohead lc rgb '#bbbbbb'\n" +
         curves(report, "r", of_each(report, [](const score::TrackerScore &tracker) {
                  Points points;
                  for (const auto &bin : tracker.reliability.bins)
                    if (bin.reports) points.emplace_back(bin.mean_confidence(), bin.frequency());
                  return points;
                }));
}

/// Runs in the folder, so that no part of its name gets into the commands.
void run_gnuplot(const std::string &folder, const std::string &file) {
  std::string program = "gnuplot", argument = file;
  char *arguments[] = {program.data(), argument.data(), nullptr};
  GError *error = nullptr;
  gchar *said = nullptr;
  gint status = 0;
  std::string problem;
  if (!g_spawn_sync(folder.c_str(), arguments, nullptr, G_SPAWN_SEARCH_PATH, nullptr, nullptr, nullptr, &said, &status,
                    &error) ||
      !g_spawn_check_wait_status(status, &error)) {
    problem = std::string(error->message) + (said ? std::string("\n") + said : "");
    g_error_free(error);
  }
  g_free(said);
  if (!problem.empty()) throw std::runtime_error("no plots (gnuplot is in Debian's gnuplot-nox): " + problem);
}

/// The gnuplot script of a figure.
std::string plot_script(const ScoreReport &report, const std::string &figure, const std::string &terminal,
                        const std::string &file) {
  return "set encoding utf8\nset terminal " + terminal + "\nset output " + quoted(file) +
         "\nset grid lt 1 lc rgb '#dddddd'\nset key outside right noenhanced\n" +
         (figure == "over-time"        ? time_script(report)
          : figure == "over-threshold" ? threshold_script(report)
                                       : reliability_script(report)) +
         "unset output\n";
}

}  // namespace

void draw_plots(const ScoreReport &report, const std::string &folder) {
  std::filesystem::create_directories(folder);
  std::string script;
  for (const char *const figure : {"over-time", "over-threshold", "reliability"}) {
    const std::string file = figure;
    script += plot_script(report, figure, "svg size 800,640 dynamic background '#ffffff'", file + ".svg") + "reset\n";
    script += plot_script(report, figure, "pngcairo size 1200,960 fontscale 1.2", file + ".png") + "reset\n";
  }
  const std::string commands = (std::filesystem::path(folder) / "plots.gp").string();
  std::ofstream out(commands, std::ios::binary);
  out << script;
  out.close();
  if (!out) throw std::runtime_error(commands + ": can't be written");
  run_gnuplot(folder, "plots.gp");
}

}  // namespace csd::programs
