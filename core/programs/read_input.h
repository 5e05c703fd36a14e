// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <variant>

#include "score/types.h"

namespace csd::programs {

using Input = std::variant<score::Truth, score::Recording>;

/// Reads truth or tracks, detected from the file's contents, not its name. Adds notes on skipped data to `notes`.
/// Throws score::InputError.
Input read_input(const std::string &path, std::vector<std::string> &notes);

}  // namespace csd::programs
