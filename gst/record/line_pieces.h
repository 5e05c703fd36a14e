// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace csd {

/// What a pad's buffer says of a text's time.
struct TextTime {
  std::optional<std::int64_t> running;  ///< ns; none without a TIME segment, or without a timestamp
  bool untimed = false;                 ///< has no timestamp, although others of its stream may
};

/// A whole line and the time of the buffer in which it begins. Throws LineError for an invalid line.
using TakeLine = std::function<void(std::string_view line, const TextTime &time)>;
/// A line that is lost, in whole or in part, and why.
using LoseLine = std::function<void(const char *why)>;

/// Joins the text_pieces() of lines.
class LinePieces {
 public:
  /// `missing`: something is lost before this piece. Throws LineError for a line that is invalid or too long.
  void add(std::string_view piece, const TextTime &time, bool missing, const TakeLine &take, const LoseLine &lose);
  bool unfinished() const { return !begun_.empty(); }
  void clear() { begun_.clear(); }

 private:
  std::string begun_;  ///< pieces of an incomplete line
  TextTime begun_time_;
};

}  // namespace csd
