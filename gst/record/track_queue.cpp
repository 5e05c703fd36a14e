// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/track_queue.h"

#include <algorithm>
#include <utility>

namespace csd {

/// Wakes waiters on either side.
void TrackQueue::changed() {
  changed_.notify_all();
  if (alarm_) gst_clock_id_unschedule(alarm_);
}

void TrackQueue::pop() {
  features_ -= entries_.front().line.line.tracks.features.size();
  entries_.pop_front();
}

bool TrackQueue::full(const TimedLine &line) const {
  return !entries_.empty() &&
         (entries_.size() >= max_lines || features_ + line.line.tracks.features.size() > max_features);
}

bool TrackQueue::push(TimedLine line) {
  std::unique_lock lock(mutex_);
  if (!lines_.last) drop_from(line.time);
  changed_.wait(lock, [&] { return !running_ || lines_.flushing || !full(line); });
  if (!running_ || lines_.flushing) return false;
  lines_.at(line.time);
  if (frames_.ended) return true;
  features_ += line.line.tracks.features.size();
  entries_.push_back({std::move(line), lines_.pass});
  if (frames_.last) drop_before(*frames_.last);
  changed();
  return true;
}

void TrackQueue::gap(std::int64_t time) {
  const std::lock_guard lock(mutex_);
  known_until_ = std::max(known_until_, time);
  changed();
}

void TrackQueue::end() {
  const std::lock_guard lock(mutex_);
  lines_.ended = true;
  changed();
}

void TrackQueue::lines_begin(unsigned group) {
  const std::lock_guard lock(mutex_);
  const unsigned before = std::exchange(lines_group_, group);
  const bool with_frames = group != before && frames_group_ != 0 && (frames_group_ == before || frames_group_ == group);
  lines_.ended = false;
  if (!with_frames) lines_begin_alone();
}

void TrackQueue::lines_begin_alone() {
  lines_.pass = frames_.pass;
  lines_.last.reset();
  known_until_ = no_time;
}

void TrackQueue::segment() {
  const std::lock_guard lock(mutex_);
  lines_.new_segment = true;
  lines_.ended = false;
  known_until_ = no_time;
}

void TrackQueue::flush_lines(bool begin) {
  const std::lock_guard lock(mutex_);
  lines_ = {};
  lines_.flushing = begin;
  known_until_ = no_time;
  late_ = false;
  entries_.clear();
  features_ = 0;
  changed();
}

void TrackQueue::frames_begin(unsigned group) {
  const std::lock_guard lock(mutex_);
  frames_group_ = group;
}

void TrackQueue::frames_segment() {
  const std::lock_guard lock(mutex_);
  frames_.new_segment = true;
  frames_.ended = false;
}

void TrackQueue::frames_end() {
  const std::lock_guard lock(mutex_);
  frames_.ended = true;
  entries_.clear();
  features_ = 0;
  changed();
}

void TrackQueue::flush_frames(bool begin) {
  const std::lock_guard lock(mutex_);
  frames_ = {};
  frames_.flushing = begin;
  changed();
}

void TrackQueue::rethink() {
  const std::lock_guard lock(mutex_);
  ++thoughts_;
  changed();
}

unsigned TrackQueue::thoughts() {
  const std::lock_guard lock(mutex_);
  return thoughts_;
}

void TrackQueue::set_linked(bool linked) {
  const std::lock_guard lock(mutex_);
  linked_ = linked;
  if (!linked) lines_begin_alone();
  changed();
}

bool TrackQueue::linked() {
  const std::lock_guard lock(mutex_);
  return linked_;
}

void TrackQueue::start() {
  const std::lock_guard lock(mutex_);
  entries_.clear();
  features_ = 0;
  lines_ = frames_ = {};
  known_until_ = no_time;
  late_ = false;
  running_ = true;
}

void TrackQueue::stop() {
  const std::lock_guard lock(mutex_);
  running_ = false;
  entries_.clear();
  features_ = 0;
  changed();
}

bool TrackQueue::running() {
  const std::lock_guard lock(mutex_);
  return running_;
}

/// The number of lines before `time` in the pass of the frames. Includes those of earlier passes.
std::size_t TrackQueue::earlier(std::int64_t time) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry &entry) {
    return entry.pass > frames_.pass || (entry.pass == frames_.pass && entry.line.time >= time);
  });
  return static_cast<std::size_t>(found - entries_.begin());
}

