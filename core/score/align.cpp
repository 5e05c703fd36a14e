// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/align.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/find_id.h"
#include "score/quantile.h"

namespace csd::score {
namespace {

constexpr std::size_t absent = std::numeric_limits<std::size_t>::max();
constexpr double infinite = std::numeric_limits<double>::infinity();

/// The position of a labelled frame among the tracks' frames.
struct Place {
  std::size_t index = absent;  ///< of the frame; absent: it has no features, so the file has no rows for it
  std::size_t end = 0;         ///< number of frames of the tracks that are not later
};

std::string where(const Truth &truth, const TruthFrame &frame) {
  return truth.file + (frame.line ? std::string(":").append(std::to_string(frame.line)) : "");
}

/// Finds frames of the tracks by pts or number.
class Finder {
 public:
  Finder(const Truth &truth, const Recording &tracks, bool by_frame)
      : truth_(truth), tracks_(tracks), by_frame_(by_frame) {
    for (std::size_t i = 0; i < tracks.frames.size(); ++i) {
      const TrackFrame &frame = tracks.frames[i];
      if (frame.numbered) insert(by_number_, static_cast<std::int64_t>(frame.frame), i, "frame ");
      if (frame.pts != no_time) by_pts_.emplace(frame.pts, i);
    }
  }

  Place find(const TruthFrame &wanted) {
    const bool by_pts = wanted.pts != no_time && !by_frame_;
    if (by_pts && by_pts_.empty())
      throw InputError(tracks_.file, 0,
                       "has no pts, which " + truth_.file + " has (--by-frame matches by frame number)");
    if (by_pts && step_ == 0) prepare_pts();
    const auto &map = by_pts ? by_pts_ : by_number_;
    const std::int64_t key = by_pts ? wanted.pts : static_cast<std::int64_t>(wanted.frame);
    const auto found = by_pts ? nearest(key) : map.find(key);
    if (found != map.end()) return {found->second, found->second + 1};
    if (tracks_.sparse && !map.empty() && key < map.rbegin()->first) {
      const auto later = map.upper_bound(key);
      return {absent, later->second};
    }
    throw InputError(tracks_.file, 0,
                     "lacks frame " + std::to_string(wanted.frame) +
                         (by_pts ? " (pts " + std::to_string(wanted.pts) + ")" : "") + " of " + where(truth_, wanted));
  }

 private:
  using Map = std::map<std::int64_t, std::size_t>;

  void insert(Map &map, std::int64_t key, std::size_t index, const char *what) {
    const auto [old, fresh] = map.emplace(key, index);
    if (!fresh)
      throw InputError(tracks_.file, tracks_.frames[index].line,
                       what + std::to_string(key) + " a second time, first in line " +
                           std::to_string(tracks_.frames[old->second].line));
  }

  void prepare_pts() {
    Map unique;
    for (std::size_t i = 0; i < tracks_.frames.size(); ++i)
      if (tracks_.frames[i].pts != no_time) insert(unique, tracks_.frames[i].pts, i, "pts ");
    step_ = 1;  // a single frame: exact pts
    for (auto a = by_pts_.begin(), b = std::next(a); b != by_pts_.end(); ++a, ++b)
      step_ = a == by_pts_.begin() ? b->first - a->first : std::min(step_, b->first - a->first);
  }

  Map::const_iterator nearest(std::int64_t key) const {
    auto best = by_pts_.lower_bound(key);
    if (best == by_pts_.end() || (best != by_pts_.begin() && key - std::prev(best)->first < best->first - key)) --best;
    return 2 * std::abs(best->first - key) < step_ ? best : by_pts_.end();
  }

  const Truth &truth_;
  const Recording &tracks_;
  bool by_frame_;
  Map by_number_, by_pts_;
  std::int64_t step_ = 0;  ///< shortest between two pts
};

void set_size(Clip &clip, const Truth &truth, const Recording &tracks, const AlignOptions &options) {
  const auto agree = [&](int width, int height, const std::string &file) {
    if (width <= 0 || height <= 0) return;
    if (clip.width == 0) {
      clip.width = width;
      clip.height = height;
    } else if (width != clip.width || height != clip.height) {
      throw InputError(file, 0,
                       "is of " + std::to_string(width) + "x" + std::to_string(height) + " pixels, not of " +
                           std::to_string(clip.width) + "x" + std::to_string(clip.height));
    }
  };
  agree(options.width, options.height, "--size");
  agree(truth.width, truth.height, truth.file);
  tracks.check_one_size();
  agree(tracks.width, tracks.height, tracks.file);
  if (clip.width == 0)
    throw InputError(tracks.file, 0,
                     "says nothing of the picture's size, nor does " + truth.file + " (--size WxH tells)");
}

/// The truth's columns to score; fills clip.ids.
std::vector<std::size_t> choose(Clip &clip, const Truth &truth, const std::vector<FeatureId> &wanted) {
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < truth.ids.size(); ++i)
    if (wanted.empty() || std::binary_search(wanted.begin(), wanted.end(), truth.ids[i])) {
      columns.push_back(i);
      clip.ids.push_back(truth.ids[i]);
    }
  for (const FeatureId id : wanted)
    if (!std::binary_search(truth.ids.begin(), truth.ids.end(), id))
      throw InputError(truth.file, 0, "has no feature " + std::to_string(id));
  if (columns.empty()) throw InputError(truth.file, 0, "has no features");
  return columns;
}

/// A tracker's last report on each feature, frame by frame.
class LastReports {
 public:
  LastReports(const std::vector<FeatureId> &ids, const Recording &tracks)
      : ids_(ids), tracks_(tracks), reports_(ids.size()) {}

