// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <memory>

#include "track/algorithm.h"

namespace csd {

/// Makes the algorithm that the settings name, for a Tracker. `executor` must outlive it. Throws std::invalid_argument
/// if there is none.
std::unique_ptr<Algorithm> make_algorithm(const Settings &settings, Executor &executor);

}  // namespace csd
