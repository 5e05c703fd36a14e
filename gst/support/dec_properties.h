// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>
#include <string>
#include <vector>

#include "support/enums.h"
#include "support/property_table.h"

namespace csd {

/// The values of csdtrackdec's properties.
struct DecValues {
  std::string location;
  GstCsdTrackOverlay overlay = GST_CSD_TRACK_OVERLAY_NONE;
  GstClockTime max_wait = 5 * GST_SECOND;
  std::int64_t ts_offset = 0;
};

/// csdtrackdec's own properties. Call it once, in class_init.
std::vector<Property<DecValues>> dec_properties();

}  // namespace csd
