// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core/types.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace csd {

/// The value of a text property, or an error: exactly one is set. `error` quotes the wrong part and says what to write
/// instead.
template <typename T>
struct Parsed {
  T value{};
  std::string error;

  explicit operator bool() const { return error.empty(); }
};

/// "x,y;x,y;…" in pixels of the picture, decimal point in every locale, blanks allowed, one trailing `;` allowed. Empty
/// text is no points. At most csd::max_points, all finite. Points may lie outside the picture.
Parsed<std::vector<cv::Point2d>> parse_points(std::string_view text);

/// Whether `points` is the word "truth".
bool is_truth(std::string_view text);

/// "x,y,w,h" in whole pixels, x and y from 0, w and h from 1. Empty text is the empty rectangle: everywhere.
Parsed<cv::Rect> parse_region(std::string_view text);

}  // namespace csd
