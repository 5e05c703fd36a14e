// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>
#include <string_view>

#include "text/read_line.h"

namespace csd {

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
  bool unfinished() const { return !line_text(rest_).empty(); }

 private:
  void append(std::string_view text) {
    if (rest_.size() + text.size() > max_line_bytes) throw LineError("is longer than 8 MiB");
    rest_.append(text);
  }
  std::string rest_;
};

}  // namespace csd
