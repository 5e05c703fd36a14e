// SPDX-License-Identifier: LGPL-2.1-or-later
// The cost of csd on real video, and whether its points return to their start. Decodes each clip into memory, then
// tracks it forward and backward (a palindrome), with features that csd finds in the first frame. Quick, since it needs
// no pipeline.
//   bench-clips [--algorithm csd] [--features 50] [--frames 250] [--rivals] [--set NUMBER=VALUE]
//               [--threads 0] [VIDEO...]
// Without VIDEO it takes the clips in $CSDTRACK_CLIPS. Prints a row for each clip: the share of samples claimed; of two
// claims on the same image, the share more than 5 px apart (at 576 lines or less; docs/metrics.md); ms a frame: p50,
// p95, the most after the first frame, and the first. beads.mkv also gets its sensitivity and K, if beads.truth.csv
// lies beside it. --set changes a number of csd's Tuning, or after --algorithm csd-2012 or csd-forest of its Choices.
// --threads adds helping threads. --rivals adds OpenCV's PyrLK forward and backward on the same points, and its CSRT on
// ten of them.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bench/i420.h"
#include "bench/make_tuned.h"
#include "csd/tuning.h"
#include "csd2012/choices.h"
#include "score/sensitivity.h"
#include "track/thread_pool.h"
#include "track/tracker.h"
#if BENCH_CSRT
#include <opencv2/tracking.hpp>
#endif

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Options {
  csd::AlgorithmKind algorithm = csd::AlgorithmKind::csd;
  csd::Tuning tuning;
  csd::csd2012::Choices choices;
  unsigned threads = 0;  // in addition to this one
  unsigned features = 50;
  std::size_t frames = 250;
  bool rivals = false;
  std::size_t worst = 0;
  std::vector<fs::path> videos;
};

double ms(Clock::time_point from) {
  return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

struct Clip {
  std::string name;
  cv::Size size;
  std::vector<cv::Mat> pictures;  // I420, raw

  /// The picture of a frame of the palindrome.
  const cv::Mat &picture(std::size_t i) const { return pictures[std::min(i, 2 * pictures.size() - 2 - i)]; }
  std::size_t frames() const { return 2 * pictures.size() - 1; }
  /// This picture's pixels for 5 px at 576 lines or less.
  double tolerance() const { return 5 * std::max(1.0, size.height / 576.0); }
};

Clip load(const fs::path &file, std::size_t most) {
  Clip clip;
  clip.name = file.stem().string();
  cv::VideoCapture video(file.string());
  cv::Mat bgr, i420;
  while (clip.pictures.size() < most && video.read(bgr)) {
    bgr = bgr(cv::Rect(0, 0, bgr.cols & ~1, bgr.rows & ~1));
    clip.size = bgr.size();
    cv::cvtColor(bgr, i420, cv::COLOR_BGR2YUV_I420);
    clip.pictures.push_back(i420.clone());
  }
  if (clip.pictures.empty()) throw std::runtime_error("no picture in " + file.string());
  return clip;
}

struct Run {
  std::vector<std::vector<csd::Feature>> features;  // by frame, by ascending id
  std::vector<double> times;                        // ms
};

Run track(const Clip &clip, const Options &options, std::size_t frames, const std::vector<csd::StartPoint> &starts) {
  csd::Settings settings;
  settings.algorithm = options.algorithm;
  settings.max_features = options.features;
  settings.replenish = false;
  settings.forget_after = 0;
  settings.learn_synchronously = true;
  settings.points_from_start = !starts.empty();
  csd::ThreadPool pool(std::max(1U, options.threads), 10);
  csd::Tracker tracker(settings,
                       csd::bench::make_tuned(settings, options.tuning, options.choices, pool,
                                              options.threads > 0 ? csd::SideBySide(pool) : csd::SideBySide()));
  Run out;
  for (std::size_t i = 0; i < frames; ++i) {
    if (!starts.empty()) tracker.offer_start(starts);
    const auto begin = Clock::now();
    const auto &tracks = tracker.process(csd::bench::view_of(clip.picture(i).data, clip.size),
                                         static_cast<std::int64_t>(i) * csd::second / 25, csd::second / 25);
    out.times.push_back(ms(begin));
    out.features.push_back(tracks.features);
  }
  return out;
}

/// Pairs of claims, and those farther apart than the tolerance.
struct Palindrome {
  double claimed = 0, apart = 0;
};

Palindrome come_home(const Clip &clip, const Run &run) {
  const auto n = run.features.size();
  std::size_t samples = 0, claims = 0, pairs = 0, apart = 0;
  for (std::size_t i = 0; i < n; ++i) {
    samples += run.features.back().size();
    for (const auto &f : run.features[i]) {
      if (!csd::claims_position(f.state)) continue;
      ++claims;
      if (2 * i + 1 >= n) continue;
      const auto &mirror = run.features[n - 1 - i];
      const auto other = std::find_if(mirror.begin(), mirror.end(), [&](const auto &o) { return o.id == f.id; });
      if (other == mirror.end() || !csd::claims_position(other->state)) continue;
      ++pairs;
      apart += std::hypot(f.x - other->x, f.y - other->y) > clip.tolerance();
    }
  }
  return {static_cast<double>(claims) / static_cast<double>(std::max<std::size_t>(samples, 1)),
          static_cast<double>(apart) / static_cast<double>(std::max<std::size_t>(pairs, 1))};
}

void print_worst(const Clip &clip, const Run &run, std::size_t wanted) {
  struct Entry {
    csd::Feature start{};
    std::size_t apart = 0, claims = 0;
    double farthest = 0;
    std::string marks;
  };
  std::map<csd::FeatureId, Entry> all;
  const auto n = run.features.size();
  for (std::size_t i = 0; i < n; ++i)
    for (const auto &f : run.features[i]) {
      auto &e = all[f.id];
      if (e.marks.empty()) e.start = f;
      const bool claimed = csd::claims_position(f.state);
      e.claims += claimed;
      char mark = claimed ? '.' : f.state == csd::FeatureState::out ? 'o' : '-';
      const auto &mirror = run.features[n - 1 - i];
      const auto other = std::find_if(mirror.begin(), mirror.end(), [&](const auto &o) { return o.id == f.id; });
      if (claimed && other != mirror.end() && csd::claims_position(other->state)) {
        const double d = std::hypot(f.x - other->x, f.y - other->y);
        e.farthest = std::max(e.farthest, d);
        if (d > clip.tolerance()) ++e.apart, mark = 'x';
      }
      e.marks += mark;
    }
  std::vector<std::pair<csd::FeatureId, Entry>> order(all.begin(), all.end());
  std::sort(order.begin(), order.end(), [](const auto &a, const auto &b) {
    return a.second.apart != b.second.apart ? a.second.apart > b.second.apart : a.second.claims < b.second.claims;
  });
  order.resize(std::min(order.size(), wanted));
  for (const auto &[id, e] : order) {
    std::printf("  %3u (%6.1f %6.1f) claims %3zu apart %3zu farthest %5.1f ", id, e.start.x, e.start.y, e.claims,
                e.apart / 2, e.farthest);
    for (std::size_t i = 0; i < e.marks.size(); i += 6) std::putchar(e.marks[i]);
    std::putchar('\n');
  }
}

struct TruePoint {
  double x = 0, y = 0;
  int visible = 0;
};
using Truth = std::map<unsigned, std::map<unsigned, TruePoint>>;  // frame, id

Truth read_truth(const fs::path &file) {
  Truth out;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    unsigned frame = 0, id = 0;
    TruePoint p;
    if (std::sscanf(line.c_str(), "%u,%u,%lf,%lf,%d", &frame, &id, &p.x, &p.y, &p.visible) == 5) out[frame][id] = p;
  }
  return out;
}

