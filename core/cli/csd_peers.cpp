// SPDX-License-Identifier: LGPL-2.1-or-later
// csd-peers: trackers of today on the same points, for csd-score.
#include <getopt.h>
#include <unistd.h>

#include <charconv>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>

#include "cli/peers/start_points.h"
#include "cli/peers/track_line.h"
#include "cli/peers/video_source.h"

namespace {

using namespace csd::peers;
using Clock = std::chrono::steady_clock;

void print_usage(std::FILE *to) {
  std::fputs(
      "usage: csd-peers --tracker NAME --points POINTS [OPTIONS] VIDEO\n\n"
      "Follows points through VIDEO with a tracker that is not csdtrack's, and writes what it finds as csdtrackenc\n"
      "writes it, a line of JSON a frame, so that csd-score reads both. VIDEO is a file, or - for Y4M on standard "
      "input\n"
      "(... ! y4menc ! fdsink | csd-peers ... -).\n\n"
      "  -t, --tracker NAME   one of\n",
      to);
  for (const auto &kind : peer_kinds())
    std::fprintf(to, "                         %-12s %s\n", std::string(kind.name).c_str(),
                 std::string(kind.about).c_str());
  std::fputs(
      "  -p, --points POINTS  \"x,y;x,y\" in pixels (ids 0, 1, ...), or a file with truth or tracks, .jsonl or .csv:\n"
      "                       the points visible in its frame 0, under their ids\n"
      "  -f, --features N     only N of them, spread evenly over the list\n"
      "  -n, --frames N       only the first N frames; the rest of standard input is read and thrown away\n"
      "  -o, --out FILE       where to write (standard output)\n"
      "  -P, --progress       say every second how far it is, also where standard error is no terminal\n"
      "  -h, --help           this\n",
      to);
}

[[noreturn]] void misused(const std::string &text) {
  std::cerr << "csd-peers: " << text << " (see csd-peers --help)\n";
  std::exit(2);
}

std::size_t count(const char *text, const char *option) {
  const std::string_view s(text);
  std::size_t n = 0;
  const auto [stop, problem] = std::from_chars(s.data(), s.data() + s.size(), n);
  if (problem != std::errc() || stop != s.data() + s.size() || n == 0)
    misused(std::string(option) + " " + text + ": must be a whole number from 1");
  return n;
}

struct Arguments {
  const PeerKind *tracker = nullptr;
  std::string points, out, video;
  std::size_t features = 0, frames = 0;  ///< 0: all
  bool progress = isatty(STDERR_FILENO) != 0;
};

Arguments read_arguments(int argc, char **argv) {
  static const option options[] = {
      {"tracker", required_argument, nullptr, 't'},  {"points", required_argument, nullptr, 'p'},
      {"features", required_argument, nullptr, 'f'}, {"frames", required_argument, nullptr, 'n'},
      {"out", required_argument, nullptr, 'o'},      {"progress", no_argument, nullptr, 'P'},
      {"help", no_argument, nullptr, 'h'},           {nullptr, 0, nullptr, 0}};
  Arguments a;
  for (int c; (c = getopt_long(argc, argv, "t:p:f:n:o:Ph", options, nullptr)) != -1;) {
    switch (c) {
      case 't':
        a.tracker = find_peer(optarg);
        if (!a.tracker) misused(std::string("there is no tracker \"") + optarg + "\"");
        break;
      case 'p':
        a.points = optarg;
        break;
      case 'f':
        a.features = count(optarg, "--features");
        break;
      case 'n':
        a.frames = count(optarg, "--frames");
        break;
      case 'o':
        a.out = optarg;
        break;
      case 'P':
        a.progress = true;
        break;
      case 'h':
        print_usage(stdout);
        std::exit(0);
      default:
        std::exit(2);  // getopt has said why
    }
  }
  if (!a.tracker) misused("--tracker is missing");
  if (a.points.empty()) misused("--points is missing");
  if (argc - optind != 1) misused("one VIDEO is wanted, or -");
  a.video = argv[optind];
  return a;
}

void run(const Arguments &a) {
  const auto points = thinned(read_start_points(a.points), a.features);
  const auto source = open_video(a.video);
  std::ofstream file;
  if (!a.out.empty()) {
    file.open(a.out);
    if (!file) throw std::runtime_error(a.out + ": can't be written");
  }
  std::ostream &out = a.out.empty() ? std::cout : file;

  const auto peer = a.tracker->make();
  Picture picture;
  cv::Size size;
  std::uint64_t frame = 0;
  const auto begin = Clock::now();
  auto said = begin;
  Clock::duration tracking{};
  for (; (a.frames == 0 || frame < a.frames) && source->next(picture); ++frame) {
    if (frame > 0 && picture.bgr.size() != size) throw std::runtime_error(a.video + ": the picture's size changes");
    size = picture.bgr.size();
    const auto before = Clock::now();
    std::vector<Report> reports;
    if (frame == 0) {
      peer->start(picture.bgr, points.positions);
      for (const auto &p : points.positions) reports.push_back({p, true});
    } else {
      reports = peer->follow(picture.bgr);
    }
    const auto now = Clock::now();
    tracking += now - before;
    out << track_line(a.tracker->name, frame, picture, points.ids, reports) << std::flush;
    if (!out) throw std::runtime_error((a.out.empty() ? "standard output" : a.out) + ": can't be written");
    if (a.progress && now - said > std::chrono::seconds(1)) {
      said = now;
      const double seconds = std::chrono::duration<double>(now - begin).count();
      std::fprintf(stderr, "csd-peers: frame %llu, %.1f a second\n", static_cast<unsigned long long>(frame),
                   static_cast<double>(frame) / seconds);
    }
  }
  if (frame == 0) throw std::runtime_error(a.video + ": no frames in it");
  source->drain();
  if (a.progress)
    std::fprintf(
        stderr, "csd-peers: %llu frames, %zu points, %.3f ms a point and frame\n",
        static_cast<unsigned long long>(frame), points.ids.size(),
        std::chrono::duration<double, std::milli>(tracking).count() / static_cast<double>(frame * points.ids.size()));
}

}  // namespace

int main(int argc, char **argv) {
  const auto arguments = read_arguments(argc, argv);
  try {
    run(arguments);
  } catch (const std::exception &e) {
    std::cerr << "csd-peers: " << e.what() << '\n';
    return 1;
  }
}
