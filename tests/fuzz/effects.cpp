// SPDX-License-Identifier: LGPL-2.1-or-later
// csdsimsrc's property `effects`.
#include <stdexcept>

#include "fuzz.h"
#include "sim/scenario.h"

void csd_fuzz::run(std::string_view text) {
  csd::sim::Effects effects;
  try {
    effects.set(text);
  } catch (const std::invalid_argument &error) {
    expect(is_utf8(error.what()));
  }
  for (std::size_t i = 0; i < csd::sim::effect_count; ++i) {
    const double strength = effects[static_cast<csd::sim::Effect>(i)];
    expect(strength >= 0 && strength <= csd::sim::strongest);
  }
}
