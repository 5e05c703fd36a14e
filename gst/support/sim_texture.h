// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <string>

namespace csd {

/// The first picture of a file that GStreamer can decode (an image or a video), as CV_8UC3, B G R. Throws
/// std::invalid_argument with the reason.
cv::Mat load_picture(const std::string &file);

}  // namespace csd
