// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/markup.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace csd {

std::string unescape_markup(std::string_view markup) {
  constexpr std::pair<std::string_view, char> names[] = {
      {"quot", '"'}, {"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"apos", '\''}};
  std::string text;
  text.reserve(markup.size());
  while (!markup.empty()) {
    const std::size_t end = markup[0] == '&' ? markup.substr(0, 12).find(';') : std::string_view::npos;
    if (end == std::string_view::npos) {
      text += markup[0];
      markup.remove_prefix(1);
      continue;
    }
    const std::string_view name = markup.substr(1, end - 1);
    const auto *const known =
        std::find_if(std::begin(names), std::end(names), [&](const auto &entity) { return entity.first == name; });
    unsigned code = 0;
    bool is_code = name.size() > 1 && name[0] == '#';
    if (is_code) {
      const bool hex = name[1] == 'x';
      const char *const last = name.data() + name.size();
      const auto read = std::from_chars(name.data() + (hex ? 2 : 1), last, code, hex ? 16 : 10);
      // Only the codes GLib escapes: characters that XML can't hold, one byte each.
      is_code = read.ec == std::errc() && read.ptr == last && code > 0 && code < 0x80;
    }
    if (known != std::end(names))
      text += known->second;
    else if (is_code)
      text += static_cast<char>(code);
    else
      text += markup.substr(0, end + 1);
    markup.remove_prefix(end + 1);
  }
  return text;
}

}  // namespace csd
