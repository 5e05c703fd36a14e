// SPDX-License-Identifier: LGPL-2.1-or-later
// What all targets share. A target is one source file that defines csd_fuzz::run(); driver.cpp is the rest of the
// program, and shows it to libFuzzer.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

namespace csd_fuzz {

/// What is done with an input. What it may throw it catches: an exception that leaves it is a finding.
void run(std::string_view bytes);

/// Once, before the first input. Element targets start GStreamer here (elements.cpp); the parsers need nothing.
void start();

/// For where they are others': a critical of GLib's is a finding no more.
void ignore_criticals();

/// By how many bytes memory is less than what is said of it: 0, unless CSDTRACK_FUZZ_PLANT=read plants that fault.
std::size_t planted_bytes();

/// What must hold of any input. Not assert(): it is a finding in every build.
inline void expect(bool holds) {
  if (!holds) std::abort();
}

/// Whether a text may go into a message on the bus.
bool is_utf8(std::string_view text);

/// The parts of an input that holds several files, or a file and numbers: between them stands this.
inline constexpr std::string_view separator = "\n====\n";
std::vector<std::string_view> split(std::string_view bytes, std::size_t most);

/// A file that is only in memory: fuzzing writes millions.
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
