// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/convert.h"

#include "image/colour_rows.h"

namespace csd {

void to_space(const cv::Mat &bgr, const ColourSpace &space, cv::Mat &out) {
  CV_Assert(bgr.type() == CV_8UC3);
  out.create(bgr.size(), CV_8UC1);
  // Row by row, so that the planes stay in the first-level cache.
  cv::Mat planes[3];
  for (int y = 0; y < bgr.rows; ++y) {
    cv::split(bgr.row(y), planes);
    rgb_to_space(space, planes[2].data, planes[1].data, planes[0].data, bgr.cols, out.ptr(y));
  }
}

}  // namespace csd
