// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <memory>
#include <vector>

#include "csd2012/aligned_patch.h"
#include "csd2012/feature_learner.h"
#include "csd2012/learning_queue.h"
#include "csd2012/search.h"
#include "track/algorithm.h"
#include "track/recursive.h"

namespace csd {

/// The tracker of Mountney & Yang (2012). LK tracks for the first half second while a descriptor is learned from its
/// positions. Then the descriptor alone finds the feature in each frame and keeps learning (§2.1). docs/method.md maps
/// the paper's equations to the code. With forest_choices() it includes the paper's future work (§5).
class Csd2012 final : public Algorithm {
 public:
  Csd2012(const Settings &settings, Executor &executor, const csd2012::Choices &choices = {});
  ~Csd2012() override;

  void track(const FrameContext &context, std::vector<Claim> &claims) override;
  Claim::Kind begin(FeatureId id, cv::Point2d position, const FrameContext &context) override;
  void end(FeatureId id) override;
  void finish(const FrameContext &context) override;
  void forget() override;
  void add_to(Stats &stats) const override;

 private:
  struct Follower;

  void recurse(const FrameContext &context);
  void look(const FrameContext &context, Follower &follower);
  void confirm(const FrameContext &context, Follower &follower, SearchResult &result) const;
  AlignedPatch::Fit fit(const FrameContext &context, const Follower &follower, cv::Point2d position) const;
  void prepare_update(const FrameContext &context, Follower &follower, const ColourSpace &space,
                      const SearchResult &result);
  Follower *find(FeatureId id);

  Settings settings_;
  csd2012::Choices choices_;
  RecursiveTracker recursive_;
  std::shared_ptr<LearningCounters> counters_;
  std::atomic<std::uint64_t> learned_ = 0;
  LearningQueue queue_;                               // before the followers, whose lanes must be destroyed first
  std::vector<std::unique_ptr<Follower>> followers_;  // by ascending id
  std::int64_t last_time_ = 0;                        // of the last frame
  // Scratch: the search window before and after smoothing; raw_ shows the frame's gathered_.
  cv::Mat raw_, channel_;
  cv::Rect gathered_;
  // With co-training: the frame that patches are aligned with.
  Pyramid pyramid_;
  GlareWeights weights_;
};

}  // namespace csd
