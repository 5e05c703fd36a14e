// SPDX-License-Identifier: LGPL-2.1-or-later
// How well an algorithm tracks simulated tissue: for quick tests while changing one. Runs simulator, Tracker and scores
// in one process without a pipeline. Published numbers come from pipelines/experiments. See --help.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bench/bound.h"
#include "bench/i420.h"
#include "bench/make_tuned.h"
#include "bench/sequences.h"
#include "csd/csd.h"
#include "csd/visibility.h"
#include "csd2012/choices.h"
#include "score/score.h"
#include "score/sensitivity.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace {

using namespace csd;
using namespace csd::bench;
namespace fs = std::filesystem;

struct Options {
  AlgorithmKind algorithm = AlgorithmKind::csd;
  Tuning tuning;
  csd2012::Choices choices;
  std::uint64_t frames = 500, first_seed = 1, last_seed = 1;
  std::size_t features = 100, worst = 0;
  std::int64_t budget = 0;  // a frame's, in reads of the clock
  bool list = false, bound = false;
  std::string keep, clips, evidence;
  std::vector<std::string> tissue;
  std::vector<Sequence> wanted;
};

/// Counts reports on features that waited in the frame.
struct Waiting {
  std::size_t reports = 0, claims = 0, right = 0;
  double believed = 0;  // sum of the claims' confidence
};

struct Row {
  score::TrackerScore score;
  double ms = 0;  // per frame
  Waiting waiting;
};

/// The evidence on which csd judged a feature, for tests/bench/fit. A line for every fifth frame, with the right
/// answer: 1 if the feature is visible and within 5 px (at 576 lines or less).
class EvidenceFile {
 public:
  void open(const std::string &name) {
    file_.open(name);
    file_ << "tissue,right";
    for (std::size_t i = 0; i < visibility_terms; ++i) file_ << ',' << visibility_name(i);
    file_ << '\n';
  }
  void add(const Csd &csd, const std::string &tissue, std::size_t frame, FeatureId id, const sim::TruthPoint &truth) {
    if (!file_.is_open() || frame % 5 != 4) return;
    const auto judged = csd.judged(id);
    if (!judged) return;
    const bool right = truth.visibility == sim::Visibility::visible &&
                       std::hypot(judged->position.x - truth.x, judged->position.y - truth.y) <=
                           score::tolerance(picture_size.height, score::headline_pixels);
    file_ << tissue << ',' << right;
    for (const double value : visibility_values(judged->evidence, default_tuning)) file_ << ',' << value;
    file_ << '\n';
  }
  void close() {
    if (file_.is_open() && !file_.flush()) throw std::runtime_error("--evidence: cannot write the file");
  }

 private:
  std::ofstream file_;
};

Row track(const Rendered &rendered, const Options &options, const std::string &name, score::Clip &clip,
          EvidenceFile &evidence) {
  Settings settings;
  settings.algorithm = options.algorithm;
  settings.points_from_start = true;
  settings.learn_synchronously = true;
  settings.content_area = ContentArea::full;
  settings.frame_budget = options.budget;
  settings.clock = [reads = std::int64_t{0}]() mutable { return reads++; };
  ThreadPool pool(1);
  auto made = make_tuned(settings, options.tuning, options.choices, pool);
  const auto *csd = dynamic_cast<const Csd *>(made.get());
  const auto tissue = name.substr(name.find('/') + 1);
  Tracker tracker(settings, std::move(made));
  std::vector<StartPoint> starts;
  for (const auto &point : rendered.truth[0])
    if (point.visibility == sim::Visibility::visible) {
      starts.push_back({point.id, {point.x, point.y}});
      clip.ids.push_back(point.id);
    }
  clip.width = picture_size.width;
  clip.height = picture_size.height;
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
    const auto &tracks = tracker.process(view_of(picture.data(), picture_size), pts, second / 25);
    row.ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    for (std::size_t f = 0; f < clip.ids.size(); ++f) {
      auto &sample = clip.at(f, i);
      const auto &truth = rendered.truth[i][clip.ids[f]];
      sample.presence = truth.visibility == sim::Visibility::visible  ? score::Presence::visible
                        : truth.visibility == sim::Visibility::hidden ? score::Presence::hidden
                                                                      : score::Presence::out;
      const auto &feature = tracks.features.at(f);  // by ascending id, like clip.ids
      sample.reported = true;
      sample.claimed = claims_position(feature.state);
      sample.dx = feature.x - truth.x;
      sample.dy = feature.y - truth.y;
      sample.confidence = feature.confidence;
      if (csd) evidence.add(*csd, tissue, i, feature.id, truth);
      if (feature.fresh) continue;
      ++row.waiting.reports;
      if (!sample.claimed) continue;
      ++row.waiting.claims;
      row.waiting.right +=
          sample.presence == score::Presence::visible &&
          std::hypot(sample.dx, sample.dy) <= score::tolerance(picture_size.height, score::headline_pixels);
      row.waiting.believed += sample.confidence;
    }
  }
  row.ms /= static_cast<double>(rendered.truth.size());
  row.score = score::score("", {&clip, 1}, 0, 1);
  return row;
}

