// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <iosfwd>
#include <memory>
#include <string>

#include "programs/video_frames.h"

namespace csd::peers {

using programs::Picture;

/// A sequence of pictures of one size.
class VideoSource {
 public:
  virtual ~VideoSource() = default;
  /// Returns false at the end. Throws std::runtime_error if the video is truncated or damaged.
  virtual bool next(Picture &picture) = 0;
  /// Reads the rest, so that the writer at the other end of a pipe isn't stopped.
  virtual void drain() {}
};

/// 8-bit YUV4MPEG2: C420…, C422, C444, C411, Cmono. BT.601 up to 576 lines, else BT.709, like GStreamer. Throws
/// std::runtime_error if `in`, which must outlive the source, has other contents. Not GStreamer's y4mdec, which
/// silently drops a truncated last frame and can't read Cmono (1.22).
std::unique_ptr<VideoSource> read_y4m(std::istream &in);

/// A video file, read by VideoFrames; "-" is Y4M on standard input. Throws std::runtime_error.
std::unique_ptr<VideoSource> open_video(const std::string &name);

}  // namespace csd::peers
