// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "image/frame_view.h"

namespace csd {

/// Finds the part of 16 bit that a camera uses: a picture of 12 bit, or of 200 grey levels, would be flat in its upper
/// 8 bits.
///
/// The picture's range excludes the darkest and the brightest 0.5 % of the pixels, on a grid of at most 16384; pixels
/// of 0 are ignored if there are others (a mask around the picture). The range, with a margin of a twelfth on either
/// side, maps to 0…255, but one level of the camera (which may be 16 of the 65536) never maps to more than one.
///
/// A window stays exactly as it is while both ends of the range are within a sixteenth of its width of where they were.
/// Otherwise it follows with a time constant of 0.3 s until they are within a sixty-fourth, then stays again. The range
/// that counts is the common one of all pictures of the last 0.3 s to 0.4 s, so a transient glint moves nothing. It
/// restarts if it shows too little: half of the pixels lie on one side of it, or all of them in a quarter of it.
class GrayWindow {
 public:
  /// The view for reading the next frame; unchanged if it is not `open_range`. `time` in ns, not negative and not
  /// before the last one's. A change of size restarts it.
  FrameView look(const FrameView &view, std::int64_t time);

  /// Forgets the stream.
  void reset() { *this = GrayWindow(); }

  double black() const { return black_; }  ///< maps to 0
  double white() const { return white_; }  ///< maps to 256

 private:
  struct Range {
    double low = 0, high = 65535;
    Range operator&(const Range &other) const { return {std::max(low, other.low), std::min(high, other.high)}; }
  };
  struct Seen {
    Range range;
    double median = 0;
  };
  Seen measure(const FrameView &view);
  Range lasting(const Range &seen, std::int64_t time);
  void follow(const Seen &seen, std::int64_t time);
  void fit();

  bool known_ = false, moving_ = false;
  int width_ = 0, rows_ = 0;
  std::int64_t time_ = 0;
  std::array<Range, 4> recent_;  ///< of 0.1 s each, indexed modulo 4
  Range range_;                  ///< of the current window
  double black_ = 0, white_ = 65536;
  int step_ = 256;                            ///< of the camera: the largest power of two that divides all levels
  std::vector<std::uint16_t> coarse_, fine_;  ///< histograms of the upper 8 bits and of all 16; 0 between frames
};

}  // namespace csd
