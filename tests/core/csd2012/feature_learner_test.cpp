// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/feature_learner.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>
#include <thread>

#include "csd2012/search.h"
#include "csd2012/smoothed.h"
#include "image/convert.h"
#include "image/patch.h"
#include "image/warps.h"
#include "track/moving_scene.h"

namespace csd {
namespace {

/// The learner's only tree.
std::shared_ptr<const Tree> tree_of(const FeatureLearner &learner) {
  const auto forest = learner.published();
  return forest ? forest->trees().front() : nullptr;
}

/// An update learns only the given patches and no warps of them, so that samples can be counted.
LearnerOptions without_warps() {
  LearnerOptions options;
  options.choices.update_warps = 0;
  return options;
}

class LearningAFeature : public testing::Test {
 protected:
  LearningAFeature() {
    snapshot_.bgr = MovingScene().render({0, 0});
    cv::cvtColor(snapshot_.bgr, snapshot_.luma, cv::COLOR_BGR2GRAY);
  }
  /// The patch around `p` as the descriptor sees it: smoothed.
  cv::Mat patch(cv::Point2d p, const Warp &warp = Warp::eye()) const {
    cv::Mat channel;
    csd2012::smooth(grown(p, warp), choices_.smoothing, channel);
    return channel.clone();
  }
  /// The same patch before smoothing.
  cv::Mat grown(cv::Point2d p, const Warp &warp = Warp::eye()) const {
    cv::Mat channel, out;
    to_space(snapshot_.bgr, learner_.published()->space(), channel);
    sample_patch(channel, p, learner_.grown(), warp, out);
    return out;
  }
  bool is_feature(const cv::Mat &patch) const { return learner_.published()->probability(patch) > 0; }

  /// The picture as the descriptor sees it.
  cv::Mat whole_picture() const {
    cv::Mat channel;
    const int margin = csd2012::smoothing_margin(choices_.smoothing);
    to_space(snapshot_.bgr, learner_.published()->space(), channel);
    cv::copyMakeBorder(channel, channel, margin, margin, margin, margin, cv::BORDER_REPLICATE);
    csd2012::smooth(channel, choices_.smoothing, channel);
    return channel.clone();
  }

