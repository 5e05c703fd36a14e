// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <glib.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace csd::programs {

/// Wrong usage of a program; exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct FreeOptionContext {
  void operator()(GOptionContext *context) const { g_option_context_free(context); }
};

/// Parses options into `entries`. `usage` and `description` are for --help, which exits, like --version. Throws
/// UsageError.
inline void parse_options(int argc, char **argv, const GOptionEntry *entries, const char *usage,
                          const char *description) {
  gboolean version = FALSE;
  const GOptionEntry common[] = {{"version", 0, 0, G_OPTION_ARG_NONE, &version, "Say which version this is", nullptr},
                                 {nullptr, 0, 0, G_OPTION_ARG_NONE, nullptr, nullptr, nullptr}};
  const std::unique_ptr<GOptionContext, FreeOptionContext> context(g_option_context_new(usage));
  g_option_context_set_description(context.get(), description);
  g_option_context_add_main_entries(context.get(), entries, nullptr);
  g_option_context_add_main_entries(context.get(), common, nullptr);
  GError *error = nullptr;
  if (g_option_context_parse(context.get(), &argc, &argv, &error)) {
    if (!version) return;
    std::printf("%s %s\n", g_get_prgname(), CSDTRACK_VERSION);
    std::exit(0);  // NOLINT(concurrency-mt-unsafe): there is only one thread yet
  }
  const std::string message = error->message;
  g_error_free(error);
  throw UsageError(message);
}

/// Standard output couldn't be written in full; errno has the reason.
[[noreturn]] inline void throw_unwritten() {
  throw std::runtime_error("the output can't be written: " + std::generic_category().message(errno));
}

/// A program's main(): returns 0, 1 if `run` throws, 2 for a UsageError. `run(notes)` adds notes for the user; they and
/// errors go to stderr, one per line.
template <class Run>
int run_command(const char *name, Run run) {
  std::vector<std::string> notes;
  // Copies nothing, because that would fail too when out of memory.
  const auto told = [&](int code, const char *problem) {
    for (const std::string &note : notes) std::fprintf(stderr, "%s: note: %s\n", name, note.c_str());
    if (problem) std::fprintf(stderr, "%s: %s\n", name, problem);
    return code;
  };
  try {
    run(notes);
    return told(0, nullptr);
  } catch (const UsageError &error) {
    return told(2, error.what());
  } catch (const std::bad_alloc &) {
    return told(1, "out of memory");
  } catch (const std::exception &error) {
    return told(1, error.what());
  }
}

}  // namespace csd::programs
