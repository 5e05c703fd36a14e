// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/text_pieces.h"

#include <string>

namespace csd {

std::vector<std::string_view> text_pieces(std::string_view line, std::size_t most_bytes) {
  const std::string between = ',' + std::string(json_feature_begin);
  std::vector<std::string_view> pieces;
  while (line.size() > most_bytes) {
    std::size_t comma = line.rfind(between, most_bytes - 1);
    if (comma == std::string_view::npos) comma = line.find(between, most_bytes);
    if (comma == std::string_view::npos) break;
    pieces.push_back(line.substr(0, comma + 1));
    line.remove_prefix(comma + 1);
  }
  pieces.push_back(line);
  return pieces;
}

}  // namespace csd
