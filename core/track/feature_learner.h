// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "image/warps.h"
#include "learn/colour_choice.h"
#include "learn/growing_tree.h"
#include "learn/negatives.h"
#include "learn/random.h"
#include "learn/smoke.h"
#include "learn/tree.h"
#include "track/csd2012_choices.h"

namespace csd {

/// What learners of one tracker count; read by Stats.
struct LearningCounters {
  std::atomic<std::uint64_t> retrainings = 0, false_correspondences = 0;
};

/// A frame that learners look at after its buffer is gone.
struct Snapshot {
  cv::Mat bgr;        ///< CV_8UC3, working size
  cv::Mat luma;       ///< CV_8UC1
  cv::Mat forbidden;  ///< CV_8UC1 or empty: nothing is learnt there
};

/// Patches of one frame that the descriptor in use is updated with (§2.1.5), cut out while the frame was there.
struct DescriptorUpdate {
  std::vector<cv::Mat> positives;  ///< the patch at the tracked position; none if the feature was not found
  std::vector<cv::Mat> negatives;  ///< random ones and false correspondences; CV_8UC1 in the descriptor's colour space
};

struct LearnerOptions {
  int patch = 21;                              ///< odd side, working pixels
  int search_radius = csd2012::search_radius;  ///< working pixels
  double pixel = 1;  ///< of a 480-line picture, in working pixels: scales the distances of csd2012_choices.h
  SmokeEquation smoke = SmokeEquation::as_meant;
  PairSearch pair_search = PairSearch::ranked;
};

/// Learns the context specific descriptor of one feature (§2.2): grows the training set and the tree and publishes
/// copies of it. One job at a time; only published() may be called meanwhile.
class FeatureLearner {
 public:
  FeatureLearner(const LearnerOptions &options, Random random, std::shared_ptr<LearningCounters> counters);

  /// One frame of the recursive start, in which the feature is at `position`, a pixel of the picture: adds positives,
  /// warps, negatives and smoke (§2.1.2), then retrains the leaves that err on this frame until the feature is
  /// classified correctly (§2.2.2). Where its patch reaches over the edge, the border is replicated, and there are no
  /// similar negatives, for the correlation has no such border.
  void learn(const Snapshot &snapshot, cv::Point position);
  /// One frame of tracking (§2.1.5).
  void update(const DescriptorUpdate &update);

  /// The descriptor of now; null before the first learn() is done. Any thread.
  std::shared_ptr<const Tree> published() const;

 private:
  ColourPatches collect(const Snapshot &snapshot, cv::Point position);
  void correct(const Snapshot &snapshot, const cv::Mat &channel, cv::Point position,
               const std::vector<SampleId> &positives);
  int retrain(const std::vector<SampleId> &samples);
  void publish();
  NegativeRules rules() const;

  LearnerOptions options_;
  Random random_;
  std::optional<Smoke> smoke_;  // made with the first lesson
  std::vector<Warp> warps_;
  std::shared_ptr<LearningCounters> counters_;
  std::optional<GrowingTree> tree_;
  std::vector<SampleId> recent_, reservoir_;  // slots of the positives and negatives that came by update()
  std::size_t next_recent_ = 0, negatives_seen_ = 0;

  mutable std::mutex mutex_;
  std::shared_ptr<const Tree> published_;  // guarded by mutex_
};

}  // namespace csd
