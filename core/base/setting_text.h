// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>
#include <string_view>

namespace csd {

/// The text without the blanks around it.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const auto first = text.find_first_not_of(blanks);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// Quotes an invalid part of a setting for an error message: its first 40 bytes, with '?' for all but printable ASCII,
/// because messages must be UTF-8.
inline std::string shown_text(std::string_view part) {
  constexpr std::size_t most_characters = 40;
  std::string text = "\"";
  for (const char c : part.substr(0, most_characters)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (part.size() > most_characters ? "…\"" : "\"");
}

}  // namespace csd
