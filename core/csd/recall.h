// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/features2d.hpp>

#include <cstdint>
#include <optional>
#include <vector>

#include "csd/tracked_point.h"

namespace csd {

/// A turn, a zoom and a shift: to = (a −b; b a)·from + shift.
struct Similarity {
  double a = 1, b = 0;
  cv::Point2d shift;
  cv::Point2d operator()(cv::Point2d p) const { return {a * p.x - b * p.y + shift.x, b * p.x + a * p.y + shift.y}; }
  double scale() const;
};

/// The similarity that most of the correspondences agree with to `tolerance` (in units of `to`), by trying all pairs of
/// the first 60, then by least squares over those that agree, three rounds. Nothing if fewer than `least` agree, or
/// where it zooms more than `max_zoom`-fold either way.
std::optional<Similarity> agree_on_similarity(const std::vector<Correspondence> &matches, double tolerance,
                                              std::size_t least, double max_zoom);

/// Black, or a covered lens: nothing to look for.
bool blank(const CsdFrame &frame);

/// Finds tissue again after black, a cut, a wipe or a long absence, when nothing is known of where the view has gone:
/// the last frame of each chart in which most points were seen is kept, and its SIFT keypoints (Lowe 2004) are matched
/// with the present frame's. Their common similarity says where the chart's points are, to some pixels, as tissue also
/// deforms; the caller looks whether they are there.
class Recall {
 public:
  /// The points of `field` (of `chart` alone) as this frame shows them. Kept if they are about as many as usual,
  /// and the picture is as rich in contrast.
  void remember(const CsdFrame &frame, const NeighbourField &field, int chart);
  bool knows(int chart) const;
  void forget(int chart);
  /// Is it time to look for a chart that `present` has hardly a point of? Eight times a second at first, more rarely
  /// the longer it has been gone, and not while the picture is blank. Where something is seen, only for what was seen
  /// before that, and only for ten seconds: then it is another scene for good. `share`, 0…1: of the points, that were
  /// looked at in this frame; the others are no evidence.
  bool due(const CsdFrame &frame, const NeighbourField &present, double share);
  /// A chart that was remembered, that `present` has hardly a point of, and that this frame shows: its points go to
  /// `found`. Takes some 20 ms. Returns the chart, or −1.
  int find(const CsdFrame &frame, const NeighbourField &present, double share, NeighbourField &found);

 private:
  struct Scene {
    int chart;
    NeighbourField field;
    cv::Mat picture, mask;  ///< level 1, CV_16UC1 and CV_8UC1
    std::int64_t time = 0;
    double usual = 0;  ///< number of points times the picture's contrast
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;  ///< of keypoints, once they were needed
    bool described = false;
  };
  /// What is seen of the scenes: the points of `field`, of `share` of all, of which a handful is none.
  struct Present {
    const NeighbourField &field;
    double share, handful;
  };
  static bool seen(const Scene &scene, const Present &present);
  bool nothing(const Present &present) const;
  bool wanted(const Scene &scene, const Present &present) const;
  void describe(const cv::Mat &level, const cv::Mat &mask, const Tuning &tuning, std::vector<cv::KeyPoint> &keypoints,
                cv::Mat &descriptors);

  cv::Ptr<cv::SIFT> sift_;
  std::vector<Scene> scenes_;                     ///< by ascending chart
  std::int64_t last_try_ = 0, last_nothing_ = 0;  ///< last_nothing_: when nothing was seen of any chart
};

}  // namespace csd
