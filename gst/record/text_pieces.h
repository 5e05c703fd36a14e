// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "text/write_line.h"

namespace csd {

/// A text track stores a line as a sample. MP4 stores a text's length in 16 bits, and mp4mux silently writes a wrong
/// one for longer texts. So a longer line becomes several samples whose concatenation is the line. The pieces need no
/// markers: a line is split after commas between features. So every piece but the last ends in a comma, unlike any
/// line, and every piece but the first starts like a feature, unlike any line.
inline constexpr std::size_t max_piece_bytes = 65535;

/// Whether `text` is a piece of a line, but not the first.
inline bool is_rest_of_line(std::string_view text) {
  return text.starts_with(json_feature_begin);
}

/// Whether `text` is a piece of a line, but not the last.
inline bool goes_on(std::string_view text) {
  return text.ends_with(',');
}

/// Splits a line of append_json() into as few pieces as possible, of at most `most_bytes` bytes, unless a single
/// feature, or the part before the features, is longer. The pieces point into the line.
std::vector<std::string_view> text_pieces(std::string_view line, std::size_t most_bytes = max_piece_bytes);

}  // namespace csd
