// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <string>

#include "programs/label_session.h"

namespace csd::programs {

/// The part of a picture shown in a window, and its scale.
struct LabelView {
  cv::Size picture;
  cv::Size screen;           ///< size of the window area that shows it
  double scale = 1;          ///< screen pixels per picture pixel
  cv::Point2d corner{0, 0};  ///< of the picture, at the screen's upper left; 0,0 is the picture's corner

  /// The whole picture, at most `largest` on the screen; never enlarged.
  static LabelView whole(cv::Size picture, cv::Size largest);
  /// Zooms around a screen pixel, which keeps its place in the picture.
  void zoom(cv::Point screen_pixel, double factor);

  cv::Point2d to_picture(cv::Point screen_pixel) const;  ///< pixel centres at integers on both sides
  cv::Point2d to_screen(cv::Point2d picture_pixel) const;
};

/// Renders the window: the picture with its labels, a loupe at the mouse, the point's look in frame 0, and a line of
/// text. The picture is at the upper left.
/// @param frame, first BGR pictures of the same size: the frame asked about, and frame 0
/// @param mouse on the screen
cv::Mat draw_label_window(const LabelView &view, const cv::Mat &frame, const cv::Mat &first,
                          const LabelSession &session, cv::Point mouse, const std::string &message);

}  // namespace csd::programs
