// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "image/frame_view.h"

namespace csd {

/// Which part of 16 bit a camera uses: a picture of 12 bit, or of 200 grey levels, would be flat in its upper 8.
///
/// The picture's range is that of all pixels but the darkest and the brightest 0.5 %, on a grid of at most 16384;
/// pixels of 0 don't count where there are others (a mask around the picture). With a twelfth of it on either side it
/// becomes 0…255, but a level of the camera's own (which may be 16 of the 65536) never becomes more than one.
///
/// A window stays as it is, exactly, while both ends of the range are where it was made for, within a sixteenth of its
/// width. Else it follows with a time constant of 0.3 s until they are within a sixty-fourth, and stays again. What
/// counts is the range of all pictures of the last 0.3 s to 0.4 s in common: a glint that comes and goes moves nothing.
/// It begins anew where it shows too little: half of the pixels lie on one side of it, or all of them in a quarter of
/// it.
class GrayWindow {
 public:
  /// The view of the next frame as it is to be read; what isn't `open_range` is given back as it came. `time` in ns,
  /// not negative and not before the last one's. A change of size begins anew.
  FrameView look(const FrameView &view, std::int64_t time);

  /// Forgets the stream.
  void reset() { *this = GrayWindow(); }

  double black() const { return black_; }  ///< becomes 0
  double white() const { return white_; }  ///< becomes 256

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
  std::array<Range, 4> recent_;  ///< of 0.1 s each, by its number modulo 4
  Range range_;                  ///< that the window is made for
  double black_ = 0, white_ = 65536;
  int step_ = 256;  ///< of the camera: the largest power of two that all levels are multiples of
  std::vector<std::uint16_t> coarse_, fine_;  ///< histograms, of the upper 8 bits and of all; 0 between the frames
};

}  // namespace csd
