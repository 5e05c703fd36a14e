// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include "support/latency.h"
#include "track/settings.h"

namespace csd {

/// The structure of the property `stats`. The caller owns it.
GstStructure *stats_structure(const Stats &stats, const Latency &latency, guint64 failed_frames);

}  // namespace csd
