// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/track_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "record/file_name.h"
#include "support/guard.h"

namespace csd {

namespace {

constexpr std::size_t chunk = 64 << 10;
/// For a jump of more than this TrackFile finds a frame by bisection: it reads some 50 lines in 10 ms.
constexpr std::int64_t jump = 2 * second;

std::string system_words(int error) {
  return std::generic_category().message(error);
}

}  // namespace

TrackFile::TrackFile(const std::string &path) : path_(path) {
  // Non-blocking: opening a pipe would wait for its writer.
  fd_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  const int error = errno;  // GLib's functions set errno too
  if (fd_ < 0)
    throw Refusal(error == ENOENT ? GST_RESOURCE_ERROR_NOT_FOUND : GST_RESOURCE_ERROR_OPEN_READ,
                  "The file of tracks " + quoted(path) + " can't be read: " + system_words(error) +
                      ". Set location to a .jsonl file that csdtrackenc has written.");
  struct stat status = {};
  if (fstat(fd_, &status) == 0 && S_ISREG(status.st_mode)) return;
  close(fd_);
  throw Refusal(GST_RESOURCE_ERROR_OPEN_READ, quoted(path) +
                                                  " is no file. Set location to a .jsonl file that csdtrackenc has "
                                                  "written; link what comes by a pipe or a network to the pad text.");
}

TrackFile::~TrackFile() {
  close(fd_);
}

void TrackFile::refuse(std::int64_t offset, const std::string &what) const {
  // Counts lines only now: after a seek the number of the current line is unknown.
  std::int64_t number = 1;
  std::string bytes(chunk, '\0');
  for (std::int64_t at = 0; at < offset;) {
    const std::size_t size =
        read_at(at, bytes.data(), std::min<std::size_t>(chunk, static_cast<std::size_t>(offset - at)));
    if (size == 0) break;
    number += std::count(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size), '\n');
    at += static_cast<std::int64_t>(size);
  }
  throw Refusal(GST_STREAM_ERROR_DECODE, "Line " + std::to_string(number) + " of " + quoted(path_) + ": " + what +
                                             ". Set location to a .jsonl file that csdtrackenc has written.");
}

std::size_t TrackFile::read_at(std::int64_t offset, char *to, std::size_t size) const {
  ssize_t got;
  do got = pread(fd_, to, size, offset);
  while (got < 0 && errno == EINTR);
  const int error = errno;
  if (got < 0)
    throw Refusal(GST_RESOURCE_ERROR_OPEN_READ, "The file of tracks " + quoted(path_) + " can't be read on: " +
                                                    system_words(error) + ". Look at the disk that it is on.");
  return static_cast<std::size_t>(got);
}

std::int64_t TrackFile::size() const {
  struct stat status = {};
  return fstat(fd_, &status) == 0 ? status.st_size : 0;
}

void TrackFile::go_to(std::int64_t offset) {
  bytes_.clear();
  used_ = searched_ = 0;
  offset_ = offset;
}

/// Appends the next part of the file. Returns false at its end.
bool TrackFile::fill() {
  bytes_.erase(0, used_);
  offset_ += static_cast<std::int64_t>(used_);
  searched_ -= used_;
  used_ = 0;
  const std::size_t before = bytes_.size();
  bytes_.resize(before + chunk);
  const std::size_t got = read_at(offset_ + static_cast<std::int64_t>(before), bytes_.data() + before, chunk);
  bytes_.resize(before + got);
  return got > 0;
}

/// The next complete line. Valid until the next call.
bool TrackFile::next_text(std::string_view &text) {
  const auto check = [this](std::size_t size) {
    if (size > max_line_bytes) refuse(offset_ + static_cast<std::int64_t>(used_), "is longer than 8 MiB");
  };
  std::size_t end;
  while ((end = bytes_.find('\n', searched_)) == std::string::npos) {
    searched_ = bytes_.size();
    check(bytes_.size() - used_);
    if (!fill()) return false;
  }
  check(end - used_);
  text = std::string_view(bytes_).substr(used_, end - used_);
  line_begin_ = offset_ + static_cast<std::int64_t>(used_);
  used_ = searched_ = end + 1;
  return true;
}

/// The next line with a time. Returns false at the end of the file, or after 4 MiB without one: a frame can't wait for
/// gigabytes. The next call continues after them.
bool TrackFile::next_line(TimedLine &line) {
  constexpr std::int64_t max_untimed = 4 << 20;
  const auto here = [this] { return offset_ + static_cast<std::int64_t>(used_); };
  const std::int64_t last = here() + max_untimed;
  for (std::string_view text; here() <= last && next_text(text);) {
    text = line_text(text);
    if (text.empty()) continue;
    try {
      line.line = read_track_line(json_, text);
    } catch (const LineError &error) {
      refuse(line_begin_, error.what());
    }
    line.time = line.line.stream_time;
    if (line.time == no_time) continue;
    if (last_time_ && line.time < *last_time_)
      refuse(line_begin_, "`stream_time` " + std::to_string(line.time) + " after " + std::to_string(*last_time_) +
                              ": lines must be sorted by it");
    last_time_ = line.time;
    return true;
  }
  return false;
}

/// Moves to a line from which reading forward finds everything near `time`.
void TrackFile::seek(std::int64_t time) {
  std::int64_t early = 0, late = size();  // the line that starts after `early` is before `time`, or the first
  TimedLine line;
  std::string_view rest;
  while (late - early > static_cast<std::int64_t>(chunk)) {
    const std::int64_t middle = early + (late - early) / 2;
    go_to(middle);
    last_time_.reset();
    if (next_text(rest) && next_line(line) && line.time < time)
      early = middle;
    else
      late = middle;
  }
  go_to(early);
  if (early > 0) next_text(rest);
  last_time_.reset();
  before_.reset();
  after_.reset();
}

std::optional<TrackLine> TrackFile::at(const FrameMoment &frame) {
  const std::int64_t begin = frame.time - frame.clipped;
  if (asked_ && (begin < *asked_ || begin > *asked_ + jump)) seek(begin - frame.reach);
  asked_ = begin;
  while (!after_ || after_->time < frame.time) {
    if (after_) before_ = std::exchange(after_, std::nullopt);
    if (!next_line(after_.emplace())) {
      after_.reset();
      break;
    }
  }
  const auto near = [&](const std::optional<TimedLine> &line) {
    return line && frame.distance(line->time) <= frame.reach;
  };
  const auto at_least_as_near = [&] {
    const std::int64_t earlier = frame.distance(before_->time), later = frame.distance(after_->time);
    return earlier <= later && after_->time != frame.time;
  };
  const bool later = near(after_) && !(near(before_) && at_least_as_near());
  std::optional<TimedLine> &found = later ? after_ : before_;
  if (!near(found)) return std::nullopt;
  return std::move(std::exchange(found, std::nullopt)->line);
}

}  // namespace csd
