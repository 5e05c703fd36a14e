// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/table.h"

#include <algorithm>

namespace csd::programs {
namespace {

/// The displayed width in characters: counts the bytes that start one.
std::size_t width(const std::string &text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

}  // namespace

std::string as_text(const Table &table) {
  std::string text = table.title + "\n";
  std::vector<std::size_t> widths(table.rows.front().size());
  for (const auto &row : table.rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  for (const auto &row : table.rows) {
    std::string line = " ";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string blanks(widths[i] - width(row[i]), ' ');
      line += " " + (i == 0 ? row[i] + blanks : " " + blanks + row[i]);
    }
    text += line.erase(line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string as_markdown(const Table &table) {
  const auto cells = [](const std::vector<std::string> &row) {
    std::string line = "|";
    for (std::string cell : row) {
      for (std::size_t at = 0; (at = cell.find('|', at)) != std::string::npos; at += 2) cell.insert(at, 1, '\\');
      line += " " + cell + " |";
    }
    return line + "\n";
  };
  std::string text = "**" + table.title + "**\n\n" + cells(table.rows.front()) + "|---|";
  for (std::size_t i = 1; i < table.rows.front().size(); ++i) text += "---:|";
  text += "\n";
  for (std::size_t i = 1; i < table.rows.size(); ++i) text += cells(table.rows[i]);
  return text;
}

}  // namespace csd::programs
