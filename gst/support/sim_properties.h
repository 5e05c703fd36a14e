// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <string>
#include <vector>

#include "support/enums.h"
#include "support/property_table.h"

namespace csd {

/// The values of csdsimsrc's properties.
struct SimValues {
  GstCsdSimScenario scenario = GST_CSD_SIM_SCENARIO_DEFORMATION;
  guint64 seed = 1;
  gdouble strength = 1;
  std::string effects;
  GstCsdSimStyle style = GST_CSD_SIM_STYLE_HEART;
  std::string texture;
  guint features = 100;
  std::string points;
  bool is_live = false;
};

/// csdsimsrc's own properties. Call it once, in class_init.
std::vector<Property<SimValues>> sim_properties();

}  // namespace csd
