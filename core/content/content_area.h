// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "content/burnt_in.h"
#include "content/dark_border.h"

namespace csd {

/// The parts of the picture without tissue: the dark border joined to the frame's edge, and burnt-in text and logos.
/// Detection and learning exclude them.
///
/// Not thread safe. No parameter depends on the resolution or on the frame rate.
class ContentAreaFinder {
 public:
  /// Adds the next frame. `luma`: CV_8UC1, the working image. Its time is in ns, and only differences matter. `patch`:
  /// odd side of the tracked patch in working pixels. The border is known from the first lit frame on, graphics after
  /// about 2.5 s of motion around them. A change of size restarts it; a time that runs back does not.
  void update(const cv::Mat &luma, std::int64_t time, int patch);

  /// CV_8UC1 of the luma's size, 255 where a patch centred there would touch border or graphics, else 0. The picture's
  /// own edge is not included. Empty before the first update().
  const cv::Mat &forbidden() const { return forbidden_; }

  /// Whether a patch centred here, in working pixels, would touch border or graphics. False outside the picture.
  bool contains(cv::Point2d p) const;

  /// Whether the last update() changed forbidden().
  bool changed() const { return changed_; }

  void reset();

 private:
  void grow(cv::Size size, int patch);

  DarkBorder border_;
  BurntIn graphics_;
  bool started_ = false;
  std::int64_t last_border_ = 0, last_graphics_ = 0;
  int patch_ = 0;
  bool changed_ = false;
  cv::Mat forbidden_;
};

}  // namespace csd