/// Drops what no frame from `time` on can need: all but the last line before it.
void TrackQueue::drop_before(std::int64_t time) {
  const std::size_t before = earlier(time);
  for (std::size_t i = 1; i < before; ++i) pop();
  if (before > 0 && entries_.front().pass != frames_.pass) pop();
  if (before > 0) changed();
}

/// Drops the lines from `time` on in the pass of the lines, and those of later passes.
void TrackQueue::drop_from(std::int64_t time) {
  while (!entries_.empty() && (entries_.back().pass > lines_.pass ||
                               (entries_.back().pass == lines_.pass && entries_.back().line.time >= time))) {
    features_ -= entries_.back().line.line.tracks.features.size();
    entries_.pop_back();
  }
}

/// Whether no future line can be that of the frame at `time`.
bool TrackQueue::is_known(std::int64_t time, std::int64_t reach) const {
  return !linked_ || lines_.ended || earlier(time) < entries_.size() ||
         (lines_.pass == frames_.pass && known_until_ > time + reach);
}

/// Waits for `ends`, which is called after each change. Returns false at the limit.
bool TrackQueue::wait(std::unique_lock<std::mutex> &lock, const FrameLimit &limit, const std::function<bool()> &ends) {
  if (!limit.clock) {
    // Not wait_until(), which overflows for a time centuries away.
    constexpr std::chrono::hours day(24);
    return changed_.wait_for(lock, std::min<std::chrono::nanoseconds>(limit.patience, day), ends);
  }
  // Waits like GstAggregator: on any clock, until a new line or event unschedules the clock id. An id unscheduled
  // before the wait doesn't wait.
  while (!ends()) {
    if (gst_clock_get_time(limit.clock.get()) >= limit.time) return false;
    const GstClockID alarm = alarm_ = gst_clock_new_single_shot_id(limit.clock.get(), limit.time);
    lock.unlock();
    const GstClockReturn woken = gst_clock_id_wait(alarm, nullptr);
    lock.lock();
    alarm_ = nullptr;
    gst_clock_id_unref(alarm);
    if (woken != GST_CLOCK_UNSCHEDULED) return ends();
  }
  return true;
}

TrackQueue::Match TrackQueue::match(std::int64_t time, std::int64_t reach, const FrameLimit &limit, unsigned thought) {
  std::unique_lock lock(mutex_);
  if (!running_ || frames_.flushing) return {Outcome::flushing, std::nullopt};
  frames_.at(time);
  drop_before(time);
  bool known = is_known(time, reach);
  if (!known && (limit.clock || !late_)) {
    const bool late = !wait(lock, limit, [&] {
      drop_before(time);
      return !running_ || frames_.flushing || thoughts_ != thought || is_known(time, reach);
    });
    if (!running_ || frames_.flushing) return {Outcome::flushing, std::nullopt};
    known = is_known(time, reach);
    if (!known && !late) return {Outcome::again, std::nullopt};
  }
  late_ = !known;

  const std::size_t before = earlier(time);  // 0 or 1: the others were dropped
  const bool next = before < entries_.size() && entries_[before].pass == frames_.pass;
  const TimedLine *const found =
      nearest(before > 0 ? &entries_[0].line : nullptr, next ? &entries_[before].line : nullptr, time, reach);
  Match match{known ? Outcome::known : Outcome::late, std::nullopt};
  if (!found) return match;
  if (before > 0 && found != &entries_[0].line) pop();
  match.line = std::move(entries_.front().line);
  features_ -= match.line->line.tracks.features.size();
  entries_.pop_front();
  changed();
  return match;
}

void TrackQueue::skip(std::int64_t time) {
  const std::lock_guard lock(mutex_);
  frames_.at(time);
  drop_before(time);
}

}  // namespace csd