/// The paper's sensitivity and K. Uncertain samples don't count.
csd::score::PaperScore score(const Clip &clip, const Run &run, const Truth &truth) {
  std::vector<csd::score::Counts> counts;
  for (std::size_t i = 0; i < run.features.size(); ++i) {
    csd::score::Counts c;
    const auto found = truth.find(static_cast<unsigned>(i));
    if (found == truth.end()) continue;
    for (const auto &f : run.features[i]) {
      const auto p = found->second.find(f.id);
      if (p == found->second.end() || p->second.visible == 2) continue;
      const bool claimed = csd::claims_position(f.state);
      const bool near = std::hypot(f.x - p->second.x, f.y - p->second.y) <= clip.tolerance();
      if (p->second.visible)
        ++(claimed ? near ? c.correct : c.wrong : c.missed);
      else
        ++(claimed ? c.on_hidden : c.quiet);
    }
    counts.push_back(c);
  }
  return csd::score::paper_score(counts);
}

/// ms a frame for OpenCV's PyrLK, forward and backward between successive frames, on csd's first points.
std::vector<double> time_lk(const Clip &clip, const std::vector<csd::Feature> &starts) {
  std::vector<cv::Point2f> points, next, back;
  for (const auto &f : starts) points.emplace_back(static_cast<float>(f.x), static_cast<float>(f.y));
  std::vector<unsigned char> found;
  std::vector<float> error;
  std::vector<double> times;
  for (std::size_t i = 0; !points.empty() && i + 1 < clip.pictures.size(); ++i) {
    const cv::Mat a = clip.pictures[i].rowRange(0, clip.size.height),
                  b = clip.pictures[i + 1].rowRange(0, clip.size.height);
    const auto begin = Clock::now();
    cv::calcOpticalFlowPyrLK(a, b, points, next, found, error);
    cv::calcOpticalFlowPyrLK(b, a, next, back, found, error);
    times.push_back(ms(begin));
    points = next;
  }
  return times;
}

