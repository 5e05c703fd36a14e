// SPDX-License-Identifier: LGPL-2.1-or-later
// How well an algorithm tracks simulated tissue: the loop for whoever changes one. Simulator, Tracker and scores in one
// process, no pipeline; what is published comes from pipelines/experiments.
//   csd-accuracy [--algorithm csd] [--frames 500] [--features 100] [--seeds 1-2] [--keep DIR] [--worst N] [--clips DIR]
//                [--budget N] [--list] [SEQUENCE...]
// prints a row for each sequence and seed. With --clips (or $CSDTRACK_CLIPS) also sequences whose texture is a picture
// of real tissue, compressed as recorders do (by ffmpeg). With --keep, rendered sequences are kept in DIR as raw I420
// beside their truth, for the next run: rendering costs ten times what tracking does. --worst lists the features that
// erred most. hidden: the share of hidden samples that is claimed; seen: of these claims, the share within 5 px of the
// truth; (last): of the last fifth. --budget: a frame's, where each look at the clock takes 1, so it is the same on
// every machine; another line says of what waited how much was right. --list names the sequences and ends.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "score/score.h"
#include "score/sensitivity.h"
#include "sim/simulator.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace {

using namespace csd;
namespace fs = std::filesystem;

struct Sequence {
  const char *name;
  sim::Scenario scenario;
  const char *effects;
  sim::Style style;
  const char *clip = nullptr;  // its first frame is the texture
};

using S = sim::Scenario;
using T = sim::Style;
constexpr Sequence sequences[] = {
    {"deformation-heart", S::deformation, "", T::heart},
    {"deformation-liver", S::deformation, "", T::liver},
    {"low-texture", S::low_texture, "", T::liver},
    {"tools-liver", S::occlusion, "", T::liver},
    {"tools-heart", S::occlusion, "", T::heart},
    {"irrigation", S::occlusion, "tools=0.7,heart-mild=0,liver=0.7,blood=1,irrigation=1", T::liver},
    {"zoom-heart", S::zoom, "", T::heart},
    {"zoom-peritoneum", S::zoom, "", T::peritoneum},
    {"rotation", S::rotation, "", T::peritoneum},
    {"smoke", S::smoke, "", T::bowel},
    {"specular-fat", S::specular, "", T::fat},
    {"specular-heart", S::specular, "", T::heart},
    {"mixed-heart", S::mixed, "", T::heart},
    {"mixed-bowel", S::mixed, "", T::bowel},
    {"cut", S::cut, "", T::bowel},
    {"wipe", S::deformation, "wipe=1", T::heart},
    {"black", S::rotation, "black=1,zoom=0.5", T::heart},
    {"picture-light", S::deformation, "heart-mild=0,heart-strong=1,light=1", T::heart, "heart.mkv"},
    {"picture-tools", S::occlusion, "specular=1,light=1,sway=1", T::heart, "abdomen.mkv"},
    {"picture-zoom", S::zoom, "specular=1", T::heart, "cutting.mp4"},
    {"picture-rotation", S::rotation, "smoke=1", T::heart, "cholecystectomy.mp4"},
};
const cv::Size size{640, 480};
constexpr std::size_t frame_bytes = std::size_t{640} * 480 * 3 / 2;

struct Options {
  AlgorithmKind algorithm = AlgorithmKind::csd;
  std::uint64_t frames = 500, first_seed = 1, last_seed = 1;
  std::size_t features = 100, worst = 0;
  std::int64_t budget = 0;  // of a frame, in looks at the clock
  bool list = false;
  std::string keep, clips;
  std::vector<Sequence> wanted;
};

/// A rendered sequence: pictures on disk, truth in memory, features × frames.
struct Rendered {
  std::vector<std::vector<sim::TruthPoint>> truth;  // by frame
  std::string file;
};

cv::Mat first_frame(const std::string &video) {
  cv::Mat frame;
  cv::VideoCapture(video).read(frame);
  if (frame.empty()) throw std::runtime_error("no picture in " + video);
  return frame;
}

/// The file's pictures, as they look after H.264.
void compress(const std::string &file) {
  const std::string raw = "-f rawvideo -pix_fmt yuv420p -s 640x480 -r 25 ", plain = file + ".plain";
  fs::rename(file, plain);
  const auto command = "ffmpeg -v error " + raw + "-i '" + plain +
                       "' -c:v libx264 -crf 23 -f h264 - | ffmpeg -v error -f h264 " + "-i - " + raw + "'" + file + "'";
  if (std::system(command.c_str()) != 0 || fs::file_size(file) != fs::file_size(plain))
    throw std::runtime_error("failed: " + command);
  fs::remove(plain);
}

