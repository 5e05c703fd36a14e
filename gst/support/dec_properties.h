// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <string>
#include <vector>

#include "support/enums.h"
#include "support/property_table.h"

namespace csd {

/// Values that may change with every frame; without text, so that copying them can't fail.
struct DecLive {
  GstCsdTrackOverlay overlay = GST_CSD_TRACK_OVERLAY_NONE;
  GstClockTime max_wait = 5 * GST_SECOND;
  gint64 ts_offset = 0;
};

/// The values of csdtrackdec's properties.
struct DecValues {
  std::string location;
  DecLive live;
};

/// csdtrackdec's own properties. Call it once, in class_init. `overlay_changed`: Property::changed.
std::vector<Property<DecValues>> dec_properties(void (*overlay_changed)(gpointer));

/// Adds the templates of csdtrackdec's pads. Call it once, in class_init.
void add_dec_pad_templates(GstElementClass *klass);

}  // namespace csd
