// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <list>
#include <mutex>

#include "image/colour_space.h"

namespace csd {

/// A frame that learners use after its buffer is gone. Shared by all features of a tracker.
struct Snapshot {
  cv::Mat bgr;        ///< CV_8UC3, working size
  cv::Mat luma;       ///< CV_8UC1
  cv::Mat forbidden;  ///< CV_8UC1 or empty: no learning there

  /// `bgr` in a colour space, CV_8UC1.
  struct Channel {
    cv::Mat raw;
    cv::Mat smoothed;  ///< with a margin of `half` on each side, where the border is replicated
  };
  /// Computed when the first learner asks for it, for all: most learn in the same space. σ in pixels; σ and `half` are
  /// the same in each call. Any thread.
  const Channel &in(const ColourSpace &space, double sigma, int half) const;

 private:
  struct Made {
    explicit Made(const ColourSpace &of) : space(of) {}
    ColourSpace space;
    std::mutex making;  // not std::call_once: exceptions must not pass it (image/work_frame.h)
    Channel channel;
  };
  mutable std::mutex mutex_;
  mutable std::list<Made> made_;  // guarded by mutex_; each channel by its own lock
};

}  // namespace csd