Rendered render(const Sequence &sequence, std::uint64_t seed, const Options &options) {
  Rendered out;
  const std::string stem =
      (fs::path(options.keep) / (std::string(sequence.name) + '-' + std::to_string(seed) + '-' +
                                 std::to_string(options.frames) + '-' + std::to_string(options.features)))
          .string();
  out.file = stem + ".i420";
  if (std::ifstream in(stem + ".truth", std::ios::binary); in) {
    std::uint64_t n = 0;
    for (std::uint64_t i = 0; i < options.frames; ++i) {
      in.read(reinterpret_cast<char *>(&n), sizeof n);
      std::vector<sim::TruthPoint> points(n);
      in.read(reinterpret_cast<char *>(points.data()), static_cast<std::streamsize>(n * sizeof(sim::TruthPoint)));
      out.truth.push_back(std::move(points));
    }
    if (in) return out;
    out.truth.clear();
  }
  sim::SimSettings settings;
  settings.effects = sim::scenario_effects(sequence.scenario);
  settings.effects.set(sequence.effects);
  settings.seed = seed;
  settings.style = sequence.style;
  settings.size = size;
  if (sequence.clip) settings.texture = first_frame((fs::path(options.clips) / sequence.clip).string());
  sim::Simulator simulator(settings);
  const auto surface = simulator.on_surface(0, simulator.detect(options.features));
  std::ofstream pictures(out.file, std::ios::binary), truth(stem + ".truth.part", std::ios::binary);
  cv::Mat bgr, i420;
  for (std::uint64_t i = 0; i < options.frames; ++i) {
    simulator.render(i, bgr);
    cv::cvtColor(bgr, i420, cv::COLOR_BGR2YUV_I420);
    pictures.write(reinterpret_cast<const char *>(i420.data), frame_bytes);
    out.truth.push_back(simulator.truth(i, surface));
    const std::uint64_t n = out.truth.back().size();
    truth.write(reinterpret_cast<const char *>(&n), sizeof n);
    truth.write(reinterpret_cast<const char *>(out.truth.back().data()),
                static_cast<std::streamsize>(n * sizeof(sim::TruthPoint)));
  }
  truth.close();
  pictures.close();
  if (!pictures || !truth) throw std::runtime_error("cannot write " + stem + ".*");
  if (sequence.clip) compress(out.file);
  fs::rename(stem + ".truth.part", stem + ".truth");
  return out;
}

FrameView view(const std::vector<std::uint8_t> &i420) {
  FrameView v;
  v.width = size.width;
  v.height = v.rows = size.height;
  v.model = ColourModel::yuv;
  v.kr = 0.299;  // cv::cvtColor's
  v.kb = 0.114;
  const std::ptrdiff_t width = size.width, luma = width * size.height;
  v.component[0] = {i420.data(), width, 1, 1, 0, 0, 0};
  v.component[1] = {i420.data() + luma, width / 2, 1, 1, 0, 1, 1};
  v.component[2] = {i420.data() + luma + luma / 4, width / 2, 1, 1, 0, 1, 1};
  return v;
}

/// Reports on features that nobody looked at in the frame.
struct Waiting {
  std::size_t reports = 0, claims = 0, right = 0;
  double believed = 0;  // sum of the claims' confidence
};

struct Row {
  score::TrackerScore score;
  double ms = 0;  // of a frame
  Waiting waiting;
};

