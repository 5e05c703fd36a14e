// SPDX-License-Identifier: LGPL-2.1-or-later
// The properties `points` of csdtrack and csdsimsrc.
#include <cmath>

#include "base/types.h"
#include "fuzz.h"
#include "text/parse.h"

void csd_fuzz::run(std::string_view text) {
  csd::is_truth(text);
  const auto points = csd::parse_points(text);
  expect(points.value.size() <= csd::max_points);
  for (const cv::Point2d &point : points.value) expect(std::isfinite(point.x) && std::isfinite(point.y));
  expect((points || points.value.empty()) && is_utf8(points.error));
}
