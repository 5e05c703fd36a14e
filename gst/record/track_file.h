// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "caps/frame_time.h"
#include "record/timed_line.h"

namespace csd {

/// Tracks in a file of JSON lines (docs/metadata.md), by stream time. Reads forward line by line; finds the place of a
/// time jump by bisection, so seeking in an hour is as fast as in a minute. Holds two lines and the bytes of one.
///
/// Skips lines without a stream time, which belong to no frame. A last line without its newline may be torn: it is read
/// once the newline is there. A growing file is read up to its current end.
class TrackFile {
 public:
  /// Throws Refusal if the file can't be read.
  explicit TrackFile(const std::string &path);
  ~TrackFile();
  TrackFile(const TrackFile &) = delete;
  TrackFile &operator=(const TrackFile &) = delete;

  /// The line nearest to the frame, within its reach; the earlier of two equally near; within its
  /// clipped part, the last. Returns each line once, unless
  /// time goes back. Throws Refusal, with the line's number, for the first line on the way that is invalid, or earlier
  /// than the one before it.
  std::optional<TrackLine> at(const FrameMoment &frame);

 private:
  [[noreturn]] void refuse(std::int64_t offset, const std::string &what) const;
  std::size_t read_at(std::int64_t offset, char *to, std::size_t size) const;
  std::int64_t size() const;
  void go_to(std::int64_t offset);
  bool fill();
  bool next_text(std::string_view &text);
  bool next_line(TimedLine &line);
  void seek(std::int64_t time);

  std::string path_;
  int fd_ = -1;
  JsonText json_;
  std::string bytes_;            ///< the file's contents from `offset_` on
  std::size_t used_ = 0;         ///< in bytes_
  std::size_t searched_ = 0;     ///< bytes_ has no newline in [used_, searched_)
  std::int64_t offset_ = 0;      ///< position of bytes_[0] in the file
  std::int64_t line_begin_ = 0;  ///< position in the file of the line that next_text() returned
  std::optional<TimedLine> before_, after_;
  std::optional<std::int64_t> last_time_;  ///< of the last line since the last seek
  std::optional<std::int64_t> asked_;      ///< the last time passed to at()
};

}  // namespace csd
