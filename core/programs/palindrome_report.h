// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>
#include <vector>

#include "score/palindrome.h"

namespace csd::programs {

/// What csd-score --palindrome found out: a row for each file of tracks.
struct PalindromeRow {
  std::string tracks, tracker;
  score::PalindromeScore score;
};
using PalindromeReport = std::vector<PalindromeRow>;

/// Where a tracker has several rows, its mean comes below.
std::string as_text(const PalindromeReport &report);
std::string as_markdown(const PalindromeReport &report);
/// docs/metrics.md describes it. What is unknown is null.
std::string as_json(const PalindromeReport &report);

}  // namespace csd::programs
