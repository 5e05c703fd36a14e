// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <string>

namespace csd {

/// The text of `points` for a GstValueArray of arrays `<x,y>` of numbers: see parse_points(). An item of another shape
/// or type gives text that parse_points() refuses, with the item in its error.
std::string points_text(const GValue &array);
/// Fills a GstValueArray with `<x,y>` (doubles) for each point of the text; empty for text that holds no points.
void set_points(GValue &array, const std::string &text);

/// The text of `region` for a GstValueArray `<x,y,width,height>` of whole numbers: see parse_region().
std::string region_text(const GValue &array);
/// Fills a GstValueArray with x, y, width and height (ints); empty where the text means the whole picture or is wrong.
void set_region(GValue &array, const std::string &text);

}  // namespace csd
