// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <iosfwd>
#include <memory>
#include <string>

#include "programs/video_frames.h"

namespace csd::peers {

using programs::Picture;

/// Pictures one after the other, all of one size.
class VideoSource {
 public:
  virtual ~VideoSource() = default;
  /// False at the end. Throws std::runtime_error where the video is broken off or damaged.
  virtual bool next(Picture &picture) = 0;
  /// Reads what is left, so that who writes into our end of the pipe need not stop.
  virtual void drain() {}
};

/// YUV4MPEG2 of 8 bit: C420…, C422, C444, C411, Cmono. BT.601 up to 576 lines, else BT.709, as GStreamer takes them.
/// Throws std::runtime_error if `in`, which must outlive the source, holds something else. Not GStreamer's y4mdec,
/// which takes a stream that breaks off within a frame for one that ends before it, and can't read Cmono (1.22).
std::unique_ptr<VideoSource> read_y4m(std::istream &in);

/// A video file, by VideoFrames; "-" is Y4M on standard input. Throws std::runtime_error.
std::unique_ptr<VideoSource> open_video(const std::string &name);

}  // namespace csd::peers
