// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "caps/frame_time.h"
#include "record/timed_line.h"

namespace csd {

/// Decides which line of a stream is that of a frame: the nearest within half a frame, the earlier of two equally near;
/// within a frame's clipped part, the last.
/// Lines and frames come in ascending order of time. A plain value without locking.
///
/// Running time goes back only with a flush. Some sources break this: they start both streams again at 0 without one,
/// in either order. Then times alone would put one recording's tracks on another's frames. So each side counts its
/// laps: the times it went back at a new segment. Only a line and a frame of one lap can match. As the sides need not
/// go back alike (one may be sparse, or the parts overlap), a side that has begun anew since the last match is in the
/// other's lap.
class LineMatcher {
 public:
  // Lines.

  void add(TimedLine line);
  /// No line with a running time from `from` to `until` comes, nor one before.
  void no_line(std::int64_t from, std::int64_t until);
  /// A new segment, without a flush: what comes first in it may be of the next lap.
  void lines_begin();
  /// What comes next has nothing to do with the lines before (a flush, a new link, a source that ended and goes on):
  /// it belongs to the frames as they are now. `keep`: the lines that are here stay, up to the first one that comes.
  void lines_begin_anew(bool keep);

  // Frames.

  void frames_begin();
  void frames_begin_anew();
  /// The next frame, which is then the current one. May be called again for the same frame.
  void frame(const FrameMoments &times);

  // The current frame.

  /// Whether no future line can be its line, or be nearer than those that are here.
  bool decided() const;
  /// Its line, as far as known. Each line is returned once.
  std::optional<TrackLine> take();
  /// Whether the lines have gone back, and the frames have not yet.
  bool lines_ahead() const { return lines_.lap > frames_.lap; }

 private:
  struct Entry {
    TimedLine line;
    unsigned lap;
  };
  struct Side {
    unsigned lap = 0;
    bool any = false;        ///< something has come since the side began anew
    bool first = false;      ///< what comes next is the first of a segment
    bool restarted = false;  ///< has begun a segment since the last match

    void begin() {
      first = any;
      restarted = true;
    }
    void begin_anew(unsigned in_lap) { *this = {in_lap, false, false, true}; }
    void arrive(bool back, Side &other);
  };

  const std::optional<FrameMoment> &moment(TimeBase base) const {
    return base == TimeBase::running ? now_.running : now_.stream;
  }
  std::optional<std::int64_t> &known(TimeBase base) {
    return base == TimeBase::running ? known_running_ : known_stream_;
  }
  bool is_before_frame(TimeBase base, std::int64_t time) const;
  std::optional<std::size_t> nearest(std::int64_t &distance) const;

  std::deque<Entry> entries_;
  Side lines_, frames_;
  bool replaces_ = false;                                     ///< the next line replaces those from its time on
  TimeBase base_ = TimeBase::running;                         ///< of the last line
  FrameMoments now_;                                          ///< the current frame; nothing before the first
  std::optional<std::int64_t> known_running_, known_stream_;  ///< no line will come before, in the lap of lines_
};

}  // namespace csd
