// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace csd {

/// What a caught exception means. What to do about it the element says, which knows what it was doing.
struct Failure {
  std::string reason;  ///< a clause without its stop; never empty
  std::string detail;  ///< the same, with where it came from if that is known: for logs and a message's debug text
  bool out_of_memory = false;
};

/// Words for the exception that is being handled; only to be called in a catch block. Does not throw.
Failure describe_current_exception() noexcept;

/// Runs `body`. No exception leaves: it is returned instead, and nothing if all went well. Every function that C code
/// calls goes through here, for an exception that unwinds through C is the end of the process. Not the making
/// of an element: without memory for that GLib ends the process by itself.
template <typename Body>
std::optional<Failure> guarded(Body &&body) noexcept {
  try {
    std::forward<Body>(body)();
    return std::nullopt;
  } catch (...) {
    return describe_current_exception();
  }
}

}  // namespace csd
