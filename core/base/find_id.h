// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <functional>
#include <ranges>

#include "base/types.h"

namespace csd {

/// The element of this id in a range that is sorted by ascending id; the range's end() if there is none. `id_of` gives
/// an element's id: a member, or a function.
template <std::ranges::random_access_range Range, typename IdOf>
auto find_id(Range &&range, FeatureId id, IdOf id_of) {
  const auto at = std::ranges::lower_bound(range, id, {}, id_of);
  return at != std::ranges::end(range) && std::invoke(id_of, *at) == id ? at : std::ranges::end(range);
}

}  // namespace csd
