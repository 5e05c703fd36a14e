// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/series.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "score/quantile.h"

namespace csd::motion {
namespace {

using score::InputError;

constexpr double farthest = 1e6;  // px

struct Clock {
  const char *name;
  std::int64_t score::TrackFrame::*time;
};

/// pts go back in a file whose edit list plays it in another order, stream time where streams are joined.
constexpr Clock clocks[] = {{"pts", &score::TrackFrame::pts},
                            {"stream_time", &score::TrackFrame::stream_time},
                            {"running_time", &score::TrackFrame::running_time}};

/// The first clock that never goes back; null if no frame has a pts.
const Clock *clock_of(const score::Recording &tracks) {
  for (const Clock &clock : clocks) {
    std::int64_t last = no_time;
    bool goes_back = false;
    for (const score::TrackFrame &frame : tracks.frames) {
      if (!frame.numbered || frame.*clock.time == no_time) continue;
      goes_back = goes_back || (last != no_time && frame.*clock.time < last);
      last = frame.*clock.time;
    }
    if (last == no_time && &clock == clocks) return nullptr;
    if (last != no_time && !goes_back) return &clock;
  }
  return clocks;
}

/// Of the times, s. The mean where most frames have the time of the one before.
double interval_of(const std::vector<double> &times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  if (steps.empty()) return 0;
  const double mean = (times.back() - times.front()) / static_cast<double>(steps.size()),
               median = score::quantile(std::move(steps), 0.5);
  return median > 0 ? median : mean;
}

cv::Point2d median(const std::vector<cv::Point2d> &points) {
  std::vector<double> x, y;
  for (const cv::Point2d &p : points) {
    x.push_back(p.x);
    y.push_back(p.y);
  }
  return {score::quantile(std::move(x), 0.5), score::quantile(std::move(y), 0.5)};
}

}  // namespace

Series series_of(const score::Recording &tracks, const Span &span) {
  const Clock *const clock = clock_of(tracks);
  if (!clock && !(span.fps > 0))
    throw InputError(tracks.file, 0, "has no times (pts): say how many frames a second there are");
  Series series;
  if (clock) series.clock = clock->name;
  std::map<FeatureId, Path> paths;
  for (const score::TrackFrame &frame : tracks.frames) {
    if (!frame.numbered || (clock && frame.*clock->time == no_time)) continue;
    const double time =
        clock ? static_cast<double>(frame.*clock->time) / second : static_cast<double>(frame.frame) / span.fps;
    if ((span.from && time < *span.from) || (span.to && time > *span.to)) continue;
    if (tracks.has_other_size(frame)) {
      if (series.left_out++ == 0) {
        series.other_width = frame.width;
        series.other_height = frame.height;
        series.other_line = frame.line;
      }
      continue;
    }
    if (!series.times.empty() && time < series.times.back())
      throw InputError(tracks.file, frame.line,
                       "the time goes back (frame " + std::to_string(frame.frame) + "): was the stream seeked?");
    const std::size_t index = series.times.size();
    series.times.push_back(time);
    series.frames.push_back(frame.frame);
    for (const Feature &feature : frame.features) {
      if (!claims_position(feature.state)) continue;
      if (std::abs(feature.x) > farthest || std::abs(feature.y) > farthest)
        throw InputError(tracks.file, frame.line,
                         "feature " + std::to_string(feature.id) + " is claimed far outside any picture");
      Path &path = paths[feature.id];
      path.id = feature.id;
      path.frames.push_back(index);
      path.positions.emplace_back(feature.x, feature.y);
    }
  }
  if (series.times.empty()) throw InputError(tracks.file, 0, "has no frame in that span of time");
  if (paths.empty()) throw InputError(tracks.file, 0, "claims no position of any feature in that span of time");
  for (auto &[id, path] : paths) series.paths.push_back(std::move(path));
  series.interval = interval_of(series.times);
  return series;
}

ClaimsByFrame::ClaimsByFrame(const Series &series) : ends_(series.times.size() + 1, 0) {
  for (const Path &path : series.paths)
    for (const std::size_t frame : path.frames) ++ends_[frame + 1];
  for (std::size_t i = 1; i < ends_.size(); ++i) ends_[i] += ends_[i - 1];
  claims_.resize(ends_.back());
  std::vector<std::size_t> next(ends_.begin(), ends_.end() - 1);
  for (std::size_t p = 0; p < series.paths.size(); ++p)
    for (std::size_t i = 0; i < series.paths[p].frames.size(); ++i) claims_[next[series.paths[p].frames[i]]++] = {p, i};
}

std::vector<cv::Point2d> velocities(const Series &series, const Path &path) {
  std::vector<cv::Point2d> all(path.positions.size(), unknown_point);
  const auto time = [&](std::size_t i) { return series.times[path.frames[i]]; };
  const auto slope = [&](std::size_t i) {  // from i to i + 1
    const double step = time(i + 1) - time(i);
    if (path.frames[i + 1] != path.frames[i] + 1 || !(step > 0 && step <= series.longest_step())) return unknown_point;
    return (path.positions[i + 1] - path.positions[i]) / step;
  };
  cv::Point2d before = unknown_point;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const cv::Point2d after = i + 1 < all.size() ? slope(i) : unknown_point;
    if (known(before) && known(after))
      all[i] = (before * (time(i + 1) - time(i)) + after * (time(i) - time(i - 1))) / (time(i + 1) - time(i - 1));
    else
      all[i] = known(before) ? before : after;
    before = after;
  }
  return all;
}

SceneMotion scene_motion(const Series &series) {
  const std::size_t count = series.times.size();
  SceneMotion scene;
  scene.displacement.assign(count, unknown_point);
  scene.velocity.assign(count, unknown_point);
  scene.features.assign(count, 0);
  std::vector<std::vector<cv::Point2d>> velocity;
  velocity.reserve(series.paths.size());
  for (const Path &path : series.paths) velocity.push_back(velocities(series, path));
  const ClaimsByFrame claims(series);
  cv::Point2d sum{0, 0};
  std::vector<cv::Point2d> steps, speeds;
  for (std::size_t i = 0; i < count; ++i) {
    steps.clear();
    speeds.clear();
    for (const Claim &claim : claims.at(i)) {
      const Path &path = series.paths[claim.path];
      if (claim.place > 0 && path.frames[claim.place - 1] + 1 == i)
        steps.push_back(path.positions[claim.place] - path.positions[claim.place - 1]);
      const cv::Point2d speed = velocity[claim.path][claim.place];
      if (known(speed)) speeds.push_back(speed);
    }
    if (!steps.empty()) sum += median(steps);
    scene.features[i] = claims.at(i).size();
    if (scene.features[i] > 0) scene.displacement[i] = sum;
    if (!speeds.empty()) scene.velocity[i] = median(speeds);
  }
  return scene;
}

}  // namespace csd::motion
