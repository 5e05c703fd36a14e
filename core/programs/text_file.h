// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace csd::programs {

/// A file of lines, possibly written by a program that was killed.
struct TextFile {
  struct Line {
    std::size_t number;  ///< from 1
    std::string_view text;
  };
  std::string name;
  std::string content;  ///< without a byte order mark
  bool torn = false;    ///< the last line has no newline and may be incomplete

  /// The complete, non-empty lines, each passed through line_text().
  std::vector<Line> lines() const;
  /// The first non-empty line, complete or not.
  Line first() const;
};

/// Throws score::InputError if the file can't be read, is empty or has a line of more than max_line_bytes.
TextFile read_text_file(const std::string &name);

/// Adds the note that a torn last line was skipped.
void note_torn(const TextFile &file, std::vector<std::string> &notes);

}  // namespace csd::programs
