// SPDX-License-Identifier: LGPL-2.1-or-later
// csd-peers: current trackers on the same points, for csd-score.
#include <glib.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include "programs/command_line.h"
#include "programs/peers/start_points.h"
#include "programs/peers/track_line.h"
#include "programs/peers/video_source.h"

namespace csd::peers {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  const PeerKind *tracker = nullptr;
  std::string points, out, video;
  std::uint64_t features = G_MAXINT64, frames = G_MAXINT64;  ///< maximum
  bool progress = false;
};

std::string description() {
  std::string text =
      "Follows points through VIDEO with a tracker that is not csdtrack's, and writes what it finds as csdtrackenc\n"
      "writes it, a line of JSON a frame, so that csd-score reads both. VIDEO is a file, or - for Y4M on standard "
      "input\n"
      "(... ! y4menc ! fdsink | csd-peers ... -). POINTS are \"x,y;x,y\" in pixels (ids 0, 1, ...), or a file with "
      "truth\n"
      "or tracks, .jsonl or .csv: the points visible in its frame 0, under their ids.\n\nTrackers:\n";
  std::size_t widest = 0;
  for (const PeerKind &kind : peer_kinds()) widest = std::max(widest, kind.name.size());
  for (const PeerKind &kind : peer_kinds()) {
    const std::string name(kind.name);
    text += "  " + name + std::string(widest + 2 - name.size(), ' ') + std::string(kind.about) + "\n";
  }
  return text + "\nExit code: 0 tracked, 1 wrong input, 2 wrong usage.";
}

Options parse(int argc, char **argv) {
  Options options;
  gchar **files = nullptr, *tracker = nullptr, *points = nullptr, *out = nullptr;
  gint64 features = G_MAXINT64, frames = G_MAXINT64;
  gboolean progress = isatty(STDERR_FILENO) != 0;
  const GOptionEntry entries[] = {
      {"tracker", 't', 0, G_OPTION_ARG_FILENAME, &tracker, "One of those below", "NAME"},
      {"points", 'p', 0, G_OPTION_ARG_FILENAME, &points, "Where to begin", "POINTS"},
      {"features", 'f', 0, G_OPTION_ARG_INT64, &features, "Only N of the points, spread evenly over the list", "N"},
      {"frames", 'n', 0, G_OPTION_ARG_INT64, &frames,
       "Only the first N frames; the rest of standard input is read and thrown away", "N"},
      {"out", 'o', 0, G_OPTION_ARG_FILENAME, &out, "Where to write (standard output)", "FILE"},
      {"progress", 'P', 0, G_OPTION_ARG_NONE, &progress,
       "Say every second how far it is, also where standard error is no terminal", nullptr},
      {G_OPTION_REMAINING, 0, 0, G_OPTION_ARG_FILENAME_ARRAY, &files, nullptr, nullptr},
      {nullptr, 0, 0, G_OPTION_ARG_NONE, nullptr, nullptr, nullptr}};
  programs::parse_options(argc, argv, entries, "VIDEO  - trackers of today on the same points, for csd-score",
                          description().c_str());
  const std::string name = tracker ? tracker : "";
  options.points = points ? points : "";
  options.out = out ? out : "";
  options.video = files && files[0] && !files[1] ? files[0] : "";
  g_strfreev(files);
  for (gchar *text : {tracker, points, out}) g_free(text);

  if (name.empty()) throw programs::UsageError("--tracker is missing; csd-peers --help tells more");
  options.tracker = find_peer(name);
  if (!options.tracker) throw programs::UsageError("there is no tracker \"" + name + "\"; csd-peers --help lists them");
  if (options.points.empty()) throw programs::UsageError("--points is missing; csd-peers --help tells more");
  if (options.video.empty()) throw programs::UsageError("one VIDEO is wanted, or -; csd-peers --help tells more");
  if (features < 1) throw programs::UsageError("--features " + std::to_string(features) + ": at least 1");
  if (frames < 1) throw programs::UsageError("--frames " + std::to_string(frames) + ": at least 1");
  options.features = static_cast<std::uint64_t>(features);
  options.frames = static_cast<std::uint64_t>(frames);
  options.progress = progress;
  return options;
}

std::string size_text(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void run(const Options &options) {
  const auto points = thinned(read_start_points(options.points), options.features);
  const auto source = open_video(options.video);
  std::ofstream file;
  if (!options.out.empty()) {
    file.open(options.out);
    if (!file) throw std::runtime_error(options.out + ": can't be written");
  }
  std::ostream &out = options.out.empty() ? std::cout : file;

  const auto peer = options.tracker->make();
  Picture picture;
  cv::Size size;
  std::uint64_t frame = 0;
  const auto begin = Clock::now();
  auto said = begin;
  Clock::duration tracking{};
  for (; frame < options.frames && source->next(picture); ++frame) {
    if (frame > 0 && picture.bgr.size() != size)
      throw std::runtime_error(options.video + ": the picture's size changes");
    size = picture.bgr.size();
    if (points.width > 0 && size != cv::Size(points.width, points.height))
      throw std::runtime_error(options.points + " is of pictures of " + size_text({points.width, points.height}) +
                               ", " + options.video + " has " + size_text(size));
    const auto before = Clock::now();
    std::vector<Report> reports;
    if (frame == 0) {
      peer->start(picture, points.positions);
      for (const auto &p : points.positions) reports.push_back({p, true});
    } else {
      reports = peer->follow(picture);
    }
    const auto now = Clock::now();
    tracking += now - before;
    out << track_line(options.tracker->name, frame, picture, points.ids, reports) << std::flush;
    if (!out) throw std::runtime_error((options.out.empty() ? "standard output" : options.out) + ": can't be written");
    if (options.progress && now - said > std::chrono::seconds(1)) {
      said = now;
      const double seconds = std::chrono::duration<double>(now - begin).count();
      std::fprintf(stderr, "csd-peers: frame %llu, %.1f a second\n", static_cast<unsigned long long>(frame),
                   static_cast<double>(frame) / seconds);
    }
  }
  if (frame == 0) throw std::runtime_error(options.video + ": no frames in it");
  source->drain();
  if (options.progress)
    std::fprintf(
        stderr, "csd-peers: %llu frames, %zu points, %.3f ms a point and frame\n",
        static_cast<unsigned long long>(frame), points.ids.size(),
        std::chrono::duration<double, std::milli>(tracking).count() / static_cast<double>(frame * points.ids.size()));
}

int main(int argc, char **argv) {
  return programs::run_command("csd-peers", [&](std::vector<std::string> &) { run(parse(argc, argv)); });
}

}  // namespace
}  // namespace csd::peers

int main(int argc, char **argv) {
  return csd::peers::main(argc, argv);
}
