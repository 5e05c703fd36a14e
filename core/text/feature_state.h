// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <optional>
#include <string_view>

#include "base/types.h"

namespace csd {

/// The state for a word of the schema; none for other words.
inline std::optional<FeatureState> state_of(std::string_view word) {
  for (std::size_t i = 0; i < feature_states; ++i)
    if (state_name(static_cast<FeatureState>(i)) == word) return static_cast<FeatureState>(i);
  return std::nullopt;
}

}  // namespace csd
