// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "base/random.h"
#include "csd2012/choices.h"
#include "csd2012/learn/colour_choice.h"
#include "csd2012/learn/forest.h"
#include "csd2012/learn/growing_tree.h"
#include "csd2012/learn/negatives.h"
#include "csd2012/learn/smoke.h"
#include "csd2012/learn/tree.h"
#include "csd2012/snapshot.h"
#include "image/warps.h"

namespace csd {

/// Counters shared by the learners of one tracker; read by Stats.
struct LearningCounters {
  std::atomic<std::uint64_t> retrainings = 0, false_correspondences = 0;
};

/// Samples of one frame that update the descriptor in use (§2.1.5). CV_8UC1 in the descriptor's colour space,
/// unsmoothed.
struct DescriptorUpdate {
  cv::Mat feature;                 ///< side FeatureLearner::surroundings(); empty if the feature was not found
  std::vector<cv::Mat> negatives;  ///< side FeatureLearner::grown(): random ones and false correspondences
};

struct LearnerOptions {
  int patch = 21;          ///< odd side, working pixels
  int search_radius = 20;  ///< working pixels
  double pixel = 1;        ///< of a 480-line picture, in working pixels: scales the distances of the choices
  csd2012::Choices choices;
};

/// Learns the context specific descriptor of one feature (§2.2): grows the training set and the tree and publishes
/// copies of the tree. One job at a time; only published() may run concurrently.
class FeatureLearner {
 public:
  FeatureLearner(const LearnerOptions &options, Random random, std::shared_ptr<LearningCounters> counters);

  /// One frame of the recursive start, with the feature at `position`, a pixel of the picture. Adds positives, warps,
  /// negatives and smoke (§2.1.2), then retrains the leaves that err on this frame until the feature is classified
  /// correctly (§2.2.2). If the patch reaches over the edge, the border is replicated, and there are no similar
  /// negatives, because the correlation has no such border.
  void learn(const Snapshot &snapshot, cv::Point position);
  /// One frame of tracking (§2.1.5).
  void update(const DescriptorUpdate &update);

  int grown() const { return options_.patch + 2 * margin_; }  ///< side of a patch before smoothing
  /// Side of the area that the warps of a patch need: rotated by 45° and shrunk it shows that much.
  int surroundings() const { return grown() + 2 * (grown() / 4 + 2); }

  /// The current descriptor; null before the first learn() is done. Any thread.
  std::shared_ptr<const Forest> published() const;

 private:
  /// A tree, and the slots of the samples that update() added.
  struct Member {
    GrowingTree tree;
    std::vector<SampleId> recent = {}, reservoir = {};  // positives, negatives
    std::size_t next_recent = 0, negatives_seen = 0;
  };
  using Samples = std::vector<std::pair<cv::Mat, Label>>;  // of one frame, as the tests compare them

  ColourPatches collect(const Snapshot &snapshot, cv::Point position);
  void plant(const ColourSpace &space);
  void learn(Member &member, const Samples &samples, const cv::Mat &picture, const cv::Mat &forbidden,
             cv::Point position, bool first);
  void correct(Member &member, const cv::Mat &picture, const cv::Mat &forbidden, cv::Point position,
               const std::vector<SampleId> &positives);
  void update(Member &member, const Samples &samples);
  bool takes_part();
  ColourSpace choose_space(const Snapshot &snapshot, cv::Point position, ColourPatches root);
  cv::Mat place(const cv::Mat &stack, std::size_t i) const;
  std::vector<cv::Mat> smoothed(const cv::Mat &stack) const;
  Samples smoothed(const cv::Mat &stack, const std::vector<Label> &labels) const;
  int retrain(GrowingTree &tree, const std::vector<SampleId> &samples);
  SampleId keep_positive(Member &member, const cv::Mat &patch);
  std::optional<SampleId> keep_negative(Member &member, const cv::Mat &patch, bool error);
  void publish();
  NegativeRules rules() const;

  LearnerOptions options_;
  int margin_;  ///< pixels, radius of the smoothing
  Random random_;
  std::optional<Smoke> smoke_;  // created with the first training frame
  std::vector<Warp> warps_;
  std::shared_ptr<LearningCounters> counters_;
  std::vector<Member> members_;

  mutable std::mutex mutex_;
  std::shared_ptr<const Forest> published_;  // guarded by mutex_
};

}  // namespace csd
