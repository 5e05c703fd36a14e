// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdlib>
#include <filesystem>
#include <opencv2/videoio.hpp>
#include <string>

namespace csd::test {

/// The real clip `name`, in $CSDTRACK_CLIPS, else in ../shared/clips; not opened if it doesn't exist. For a missing
/// file OpenCV would try all its backends, cameras too (libgphoto2, libusb), in which valgrind finds leaks.
inline cv::VideoCapture open_clip(const std::string &name) {
  const char *folder = std::getenv("CSDTRACK_CLIPS");
  const std::string path = std::string(folder ? folder : "../shared/clips") + "/" + name;
  return std::filesystem::exists(path) ? cv::VideoCapture(path) : cv::VideoCapture();
}

}  // namespace csd::test