/// Of the claims on hidden points, the share within 5 px (at 576 lines or less) of the truth: there, tissue still shows
/// through water or smoke.
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
    // The frames, one character for every fifth: . correct, m missed, w wrong, h claimed while hidden, blank hidden.
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

constexpr char usage[] =
    R"(usage: csd-accuracy [--algorithm csd] [--frames 500] [--features 100] [--seeds 1-2] [--set NAME=NUMBER]... [--keep DIR]
                    [--worst N] [--clips DIR] [--tissue DIR]... [--evidence FILE] [--bound] [--budget N] [--list] [SEQUENCE...]

Prints a row for each sequence and seed. SEQUENCE is a name, or else the beginning of several. hidden: the share of hidden samples
that is claimed. seen: of these claims, the share within 5 px of the truth. (last): for the last fifth.

--set       sets one of the algorithm's numbers (core/csd/tuning.h, core/csd2012/choices.h)
--clips     (or $CSDTRACK_CLIPS) adds sequences whose texture is a picture of real tissue, compressed as by recorders (ffmpeg)
--tissue    uses each picture and video of the folder (its first frame) as the texture of each kind of sequence, KIND/PICTURE.
            Only these run then. The output ends with a table: for each kind the means over its pictures, and the worst picture
--keep      keeps rendered sequences in DIR for the next run, as raw I420 beside their truth: rendering takes ten times as
            long as tracking
--worst     lists the N features with the largest errors
--evidence  writes the evidence of csd's judgements, for tests/bench/fit
--bound     adds the results of alignments that start at the true place
--budget    sets a frame's budget. Each read of the clock takes 1, so it is the same on every machine. Another line says how
            many of the waiting features were right
--list      lists the sequences and exits
)";

AlgorithmKind parse_algorithm(std::string_view name) {
  for (int i = 0; i < 8; ++i)
    if (algorithm_name(static_cast<AlgorithmKind>(i)) == name) return static_cast<AlgorithmKind>(i);
  throw std::runtime_error("no algorithm " + std::string(name));
}

Options parse(int argc, char **argv) {
  Options options;
  options.keep = fs::temp_directory_path().string();
  if (const char *clips = std::getenv("CSDTRACK_CLIPS")) options.clips = clips;
  std::vector<std::string> names, assignments;
  for (int i = 1; i < argc; ++i) {
    const std::string_view name = argv[i];
    const auto value = [&]() -> std::string {
      if (++i == argc) throw std::runtime_error(std::string(name) + " needs a value");
      return argv[i];
    };
    if (name == "--help" || name == "-h") {
      std::fputs(usage, stdout);
      std::exit(0);
    } else if (name == "--list") {
      options.list = true;
    } else if (name == "--bound") {
      options.bound = true;
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
    } else if (name == "--set") {
      assignments.push_back(value());
    } else if (name == "--evidence") {
      options.evidence = value();
    } else if (name == "--seeds") {
      const auto text = value();
      options.first_seed = options.last_seed = std::stoull(text);
      if (const auto dash = text.find('-'); dash != text.npos) options.last_seed = std::stoull(text.substr(dash + 1));
    } else if (name == "--tissue") {
      options.tissue.push_back(value());
    } else if (name.starts_with('-')) {
      throw std::runtime_error("there is no option " + std::string(name) + "; see csd-accuracy --help");
    } else {
      names.emplace_back(name);
    }
  }
  if (options.algorithm == AlgorithmKind::csd_forest) options.choices = csd2012::forest_choices();
  for (const auto &assignment : assignments)
    options.algorithm == AlgorithmKind::csd ? set(options.tuning, assignment) : set(options.choices, assignment);
  const auto known = options.tissue.empty() ? known_sequences(options.clips) : on_tissue(options.tissue);
  for (const auto &name : names) {
    const bool whole = std::any_of(known.begin(), known.end(), [&](const auto &s) { return s.name == name; });
    const auto before = options.wanted.size();
    for (const auto &sequence : known)
      if (whole ? sequence.name == name : sequence.name.starts_with(name)) options.wanted.push_back(sequence);
    if (options.wanted.size() == before) throw std::runtime_error("no sequence " + name);
  }
  if (names.empty()) options.wanted = known;
  return options;
}

