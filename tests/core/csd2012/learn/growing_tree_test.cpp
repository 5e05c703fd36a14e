// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/growing_tree.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "base/random.h"

namespace csd {
namespace {

constexpr int side = 5;

cv::Mat noise_patch(Random &random, int levels = 256) {
  cv::Mat m(side, side, CV_8UC1);
  for (int i = 0; i < side * side; ++i)
    m.data[i] = static_cast<std::uint8_t>(random.below(static_cast<unsigned>(levels)));
  return m;
}

GrowthOptions exhaustive() {
  GrowthOptions o;
  o.search.search = PairSearch::exhaustive;
  return o;
}

// Checks the labels and counts of all leaves by dropping every sample down the published tree.
void expect_counts_agree(const GrowingTree &growing) {
  const auto tree = growing.publish();
  std::map<std::int32_t, std::pair<unsigned, unsigned>> counted;
  unsigned features = 0;
  for (SampleId id = 0; id < growing.samples().slots(); ++id) {
    if (!growing.samples().contains(id)) continue;
    const cv::Mat patch(side, side, CV_8UC1, const_cast<std::uint8_t *>(growing.samples().patch(id)));
    auto &c = counted[tree->leaf(patch)];
    ++(growing.samples().label(id) == Label::feature ? c.first : c.second);
    features += growing.samples().label(id) == Label::feature;
  }
  EXPECT_EQ(tree->features(), features);
  for (std::size_t i = 0; i < tree->nodes().size(); ++i) {
    const auto leaf = static_cast<std::int32_t>(i);
    const Tree::Node &n = tree->nodes()[i];
    const auto c = counted.contains(leaf) ? counted[leaf] : std::pair<unsigned, unsigned>{};
    EXPECT_EQ(n.feature, c.first) << i;
    EXPECT_EQ(n.not_feature, c.second) << i;
    if (n.first_child < leaf) {
      EXPECT_EQ(n.first_child, leaf - 1);
      EXPECT_EQ(tree->is_feature(leaf), c.first > c.second);
    } else {
      EXPECT_FALSE(counted.contains(leaf));
    }
  }
}

TEST(GrowingTree, BeginsAsOneEmptyLeafThatIsNotAFeature) {
  const GrowingTree growing(side, {1, 1, 1}, {});
  const auto tree = growing.publish();
  ASSERT_EQ(tree->nodes().size(), 1u);
  EXPECT_FALSE(tree->is_feature(0));
  EXPECT_EQ(tree->probability(0), 0.0);
  EXPECT_EQ(tree->leaf(cv::Mat::zeros(side, side, CV_8UC1)), 0);
}

// In features, pixel 7 is brighter than pixel 3; in a second group darker, in a third equal. One test suffices.
TEST(GrowingTree, FindsTheOneTestThatSeparates) {
  GrowingTree growing(side, {1, 1, 1}, exhaustive());
  Random random(5);
  for (int i = 0; i < 60; ++i) {
    cv::Mat m = noise_patch(random);
    const int v = 20 + static_cast<int>(random.below(200));
    m.data[3] = static_cast<std::uint8_t>(v);
    m.data[7] = static_cast<std::uint8_t>(i % 3 == 0 ? v + 10 : i % 3 == 1 ? v : v - 10);
    growing.add(m, i % 3 == 0 ? Label::feature : Label::not_feature);
  }
  growing.build();
  const auto tree = growing.publish();
  ASSERT_EQ(tree->nodes().size(), 4u);
  EXPECT_EQ(tree->depth(), 1);
  EXPECT_EQ(tree->nodes()[0].p1, 3);
  EXPECT_EQ(tree->nodes()[0].p2, 7);
  EXPECT_FALSE(tree->is_feature(1));  // P3 > P7
  EXPECT_FALSE(tree->is_feature(2));  // P3 = P7
  EXPECT_TRUE(tree->is_feature(3));   // P3 < P7
  EXPECT_EQ(tree->probability(3), 1.0);
  expect_counts_agree(growing);
}

TEST(GrowingTree, ClassifiesItsTrainingSet) {
  for (const PairSearch search : {PairSearch::ranked, PairSearch::exhaustive}) {
    GrowthOptions options;
    options.search.search = search;
    options.stop.min_samples = 2;
    GrowingTree growing(side, {1, 1, 1}, options);
    Random random(9);
    for (int i = 0; i < 300; ++i) growing.add(noise_patch(random), i % 3 ? Label::not_feature : Label::feature);
    growing.build();
    for (SampleId id = 0; id < 300; ++id) EXPECT_FALSE(growing.misclassified(id)) << id;
    expect_counts_agree(growing);
  }
}

TEST(GrowingTree, StopsWhereSamplesContradictEachOther) {
  GrowingTree growing(side, {1, 1, 1}, {});
  const cv::Mat same = cv::Mat::ones(side, side, CV_8UC1);
  for (int i = 0; i < 10; ++i) growing.add(same, i < 4 ? Label::feature : Label::not_feature);
  growing.build();
  EXPECT_EQ(growing.node_count(), 1u);
  EXPECT_EQ(growing.classify(same), Label::not_feature);  // 4 against 6
  growing.add(same, Label::feature);
  growing.add(same, Label::feature);
  EXPECT_EQ(growing.classify(same), Label::not_feature);  // 6 against 6
  growing.add(same, Label::feature);
  EXPECT_EQ(growing.classify(same), Label::feature);
}

TEST(GrowingTree, RespectsTheMaximumDepth) {
  GrowthOptions options;
  options.stop.max_depth = 2;
  GrowingTree growing(side, {1, 1, 1}, options);
  Random random(2);
  for (int i = 0; i < 200; ++i) growing.add(noise_patch(random), i % 2 ? Label::not_feature : Label::feature);
  growing.build();
  EXPECT_EQ(growing.publish()->depth(), 2);
  expect_counts_agree(growing);
}

TEST(GrowingTree, ItsSizeIsBoundedHoweverLongItLearns) {
  constexpr std::size_t samples = 60;
  const auto largest_tree = [](std::size_t max_nodes) {
    GrowthOptions options;
    options.max_nodes = max_nodes;
    GrowingTree growing(side, {1, 1, 1}, options);
    Random random(4);
    for (std::size_t i = 0; i < samples; ++i)
      growing.add(noise_patch(random), i % 2 ? Label::not_feature : Label::feature);
    growing.build();
    std::size_t most = 0;
    for (int i = 0; i < 2000; ++i) {
      const auto id = static_cast<SampleId>(random.below(samples));
      growing.replace(id, noise_patch(random), random.below(2) ? Label::not_feature : Label::feature);
      growing.retrain({{id}});
      most = std::max(most, growing.node_count());
    }
    expect_counts_agree(growing);
    return most;
  };
  EXPECT_LE(largest_tree(0), 4 * samples);
  EXPECT_GT(largest_tree(1 << 14), 5 * samples) << "else this test proves nothing";
}

TEST(GrowingTree, RetrainsOnlyTheLeafThatErred) {
  GrowthOptions options = exhaustive();
  options.stop.min_samples = 2;
  GrowingTree growing(side, {1, 1, 1}, options);
  Random random(3);
  for (int i = 0; i < 200; ++i) growing.add(noise_patch(random), i % 4 ? Label::not_feature : Label::feature);
  growing.build();
  const auto before = growing.publish();

  cv::Mat false_positive;
  do false_positive = noise_patch(random);
  while (growing.classify(false_positive) != Label::feature);
  const SampleId id = growing.add(false_positive, Label::not_feature);
  // One sample against a pure leaf: the leaf keeps its label, so this sample is misclassified.
  ASSERT_TRUE(growing.misclassified(id));
  const std::array<SampleId, 1> wrong{id};
  EXPECT_EQ(growing.retrain(wrong), 1);
  EXPECT_EQ(growing.retrainings(), 1u);
  EXPECT_FALSE(growing.misclassified(id));
  EXPECT_EQ(growing.retrain(wrong), 0);
  for (SampleId i = 0; i < growing.samples().slots(); ++i) EXPECT_FALSE(growing.misclassified(i));
  expect_counts_agree(growing);

  // The rest is unchanged: patches in other leaves keep their labels.
  const auto after = growing.publish();
  const std::int32_t erred = before->leaf(false_positive);
  for (int i = 0; i < 500; ++i) {
    const cv::Mat m = noise_patch(random);
    if (before->leaf(m) == erred) continue;
    EXPECT_EQ(before->is_feature(before->leaf(m)), after->is_feature(after->leaf(m)));
  }
}

// The others outnumber the features. So the features are misclassified, and the sample passed to retrain() is not.
TEST(GrowingTree, RetrainsALeafWhereTheFeatureIsOutnumbered) {
  GrowingTree growing(side, {1, 1, 1}, {});
  Random random(6);
  std::array<SampleId, 2> features{};
  for (auto &id : features) id = growing.add(noise_patch(random), Label::feature);
  SampleId other = 0;
  for (int i = 0; i < 4; ++i) other = growing.add(noise_patch(random), Label::not_feature);
  ASSERT_FALSE(growing.misclassified(other));
  const std::array<SampleId, 1> asked{other};
  EXPECT_EQ(growing.retrain(asked), 1);
  for (const auto id : features) EXPECT_FALSE(growing.misclassified(id));
}

TEST(GrowingTree, CountsFollowAddReplaceAndRemove) {
  GrowingTree growing(side, {1, 1, 1}, {});
  Random random(4);
  for (int i = 0; i < 120; ++i) growing.add(noise_patch(random), i % 3 ? Label::not_feature : Label::feature);
  growing.build();
  for (int i = 0; i < 400; ++i) {
    const SampleId id = random.below(static_cast<std::uint32_t>(growing.samples().slots()));
    const Label label = random.below(2) ? Label::feature : Label::not_feature;
    if (!growing.samples().contains(id) || random.below(3) == 0) {
      growing.add(noise_patch(random), label);
    } else if (random.below(2)) {
      growing.replace(id, noise_patch(random), label);
    } else {
      growing.remove(id);
    }
  }
  expect_counts_agree(growing);
  growing.build();
  expect_counts_agree(growing);
}

// The root is the only leaf here.
TEST(GrowingTree, ALeafShowsItsNewestFeaturePatches) {
  Random random(7, 0);
  GrowthOptions options = exhaustive();
  options.own_patches = 2;
  GrowingTree growing(side, {1, 1, 1}, options);
  std::vector<cv::Mat> patches;
  std::vector<SampleId> ids;
  const auto shown = [&](std::size_t i) { return growing.publish()->likeness(0, patches[i].data) > 0.999; };
  const auto add = [&](Label label) {
    patches.push_back(noise_patch(random));
    ids.push_back(growing.add(patches.back(), label));
  };
  for (int i = 0; i < 3; ++i) add(Label::feature);
  EXPECT_FALSE(shown(0));
  EXPECT_TRUE(shown(1) && shown(2));
  add(Label::not_feature);
  EXPECT_FALSE(shown(3)) << "not labelled feature";
  EXPECT_TRUE(shown(1) && shown(2));
  // A patch that replaces an old one is the newest.
  patches.push_back(noise_patch(random));
  growing.replace(ids[0], patches.back(), Label::feature);
  EXPECT_TRUE(shown(2) && shown(4));
  EXPECT_FALSE(shown(1));
  growing.remove(ids[2]);
  EXPECT_TRUE(shown(1) && shown(4));
  // A published tree keeps what it was published with.
  const auto before = growing.publish();
  for (int i = 0; i < 2; ++i) add(Label::feature);
  EXPECT_GT(before->likeness(0, patches[4].data), 0.999);
  EXPECT_FALSE(shown(4));
}

TEST(GrowingTree, ALeafThatIsDividedGivesItsPatchesToItsChildren) {
  Random random(8, 0);
  GrowthOptions options = exhaustive();
  options.own_patches = 4;
  GrowingTree growing(side, {1, 1, 1}, options);
  std::vector<cv::Mat> patches;
  for (int i = 0; i < 40; ++i) {
    patches.push_back(noise_patch(random));
    growing.add(patches.back(), i % 2 == 0 ? Label::feature : Label::not_feature);
    if (i % 8 == 0) growing.publish();
  }
  growing.build();
  const auto tree = growing.publish();
  for (const auto &patch : patches) {
    const auto leaf = tree->leaf(patch);
    const auto features = tree->nodes()[static_cast<std::size_t>(leaf)].feature;
    const double likeness = tree->likeness(leaf, patch.data);
    if (!tree->is_feature(leaf)) {
      EXPECT_EQ(likeness, 0);
    } else if (features <= 4) {
      EXPECT_GT(likeness, 0.999);
    }
  }
  EXPECT_EQ(GrowingTree(side, {1, 1, 1}, exhaustive()).publish()->likeness(0, patches[0].data), 0) << "none wanted";
}

TEST(GrowingTree, TheSameSeedGivesTheSameTree) {
  const auto grown = [](std::uint64_t stream) {
    GrowthOptions options;
    options.stream = stream;
    options.search.top_pixels = 4;  // so that random pairs matter
    GrowingTree growing(side, {1, 1, 1}, options);
    Random random(8);
    for (int i = 0; i < 300; ++i) growing.add(noise_patch(random, 40), i % 3 ? Label::not_feature : Label::feature);
    growing.build();
    std::vector<int> tests;
    const auto tree = growing.publish();
    for (const Tree::Node &n : tree->nodes()) tests.insert(tests.end(), {n.p1, n.p2, n.first_child});
    return tests;
  };
  EXPECT_EQ(grown(1), grown(1));
  EXPECT_NE(grown(1), grown(2));
}

TEST(GrowingTree, RefusesPatchesOfAnotherKind) {
  GrowingTree growing(side, {1, 1, 1}, {});
  EXPECT_THROW(growing.add(cv::Mat::zeros(side, side + 1, CV_8UC1), Label::feature), cv::Exception);
  EXPECT_THROW(growing.add(cv::Mat::zeros(side, side, CV_8UC3), Label::feature), cv::Exception);
  EXPECT_THROW(growing.remove(0), cv::Exception);
  EXPECT_EQ(growing.samples().size(), 0u);
  EXPECT_THROW(GrowingTree(4, {1, 1, 1}, {}), cv::Exception);
}

}  // namespace
}  // namespace csd
