// SPDX-License-Identifier: LGPL-2.1-or-later
// Shared by all targets. A target is one source file that defines csd_fuzz::run(). driver.cpp is the rest of the
// program, and connects it to libFuzzer.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

namespace csd_fuzz {

/// Processes an input. Catches the exceptions that are expected: any other is a finding.
void run(std::string_view bytes);

/// Called once, before the first input. Element targets start GStreamer here (elements.cpp); the parsers need nothing.
void start();

/// From here on GLib's criticals are no findings: for criticals that are other projects' bugs.
void ignore_criticals();

/// How many bytes a memory is shorter than stated: 0, unless CSDTRACK_FUZZ_PLANT=read plants that fault.
std::size_t planted_bytes();

/// Checks what must hold for any input. Unlike assert(), it works in every build.
inline void expect(bool holds) {
  if (!holds) std::abort();
}

/// Whether a text may go into a message on the bus.
bool is_utf8(std::string_view text);

/// Separates the parts of an input that holds several files, or a file and numbers.
inline constexpr std::string_view separator = "\n====\n";
std::vector<std::string_view> split(std::string_view bytes, std::size_t most);

/// A file in memory only, since fuzzing writes millions.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view content);
  ~MemoryFile();
  MemoryFile(const MemoryFile &) = delete;
  MemoryFile &operator=(const MemoryFile &) = delete;
  const std::string &path() const { return path_; }

 private:
  int fd_;
  std::string path_;
};

}  // namespace csd_fuzz
