// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>
#include <vector>

#include "score/palindrome.h"

namespace csd::programs {

/// The results of csd-score --palindrome: a row for each file of tracks.
struct PalindromeRow {
  std::string tracks, tracker;
  score::PalindromeScore score;
};
using PalindromeReport = std::vector<PalindromeRow>;

/// Below, adds the mean of each tracker with several rows.
std::string as_text(const PalindromeReport &report);
std::string as_markdown(const PalindromeReport &report);
/// docs/metrics.md describes it. Unknown values are null.
std::string as_json(const PalindromeReport &report);

}  // namespace csd::programs
