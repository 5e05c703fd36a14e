// SPDX-License-Identifier: LGPL-2.1-or-later
// A module linked like ours, for imports_test.py to load. Its exceptions pass destructors.
#include <opencv2/imgproc.hpp>

#include <string>
#include <vector>

#include "../faults.h"
#include "image/work_frame.h"

namespace {

struct Guard {
  explicit Guard(bool &gone) : gone_(gone) {}
  ~Guard() { gone_ = true; }
  bool &gone_;
};

/// Whether `body` throws an Exception and the objects alive are destroyed.
template <class Exception, class Body>
bool thrown(Body body) {
  bool gone = false;
  try {
    const Guard guard(gone);
    body();
  } catch (const Exception &) {
    return gone;
  }
  return false;
}

/// Whether the colour of a downscaled picture can be read after each allocation on the way has failed once.
bool survives_lack_of_memory() {
  constexpr int width = 320, height = 180;
  const std::vector<std::uint8_t> pixels(std::size_t{3} * width * height, 100);
  csd::FrameView view;
  view.width = width;
  view.height = view.rows = height;
  view.model = csd::ColourModel::rgb;
  for (std::size_t k = 0; k < 3; ++k)
    view.component[k] = {.data = pixels.data() + k * width * height, .row_stride = width};
  long failed = 0;
  for (bool whole = false; !whole; failed += !whole) {
    csd::WorkFrame frame;
    frame.load(view, height / 2);
    cv::Mat colour(20, 20, CV_8UC3);
    left[operator_new] = failed;
    counting = true;
    whole = !thrown<std::bad_alloc>([&] { frame.gather_bgr({10, 10, 20, 20}, colour); });
    counting = false;
    frame.gather_bgr({10, 10, 20, 20}, colour);
    if (colour.at<cv::Vec3b>(10, 10) != cv::Vec3b(100, 100, 100)) return false;
  }
  return failed > 0;
}

}  // namespace

extern "C" {

[[gnu::visibility("default")]] bool throws_ours() {
  return thrown<std::invalid_argument>([] { throw std::invalid_argument("ours"); });
}
[[gnu::visibility("default")]] bool throws_the_library() {
  return thrown<std::invalid_argument>([] { return std::stoi("none"); });
}
[[gnu::visibility("default")]] bool throws_opencv() {
  return thrown<cv::Exception>([] { cv::resize(cv::Mat(), cv::Mat(), {}); });
}
[[gnu::visibility("default")]] bool throws_again() {
  return thrown<std::exception>([] {
    bool gone;
    try {
      const Guard guard(gone);
      throw std::runtime_error("ours");
    } catch (...) {
      throw;
    }
  });
}
[[gnu::visibility("default")]] bool throws_for_memory() {
  return survives_lack_of_memory();
}
}
