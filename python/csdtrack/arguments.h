// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <pybind11/pybind11.h>

#include <opencv2/core/types.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace csd {

/// Converts Python's values to the core's. If that fails, TypeError or ValueError say what to write instead.

inline constexpr std::int64_t largest_side = 32768;  // pixels; as in the element's `region`

std::string text_of(pybind11::handle value);  ///< repr()
std::string type_of(pybind11::handle value);  ///< the name of its type

/// A whole number within bounds: an int or a numpy integer, not a bool or a float. `advice` ends the error's text.
std::int64_t whole(pybind11::handle value, const std::string &name, std::int64_t lowest, std::int64_t highest,
                   const std::string &advice = "");
/// The same for uint64, without further bounds.
std::uint64_t whole_seed(pybind11::handle value);
/// Nanoseconds.
std::int64_t time_setting(pybind11::handle value, const char *name);
/// A frame's time in nanoseconds; None is no_time.
std::int64_t frame_time(pybind11::handle value, const char *name);

bool truth(pybind11::handle value, const char *name);  ///< anything with a truth value like a number's, but no text
double coordinate(pybind11::handle value, const char *name);  ///< pixels, finite

/// The index of `value` among the words.
std::size_t choice(pybind11::handle value, const char *name, const std::vector<std::string> &words);

/// N×2 numbers; none for None.
std::vector<cv::Point2d> given_points(pybind11::handle value);
/// x, y, width, height; empty for None.
cv::Rect given_region(pybind11::handle value);

}  // namespace csd
