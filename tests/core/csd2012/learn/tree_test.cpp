// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/tree.h"

#include <gtest/gtest.h>

#include "csd2012/learn/growing_tree.h"

namespace csd {
namespace {

// Root: compares pixels 0 and 8. Greater: leaf 1 (3 of 4 are features). Equal: compares pixels 1 and 2. Less: leaf 3
// (none).
Tree by_hand() {
  std::vector<Tree::Node> n(7);
  n[0] = {0, 8, 1, 0, 0};
  n[1] = {0, 0, 0, 3, 1};
  n[2] = {1, 2, 4, 0, 0};
  n[3] = {0, 0, 2, 0, 9};
  n[4] = {0, 0, 3, 1, 0};
  n[5] = {0, 0, 4, 2, 2};
  n[6] = {0, 0, 5, 0, 0};
  return {3, {1, 1, 1}, n, 2};
}

TEST(Tree, LeavesLabelsAndProbabilitiesAreAsByHand) {
  const Tree tree = by_hand();
  cv::Mat m = cv::Mat::zeros(3, 3, CV_8UC1);
  EXPECT_EQ(tree.leaf(m), 5);
  m.at<std::uint8_t>(0, 1) = 1;
  EXPECT_EQ(tree.leaf(m), 4);
  m.at<std::uint8_t>(0, 2) = 255;
  EXPECT_EQ(tree.leaf(m), 6);
  m.at<std::uint8_t>(0, 0) = 255;
  EXPECT_EQ(tree.leaf(m), 1);
  m.at<std::uint8_t>(0, 0) = 0;
  m.at<std::uint8_t>(2, 2) = 128;
  EXPECT_EQ(tree.leaf(m), 3);

  EXPECT_EQ(tree.features(), 6u);
  EXPECT_TRUE(tree.is_feature(1));
  EXPECT_FALSE(tree.is_feature(3));
  EXPECT_TRUE(tree.is_feature(4));
  EXPECT_FALSE(tree.is_feature(5));  // two of each
  EXPECT_FALSE(tree.is_feature(6));  // empty
  EXPECT_DOUBLE_EQ(tree.probability(1), 3.0 / 6);
  EXPECT_EQ(tree.probability(3), 0.0);
}

TEST(Tree, AScanAgreesWithSinglePatches) {
  Random random(7);
  cv::Mat whole(70, 90, CV_8UC1);
  for (int i = 0; i < 70 * 90; ++i) whole.data[i] = static_cast<std::uint8_t>(random.below(30));
  const cv::Mat channel = whole(cv::Rect(5, 3, 71, 60));  // rows with a gap between them
  GrowingTree growing(7, {1, 1, 1}, {});
  for (int i = 0; i < 400; ++i) {
    const int x = static_cast<int>(random.below(64)), y = static_cast<int>(random.below(53));
    growing.add(channel(cv::Rect(x, y, 7, 7)), i % 3 ? Label::not_feature : Label::feature);
  }
  growing.build();
  const auto tree = growing.publish();
  ASSERT_GT(tree->depth(), 3);
  std::vector<std::int32_t> fast, plain;
  for (const cv::Rect &centres : {cv::Rect(3, 3, 65, 54), cv::Rect(10, 9, 16, 2), cv::Rect(3, 3, 15, 1),
                                  cv::Rect(67, 56, 1, 1), cv::Rect(20, 20, 0, 5)}) {
    tree->scan(channel, centres, fast);
    tree->scan_plain(channel, centres, plain);
    EXPECT_EQ(fast, plain) << centres;
    EXPECT_EQ(fast.size(), static_cast<std::size_t>(centres.area()));
  }
  EXPECT_THROW(tree->scan(channel, cv::Rect(2, 3, 4, 4), fast), cv::Exception);
  EXPECT_THROW(tree->scan(channel, cv::Rect(60, 3, 9, 4), fast), cv::Exception);
  EXPECT_THROW(tree->scan(channel, cv::Rect(3, 50, 4, 8), fast), cv::Exception);
}

}  // namespace
}  // namespace csd
