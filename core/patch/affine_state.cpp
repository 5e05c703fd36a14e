// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/affine_state.h"

#include <cmath>

namespace csd {

double AffineState::scale() const {
  return std::sqrt(shape(0, 0) * shape(1, 1) - shape(0, 1) * shape(1, 0));
}

}  // namespace csd