/// The summary of --tissue: for each kind, the means over the pictures and the picture with the least sensitivity.
class Summary {
 public:
  void add(const std::string &name, const score::TrackerScore &score) {
    const auto slash = name.find('/');
    if (slash == name.npos) return;
    const Entry entry{name.substr(slash + 1), score.clips[0].paper.sensitivity, score.clips[0].paper.k,
                      score.curve[1].paper.sensitivity, score.reliability.ece()};
    if (kinds_.empty() || kinds_.back().first != name.substr(0, slash)) kinds_.push_back({name.substr(0, slash), {}});
    kinds_.back().second.push_back(entry);
  }
  void print() const {
    if (kinds_.empty()) return;
    std::printf("\n%-8s %8s  %6s %6s %6s %6s  %6s %6s  %s\n", "kind", "pictures", "sens2", "sens5", "K5", "ECE",
                "sens5", "K5", "of the worst");
    for (const auto &[kind, entries] : kinds_) {
      Entry mean;
      const auto n = static_cast<double>(entries.size());
      for (const auto &e : entries) {
        mean.sensitivity += e.sensitivity / n, mean.k += e.k / n;
        mean.within_2 += e.within_2 / n, mean.ece += e.ece / n;
      }
      const auto &worst = *std::min_element(
          entries.begin(), entries.end(), [](const Entry &a, const Entry &b) { return a.sensitivity < b.sensitivity; });
      std::printf("%-8s %8zu  %6.4f %6.4f %6.4f %6.4f  %6.4f %6.4f  %s\n", kind.c_str(), entries.size(), mean.within_2,
                  mean.sensitivity, mean.k, mean.ece, worst.sensitivity, worst.k, worst.picture.c_str());
    }
  }

 private:
  struct Entry {
    std::string picture;
    double sensitivity = 0, k = 0, within_2 = 0, ece = 0;
  };
  std::vector<std::pair<std::string, std::vector<Entry>>> kinds_;
};

}  // namespace

int main(int argc, char **argv) {
  try {
    const auto options = parse(argc, argv);
    if (options.list) {
      for (const auto &sequence : options.wanted) std::printf("%s\n", sequence.name.c_str());
      return 0;
    }
    std::printf("%-18s %4s  %6s %6s %6s %6s %6s %7s %6s %6s  %6s %6s %6s  %5s\n", "sequence", "seed", "sens2", "sens5",
                "K5", "hidden", "seen", "median", "95 %", "ECE", "sens5", "K5", "(last)", "ms");
    Summary summary;
    EvidenceFile evidence;
    if (!options.evidence.empty()) evidence.open(options.evidence);
    for (const auto &sequence : options.wanted)
      for (auto seed = options.first_seed; seed <= options.last_seed; ++seed) {
        const auto rendered = render(sequence, seed, options.frames, options.features, options.keep);
        score::Clip clip;
        const auto [score, ms, waiting] = track(rendered, options, sequence.name, clip, evidence);
        const auto &frames = score.clips[0].frames;
        const auto last = score::paper_score({frames.data() + frames.size() * 4 / 5, frames.size() / 5});
        std::printf("%-18s %4llu  %6.4f %6.4f %6.4f %6.4f %6.4f %7.3f %6.2f %6.4f  %6.4f %6.4f %6s  %5.2f\n",
                    sequence.name.c_str(), static_cast<unsigned long long>(seed), score.curve[1].paper.sensitivity,
                    score.clips[0].paper.sensitivity, score.clips[0].paper.k, score.total.hidden_claimed(),
                    seen_through(clip), score.error_median, score.error_95, score.reliability.ece(), last.sensitivity,
                    last.k, "", ms);
        summary.add(sequence.name, score);
        if (options.bound) {
          const auto bound = align_from_truth(rendered);
          std::printf("    from the truth: within 2 px %.4f, within 5 px %.4f; of what seems reliable, wrong %.4f\n",
                      bound.within_2, bound.within_5, bound.wrong);
        }
        if (options.budget > 0) {
          const auto claims = static_cast<double>(std::max<std::size_t>(waiting.claims, 1));
          std::printf("    waited: %.3f of the reports; of these, claims: %zu, right %.3f, believed %.3f\n",
                      static_cast<double>(waiting.reports) / static_cast<double>(clip.samples.size()), waiting.claims,
                      static_cast<double>(waiting.right) / claims, waiting.believed / claims);
        }
        if (options.worst) print_worst(clip, options.worst);
        std::fflush(stdout);
      }
    summary.print();
    evidence.close();
  } catch (const std::exception &e) {
    std::fprintf(stderr, "csd-accuracy: %s\n", e.what());
    return 1;
  }
  return 0;
}
