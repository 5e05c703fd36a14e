// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "score/clip.h"

namespace csd::score {

inline constexpr double returned_pixels = 2, apart_pixels = 5;  ///< at 576 lines or less

/// Scores of a video played forward and then backward, without ground truth: each image is seen twice, with the
/// features at the same positions. Shares of nothing are unknown.
struct PalindromeScore {
  std::size_t frames = 0;            ///< in both directions
  std::size_t features = 0;          ///< claimed in the first frame; only these count
  std::size_t claims = 0;            ///< out of features · frames
  std::size_t pairs = 0;             ///< claims on one feature at both visits of an image
  std::size_t apart = 0;             ///< pairs more than 5 px · max(1, H/576) apart
  std::size_t returned = 0;          ///< features claimed in the last frame ≤ 2 px · max(1, H/576) from the start
  std::size_t falsely_returned = 0;  ///< features claimed there > 5 px · max(1, H/576) from it

  double claimed_share() const { return share(claims, features * frames); }
  double apart_share() const { return share(apart, pairs); }
  double returned_share() const { return share(returned, features); }
  double falsely_returned_share() const { return share(falsely_returned, features); }

 private:
  static double share(std::size_t part, std::size_t whole) {
    return whole ? static_cast<double>(part) / static_cast<double>(whole) : unknown;
  }
};

/// Scores the tracks of a palindrome: of L frames the i-th from the start and the i-th from the end show the same image
/// (2N frames of N images if the last is shown twice, else 2N − 1). Throws InputError if these can't be tracks of a
/// palindrome: fewer than three frames, a missing one, no picture height, no claims in the first frame.
PalindromeScore score_palindrome(const Recording &tracks);

}  // namespace csd::score
