// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <pybind11/numpy.h>

#include "image/frame_view.h"

namespace csd {

/// An array's pixels. While it holds them, the array can't be resized. Only for the holder of the GIL.
class Pixels {
 public:
  /// `frame` must be a numpy array of uint8, H×W or H×W×3, with any strides. Otherwise TypeError and ValueError say
  /// what it is.
  Pixels(const pybind11::object &frame, bool bgr);

  const FrameView &view() const { return view_; }

 private:
  pybind11::buffer_info info_;
  FrameView view_;
};

}  // namespace csd
