// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <string>

#include "support/track_properties.h"
#include "track/settings.h"

namespace csd {

/// The core's settings. If a text property can't be parsed, `error` says why.
Settings core_settings(const ElementSettings &settings, std::string &error);

/// The number of threads for `n-threads`: 0 is one fewer than the number of processors, at least 1.
unsigned thread_count(guint n_threads);

}  // namespace csd
