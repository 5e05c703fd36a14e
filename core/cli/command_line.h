// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <glib.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace csd::cli {

/// A program was called wrongly; exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct FreeOptionContext {
  void operator()(GOptionContext *context) const { g_option_context_free(context); }
};

/// Fills in what `entries` point to. `usage` and `description` are for --help, which ends the program. Throws
/// UsageError.
inline void parse_options(int argc, char **argv, const GOptionEntry *entries, const char *usage,
                          const char *description) {
  const std::unique_ptr<GOptionContext, FreeOptionContext> context(g_option_context_new(usage));
  g_option_context_set_description(context.get(), description);
  g_option_context_add_main_entries(context.get(), entries, nullptr);
  GError *error = nullptr;
  if (g_option_context_parse(context.get(), &argc, &argv, &error)) return;
  const std::string message = error->message;
  g_error_free(error);
  throw UsageError(message);
}

}  // namespace csd::cli