  /// Advances to `end` frames.
  void advance(std::size_t end) {
    for (; seen_ < end; ++seen_)
      for (const Feature &feature : tracks_.frames[seen_].features) {
        const auto id = find_id(ids_, feature.id, std::identity{});
        if (id != ids_.end()) reports_[static_cast<std::size_t>(id - ids_.begin())] = {feature, seen_};
      }
  }

  struct Report {
    Feature feature;
    std::size_t index = absent;  ///< of the frame; absent: none yet
    cv::Point2d position() const {
      return index == absent ? cv::Point2d(infinite, infinite) : cv::Point2d(feature.x, feature.y);
    }
  };
  const Report &operator[](std::size_t i) const { return reports_[i]; }

  /// Call after all frames.
  void check_all_mentioned(const Truth &truth) const {
    std::string missing;
    std::size_t count = 0;
    for (std::size_t i = 0; i < ids_.size(); ++i)
      if (reports_[i].index == absent && ++count <= 5) missing += (count > 1 ? ", " : "") + std::to_string(ids_[i]);
    if (count)
      throw InputError(tracks_.file, 0,
                       "never mentions feature" + std::string(count > 1 ? "s " : " ") + missing +
                           (count > 5 ? " and " + std::to_string(count - 5) + " more" : "") + " of " + truth.file +
                           " (--ids scores some features only)");
  }

 private:
  const std::vector<FeatureId> &ids_;
  const Recording &tracks_;
  std::vector<Report> reports_;
  std::size_t seen_ = 0;
};

Sample compare(const TruthPoint &point, const LastReports::Report &report, std::size_t index) {
  Sample sample;
  sample.presence = point.presence;
  sample.reported = report.index != absent && report.index == index;
  sample.claimed = sample.reported && claims_position(report.feature.state);
  sample.confidence = sample.reported ? report.feature.confidence : 0;
  const cv::Point2d difference = report.position() - point.position;
  if (std::isfinite(difference.x) && std::isfinite(difference.y)) {
    sample.dx = difference.x;
    sample.dy = difference.y;
  }
  return sample;
}

/// Notes tracks with other start positions: they belong to another clip, or have other ids.
void note_start(const Clip &clip, std::vector<std::string> &notes) {
  std::vector<double> distances;
  for (std::size_t f = 0; f < clip.ids.size(); ++f)
    for (std::size_t t = 0; t < clip.moments.size(); ++t)
      if (clip.at(f, t).visible()) {
        if (clip.at(f, t).claimed) distances.push_back(clip.at(f, t).distance());
        break;
      }
  const double median = quantile(std::move(distances), 0.5);
  if (median > tolerance(clip.height, 5))
    notes.push_back(clip.tracks + ": its features begin " + std::to_string(std::lround(median)) +
                    " px (median) from those of " + clip.truth + ": is it the same video, with the same ids?");
}

/// The report on a feature in a frame of the tracks, if that claims a position.
const Feature *claim_of(const TrackFrame &frame, FeatureId id) {
  const auto found = find_id(frame.features, id, &Feature::id);
  return found != frame.features.end() && claims_position(found->state) ? &*found : nullptr;
}

/// How much better the labels fit the frame `step` (1 or -1) from their own: of each labelled frame the mean over the
/// features that move, from -1 (they fit their own exactly) to 1 (they fit the other exactly).
std::vector<double> votes_for(int step, const Truth &truth, const std::vector<std::size_t> &columns,
                              const Recording &tracks, const std::vector<Place> &places) {
  std::vector<double> votes;
  for (std::size_t t = 0; t < places.size(); ++t) {
    const std::size_t index = places[t].index, other = index + static_cast<std::size_t>(step);
    if (index == absent || other >= tracks.frames.size() ||
        tracks.frames[other].frame != tracks.frames[index].frame + static_cast<std::uint64_t>(step))
      continue;
    double sum = 0, weights = 0;
    for (const std::size_t column : columns) {
      const TruthPoint &label = truth.frames[t].points[column];
      const Feature *const here = claim_of(tracks.frames[index], truth.ids[column]), *const there =
                                                                                         claim_of(tracks.frames[other],
                                                                                                  truth.ids[column]);
      if (label.presence != Presence::visible || !here || !there) continue;
      const double from_here = std::hypot(here->x - label.position.x, here->y - label.position.y),
                   from_there = std::hypot(there->x - label.position.x, there->y - label.position.y);
      // Less of what hardly moves; a jump of the tracker's counts no more than a pixel.
      const double weight = std::min(std::hypot(there->x - here->x, there->y - here->y), 1.0);
      if (weight > 0) sum += weight * (from_here - from_there) / (from_here + from_there);
      weights += weight;
    }
    if (weights > 0) votes.push_back(sum / weights);
  }
  return votes;
}

/// Notes labels that are numbered from 1, or otherwise one frame off: they fit the frame beside their own better, by
/// more than three standard errors.
void note_offset(const Truth &truth, const std::vector<std::size_t> &columns, const Recording &tracks,
                 const std::vector<Place> &places, std::vector<std::string> &notes) {
  constexpr double least_deviation = 0.25;
  for (const int step : {-1, 1}) {
    const std::vector<double> votes = votes_for(step, truth, columns, tracks, places);
    const auto count = static_cast<double>(votes.size());
    double mean = 0, variance = 0;
    for (const double vote : votes) mean += vote / count;
    for (const double vote : votes) variance += (vote - mean) * (vote - mean) / (count - 1);
    if (votes.size() >= 2 && mean > 3 * std::max(std::sqrt(variance), least_deviation) / std::sqrt(count))
      notes.push_back(
          truth.file + ": its labels fit the frame " + (step < 0 ? "before" : "after") + " theirs in " + tracks.file +
          " better: " + (step < 0 ? "are they numbered from 1? The first frame is 0" : "are they one frame off?"));
  }
}

}  // namespace

