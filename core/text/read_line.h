// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include "text/json.h"
#include "track/types.h"

namespace csd {

/// What one line may hold: more than csdtrack writes (10000 points and as many features, each of which may end in the
/// frame in which another begins), less than would harm who reads it.
inline constexpr std::size_t max_line_bytes = 8 << 20;
inline constexpr std::size_t max_line_features = 1 << 16;
inline constexpr std::size_t max_line_values = 1 << 19;  ///< of that many features with 7 members each
inline constexpr int max_pixels = 1 << 20;               ///< of a picture's side; |x| and |y| are no larger either
/// ns: what is added to stream times, or taken from them, can't overflow.
inline constexpr std::int64_t max_time = std::numeric_limits<std::int64_t>::max() / 2;

/// What a line may end with, or be made of where it is none: blanks, and zeros, which subtitles end with, and which a
/// file system leaves where the power failed.
inline constexpr std::string_view line_blanks{" \t\r\n\0", 5};

/// A line without them, and without a byte order mark. Empty: there is no line, whoever reads it.
std::string_view line_text(std::string_view bytes);

/// Text as it may be shown: control characters (C0, DEL, C1 in UTF-8), which a terminal or gnuplot would obey, become
/// '?'.
std::string printable(std::string_view text);

/// Why a line is refused: words that follow a file's name and the line's number. What it quotes of the line is
/// printable().
struct LineError : std::runtime_error {
  explicit LineError(const std::string &words) : std::runtime_error(printable(words)) {}
};

/// A line of csdtrackenc: docs/metadata.md.
struct TrackLine {
  bool truth = false;  ///< its role: truth, else track
  std::string source, algorithm;
  bool numbered = false;  ///< has a `frame`: some element has tracked this frame
  /// Nanoseconds; no_time where the line says null or nothing.
  std::int64_t pts = no_time, duration = no_time, stream_time = no_time;
  Tracks tracks;  ///< width and height may be 0 where it is not numbered
};

/// Reads a line, as line_text() leaves it, of at most max_line_bytes. Fields that aren't known are skipped. Throws
/// LineError for all that is no such line, however it was made: `json` is spared what would overflow its stack or fill
/// the memory, and what it would read as another number than is written.
TrackLine read_track_line(JsonText &json, std::string_view text);

}  // namespace csd
