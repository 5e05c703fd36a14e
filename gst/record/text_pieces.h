// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "text/write_line.h"

namespace csd {

/// A text track holds a line as a sample, and MP4 says in 16 bits how long a text is: mp4mux writes what is longer as
/// if it were shorter, and says nothing. So a longer line is several samples, and these, one after the other, are the
/// line. Nothing is added by which to know them: a line is cut behind commas between features, so that a piece that is
/// not its line's last one ends in a comma, which no line does, and one that is not the first begins as a feature does,
/// and no line.
inline constexpr std::size_t max_piece_bytes = 65535;

/// Whether `text` is a piece of a line, but not the first.
inline bool is_rest_of_line(std::string_view text) {
  return text.starts_with(json_feature_begin);
}

/// Whether `text` is a piece of a line, but not the last.
inline bool goes_on(std::string_view text) {
  return text.ends_with(',');
}

/// A line of append_json() in as few pieces as may be, of `most` bytes at most, but where a single feature, or what
/// stands before the features, is longer. They point into the line.
std::vector<std::string_view> text_pieces(std::string_view line, std::size_t most = max_piece_bytes);

}  // namespace csd
