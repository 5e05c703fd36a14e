// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>
#include <vector>

namespace csd::programs {

struct Table {
  std::string title;
  std::vector<std::vector<std::string>> rows;  ///< the first is the header
};

/// For a terminal: aligned columns, the first one left, the others right.
std::string as_text(const Table &table);
std::string as_markdown(const Table &table);

}  // namespace csd::programs
