// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <pybind11/pybind11.h>

#include <opencv2/core/types.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace csd {

/// What Python gives, as the core takes it. Where it can't be, TypeError or ValueError say what to write instead.

inline constexpr std::int64_t largest_side = 32768;  // pixels; as the element's `region`

std::string text_of(pybind11::handle value);  ///< repr()
std::string type_of(pybind11::handle value);  ///< the name of its type

/// A whole number within bounds: int, or a numpy integer. A bool isn't one, nor is a float. `advice` ends the error.
std::int64_t whole(pybind11::handle value, const std::string &name, std::int64_t least, std::int64_t most,
                   const std::string &advice = "");
/// The same for uint64, which has no other bounds.
std::uint64_t whole_seed(pybind11::handle value);
/// Nanoseconds.
std::int64_t time_setting(pybind11::handle value, const char *name);
/// Nanoseconds of a frame; None is no_time.
std::int64_t frame_time(pybind11::handle value, const char *name);

bool truth(pybind11::handle value, const char *name);         ///< what has a truth value as numbers have; no text
double coordinate(pybind11::handle value, const char *name);  ///< pixels, finite

/// Which of the words `value` is.
std::size_t choice(pybind11::handle value, const char *name, const std::vector<std::string> &words);

/// N×2 numbers; none for None.
std::vector<cv::Point2d> given_points(pybind11::handle value);
/// x, y, width, height; empty for None.
cv::Rect given_region(pybind11::handle value);

}  // namespace csd
