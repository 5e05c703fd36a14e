// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>

#include "frame_limit.h"
#include "record/track_file.h"

namespace csd {

/// Lines between the thread that brings them and the thread of the video, which takes for each frame its own. Bounded:
/// who brings waits while it is full. It is never full for ever: a frame that waits drops all that is too old for it.
///
/// Times are of the stream, ascending within a pass; a pass ends where time goes back without a flush (a segment loop).
/// All functions may be called in any thread.
class TrackQueue {
 public:
  static constexpr std::size_t max_lines = 256;         ///< 10 s at 25 frames a second
  static constexpr std::size_t max_features = 1 << 18;  ///< of all lines together; one line may have more

  enum class Outcome {
    known,    ///< the frame's line, or that there is none, is known
    late,     ///< nothing came in time: what is there was looked through
    again,    ///< by rethink(): the limit may be another one
    flushing  ///< the frame need not go on
  };
  struct Match {
    Outcome outcome;
    std::optional<TimedLine> line;
  };

  // The side that brings.

  /// Waits while the queue is full. False: flushing, or nobody will ask for it.
  bool push(TimedLine line);
  /// There will be no line before `time`.
  void gap(std::int64_t time);
  void end();
  /// Another stream of lines begins, of the group-id `group` (0: of none). Where the frames go over to that group, too,
  /// sooner or later, its lines are for them, as after segment(). Else it is the lines alone that begin anew (they were
  /// linked or connected again): they may be of any time, and replace what waits from the first one's time on.
  void lines_begin(unsigned group);
  /// A new segment: the next lines may go back in time.
  void segment();
  /// A flush of what brings begins (nothing waits or is taken any more), or ends (all is forgotten).
  void flush_lines(bool begin);

  // The side that asks.

  /// The line of the frame at `time`, no further than `reach` away. Waits until it is known, but no longer than the
  /// limit, which was reckoned after thoughts() said `thought`. While it is `late` it doesn't wait at all where there
  /// is no clock, until a line of a later frame's time is there again: each of many would wait in vain. By a clock none
  /// of them goes on later than the first.
  Match match(std::int64_t time, std::int64_t reach, const FrameLimit &limit, unsigned thought);
  /// Nothing will be asked for before `time`.
  void skip(std::int64_t time);
  /// Another stream of frames begins, of that group-id.
  void frames_begin(unsigned group);
  /// A new segment: the next frames may go back in time.
  void frames_segment();
  void frames_end();
  void flush_frames(bool begin);

  // Both.

  /// Limits are to be reckoned anew.
  void rethink();
  unsigned thoughts();
  /// Without a link nothing will come: no frame waits. What comes with another link begins anew, as in lines_begin().
  void set_linked(bool linked);
  bool linked();
  /// Stopped: nobody waits. Started: all is as new.
  void start();
  void stop();
  bool running();

 private:
  struct Entry {
    TimedLine line;
    unsigned pass;
  };
  /// What one side knows of where it is.
  struct Side {
    unsigned pass = 0;
    std::optional<std::int64_t> last;  ///< the time of its last line or frame in this pass
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
  // All guarded by mutex_.
  GstClockID alarm_ = nullptr;  ///< of the frame that waits by a clock
  unsigned thoughts_ = 0;
  std::deque<Entry> entries_;
  std::size_t features_ = 0;  ///< of entries_
  Side lines_, frames_;
  unsigned lines_group_ = 0, frames_group_ = 0;
  std::int64_t known_until_ = no_time;  ///< by gaps, in the pass of lines_
  bool linked_ = false, running_ = false;
  bool late_ = false;  ///< a frame has waited in vain, and nothing has caught up since
};

}  // namespace csd