Clip align(const Truth &truth, const Recording &tracks, const AlignOptions &options, std::vector<std::string> &notes) {
  Clip clip;
  clip.truth = truth.file;
  clip.tracks = tracks.file;
  set_size(clip, truth, tracks, options);
  if (truth.frames.empty()) throw InputError(truth.file, 0, "labels no frame");
  if (tracks.frames.empty()) throw InputError(tracks.file, 0, "has no frames");
  const std::vector<std::size_t> columns = choose(clip, truth, options.ids);

  Finder finder(truth, tracks, options.by_frame);
  std::vector<Place> places;
  std::size_t without_rows = 0;
  for (const TruthFrame &frame : truth.frames) {
    places.push_back(finder.find(frame));
    if (places.back().index == absent) ++without_rows;
    if (places.size() > 1 && places.back().end < places[places.size() - 2].end)
      throw InputError(tracks.file, tracks.frames[places.back().end - 1].line,
                       "goes back in time where " + where(truth, frame) + " goes on");
    if (places.size() > 1 && places.back().index != absent && places.back().index == places[places.size() - 2].index)
      throw InputError(truth.file, frame.line, "is the same frame as the one before, by the pts of " + tracks.file);
  }
  if (without_rows)
    notes.push_back(tracks.file + ": " + std::to_string(without_rows) +
                    " labelled frames have no rows and count as frames without features");

  LastReports last(clip.ids, tracks);
  if (truth.identified) {
    for (const TruthFrame &frame : truth.frames) clip.moments.push_back({frame.frame, frame.pts});
    clip.samples.resize(clip.ids.size() * clip.moments.size());
  }
  for (std::size_t t = 0; t < clip.moments.size(); ++t) {
    last.advance(places[t].end);
    for (std::size_t f = 0; f < columns.size(); ++f)
      clip.at(f, t) = compare(truth.frames[t].points[columns[f]], last[f], places[t].index);
  }
  if (!truth.identified) {
    last.advance(tracks.frames.size());
    clip.ends = truth.end_points;
    notes.push_back(truth.file + ": its end is compared with the last frame of " + tracks.file + ", line " +
                    std::to_string(tracks.frames.back().line));
  }
  for (std::size_t f = 0; f < columns.size(); ++f) {
    const TruthPoint &first = truth.frames.front().points[columns[f]], &end = truth.frames.back().points[columns[f]];
    if (truth.identified && end.presence == Presence::visible) clip.ends.push_back(end.position);
    if (first.presence != Presence::visible) continue;
    clip.starts.push_back(first.position);
    clip.reports_last.push_back(last[f].position());
  }
  last.advance(tracks.frames.size());
  last.check_all_mentioned(truth);
  note_start(clip, notes);
  if (options.by_frame || truth.frames.front().pts == no_time) note_offset(truth, columns, tracks, places, notes);
  return clip;
}

}  // namespace csd::score
