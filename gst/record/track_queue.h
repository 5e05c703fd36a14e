// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>

#include "record/frame_limit.h"
#include "record/track_file.h"

namespace csd {

/// Passes lines from the thread that brings them to the video's thread, which takes one for each frame. Bounded: the
/// writer blocks while it is full. It can't stay full, because a waiting frame drops all lines that are too old for it.
///
/// Times are stream times, ascending within a pass; a pass ends when time goes back without a flush (a segment loop).
/// All functions are thread-safe.
class TrackQueue {
 public:
  static constexpr std::size_t max_lines = 256;         ///< 10 s at 25 frames a second
  static constexpr std::size_t max_features = 1 << 18;  ///< of all lines together; a single line may have more

  enum class Outcome {
    known,    ///< the frame's line, or its absence, is known
    late,     ///< nothing came in time: the result is from the lines so far
    again,    ///< rethink() was called: the limit may have changed
    flushing  ///< the frame may be dropped
  };
  struct Match {
    Outcome outcome;
    std::optional<TimedLine> line;
  };

  // The writing side.

  /// Waits while the queue is full. Returns false if it is flushing, or if no frame will need the line.
  bool push(TimedLine line);
  /// No line will come before `time`.
  void gap(std::int64_t time);
  void end();
  /// Starts another stream of lines with the group-id `group` (0: none). If the frames switch to that group too, sooner
  /// or later, its lines belong to them, as after segment(). Otherwise only the lines restart (they were relinked or
  /// reconnected): they may have any time, and replace the queued lines from the first one's time on.
  void lines_begin(unsigned group);
  /// A new segment: the next lines may go back in time.
  void segment();
  /// Starts a flush of the lines (nothing waits or is accepted any more), or ends it (the queue is empty).
  void flush_lines(bool begin);

  // The reading side.

  /// The line of the frame at `time`, at most `reach` away. Waits until it is known, or until the limit, which must
  /// have been computed after thoughts() returned `thought`. After `late` it doesn't wait without a clock until a line
  /// catches up with the frames, or each frame would wait in vain. With a clock no frame leaves later than the first.
  Match match(std::int64_t time, std::int64_t reach, const FrameLimit &limit, unsigned thought);
  /// No frame will come before `time`.
  void skip(std::int64_t time);
  /// Starts another stream of frames with that group-id.
  void frames_begin(unsigned group);
  /// A new segment: the next frames may go back in time.
  void frames_segment();
  void frames_end();
  void flush_frames(bool begin);

  // Both sides.

  /// Makes waiting frames recompute their limits.
  void rethink();
  unsigned thoughts();
  /// Without a link nothing will come: no frame waits. Lines of a new link restart, as in lines_begin().
  void set_linked(bool linked);
  bool linked();
  /// Stopped: nothing waits. Started: everything is reset.
  void start();
  void stop();
  bool running();

 private:
  struct Entry {
    TimedLine line;
    unsigned pass;
  };
  /// The position of one side.
  struct Side {
    unsigned pass = 0;
    std::optional<std::int64_t> last;  ///< time of its last line or frame in this pass
    bool new_segment = false, ended = false, flushing = false;
    void at(std::int64_t time) {
      if (new_segment && last && time < *last) ++pass;
      new_segment = false;
      last = time;
    }
  };

  void changed();
  bool wait(std::unique_lock<std::mutex> &lock, const FrameLimit &limit, const std::function<bool()> &ends);
  void pop();
  void drop_from(std::int64_t time);
  void lines_begin_alone();
  void drop_before(std::int64_t time);
  std::size_t earlier(std::int64_t time) const;
  bool is_known(std::int64_t time, std::int64_t reach) const;
  bool full(const TimedLine &line) const;

  std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by mutex_.
  GstClockID alarm_ = nullptr;  ///< of the frame that waits on a clock
  unsigned thoughts_ = 0;
  std::deque<Entry> entries_;
  std::size_t features_ = 0;  ///< in entries_
  Side lines_, frames_;
  unsigned lines_group_ = 0, frames_group_ = 0;
  std::int64_t known_until_ = no_time;  ///< from gaps, in the pass of lines_
  bool linked_ = false, running_ = false;
  bool late_ = false;  ///< a frame has waited in vain, and no line has caught up since
};

}  // namespace csd
