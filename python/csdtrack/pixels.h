// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <pybind11/numpy.h>

#include "image/frame_view.h"

namespace csd {

/// An array's pixels, held so that nobody can resize the array meanwhile. Belongs to who holds the GIL.
class Pixels {
 public:
  /// `frame` is to be a numpy array of uint8, H×W or H×W×3; its strides may be anything. TypeError and ValueError say
  /// what else it is.
  Pixels(const pybind11::object &frame, bool bgr);

  const FrameView &view() const { return view_; }

 private:
  pybind11::buffer_info info_;
  FrameView view_;
};

}  // namespace csd
