// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>
#include <string_view>

namespace csd {

/// Quotes an invalid part of a setting for an error message: its first 40 bytes, with '?' for all but printable ASCII,
/// because messages must be UTF-8.
inline std::string shown_text(std::string_view part) {
  constexpr std::size_t most = 40;
  std::string text = "\"";
  for (const char c : part.substr(0, most)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (part.size() > most ? "…\"" : "\"");
}

}  // namespace csd
