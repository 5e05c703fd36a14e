// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace csd {

/// Lines in packets of SMPTE 336 (KLV: key, length, value), for MPEG-TS and RTP. The key is a universal label of 16
/// bytes: klv_label, the line's number, and the number of pieces still to come; both are 0 if the line is a single
/// packet. The value is the line without its newline, or one of its text_pieces(). docs/metadata.md is the reference
/// for other programs.
///
/// The ninth byte is class 15, for experiments, whose labels are not registered.
inline constexpr std::string_view klv_label{
    "\x06\x0e\x2b\x34\x01\x01\x01\x01\x0f"
    "csdtr",
    14};

/// The maximum text in a packet. A PES packet of MPEG-TS has a 16-bit length. Seen with mpegtsmux 1.22: a KLV packet of
/// more than 65527 bytes gets no length, and comes out only when the next one starts; one of more than 65532 is
/// dropped.
inline constexpr std::size_t max_klv_text = 65000;

/// The packet of piece `number` (from 0) of a line's `count` pieces. `line` distinguishes neighbouring lines.
std::string klv_packet(std::string_view piece, std::uint64_t line, std::size_t number, std::size_t count);

/// Splits bytes into the values of our packets, whatever the chunks. Skips everything between them: packets with other
/// labels, and the headers of metadata access units (ISO/IEC 13818-1). Lines have no control characters, so the start
/// of a label within a value means that this packet is torn and another begins. Holds one unfinished packet.
class KlvSplitter {
 public:
  /// Appends `bytes`. Calls `take(value, follows)` for each packet that they complete, where `follows` means that it
  /// continues the previous packet's line with nothing missing in between; and `tear()` for each torn packet.
  template <class Take, class Tear>
  void add(std::string_view bytes, Take take, Tear tear) {
    bytes_ += bytes;
    for (Found found; (found = next()) != Found::nothing;) {
      if (found == Found::torn) {
        tear();
        continue;
      }
      const bool follows = line_ == last_line_ && rest_ == (last_rest_ + 127) % 128;
      last_line_ = line_;
      last_rest_ = rest_;
      take(std::string_view(bytes_).substr(value_, used_ - value_), follows);
    }
    bytes_.erase(0, used_);
    checked_ -= std::min(checked_, used_);
    used_ = 0;
  }
  void clear() { *this = {}; }
  /// Whether a packet has begun.
  bool unfinished() const { return inside_; }

 private:
  enum class Found { nothing, packet, torn };

  Found next();
  Found leave(std::size_t to, Found found) {
    inside_ = false;
    used_ = checked_ = to;
    return found;
  }

  std::string bytes_;
  std::size_t used_ = 0;     ///< in bytes_
  std::size_t checked_ = 0;  ///< no other label starts between used_ and here
  bool inside_ = false;      ///< a packet starts at used_
  // The last packet found, and the one before it.
  std::size_t value_ = 0;
  unsigned line_ = 0, rest_ = 0, last_line_ = 0, last_rest_ = 0;
};

}  // namespace csd
