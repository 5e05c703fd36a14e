// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <string>
#include <vector>

#include "support/enums.h"
#include "support/property_table.h"

namespace csd {

/// The values of csdtrackenc's properties.
struct EncValues {
  GstCsdTrackEncRole role = GST_CSD_TRACK_ENC_ROLE_TRACK;
  std::string source;
};

/// csdtrackenc's own properties. Call it once, in class_init.
std::vector<Property<EncValues>> enc_properties();

}  // namespace csd
