// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack's property `region`.
#include "fuzz.h"
#include "text/parse.h"

void csd_fuzz::run(std::string_view text) {
  const auto region = csd::parse_region(text);
  const cv::Rect &r = region.value;
  expect(r == cv::Rect() || (region && r.x >= 0 && r.y >= 0 && r.width > 0 && r.height > 0));
  expect(is_utf8(region.error));
}
