// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <memory>
#include <string>

namespace csd::programs {

/// A frame of a video.
struct Picture {
  cv::Mat bgr;  ///< CV_8UC3
  /// GStreamer's times in ns; −1: unknown. With B-frames, pts may start late; the other two don't.
  std::int64_t pts = -1, duration = -1, running_time = -1, stream_time = -1;
};

/// Frames of a video file, decoded by GStreamer's decodebin, so that they have the same numbers as in csdtrack.
class VideoFrames {
 public:
  /// Throws std::runtime_error if the file can't be opened or has no video.
  explicit VideoFrames(std::string file);
  ~VideoFrames();

  /// A frame by its number; `bgr` is empty past the end. Going back decodes from the start. Throws std::runtime_error
  /// if the stream is damaged.
  Picture at(std::uint64_t number);

 private:
  struct Pipeline;
  void open();
  std::string file_;
  std::unique_ptr<Pipeline> pipeline_;
  std::uint64_t next_ = 0;  ///< number of the pipeline's next frame
  Picture current_;         ///< the one before
};

}  // namespace csd::programs
