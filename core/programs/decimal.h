// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <charconv>
#include <cmath>
#include <string>

namespace csd::programs {

/// Decimal point in every locale; `nothing` for a non-finite value.
inline std::string decimal(double value, int digits, const char *nothing) {
  if (!std::isfinite(value)) return nothing;
  if (std::abs(value) < 0.5 * std::pow(10.0, -digits)) value = 0;  // never "-0.000"
  char buffer[330];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, digits).ptr};
}

}  // namespace csd::programs
