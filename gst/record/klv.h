// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace csd {

/// Lines in packets of SMPTE 336 (KLV: key, length, value), for MPEG-TS and RTP. The key is a universal label of 16
/// bytes: klv_label, the line's number, and how many pieces of it are still to come; both are 0 where the line is one
/// packet. The value is the line without its newline, or one of its text_pieces(). docs/metadata.md tells it others.
///
/// The ninth byte is class 15, for experiments, whose labels nobody registers.
inline constexpr std::string_view klv_label{
    "\x06\x0e\x2b\x34\x01\x01\x01\x01\x0f"
    "csdtr",
    14};

/// What a packet holds of a line at most. A PES packet of MPEG-TS says its length in 16 bits. Seen with mpegtsmux 1.22:
/// a KLV packet of more than 65527 bytes has none, and comes out only when the next one begins; one of more than 65532
/// is dropped.
inline constexpr std::size_t max_klv_text = 65000;

/// The packet of the piece `number` (from 0) of the `count` pieces of a line. `line` tells neighbouring lines apart.
std::string klv_packet(std::string_view piece, std::uint64_t line, std::size_t number, std::size_t count);

/// Bytes into the values of our packets, however they are cut. All else between these is passed over: packets of other
/// labels, and the headers of metadata access units (ISO/IEC 13818-1). No line has control characters: what a label
/// begins with, inside of a value, says that its packet is torn and another begins. Holds one unfinished packet.
class KlvSplitter {
 public:
  /// Appends `bytes`. Calls `take(value, follows)` for each packet that they end, where `follows` says that it goes on
  /// with the line of the one before it and nothing is missing between them; and `tear()` for each that is torn.
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
  std::size_t used_ = 0;     ///< of bytes_
  std::size_t checked_ = 0;  ///< from used_ on: no other label begins before it
  bool inside_ = false;      ///< a packet begins at used_
  // Of the packet that was found last, and the one before it.
  std::size_t value_ = 0;
  unsigned line_ = 0, rest_ = 0, last_line_ = 0, last_rest_ = 0;
};

}  // namespace csd
