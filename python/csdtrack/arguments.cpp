// SPDX-License-Identifier: LGPL-2.1-or-later
#include "arguments.h"

#include <pybind11/numpy.h>

#include <cmath>

#include "base/types.h"

namespace py = pybind11;

namespace csd {
namespace {

constexpr std::int64_t any_time = INT64_MAX;
const char *const time_advice = ": give whole nanoseconds, round(seconds * 1e9)";

std::string range_text(std::int64_t lowest, std::int64_t highest) {
  return std::to_string(lowest) + "…" + (highest == any_time ? "2^63-1" : std::to_string(highest));
}

}  // namespace

std::string text_of(py::handle value) {
  return py::cast<std::string>(py::repr(value));
}

std::string type_of(py::handle value) {
  return py::cast<std::string>(py::type::handle_of(value).attr("__name__"));
}

std::int64_t whole(py::handle value, const std::string &name, std::int64_t lowest, std::int64_t highest,
                   const std::string &advice) {
  if (!PyIndex_Check(value.ptr()) || PyBool_Check(value.ptr()))
    throw py::type_error(name + " is a " + type_of(value) + ", not an int" + advice);
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!number) throw py::error_already_set();
  int overflow = 0;
  const std::int64_t result = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
  if (overflow != 0 || result < lowest || result > highest)
    throw py::value_error(name + "=" + text_of(number) + " is not in " + range_text(lowest, highest) + advice);
  return result;
}

std::uint64_t whole_seed(py::handle value) {
  const std::string advice = "give any whole number below 2^64";
  if (!PyIndex_Check(value.ptr()) || PyBool_Check(value.ptr()))
    throw py::type_error("seed is a " + type_of(value) + ", not an int: " + advice);
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!number) throw py::error_already_set();
  const std::uint64_t result = PyLong_AsUnsignedLongLong(number.ptr());
  if (PyErr_Occurred()) {
    PyErr_Clear();
    throw py::value_error("seed=" + text_of(number) + " is not in 0…2^64-1: " + advice);
  }
  return result;
}

std::int64_t time_setting(py::handle value, const char *name) {
  return whole(value, name, 0, any_time, time_advice);
}

std::int64_t frame_time(py::handle value, const char *name) {
  return value.is_none() ? no_time : whole(value, name, 0, any_time, std::string(time_advice) + ", or None");
}

bool truth(py::handle value, const char *name) {
  py::detail::make_caster<bool> caster;
  if (value.is_none() || !caster.load(value, true))  // the caster takes None for false
    throw py::type_error(std::string(name) + " is a " + type_of(value) + ", not a bool: give True or False");
  return caster;
}

double coordinate(py::handle value, const char *name) {
  py::detail::make_caster<double> caster;
  if (PyBool_Check(value.ptr()) || !caster.load(value, true))
    throw py::type_error(std::string(name) + " is a " + type_of(value) + ", not a number: give pixels");
  const double number = caster;
  if (!std::isfinite(number))
    throw py::value_error(std::string(name) + "=" + text_of(value) + " is not finite: give pixels");
  return number;
}

std::size_t choice(py::handle value, const char *name, const std::vector<std::string> &words) {
  const bool is_text = py::isinstance<py::str>(value);
  std::string all;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (is_text && py::cast<std::string>(value) == words[i]) return i;
    all += (i ? ", '" : "'") + words[i] + "'";
  }
  const std::string problem = std::string(name) + "=" + text_of(value) + " is none of " + all;
  if (!is_text) throw py::type_error(problem);
  throw py::value_error(problem);
}

std::vector<cv::Point2d> given_points(py::handle value) {
  if (value.is_none()) return {};
  const std::string advice = ": give N rows of x, y in pixels";
  using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;
  const auto array = Rows::ensure(value);
  if (!array) throw py::type_error("points is no array of numbers" + advice);
  if (array.size() == 0)
    throw py::value_error(
        "points is empty: leave it out to have features detected, or set max_features=0 to begin with none");
  if (array.ndim() != 2 || array.shape(1) != 2)
    throw py::value_error("points has the shape " + text_of(array.attr("shape")) + advice);
  const auto count = static_cast<std::size_t>(array.shape(0));
  if (count > max_points)
    throw py::value_error("points has " + std::to_string(count) + " rows: at most " + std::to_string(max_points) +
                          " points can be tracked");
  std::vector<cv::Point2d> points;
  for (py::ssize_t i = 0; i < array.shape(0); ++i) {
    points.emplace_back(array.at(i, 0), array.at(i, 1));
    if (!std::isfinite(points.back().x) || !std::isfinite(points.back().y))
      throw py::value_error("points[" + std::to_string(i) + "] is not finite: leave it out");
  }
  return points;
}

cv::Rect given_region(py::handle value) {
  if (value.is_none()) return {};
  const std::string advice = ": give x, y, width, height in whole pixels";
  if (!PySequence_Check(value.ptr()) || py::isinstance<py::str>(value))
    throw py::type_error("region is a " + type_of(value) + advice);
  const auto sequence = py::reinterpret_borrow<py::sequence>(value);
  if (sequence.size() != 4) throw py::value_error("region=" + text_of(value) + " has not four numbers" + advice);
  int numbers[4];
  for (std::size_t i = 0; i < 4; ++i) {
    const py::object number = sequence[i];
    numbers[i] =
        static_cast<int>(whole(number, "region[" + std::to_string(i) + "]", i < 2 ? 0 : 1, largest_side, advice));
  }
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

}  // namespace csd
