// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <memory>
#include <string>

namespace csd::cli {

/// Frames of a video file, decoded by GStreamer's decodebin, so that their numbers are those that csdtrack counts.
class VideoFrames {
 public:
  /// Throws std::runtime_error if the file can't be opened or has no video.
  explicit VideoFrames(std::string file);
  ~VideoFrames();

  /// A frame by its number, BGR; empty past the end. Going back decodes from the beginning. Throws std::runtime_error
  /// if the stream is damaged.
  cv::Mat at(std::uint64_t number);

 private:
  struct Pipeline;
  void open();
  std::string file_;
  std::unique_ptr<Pipeline> pipeline_;
  std::uint64_t next_ = 0;  ///< the frame that the pipeline gives next
  cv::Mat current_;         ///< the one before
};

}  // namespace csd::cli