Row track(const Rendered &rendered, const Options &options, score::Clip &clip) {
  Settings settings;
  settings.algorithm = options.algorithm;
  settings.points_from_start = true;
  settings.learn_synchronously = true;
  settings.content_area = ContentArea::full;
  settings.frame_budget = options.budget;
  settings.clock = [looks = std::int64_t{0}]() mutable { return looks++; };
  ThreadPool pool(1);
  Tracker tracker(settings, pool);
  std::vector<StartPoint> starts;
  for (const auto &point : rendered.truth[0])
    if (point.visibility == sim::Visibility::visible) {
      starts.push_back({point.id, {point.x, point.y}});
      clip.ids.push_back(point.id);
    }
  clip.width = size.width;
  clip.height = size.height;
  clip.moments.resize(rendered.truth.size());
  clip.samples.resize(clip.ids.size() * clip.moments.size());
  std::vector<std::uint8_t> picture(frame_bytes);
  std::ifstream in(rendered.file, std::ios::binary);
  Row row;
  for (std::size_t i = 0; i < rendered.truth.size(); ++i) {
    if (!in.read(reinterpret_cast<char *>(picture.data()), frame_bytes))
      throw std::runtime_error(rendered.file + " is too short");
    const auto pts = static_cast<std::int64_t>(i) * second / 25;
    clip.moments[i] = {i, pts};
    tracker.offer_start(starts);
    const auto begin = std::chrono::steady_clock::now();
    const auto &tracks = tracker.process(view(picture), pts, second / 25);
    row.ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    for (std::size_t f = 0; f < clip.ids.size(); ++f) {
      auto &sample = clip.at(f, i);
      const auto &truth = rendered.truth[i][clip.ids[f]];
      sample.presence = truth.visibility == sim::Visibility::visible  ? score::Presence::visible
                        : truth.visibility == sim::Visibility::hidden ? score::Presence::hidden
                                                                      : score::Presence::out;
      const auto &feature = tracks.features.at(f);  // by ascending id, as clip.ids
      sample.reported = true;
      sample.claimed = claims_position(feature.state);
      sample.dx = feature.x - truth.x;
      sample.dy = feature.y - truth.y;
      sample.confidence = feature.confidence;
      if (feature.fresh) continue;
      ++row.waiting.reports;
      if (!sample.claimed) continue;
      ++row.waiting.claims;
      row.waiting.right += sample.presence == score::Presence::visible &&
                           std::hypot(sample.dx, sample.dy) <= score::tolerance(size.height, score::headline_pixels);
      row.waiting.believed += sample.confidence;
    }
  }
  row.ms /= static_cast<double>(rendered.truth.size());
  row.score = score::score("", {&clip, 1}, 0, 1);
  return row;
}

/// Of the claims on what the truth calls hidden, the share within 5 px (at 576 lines or less) of where it is: tissue
/// that is still seen, through water or smoke.
double seen_through(const score::Clip &clip) {
  const score::Outcomes outcomes(clip, score::tolerance(clip.height, score::headline_pixels));
  std::size_t claimed = 0, near = 0;
  for (std::size_t k = 0; k < clip.samples.size(); ++k) {
    if (clip.samples[k].presence != score::Presence::hidden || !outcomes.claimed[k]) continue;
    ++claimed;
    near += std::hypot(clip.samples[k].dx, clip.samples[k].dy) <= score::tolerance(clip.height, score::headline_pixels);
  }
  return claimed ? static_cast<double>(near) / static_cast<double>(claimed) : 0;
}

void print_worst(const score::Clip &clip, std::size_t wanted) {
  struct Feature {
    std::size_t index;
    score::Counts counts;
    std::size_t bad() const { return counts.wrong + counts.missed + counts.on_hidden; }
  };
  const score::Outcomes outcomes(clip, score::tolerance(clip.height, score::headline_pixels));
  std::vector<Feature> all;
  for (std::size_t f = 0; f < clip.ids.size(); ++f) {
    Feature feature{f, {}};
    for (std::size_t i = 0; i < clip.moments.size(); ++i) {
      const auto k = f * clip.moments.size() + i;
      if (outcomes.visible[k])
        ++(outcomes.correct[k]   ? feature.counts.correct
           : outcomes.claimed[k] ? feature.counts.wrong
                                 : feature.counts.missed);
      else
        ++(outcomes.claimed[k] ? feature.counts.on_hidden : feature.counts.quiet);
    }
    all.push_back(feature);
  }
  std::sort(all.begin(), all.end(), [](const Feature &a, const Feature &b) { return a.bad() > b.bad(); });
  all.resize(std::min(wanted, all.size()));
  for (const auto &feature : all) {
    if (feature.bad() == 0) break;
    std::printf("    %3u: correct %3llu missed %3llu wrong %3llu hidden %3llu ", clip.ids[feature.index],
                static_cast<unsigned long long>(feature.counts.correct),
                static_cast<unsigned long long>(feature.counts.missed),
                static_cast<unsigned long long>(feature.counts.wrong),
                static_cast<unsigned long long>(feature.counts.on_hidden));
    // The frames, a character for every fifth: . correct, m missed, w wrong, h claimed while hidden, blank hidden.
    for (std::size_t i = 0; i < clip.moments.size(); i += 5) {
      const auto k = feature.index * clip.moments.size() + i;
      std::putchar(outcomes.visible[k] ? (outcomes.correct[k]   ? '.'
                                          : outcomes.claimed[k] ? 'w'
                                                                : 'm')
                                       : (outcomes.claimed[k] ? 'h' : ' '));
    }
    std::putchar('\n');
  }
}

