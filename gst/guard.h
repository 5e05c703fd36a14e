// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace csd {

/// What only the user can put right: an error of its own code, that says all there is to say.
struct Refusal : std::runtime_error {
  Refusal(GstResourceError number, const std::string &text)
      : std::runtime_error(text), domain(GST_RESOURCE_ERROR), code(number) {}
  Refusal(GstStreamError number, const std::string &text)
      : std::runtime_error(text), domain(GST_STREAM_ERROR), code(number) {}

  GQuark domain;
  int code;
};

/// What a caught exception means. What to do about it the element says, which knows what it was doing.
struct Failure {
  std::string reason;  ///< a clause without its stop, or all of a Refusal's text; never empty
  std::string detail;  ///< the same, with where it came from if that is known: for logs and a message's debug text
  bool out_of_memory = false;
  GQuark domain = 0;  ///< a Refusal's; 0: it is none
  int code = 0;
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

using Text = std::unique_ptr<gchar, decltype(&g_free)>;

/// How the elements run what may throw, and how they tell what has failed.
class Guard {
 public:
  /// `category`: where the element keeps its own. `memory`: all that is said where memory is short. `failed`: what is
  /// said before the reason, else; `advice`: a sentence after it, or "".
  constexpr Guard(GstDebugCategory *&category, const char *memory, const char *failed, const char *advice)
      : category_(&category), memory_(memory), failed_(failed), advice_(advice) {}

  /// Runs `body`. False after an exception, which has become an error on the bus then.
  template <typename Body>
  bool posted(gpointer element, Body &&body) const noexcept {
    const auto failure = guarded(std::forward<Body>(body));
    if (failure) post(element, *failure);
    return !failure;
  }
  /// For where nothing can be done about a failure, and nobody has to know: the same, but it goes to the log.
  template <typename Body>
  bool logged(gpointer element, Body &&body) const noexcept {
    const auto failure = guarded(std::forward<Body>(body));
    if (failure) log(element, *failure);
    return !failure;
  }

  void post(gpointer element, const Failure &failure) const noexcept;
  void log(gpointer element, const Failure &failure) const noexcept;
  /// For the person who runs the pipeline.
  Text text(const Failure &failure) const noexcept;

 private:
  GstDebugCategory **category_;
  const char *memory_, *failed_, *advice_;
};

}  // namespace csd
