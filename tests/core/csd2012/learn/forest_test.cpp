// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/forest.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd {
namespace {

// A tree on 3×3 patches. Where pixel `p1` is greater than the middle, the leaf holds `feature` of the tree's 8
// features; other leaves hold the rest.
std::shared_ptr<const Tree> stump(std::uint16_t p1, std::uint32_t feature, const ColourSpace &space = {1, 1, 1}) {
  std::vector<Tree::Node> nodes(4);
  nodes[0] = {p1, 4, 1, 0, 0};
  nodes[1] = {0, 0, 0, feature, 0};
  nodes[2] = {0, 0, 1, 8 - feature, 9};
  nodes[3] = {0, 0, 2, 0, 9};
  return std::make_shared<const Tree>(3, space, std::move(nodes), 1);
}

/// A patch of 100s, with the listed pixels at 200.
cv::Mat patch(std::initializer_list<int> bright) {
  cv::Mat m(3, 3, CV_8UC1, cv::Scalar(100));
  for (const int i : bright) m.data[i] = 200;
  return m;
}

TEST(Forest, TheMajorityDecidesAndAllTreesCount) {
  const Forest three({stump(0, 6), stump(1, 4), stump(2, 8)});
  EXPECT_FLOAT_EQ(static_cast<float>(three.probability(patch({0, 1, 2}))), (6 + 4 + 8) / 8.F / 3);
  EXPECT_FLOAT_EQ(static_cast<float>(three.probability(patch({0, 2}))), (6 + 8) / 8.F / 3)
      << "the tree that says no counts as 0";
  EXPECT_EQ(three.probability(patch({2})), 0) << "one of three is no majority";
  const Forest two({stump(0, 6), stump(1, 4)});
  EXPECT_EQ(two.probability(patch({0})), 0) << "half is no majority";
  EXPECT_EQ(Forest({stump(0, 6)}).probability(patch({0})), 6 / 8.) << "the paper's P(N)";
}

TEST(Forest, ScansTheAreaAndAgreesWithSinglePatches) {
  const Forest three({stump(0, 6), stump(1, 4), stump(5, 8)});
  cv::Mat channel(12, 15, CV_8UC1);
  cv::RNG(3).fill(channel, cv::RNG::UNIFORM, 0, 4);
  for (const int step : {1, 2, 3}) {
    const cv::Rect area(2, 1, 11, 9);
    cv::Mat found;
    three.scan(channel, area, step, found);
    ASSERT_EQ(found.size(), cv::Size((area.width + step - 1) / step, (area.height + step - 1) / step));
    for (int y = 0; y < found.rows; ++y)
      for (int x = 0; x < found.cols; ++x) {
        const cv::Rect around(area.x + x * step - 1, area.y + y * step - 1, 3, 3);
        EXPECT_EQ(found.at<float>(y, x), three.probability(channel(around).clone())) << around;
      }
    EXPECT_GT(cv::countNonZero(found), 0);
  }
}

/// stump(0, 6) whose leaf of features has seen `own`.
std::shared_ptr<const Tree> stump_with(const cv::Mat &own) {
  auto patches = std::make_shared<LeafPatches>(9);
  patches->add(own.data);
  auto nodes = stump(0, 6)->nodes();
  return std::make_shared<const Tree>(3, ColourSpace{1, 1, 1}, std::move(nodes), 1,
                                      Tree::LeavesPatches{nullptr, std::move(patches), nullptr, nullptr});
}

TEST(Forest, ALeafCountsByTheLikenessToItsOwnPatches) {
  const cv::Mat seen = patch({0, 1}), other = patch({0, 5});
  const double likeness = stump_with(seen)->likeness(1, other.data);
  ASSERT_GT(likeness, 0.3);
  ASSERT_LT(likeness, 0.9);
  const auto scanned = [&](const Forest &forest, double power) {
    cv::Mat found;
    forest.scan(other, {1, 1, 1, 1}, 1, found, power);
    return found.at<float>(0, 0);
  };
  EXPECT_FLOAT_EQ(scanned(Forest({stump_with(seen)}), 0), 6 / 8.F) << "not asked for";
  EXPECT_FLOAT_EQ(scanned(Forest({stump_with(seen)}), 1), static_cast<float>(6 / 8. * likeness));
  EXPECT_FLOAT_EQ(scanned(Forest({stump_with(seen)}), 3), static_cast<float>(6 / 8. * std::pow(likeness, 3)));
  EXPECT_FLOAT_EQ(scanned(Forest({stump_with(other)}), 3), 6 / 8.F) << "the very patch";
  // Each tree's own patches count for its own probability, and a tree that disagrees counts as 0.
  EXPECT_FLOAT_EQ(scanned(Forest({stump_with(seen), stump_with(other), stump(1, 4)}), 1),
                  static_cast<float>(6 / 8. * (likeness + 1) / 3));
  EXPECT_EQ(scanned(Forest({stump(0, 6)}), 1), 0) << "a leaf without patches of its own";
}

TEST(Forest, RefusesNoTreesAndTreesOfDifferentKinds) {
  EXPECT_THROW(Forest({}), cv::Exception);
  EXPECT_THROW(Forest({stump(0, 6), stump(0, 6, {2, 1, 0})}), cv::Exception);
}

}  // namespace
}  // namespace csd