AlgorithmKind parse_algorithm(std::string_view name) {
  for (int i = 0; i < 8; ++i)
    if (algorithm_name(static_cast<AlgorithmKind>(i)) == name) return static_cast<AlgorithmKind>(i);
  throw std::runtime_error("no algorithm " + std::string(name));
}

Options parse(int argc, char **argv) {
  Options options;
  options.keep = fs::temp_directory_path().string();
  if (const char *clips = std::getenv("CSDTRACK_CLIPS")) options.clips = clips;
  for (int i = 1; i < argc; ++i) {
    const std::string_view name = argv[i];
    const auto value = [&]() -> std::string {
      if (++i == argc) throw std::runtime_error(std::string(name) + " needs a value");
      return argv[i];
    };
    if (name == "--list") {
      options.list = true;
    } else if (name == "--algorithm") {
      options.algorithm = parse_algorithm(value());
    } else if (name == "--frames") {
      options.frames = std::stoull(value());
    } else if (name == "--features") {
      options.features = std::stoull(value());
    } else if (name == "--worst") {
      options.worst = std::stoull(value());
    } else if (name == "--budget") {
      options.budget = std::stol(value());
    } else if (name == "--keep") {
      options.keep = value();
    } else if (name == "--clips") {
      options.clips = value();
    } else if (name == "--seeds") {
      const auto text = value();
      options.first_seed = options.last_seed = std::stoull(text);
      if (const auto dash = text.find('-'); dash != text.npos) options.last_seed = std::stoull(text.substr(dash + 1));
    } else {
      bool found = false;
      for (const auto &sequence : sequences)
        if (std::string_view(sequence.name).starts_with(name)) options.wanted.push_back(sequence), found = true;
      if (!found) throw std::runtime_error("no sequence " + std::string(name));
    }
  }
  if (options.wanted.empty()) options.wanted.assign(std::begin(sequences), std::end(sequences));
  if (options.clips.empty()) std::erase_if(options.wanted, [](const Sequence &s) { return s.clip; });
  return options;
}

}  // namespace

int main(int argc, char **argv) {
  try {
    const auto options = parse(argc, argv);
    if (options.list) {
      for (const auto &sequence : options.wanted) std::printf("%s\n", sequence.name);
      return 0;
    }
    std::printf("%-18s %4s  %6s %6s %6s %6s %6s %7s %6s %6s  %6s %6s %6s  %5s\n", "sequence", "seed", "sens2", "sens5",
                "K5", "hidden", "seen", "median", "95 %", "ECE", "sens5", "K5", "(last)", "ms");
    for (const auto &sequence : options.wanted)
      for (auto seed = options.first_seed; seed <= options.last_seed; ++seed) {
        const auto rendered = render(sequence, seed, options);
        score::Clip clip;
        const auto [score, ms, waiting] = track(rendered, options, clip);
        const auto &frames = score.clips[0].frames;
        const auto last = score::paper_score({frames.data() + frames.size() * 4 / 5, frames.size() / 5});
        std::printf("%-18s %4llu  %6.4f %6.4f %6.4f %6.4f %6.4f %7.3f %6.2f %6.4f  %6.4f %6.4f %6s  %5.2f\n",
                    sequence.name, static_cast<unsigned long long>(seed), score.curve[1].paper.sensitivity,
                    score.clips[0].paper.sensitivity, score.clips[0].paper.k, score.total.hidden_claimed(),
                    seen_through(clip), score.error_median, score.error_95, score.reliability.ece(), last.sensitivity,
                    last.k, "", ms);
        if (options.budget > 0) {
          const auto claims = static_cast<double>(std::max<std::size_t>(waiting.claims, 1));
          std::printf("    not looked at: %.3f of the reports; of these, claims: %zu, right %.3f, believed %.3f\n",
                      static_cast<double>(waiting.reports) / static_cast<double>(clip.samples.size()), waiting.claims,
                      static_cast<double>(waiting.right) / claims, waiting.believed / claims);
        }
        if (options.worst) print_worst(clip, options.worst);
        std::fflush(stdout);
      }
  } catch (const std::exception &e) {
    std::fprintf(stderr, "csd-accuracy: %s\n", e.what());
    return 1;
  }
  return 0;
}
