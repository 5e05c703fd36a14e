// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <string>

namespace csd {

/// The picture in a file, as CV_8UC3, B G R, without its alpha: any format that gdk-pixbuf has a loader for, at most
/// 8192 × 8192 pixels and 1 GiB; of an animation, the first picture. Throws std::invalid_argument with the reason.
cv::Mat load_picture(const std::string &file);

}  // namespace csd