  const csd2012::Choices choices_ = without_warps().choices;
  Snapshot snapshot_;
  const cv::Point at_{160, 120};
  std::shared_ptr<LearningCounters> counters_ = std::make_shared<LearningCounters>();
  FeatureLearner learner_{without_warps(), Random(1), counters_};
};

TEST_F(LearningAFeature, PublishesNothingBeforeTheFirstLesson) {
  EXPECT_EQ(learner_.published(), nullptr);
  learner_.update({});
  EXPECT_EQ(learner_.published(), nullptr);
}

TEST_F(LearningAFeature, RecognisesTheFeatureButNotItsSurroundings) {
  learner_.learn(snapshot_, at_);
  const auto tree = tree_of(learner_);
  ASSERT_NE(tree, nullptr);
  const cv::Mat channel = whole_picture();
  EXPECT_TRUE(is_feature(patch(at_)));
  // One positive, 3 in smoke, 66 warps.
  EXPECT_EQ(tree->features(), 70u);
  const auto result = search(*learner_.published(), channel, {0, 0}, {{120, 80, 81, 81}, 1}, {at_, 10});
  ASSERT_TRUE(result.best);
  EXPECT_LE(std::hypot(result.best->x - at_.x, result.best->y - at_.y), 4);
  // §2.2.2 ends without false matches in the search window (radius 20), except in the 4 px around the feature, which it
  // skips.
  for (const auto &p : result.matches) {
    const double distance = std::hypot(p.x - at_.x, p.y - at_.y);
    EXPECT_TRUE(distance <= 4 || std::abs(p.x - at_.x) > 20 || std::abs(p.y - at_.y) > 20) << p;
  }
  // Nor are there any on the grid of every 4th position of the picture.
  const auto grid = search(*learner_.published(), channel, {0, 0}, {{12, 12, 296, 216}, 4}, {at_, 10});
  for (const auto &p : grid.matches) EXPECT_LE(std::hypot(p.x - at_.x, p.y - at_.y), 4) << p;
}

// LK may follow a feature up to the last pixel. Past the border, the border's pixels are repeated.
TEST_F(LearningAFeature, RecognisesAFeatureInTheCornerWithReplicatedBorder) {
  const cv::Point corner(319, 239);
  learner_.learn(snapshot_, corner);
  EXPECT_TRUE(is_feature(patch(corner)));
  EXPECT_EQ(tree_of(learner_)->features(), 70u);
}

// The warps are in the training set. One may still get "not a feature", but only in a leaf of fewer than four samples,
// which the stop rules do not divide (StopRules).
TEST_F(LearningAFeature, RecognisesWarpsAsFarAsTheStopRulesAllow) {
  learner_.learn(snapshot_, at_);
  const auto tree = tree_of(learner_);
  int recognised = 0;
  for (const auto &warp : geometric_warps(21)) {
    const cv::Mat bent = patch(at_, warp);
    const auto &leaf = tree->nodes()[static_cast<std::size_t>(tree->leaf(bent))];
    EXPECT_GE(leaf.feature, 1u);
    if (is_feature(bent))
      ++recognised;
    else
      EXPECT_LT(leaf.feature + leaf.not_feature, 4u);
  }
  EXPECT_GT(recognised, 33);
}

// Each tree draws its own half of the 70 positives and of the updates. All recognise the feature.
TEST_F(LearningAFeature, SeveralTreesLearnSharesOfTheSameSamples) {
  auto options = without_warps();
  options.choices.trees = 5;
  learner_.learn(snapshot_, at_);  // in the same colour space
  FeatureLearner several(options, Random(1), counters_);
  several.learn(snapshot_, at_);
  const auto forest = several.published();
  ASSERT_EQ(forest->trees().size(), 5u);
  std::set<std::uint32_t> shares;
  for (const auto &tree : forest->trees()) {
    EXPECT_GT(tree->features(), 20u);
    EXPECT_LT(tree->features(), 50u);
    shares.insert(tree->features());
  }
  EXPECT_GT(shares.size(), 1u);
  EXPECT_GT(forest->probability(patch(at_)), 0);
  for (int i = 0; i < 40; ++i) several.update({grown(at_), {}});
  for (std::size_t i = 0; i < 5; ++i) {
    const auto more = several.published()->trees()[i]->features() - forest->trees()[i]->features();
    EXPECT_GT(more, 8u);
    EXPECT_LT(more, 32u);
  }
}

// The 70 positives gain a copy of the one positive without warp or smoke.
TEST_F(LearningAFeature, EachAppearanceModelAddsItsCopies) {
  for (const auto *model : {"highlights=3", "blurs=3", "compressions=3"}) {
    auto options = without_warps();
    csd2012::set(options.choices, model);
    FeatureLearner learner(options, Random(1), counters_);
    learner.learn(snapshot_, at_);
    EXPECT_EQ(tree_of(learner)->features(), 73u) << model;
  }
}

TEST_F(LearningAFeature, LearnsInTheChosenColourSpace) {
  for (const int colour : {0, 1, 2}) {
    LearnerOptions options;
    options.choices.colour = colour;
    FeatureLearner learner(options, Random(1), counters_);
    learner.learn(snapshot_, at_);
    EXPECT_EQ(learner.published()->space() == (ColourSpace{1, 1, 1}), colour == 0)
        << "the scene's colours separate better";
  }
}

// A patch found 40° from the learnt one, which is the limit of the warps, is learnt with warps of its own: up to 40°
// more.
TEST_F(LearningAFeature, WarpsOfAFoundPatchReachFurther) {
  const auto recognised = [&](double warps) {
    LearnerOptions options;
    options.choices.update_warps = warps;
    FeatureLearner learner(options, Random(1), counters_);
    learner.learn(snapshot_, at_);
    cv::Mat channel, turned, patch, seen;
    to_space(snapshot_.bgr, learner.published()->space(), channel);
    sample_patch(channel, at_, learner.surroundings(), rotation_warp(40), turned);
    for (int i = 0; i < 30; ++i) learner.update({turned, {}});
    int found = 0;
    for (int degrees = 50; degrees <= 80; degrees += 2) {
      sample_patch(channel, at_, learner.grown(), rotation_warp(degrees), patch);
      csd2012::smooth(patch, choices_.smoothing, seen);
      const auto tree = tree_of(learner);
      found += tree->is_feature(tree->leaf(seen.clone()));
    }
    return found;
  };
  EXPECT_GT(recognised(8), recognised(0) + 4) << "of 16";
}

TEST_F(LearningAFeature, EachLessonAddsItsPositives) {
  learner_.learn(snapshot_, at_);
  learner_.learn(snapshot_, at_);
  EXPECT_EQ(tree_of(learner_)->features(), 140u);
}

TEST_F(LearningAFeature, TheDescriptorIsUsableWhileTheNextIsLearnt) {
  learner_.learn(snapshot_, at_);
  std::atomic<bool> done = false;
  std::vector<std::uint32_t> seen;
  std::thread reader([&] {
    do {
      const auto tree = tree_of(learner_);
      const cv::Mat flat(21, 21, CV_8UC1, cv::Scalar(90));
      EXPECT_LE(tree->probability(tree->leaf(flat)), 1.0);
      if (seen.empty() || seen.back() != tree->features()) seen.push_back(tree->features());
    } while (!done);
  });
  learner_.learn(snapshot_, at_);
  learner_.learn(snapshot_, at_);
  done = true;
  reader.join();
  // Only whole lessons are published.
  for (const auto features : seen) EXPECT_EQ(features % 70, 0u);
  EXPECT_EQ(tree_of(learner_)->features(), 210u);
}

TEST_F(LearningAFeature, ASuccessAddsSamplesAndTheRingHolds200) {
  learner_.learn(snapshot_, at_);
  DescriptorUpdate update;
  update.feature = grown(at_);
  learner_.update(update);
  EXPECT_EQ(tree_of(learner_)->features(), 71u);
  for (int i = 0; i < 300; ++i) learner_.update(update);
  EXPECT_EQ(tree_of(learner_)->features(), 270u);
}

TEST_F(LearningAFeature, AFalseMatchRetrainsItsLeaf) {
  learner_.learn(snapshot_, at_);
  // A look-alike: the feature with a bright stripe, unknown to the descriptor.
  cv::Mat alike;
  for (int row = 0; row < learner_.grown() && alike.empty(); ++row) {
    cv::Mat tried = grown(at_), seen;
    tried.row(row).setTo(255);
    csd2012::smooth(tried, choices_.smoothing, seen);
    if (is_feature(seen.clone())) alike = tried;
  }
  ASSERT_FALSE(alike.empty()) << "no stripe fools the descriptor";
  const auto retrainings = counters_->retrainings.load();
  // Of this many negatives the reservoir keeps one in twenty, but all of those classified as the feature.
  const int side = learner_.grown();
  const cv::Mat flat(side, side, CV_8UC1, cv::Scalar(90));
  ASSERT_FALSE(is_feature(flat({0, 0, 21, 21}).clone()));
  DescriptorUpdate update;
  update.negatives.assign(60000, flat);
  learner_.update(update);
  std::size_t negatives = 0;
  for (const auto tree = tree_of(learner_); const auto &node : tree->nodes()) negatives += node.not_feature;
  EXPECT_LT(negatives, 4000u);
  EXPECT_GE(negatives, 3000u);
  update.negatives.clear();
  // Four of them, because a leaf of fewer samples is not divided.
  for (int i = 0; i < 4; ++i) update.negatives.push_back(alike);
  learner_.update(update);
  cv::Mat seen;
  csd2012::smooth(alike, choices_.smoothing, seen);
  EXPECT_FALSE(is_feature(seen.clone()));
  EXPECT_TRUE(is_feature(patch(at_)));
  EXPECT_GT(counters_->retrainings, retrainings);
}

TEST_F(LearningAFeature, LearnsNothingWhereForbidden) {
  snapshot_.forbidden = cv::Mat(snapshot_.luma.size(), CV_8UC1, cv::Scalar(255));
  learner_.learn(snapshot_, at_);
  const auto tree = tree_of(learner_);
  std::uint32_t negatives = 0;
  for (const auto &node : tree->nodes()) negatives += node.not_feature;
  EXPECT_EQ(negatives, 0u);
  EXPECT_EQ(tree->features(), 70u);
}

// Evaluation (§2.2.2) covers the search window and the grid of every 4th position. Both are forbidden here, so all
// negatives are those of §2.1.2.1: the similar ones and 26 of the 40 random ones (the other third is drawn from the
// window), each also in three densities of smoke.
TEST_F(LearningAFeature, NegativesAreRandomAndSimilarEachAlsoInSmoke) {
  const cv::Rect copy(183, 110, 21, 21);  // 33 px from the feature, off the grid
  snapshot_.bgr({150, 110, 21, 21}).copyTo(snapshot_.bgr(copy));
  cv::cvtColor(snapshot_.bgr, snapshot_.luma, cv::COLOR_BGR2GRAY);
  snapshot_.forbidden = cv::Mat(snapshot_.luma.size(), CV_8UC1, cv::Scalar(0));
  snapshot_.forbidden({139, 99, 43, 43}).setTo(255);
  for (int y = 0; y < 240; y += 4)
    for (int x = 0; x < 320; x += 4) snapshot_.forbidden.at<unsigned char>(y, x) = 255;
  const auto similar =
      similar_negatives(snapshot_.luma, snapshot_.forbidden, at_, 20, 0.5, 40, NegativeRules{21, 4, 12}).size();
  ASSERT_GE(similar, 1u) << "the copy is one";
  learner_.learn(snapshot_, at_);
  std::size_t negatives = 0;
  const auto tree = tree_of(learner_);
  for (const auto &node : tree->nodes()) negatives += node.not_feature;
  EXPECT_EQ(negatives, 4 * (26 + similar));
}

TEST_F(LearningAFeature, TheRingForgetsTheOldestSuccesses) {
  learner_.learn(snapshot_, at_);
  const cv::Mat own = grown(at_), inverse = 255 - own;
  cv::Mat other;
  csd2012::smooth(inverse, choices_.smoothing, other);
  other = other.clone();
  const auto features_with_other = [&] {
    const auto tree = tree_of(learner_);
    return tree->nodes()[static_cast<std::size_t>(tree->leaf(other))].feature;
  };
  ASSERT_NE(tree_of(learner_)->leaf(patch(at_)), tree_of(learner_)->leaf(other));
  const auto before = features_with_other();
  const auto succeed = [&](int times, const cv::Mat &feature) {
    for (int i = 0; i < times; ++i) learner_.update({feature, {}});
  };
  succeed(200, inverse);
  EXPECT_EQ(features_with_other(), before + 200);
  succeed(150, own);
  EXPECT_EQ(features_with_other(), before + 50);
  succeed(150, own);
  EXPECT_EQ(features_with_other(), before);
}

TEST_F(LearningAFeature, LearnsAtTheEdgeOfThePicture) {
  for (const auto &p : {cv::Point(0, 0), cv::Point(319, 239), cv::Point(3, 120)}) {
    FeatureLearner learner({}, Random(1), counters_);
    learner.learn(snapshot_, p);
    ASSERT_NE(learner.published(), nullptr);
    EXPECT_GE(tree_of(learner)->features(), 70u);
  }
}

}  // namespace
}  // namespace csd
