// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/features2d.hpp>

#include <cstdint>
#include <optional>
#include <vector>

#include "csd/similarity.h"
#include "csd/tracked_point.h"

namespace csd {

/// The similarity with the most inliers within `tolerance` (in units of `to`): tries all pairs of the first 60 matches,
/// then refines by three rounds of least squares over the inliers. Empty if there are fewer than `least` inliers or it
/// zooms more than `max_zoom`-fold either way.
std::optional<Similarity> agree_on_similarity(const std::vector<Correspondence> &matches, double tolerance,
                                              std::size_t least, double max_zoom);

/// A black picture or a covered lens: there is nothing to find.
bool blank(const CsdFrame &frame);

/// Finds tissue again after black, a cut, a wipe or a long absence, when the motion of the view is unknown. For each
/// chart it keeps the last frame in which most points were visible, and matches that frame's SIFT keypoints (Lowe 2004)
/// with the current ones. Their common similarity predicts the chart's points to within some pixels, because tissue
/// also deforms; the caller verifies them by alignment.
class Recall {
 public:
  /// Stores the points of `field` (those of `chart`) with this frame, if there are about as many as usual and the
  /// picture has about the usual contrast.
  void remember(const CsdFrame &frame, const NeighbourField &field, int chart);
  bool knows(int chart) const;
  void forget(int chart);
  /// Whether to search for a chart that has hardly a point in `present`: eight times a second at first, less often the
  /// longer it is gone, never while the picture is blank. If another chart is visible, only for older charts and only
  /// for ten seconds: after that it is a different scene for good. `share`, 0…1: of the points that were aligned in
  /// this frame; the others are no evidence.
  bool due(const CsdFrame &frame, const NeighbourField &present, double share);
  /// Finds a stored chart that has hardly a point in `present` and that this frame shows. Puts its points into `found`.
  /// Takes about 20 ms. Returns the chart, or −1.
  int find(const CsdFrame &frame, const NeighbourField &present, double share, NeighbourField &found);

 private:
  struct Scene {
    int chart;
    NeighbourField field;
    cv::Mat picture, mask;  ///< level 1, CV_16UC1 and CV_8UC1
    std::int64_t time = 0;
    double usual = 0;  ///< number of points times the picture's contrast
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;  ///< of keypoints, computed on demand
    bool described = false;
  };
  /// What is visible of the scenes: the points of `field`, out of the aligned `share` of all. Up to `handful` of a
  /// scene's points do not count.
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
  std::int64_t last_try_ = 0, last_nothing_ = 0;  ///< last_nothing_: when no chart was visible
};

}  // namespace csd
