// SPDX-License-Identifier: LGPL-2.1-or-later
#include <glib.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

#include "fuzz.h"

// Set here and not in the environment, so that a finding can be given to the program directly.
extern "C" {
const char *__asan_default_options();
const char *__asan_default_options() {
  // A small quarantine, since libFuzzer counts it as the target's memory.
  return "detect_stack_use_after_return=1:strict_string_checks=1:quarantine_size_mb=32:allocator_may_return_null="
         "0";
}
const char *__ubsan_default_options();
const char *__ubsan_default_options() {
  return "halt_on_error=1:print_stacktrace=1";
}
const char *__lsan_default_suppressions();
const char *__lsan_default_suppressions() {
  return "leak:ld-linux\n";  // tests/setups/lsan.supp explains it
}
int LLVMFuzzerInitialize(int *, char ***);
int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size);
}

namespace csd_fuzz {

[[gnu::weak]] void start() {}

namespace {

std::string_view planted() {
  static const char *const fault = std::getenv("CSDTRACK_FUZZ_PLANT");
  return fault ? fault : "";
}

/// Faults to plant, independent of the code under test.
void plant() {
  if (planted() == "critical") g_return_if_fail_warning("csdtrack", __func__, "planted");
  if (planted() == "leak") *static_cast<volatile char *>(g_malloc(16)) = 1;
}

bool hears = true;

/// A critical from GLib or GStreamer is a bug of ours. G_DEBUG=fatal-criticals is no use: it ends in a SIGTRAP, which
/// libFuzzer doesn't handle, and the input would be lost.
GLogWriterOutput log(GLogLevelFlags level, const GLogField *fields, gsize count, gpointer) {
  if (hears && (level & (G_LOG_LEVEL_CRITICAL | G_LOG_LEVEL_ERROR))) {
    g_log_writer_standard_streams(level, fields, count, nullptr);
    std::abort();
  }
  return G_LOG_WRITER_HANDLED;
}

}  // namespace

static void hear_criticals() {
  g_log_set_writer_func(log, nullptr, nullptr);
}

void ignore_criticals() {
  hears = false;
}

std::size_t planted_bytes() {
  return planted() == "read" ? 1 : 0;
}

bool is_utf8(std::string_view text) {
  return g_utf8_validate(text.data(), static_cast<gssize>(text.size()), nullptr);
}

std::vector<std::string_view> split(std::string_view bytes, std::size_t most) {
  std::vector<std::string_view> parts;
  while (parts.size() + 1 < most) {
    const std::size_t at = bytes.find(separator);
    if (at == std::string_view::npos) break;
    parts.push_back(bytes.substr(0, at + 1));  // with its newline
    bytes.remove_prefix(at + separator.size());
  }
  parts.push_back(bytes);
  return parts;
}

MemoryFile::MemoryFile(std::string_view content)
    : fd_(memfd_create("fuzz", MFD_CLOEXEC)), path_("/proc/self/fd/" + std::to_string(fd_)) {
  expect(write(fd_, content.data(), content.size()) == static_cast<ssize_t>(content.size()));
}

MemoryFile::~MemoryFile() {
  close(fd_);
}

}  // namespace csd_fuzz

int LLVMFuzzerInitialize(int *, char ***) {
  csd_fuzz::hear_criticals();
  csd_fuzz::start();
  return 0;
}

int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
  csd_fuzz::run({reinterpret_cast<const char *>(data), size + (size > 0 ? csd_fuzz::planted_bytes() : 0)});
  csd_fuzz::plant();
  return 0;
}
