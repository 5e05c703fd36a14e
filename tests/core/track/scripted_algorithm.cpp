// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/scripted_algorithm.h"

namespace csd {

/// Takes the place of core/track/make_algorithm.cpp in the program that this is linked into.
std::unique_ptr<Algorithm> make_algorithm(const Settings &, Executor &) {
  return std::make_unique<Scripted>();
}

}  // namespace csd
