// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "programs/video_frames.h"

/// Current trackers for comparison; not part of the plugin (docs/baselines.md has their settings).
namespace csd::peers {

/// A tracker's result for one point in one frame.
struct Report {
  cv::Point2d position;  ///< pixels, centres at integers; if not seen, the last one or a guess
  bool seen = false;
};

/// A point tracker.
class Peer {
 public:
  virtual ~Peer() = default;

  /// Starts with points in this picture. Called once, first.
  virtual void start(const programs::Picture &picture, const std::vector<cv::Point2d> &points) = 0;
  /// Tracks into the next picture, of the same size: one report for each point, in the same order.
  virtual std::vector<Report> follow(const programs::Picture &picture) = 0;
};

struct PeerKind {
  std::string_view name;
  std::string_view about;
  std::unique_ptr<Peer> (*make)();
};

std::span<const PeerKind> peer_kinds();
/// Null for an unknown name.
const PeerKind *find_peer(std::string_view name);

/// Lengths are for pictures of up to 576 lines; they scale with the lines of larger ones.
double picture_scale(const cv::Mat &picture);
/// The odd number of pixels nearest to `length` at that scale.
int odd_length(double length, const cv::Mat &picture);

// boxes.cpp: a box around each point, followed by OpenCV's tracking module.
std::unique_ptr<Peer> make_csrt();
std::unique_ptr<Peer> make_kcf();
std::unique_ptr<Peer> make_median_flow();
// flow.cpp: pyramidal Lucas–Kanade, OpenCV's.
std::unique_ptr<Peer> make_flow_checked();
std::unique_ptr<Peer> make_flow_anchored();
// peer.cpp
std::unique_ptr<Peer> make_still();

}  // namespace csd::peers
