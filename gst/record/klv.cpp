// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/klv.h"

#include <algorithm>

#include "text/read_line.h"

namespace csd {

namespace {

constexpr std::size_t key_bytes = 16;
constexpr std::string_view label_begin = klv_label.substr(0, 4);  // common to all labels

/// Length and start of a packet's value. `value` is 0 while bytes are missing.
struct Head {
  std::size_t value = 0, length = 0;
  bool possible = true;
};

Head head(std::string_view packet) {
  if (packet.size() <= key_bytes) return {};
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(packet[at]); };
  const unsigned first = byte(key_bytes), more = first & 0x7f;
  if (first < 0x80) return {key_bytes + 1, first};
  if (more == 0 || more > 8) return {0, 0, false};
  if (packet.size() < key_bytes + 1 + more) return {};
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < more; ++i) length = length << 8 | byte(key_bytes + 1 + i);
  return {key_bytes + 1 + more, static_cast<std::size_t>(length), length <= max_line_bytes};
}

}  // namespace

std::string klv_packet(std::string_view piece, std::uint64_t line, std::size_t number, std::size_t count) {
  std::string packet(klv_label);
  packet += static_cast<char>(count == 1 ? 0 : line % 127 + 1);  // label bytes are below 128
  packet += static_cast<char>((count - 1 - number) % 128);
  std::string length;
  for (std::size_t rest = piece.size(); rest > 0; rest >>= 8) length.insert(length.begin(), static_cast<char>(rest));
  if (piece.size() >= 128)
    packet += static_cast<char>(0x80 | length.size());
  else if (length.empty())
    length += '\0';
  return packet += length += piece;
}

KlvSplitter::Found KlvSplitter::next() {
  const std::string_view bytes = bytes_;
  if (!inside_) {
    const std::size_t begin = bytes.find(klv_label, used_);
    if (begin == bytes.npos) {  // the last bytes may start a label
      used_ = std::max(used_, bytes.size() - std::min(bytes.size(), klv_label.size() - 1));
      return Found::nothing;
    }
    inside_ = true;
    used_ = begin;
    checked_ = begin;
  }
  const Head of = head(bytes.substr(used_));
  if (!of.possible) return leave(used_ + klv_label.size(), Found::torn);
  if (of.value == 0) return Found::nothing;
  value_ = used_ + of.value;
  const std::size_t end = value_ + of.length;
  const std::string_view key_end = bytes.substr(0, value_ + label_begin.size() - 1);
  std::size_t other = key_end.find(label_begin, used_ + klv_label.size());
  if (other == bytes.npos) other = bytes.substr(0, end).find(label_begin[0], std::max(checked_, value_));
  if (other != bytes.npos) return leave(other, Found::torn);
  if (end > bytes.size()) {
    checked_ = bytes.size();
    return Found::nothing;
  }
  line_ = static_cast<unsigned char>(bytes[used_ + klv_label.size()]);
  rest_ = static_cast<unsigned char>(bytes[used_ + klv_label.size() + 1]);
  return leave(end, Found::packet);
}

}  // namespace csd
