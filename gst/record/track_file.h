// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "text/read_line.h"

namespace csd {

/// A line and its stream time in ns.
struct TimedLine {
  std::int64_t time = 0;
  TrackLine line;
};

/// Chooses the line of a frame from `before` (the last line before it) and `after` (the first that is not), which may
/// be null: the nearer one within `reach` ns. The earlier one if both are equally near.
const TimedLine *nearest(const TimedLine *before, const TimedLine *after, std::int64_t time, std::int64_t reach);

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

  /// The line of the frame at `time`, at most `reach` ns away; returns each line once, unless time goes back. Throws
  /// Refusal, with the line's number, for the first line on the way that is invalid, or earlier than the one before it.
  std::optional<TimedLine> at(std::int64_t time, std::int64_t reach);

 private:
  [[noreturn]] void refuse(std::int64_t offset, const std::string &what) const;
  std::size_t read_at(std::int64_t offset, char *to, std::size_t size) const;
  std::int64_t size() const;
  void go_to(std::int64_t offset);
  bool skip_line();
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

/// Splits chunks of bytes into lines. Holds one unfinished line.
class LineSplitter {
 public:
  /// Appends `piece` and calls `take(text, whole)` for each line that it completes; `whole`: the piece is exactly that
  /// line. Throws LineError if a line is longer than allowed.
  template <class Take>
  void add(std::string_view piece, Take take) {
    const bool whole = rest_.empty() && piece.find('\n') == piece.size() - 1;
    for (std::size_t end; (end = piece.find('\n')) != std::string_view::npos; piece.remove_prefix(end + 1)) {
      append(piece.substr(0, end));
      take(std::string_view(rest_), whole);
      rest_.clear();
    }
    append(piece);
  }
  void clear() { rest_ = {}; }
  /// Whether a non-empty line has begun.
  bool unfinished() const;

 private:
  void append(std::string_view text) {
    if (rest_.size() + text.size() > max_line_bytes) throw LineError("is longer than 8 MiB");
    rest_.append(text);
  }
  std::string rest_;
};

/// Unescapes Pango markup: &quot; &amp; &lt; &gt; &apos; and numbers, &#39; &#x27;. Anything else stays.
std::string unescape_markup(std::string_view markup);

}  // namespace csd
