// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/text_file.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>

#include "score/types.h"
#include "text/read_line.h"

namespace csd::programs {

namespace {

/// Removes the next line from `rest` and returns it, with its newline if any.
std::string_view next_line(std::string_view &rest) {
  const std::string_view line = rest.substr(0, rest.find('\n') == rest.npos ? rest.npos : rest.find('\n') + 1);
  rest.remove_prefix(line.size());
  return line;
}

}  // namespace

std::vector<TextFile::Line> TextFile::lines() const {
  std::vector<Line> lines;
  std::string_view rest = content;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::string_view line = next_line(rest), text = line_text(line);
    if (line.ends_with('\n') && !text.empty()) lines.push_back({number, text});
  }
  return lines;
}

TextFile::Line TextFile::first() const {
  std::string_view rest = content;
  for (std::size_t number = 1; !rest.empty(); ++number)
    if (const std::string_view text = line_text(next_line(rest)); !text.empty()) return {number, text};
  return {1, {}};
}

namespace {

/// Reads the whole file, but stops at a line that is too long: this rejects binary files before they fill the memory.
std::string content_of(const std::string &name) {
  errno = 0;
  std::ifstream in(name, std::ios::binary);
  std::string content;
  std::size_t number = 1, begin = 0;  // of the current line
  for (std::vector<char> chunk(1 << 20); in;) {
    in.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    const auto size = static_cast<std::size_t>(in.gcount());
    content.append(chunk.data(), size);
    for (;;) {
      const std::size_t end = content.find('\n', std::max(begin, content.size() - size));
      if (std::min(end, content.size()) - begin > max_line_bytes)
        throw score::InputError(name, number, "is longer than " + std::to_string(max_line_bytes >> 20) + " MiB");
      if (end == std::string::npos) break;
      begin = end + 1;
      ++number;
    }
  }
  if (!in.eof())
    throw score::InputError(name, 0, "can't be read: " + std::generic_category().message(errno ? errno : EIO));
  return content;
}

}  // namespace

TextFile read_text_file(const std::string &name) {
  TextFile file{name, content_of(name), false};
  if (file.content.starts_with("\xef\xbb\xbf")) file.content.erase(0, 3);  // labels.json has no lines
  if (file.content.find_first_not_of(line_blanks) == std::string::npos) throw score::InputError(name, 0, "is empty");
  file.torn = !file.content.ends_with('\n');
  return file;
}

void note_torn(const TextFile &file, std::vector<std::string> &notes) {
  if (!file.torn) return;
  const auto line = std::count(file.content.begin(), file.content.end(), '\n') + 1;
  notes.push_back(file.name + ":" + std::to_string(line) + ": the last line has no newline, may be torn, is ignored");
}

}  // namespace csd::programs
