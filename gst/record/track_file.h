// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "text/read_line.h"

namespace csd {

/// A line and when it is, in ns of stream time.
struct TimedLine {
  std::int64_t time = 0;
  TrackLine line;
};

/// Of `before` (the last line before a frame) and `after` (the first that is not), which may be null, the one that is
/// the frame's: the nearer one, and no further than `reach` ns away. The earlier one if both are as near.
const TimedLine *nearest(const TimedLine *before, const TimedLine *after, std::int64_t time, std::int64_t reach);

/// Tracks in a file of JSON lines (docs/metadata.md), by stream time. Read forward, a line at a time; where time jumps,
/// the place is found by bisection, so an hour is sought in as fast as a minute. Holds two lines and one of bytes.
///
/// Lines without a stream time belong to no frame and are passed over. A last line without its newline may be torn: it
/// is not read until its newline is there. A file that grows is read as far as it goes.
class TrackFile {
 public:
  /// Throws Refusal if that is no file that can be read.
  explicit TrackFile(const std::string &path);
  ~TrackFile();
  TrackFile(const TrackFile &) = delete;
  TrackFile &operator=(const TrackFile &) = delete;

  /// The line of the frame at `time`, no further than `reach` ns away; each line is given once, unless time goes back.
  /// Throws Refusal, with the line's number, for the first line on the way that is none, or is earlier than
  /// the one before it.
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
  std::string bytes_;            ///< of the file, from `offset_` on
  std::size_t used_ = 0;         ///< of bytes_
  std::size_t searched_ = 0;     ///< bytes_ has no newline in [used_, searched_)
  std::int64_t offset_ = 0;      ///< in the file, of bytes_[0]
  std::int64_t line_begin_ = 0;  ///< in the file, of the line that next_text() gave
  std::optional<TimedLine> before_, after_;
  std::optional<std::int64_t> last_time_;  ///< of the last line that was read since the last seek
  std::optional<std::int64_t> asked_;      ///< the last time that at() was asked for
};

/// Bytes into lines, as they come in pieces. Holds one unfinished line.
class LineSplitter {
 public:
  /// Appends `piece` and calls `take(text, whole)` for each line that it ends; `whole`: the piece is that line and
  /// nothing else. Throws LineError if a line is longer than any may be.
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
  /// Whether a line has begun that isn't empty.
  bool unfinished() const;

 private:
  void append(std::string_view text) {
    if (rest_.size() + text.size() > max_line_bytes) throw LineError("is longer than 8 MiB");
    rest_.append(text);
  }
  std::string rest_;
};

/// Undoes the escaping of Pango markup: &quot; &amp; &lt; &gt; &apos; and numbers, &#39; &#x27;. Anything else stays.
std::string unescape_markup(std::string_view markup);

}  // namespace csd
