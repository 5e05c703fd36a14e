// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/line_matcher.h"

#include <algorithm>
#include <utility>

namespace csd {

/// `back`: what has come is before the frames so far.
void LineMatcher::Side::arrive(bool back, Side &other) {
  any = true;
  if (!std::exchange(first, false)) return;
  // If the other side has begun a segment, and something of it has come, then this side is the one that follows.
  if (back && !(other.restarted && !other.first)) ++lap;
  if (back && other.restarted) other.lap = std::max(other.lap, lap);
  lap = std::max(lap, other.lap);
}

bool LineMatcher::is_before_frame(TimeBase base, std::int64_t time) const {
  const auto &frame = moment(base);
  return frame && time < frame->time - frame->clipped - frame->reach;
}

void LineMatcher::add(TimedLine line) {
  base_ = line.base;
  lines_.arrive(is_before_frame(line.base, line.time), frames_);
  if (lines_.lap < frames_.lap) return;  // the frames have gone back, and these lines not yet
  // What a new link or segment repeats takes the place of what was there.
  const auto replaced = [&](const Entry &entry) {
    return entry.lap == lines_.lap && (replaces_ ? entry.line.time >= line.time : entry.line.time > line.time);
  };
  while (!entries_.empty() && replaced(entries_.back())) entries_.pop_back();
  replaces_ = false;
  auto &until = known(line.base);
  until = std::max(until.value_or(line.time), line.time);
  entries_.push_back({std::move(line), lines_.lap});
}

void LineMatcher::no_line(std::int64_t from, std::int64_t until) {
  lines_.arrive(is_before_frame(TimeBase::running, from), frames_);
  known_running_ = std::max(known_running_.value_or(until), until);
}

void LineMatcher::lines_begin() {
  lines_.begin();
  known_running_.reset();
  known_stream_.reset();
}

void LineMatcher::lines_begin_anew(bool keep) {
  if (!keep) entries_.clear();
  replaces_ = keep;
  lines_.begin_anew(frames_.lap);
  known_running_.reset();
  known_stream_.reset();
}

void LineMatcher::frames_begin() {
  frames_.begin();
}

void LineMatcher::frames_begin_anew() {
  frames_.begin_anew(std::max(frames_.lap, lines_.lap));
  now_ = {};
}

void LineMatcher::frame(const FrameMoments &times) {
  const auto earlier = [](const std::optional<FrameMoment> &a, const std::optional<FrameMoment> &b) {
    return a && b && a->time < b->time;
  };
  // The stream time goes back in every loop: it tells about laps only where lines are matched by it.
  frames_.arrive(
      earlier(times.running, now_.running) || (base_ == TimeBase::stream && earlier(times.stream, now_.stream)),
      lines_);
  now_ = times;
  const auto outdated = [&](const Entry &entry) {
    return entry.lap < frames_.lap || (entry.lap == frames_.lap && is_before_frame(entry.line.base, entry.line.time));
  };
  while (!entries_.empty() && outdated(entries_.front())) entries_.pop_front();
}

/// The place of the nearest line within reach; `distance` is unchanged without one.
std::optional<std::size_t> LineMatcher::nearest(std::int64_t &distance) const {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry &entry = entries_[i];
    const auto &frame = moment(entry.line.base);
    if (entry.lap > frames_.lap || !frame || entry.line.time > frame->time + frame->reach) break;  // they are sorted
    const std::int64_t its = frame->distance(entry.line.time);
    const bool nearer = !found || its < distance || (its == 0 && entry.line.time > entries_[*found].line.time);
    if (its > frame->reach || !nearer) continue;
    found = i;
    distance = its;
  }
  return found;
}

bool LineMatcher::decided() const {
  if (!now_.running && !now_.stream) return true;
  if (lines_.lap != frames_.lap) return lines_.lap > frames_.lap;
  std::int64_t distance = 0;
  const auto found = nearest(distance);
  if (found && entries_[*found].line.time == moment(entries_[*found].line.base)->time) return true;
  const auto past = [&](const std::optional<FrameMoment> &frame, const std::optional<std::int64_t> &until) {
    return frame && until && *until > frame->time && frame->distance(*until) >= (found ? distance : frame->reach + 1);
  };
  return past(now_.running, known_running_) || past(now_.stream, known_stream_);
}

std::optional<TrackLine> LineMatcher::take() {
  std::int64_t distance = 0;
  const auto found = nearest(distance);
  if (!found) return std::nullopt;
  lines_.restarted = lines_.first;
  frames_.restarted = false;
  const auto place = entries_.begin() + static_cast<std::ptrdiff_t>(*found);
  std::optional<TrackLine> line(std::move(place->line.line));
  entries_.erase(place);
  return line;
}

}  // namespace csd
