// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/types.h"
#include "text/json.h"

namespace csd {

/// Limits of a line: more than csdtrack writes (10000 points and as many features, each of which may end in the frame
/// in which another starts), less than would harm a reader.
inline constexpr std::size_t max_line_bytes = 8 << 20;
inline constexpr std::size_t max_line_features = 1 << 16;
inline constexpr std::size_t max_line_values = 1 << 19;  ///< for that many features with 7 members each
inline constexpr int max_pixels = 1 << 20;               ///< of a picture's side; also the limit of |x| and |y|
/// ns: adding or subtracting stream times can't overflow.
inline constexpr std::int64_t max_time = std::numeric_limits<std::int64_t>::max() / 2;

/// What may end a line, or make up an empty one: blanks, and the zeros that end subtitles and that a file system leaves
/// after a power failure.
inline constexpr std::string_view line_blanks{" \t\r\n\0", 5};

/// A line without them and without a byte order mark. Empty: not a line for any reader.
std::string_view line_text(std::string_view bytes);

/// Text that is safe to show: control characters (C0, DEL, C1 in UTF-8), which a terminal or gnuplot would interpret,
/// become '?'.
std::string printable(std::string_view text);

/// Why a line is refused: text to follow a file's name and the line's number. Quotes from the line are printable().
struct LineError : std::runtime_error {
  explicit LineError(const std::string &words) : std::runtime_error(printable(words)) {}
};

/// A line of csdtrackenc: docs/metadata.md.
struct TrackLine {
  bool truth = false;  ///< its role: truth, else track
  std::string source, algorithm;
  bool numbered = false;  ///< has a `frame`: an element has tracked this frame
  /// Nanoseconds; no_time if null or missing.
  std::int64_t pts = no_time, duration = no_time, stream_time = no_time, running_time = no_time;
  Tracks tracks;  ///< width and height may be 0 if not numbered
  /// The shape of the picture's pixels, width to height: 16:11 in widescreen PAL. 0 if the line doesn't say.
  int pixel_aspect_n = 0, pixel_aspect_d = 0;
};

/// Reads a line, processed by line_text(), of at most max_line_bytes. Skips unknown fields. Throws LineError for any
/// other input, even malicious.
TrackLine read_track_line(JsonText &json, std::string_view text);

}  // namespace csd
