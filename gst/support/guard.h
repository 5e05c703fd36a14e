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

/// An error that only the user can fix. It has its own code and a complete message.
struct Refusal : std::runtime_error {
  Refusal(GstResourceError number, const std::string &text)
      : std::runtime_error(text), domain(GST_RESOURCE_ERROR), code(number) {}
  Refusal(GstStreamError number, const std::string &text)
      : std::runtime_error(text), domain(GST_STREAM_ERROR), code(number) {}

  GQuark domain;
  int code;
};

/// What a caught exception means. The element adds what to do about it, because it knows the context.
struct Failure {
  std::string reason;  ///< a clause without a full stop, or the whole text of a Refusal; never empty
  std::string detail;  ///< the same with the exception's origin, if known: for logs and a message's debug text
  bool out_of_memory = false;
  GQuark domain = 0;  ///< of a Refusal; 0: none
  int code = 0;
};

/// Describes the exception being handled. Call it only in a catch block. Does not throw.
Failure describe_current_exception() noexcept;

/// Runs `body` and returns its exception, or nothing on success. Every function called from C code must use it, because
/// an exception that unwinds through C ends the process. Only the creation of an element is not guarded:
/// without memory GLib ends the process there anyway.
template <typename Body>
std::optional<Failure> guarded(Body &&body) noexcept {
  try {
    std::forward<Body>(body)();
    return std::nullopt;
  } catch (...) {
    return describe_current_exception();
  }
}

/// A place in the source code. As a default argument, `Place::here()` is the place of the call. (std::source_location
/// does this, but clang 14 lacks it.)
struct Place {
  const char *file, *function;
  int line;

  static constexpr Place here(const char *file = __builtin_FILE(), const char *function = __builtin_FUNCTION(),
                              int line = __builtin_LINE()) {
    return {file, function, line};
  }
};

using Text = std::unique_ptr<gchar, decltype(&g_free)>;

/// How the elements run code that may throw, and report failures. Messages and logs name the place of the call.
class Guard {
 public:
  /// `category`: the element's debug category variable. `memory`: the whole message when out of memory. `failed`:
  /// otherwise, the text before the reason; `advice`: a sentence after it, or "".
  constexpr Guard(GstDebugCategory *&category, const char *memory, const char *failed, const char *advice)
      : category_(&category), memory_(memory), failed_(failed), advice_(advice) {}

  /// Runs `body`. After an exception posts an error on the bus and returns false.
  template <typename Body>
  bool posted(gpointer element, Body &&body, Place place = Place::here()) const noexcept {
    const auto failure = guarded(std::forward<Body>(body));
    if (failure) post(element, *failure, place);
    return !failure;
  }
  /// The same, but only logs the failure. For failures that nothing can be done about.
  template <typename Body>
  bool logged(gpointer element, Body &&body, Place place = Place::here()) const noexcept {
    const auto failure = guarded(std::forward<Body>(body));
    if (failure) log(element, *failure, place);
    return !failure;
  }

  void post(gpointer element, const Failure &failure, Place place = Place::here()) const noexcept;
  void log(gpointer element, const Failure &failure, Place place = Place::here()) const noexcept;
  /// For the user who runs the pipeline.
  Text text(const Failure &failure) const noexcept;

 private:
  GstDebugCategory **category_;
  const char *memory_, *failed_, *advice_;
};

}  // namespace csd
