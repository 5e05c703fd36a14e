// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pixels.h"

#include <algorithm>
#include <string>

#include "arguments.h"

namespace py = pybind11;

namespace csd {

Pixels::Pixels(const py::object &frame, bool bgr) {
  if (!py::isinstance<py::array>(frame))
    throw py::type_error("frame is a " + type_of(frame) + ": give a numpy array of uint8, H×W or H×W×3");
  if (!py::isinstance<py::array_t<std::uint8_t>>(frame))
    throw py::type_error("frame is an array of " + py::cast<std::string>(py::str(frame.attr("dtype"))) +
                         ": give uint8, 0…255");
  const auto array = py::reinterpret_borrow<py::array>(frame);
  info_ = array.request();
  const auto shape = text_of(array.attr("shape"));
  if (info_.ndim == 3 && info_.shape[2] == 4)
    throw py::value_error("frame has the shape " + shape + ": leave alpha out, frame[..., :3] copies nothing");
  const bool gray = info_.ndim == 2;
  if (!gray && (info_.ndim != 3 || info_.shape[2] != 3))
    throw py::value_error("frame has the shape " + shape + ": give H×W (gray) or H×W×3 (colour)");
  if (std::min(info_.shape[0], info_.shape[1]) < 1 || std::max(info_.shape[0], info_.shape[1]) > largest_side)
    throw py::value_error("frame has the shape " + shape + ": give 1…" + std::to_string(largest_side) +
                          " pixels in width and height");
  view_.height = view_.rows = static_cast<int>(info_.shape[0]);
  view_.width = static_cast<int>(info_.shape[1]);
  view_.model = gray ? ColourModel::gray : ColourModel::rgb;
  // As GStreamer weighs RGB of this height, so that the element reports the same for the same picture.
  const bool standard_definition = view_.height <= 576;
  view_.kr = standard_definition ? 0.299 : 0.2126;
  view_.kb = standard_definition ? 0.114 : 0.0722;
  const auto *first = static_cast<const std::uint8_t *>(info_.ptr);
  for (std::size_t i = 0; i < (gray ? 1 : 3); ++i) {
    auto &component = view_.component[i];
    component.data = gray ? first : first + static_cast<std::ptrdiff_t>(bgr ? 2 - i : i) * info_.strides[2];
    component.row_stride = info_.strides[0];
    component.pixel_stride = info_.strides[1];
  }
}

}  // namespace csd