std::vector<double> time_csrt([[maybe_unused]] const Clip &clip,
                              [[maybe_unused]] const std::vector<csd::Feature> &starts) {
  std::vector<double> times;
#if BENCH_CSRT
  constexpr std::size_t most = 10;
  constexpr int side = 31;
  std::vector<cv::Ptr<cv::TrackerCSRT>> trackers;
  cv::Mat bgr;
  cv::cvtColor(clip.pictures[0], bgr, cv::COLOR_YUV2BGR_I420);
  for (const auto &f : starts) {
    if (trackers.size() == most) break;
    const cv::Rect box(static_cast<int>(f.x) - side / 2, static_cast<int>(f.y) - side / 2, side, side);
    if ((box & cv::Rect({0, 0}, clip.size)) != box) continue;
    trackers.push_back(cv::TrackerCSRT::create());
    trackers.back()->init(bgr, box);
  }
  for (std::size_t i = 1; i < std::min<std::size_t>(clip.pictures.size(), 40); ++i) {
    cv::cvtColor(clip.pictures[i], bgr, cv::COLOR_YUV2BGR_I420);
    const auto begin = Clock::now();
    cv::Rect box;
    for (auto &t : trackers) t->update(bgr, box);
    times.push_back(ms(begin));
  }
#endif
  return times;
}

Options parse(int argc, char **argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view name = argv[i];
    const auto value = [&]() -> std::string {
      if (++i == argc) throw std::runtime_error(std::string(name) + " needs a value");
      return argv[i];
    };
    if (name == "--algorithm") {
      const auto wanted = value();
      for (int k = 0; k < 8; ++k)
        if (csd::algorithm_name(static_cast<csd::AlgorithmKind>(k)) == wanted)
          options.algorithm = static_cast<csd::AlgorithmKind>(k);
      if (options.algorithm == csd::AlgorithmKind::csd_forest) options.choices = csd::csd2012::forest_choices();
    } else if (name == "--threads") {
      options.threads = static_cast<unsigned>(std::stoul(value()));
    } else if (name == "--set") {
      const auto assignment = value();
      options.algorithm == csd::AlgorithmKind::csd ? set(options.tuning, assignment) : set(options.choices, assignment);
    } else if (name == "--features") {
      options.features = static_cast<unsigned>(std::stoul(value()));
    } else if (name == "--frames") {
      options.frames = std::stoul(value());
    } else if (name == "--worst") {
      options.worst = std::stoul(value());
    } else if (name == "--rivals") {
      options.rivals = true;
    } else if (name.starts_with("--")) {
      throw std::runtime_error("no option " + std::string(name));
    } else {
      options.videos.emplace_back(name);
    }
  }
  const char *clips = std::getenv("CSDTRACK_CLIPS");
  if (options.videos.empty() && clips && fs::is_directory(clips))
    for (const auto &entry : fs::directory_iterator(clips))
      if (entry.path().extension() == ".mkv" || entry.path().extension() == ".mp4")
        options.videos.push_back(entry.path());
  std::sort(options.videos.begin(), options.videos.end());
  return options;
}

void print_clip(const fs::path &file, const Options &options) {
  const auto clip = load(file, options.frames);
  const auto run = track(clip, options, clip.frames(), {});
  const auto home = come_home(clip, run);
  const std::vector<double> after(run.times.begin() + 1, run.times.end());
  std::printf("%-16s %4dx%-4d %6zu %4zu  %7.4f %6.4f  %6.2f %6.2f %6.1f %6.1f", clip.name.c_str(), clip.size.width,
              clip.size.height, clip.frames(), run.features.back().size(), home.claimed, home.apart,
              percentile(after, .5), percentile(after, .95), percentile(after, 1), run.times.front());
  if (options.rivals) {
    std::vector<csd::Feature> starts;
    for (const auto &features : run.features)
      if (starts.empty()) starts = features;
    const auto lk = time_lk(clip, starts), csrt = time_csrt(clip, starts);
    std::printf("  %6.2f %6.2f", percentile(lk, .5), percentile(lk, .95));
    csrt.empty() ? std::printf("       -      -")
                 : std::printf("  %6.1f %6.1f", percentile(csrt, .5), percentile(csrt, .95));
  }
  auto truth_file = file;
  if (const auto truth = read_truth(truth_file.replace_extension(".truth.csv")); !truth.empty()) {
    std::vector<csd::StartPoint> starts;
    for (const auto &[id, p] : truth.begin()->second)
      if (p.visible == 1) starts.push_back({id, {p.x, p.y}});
    const auto paper = score(clip, track(clip, options, clip.pictures.size(), starts), truth);
    std::printf("  truth %.4f/%.4f", paper.sensitivity, paper.k);
  }
  std::printf("\n");
  if (options.worst) print_worst(clip, run, options.worst);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char **argv) {
  try {
    const auto options = parse(argc, argv);
    std::printf("%-16s %9s %6s %4s  %7s %6s  %6s %6s %6s %6s%s\n", "clip", "size", "frames", "feat", "claimed", "apart",
                "p50", "p95", "most", "first", options.rivals ? "  LK f+b    95 %  CSRT10   95 %" : "");
    for (const auto &video : options.videos) print_clip(video, options);
  } catch (const std::exception &e) {
    std::fprintf(stderr, "bench-clips: %s\n", e.what());
    return 1;
  }
  return 0;
}
