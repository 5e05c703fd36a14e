// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/peers/peer.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace csd::peers {

namespace {

/// The trivial baseline: the points never move.
class Still final : public Peer {
  void start(const programs::Picture &, const std::vector<cv::Point2d> &points) override {
    for (const auto &p : points) reports_.push_back({p, true});
  }
  std::vector<Report> follow(const programs::Picture &) override { return reports_; }

  std::vector<Report> reports_;
};

}  // namespace

std::unique_ptr<Peer> make_still() {
  return std::make_unique<Still>();
}

std::span<const PeerKind> peer_kinds() {
  static constexpr std::array<PeerKind, 6> kinds{{
      {"csrt", "discriminative correlation filter with channel and spatial reliability, on a box", make_csrt},
      {"kcf", "kernelized correlation filter, on a box", make_kcf},
      {"medianflow", "median flow with forward-backward errors, on a box", make_median_flow},
      {"lk-fb", "pyramidal Lucas-Kanade; dropped for ever where forward and backward disagree", make_flow_checked},
      {"lk-anchored", "pyramidal Lucas-Kanade, aligned again with the first frame's patch in each frame",
       make_flow_anchored},
      {"still", "never moves", make_still},
  }};
  return kinds;
}

const PeerKind *find_peer(std::string_view name) {
  const auto kinds = peer_kinds();
  const auto at = std::find_if(kinds.begin(), kinds.end(), [name](const PeerKind &k) { return k.name == name; });
  return at == kinds.end() ? nullptr : &*at;
}

double picture_scale(const cv::Mat &picture) {
  return std::max(1.0, picture.rows / 576.0);
}

int odd_length(double length, const cv::Mat &picture) {
  return 2 * static_cast<int>(std::lround((length * picture_scale(picture) - 1) / 2)) + 1;
}

}  // namespace csd::peers
