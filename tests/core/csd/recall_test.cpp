// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/recall.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "base/types.h"
#include "image/work_frame.h"
#include "track/moving_scene.h"

namespace csd {
namespace {

constexpr double degree = CV_PI / 180;

Similarity turn(double degrees, double zoom, cv::Point2d shift) {
  return {zoom * std::cos(degrees * degree), zoom * std::sin(degrees * degree), shift};
}

/// `right` matches that follow `motion` to half a pixel, and `wrong` ones that lead anywhere.
std::vector<Correspondence> matches_of(const Similarity &motion, int right, int wrong) {
  cv::RNG rng(3);
  const auto anywhere = [&] { return cv::Point2d(rng.uniform(0., 320.), rng.uniform(0., 240.)); };
  std::vector<Correspondence> matches;
  for (int i = 0; i < right + wrong; ++i) {
    const auto p = anywhere();
    const cv::Point2d beside(rng.uniform(-.5, .5), rng.uniform(-.5, .5));
    matches.push_back(
        {p, i * right / (right + wrong) < (i + 1) * right / (right + wrong) ? motion(p) + beside : anywhere()});
  }
  return matches;
}

TEST(AgreeOnSimilarity, FindsTheMotionOfAThirdOfTheMatches) {
  const auto motion = turn(75, 0.6, {250, -20});
  const auto found = agree_on_similarity(matches_of(motion, 20, 40), 3, 8, 4);
  ASSERT_TRUE(found);
  for (const cv::Point2d p : {cv::Point2d(0, 0), {319, 0}, {160, 239}}) EXPECT_LT(cv::norm((*found)(p)-motion(p)), 0.7);
  EXPECT_NEAR(found->scale(), 0.6, 0.01);
}

TEST(AgreeOnSimilarity, FindsNothingInChanceOrTooFewMatches) {
  EXPECT_FALSE(agree_on_similarity(matches_of({}, 0, 60), 3, 8, 4));
  EXPECT_FALSE(agree_on_similarity(matches_of(turn(30, 1, {}), 7, 0), 3, 8, 4));
  EXPECT_TRUE(agree_on_similarity(matches_of(turn(30, 1, {}), 8, 0), 3, 8, 4));
  EXPECT_FALSE(agree_on_similarity(matches_of(turn(30, 5, {}), 30, 0), 3, 8, 4)) << "no cut zooms this far";
  EXPECT_FALSE(agree_on_similarity({}, 3, 8, 4));
  EXPECT_FALSE(agree_on_similarity(std::vector<Correspondence>(20, {{5, 5}, {9, 9}}), 3, 8, 4)) << "all at one place";
}

class RecallTest : public testing::Test {
 protected:
  static constexpr double fps = 25;
  CsdFrame show(const cv::Mat &bgr, double seconds) {
    cv::Mat luma;
    cv::cvtColor(bgr, luma, cv::COLOR_BGR2GRAY);
    frame_.load(MovingScene::view(bgr));
    pyramid_.build(luma);
    glare_.build(frame_, {});
    return {.pyramid = pyramid_,
            .weights = glare_,
            .size = luma.size(),
            .unit = luma.rows / 480.0,
            .time = static_cast<std::int64_t>(seconds * second),
            .training_time = second / 2};
  }
  cv::Mat turned(const Similarity &motion) const {
    cv::Mat out;
    const cv::Matx23d m(motion.a, -motion.b, motion.shift.x, motion.b, motion.a, motion.shift.y);
    cv::warpAffine(scene_.render({}), out, m, {320, 240}, cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
    return out;
  }
  static NeighbourField grid(int chart, int count = 48) {
    NeighbourField field;
    for (int i = 0; i < count; ++i) {
      const cv::Point2d p(20 + i % 8 * 40, 20 + i / 8 * 40);
      field.add(static_cast<std::size_t>(i), chart, {p, p});
    }
    return field;
  }

  MovingScene scene_;
  WorkFrame frame_;
  Pyramid pyramid_;
  GlareWeights glare_;
  Recall recall_;
};

TEST_F(RecallTest, FindsAChartAfterAnyRotationAndZoom) {
  recall_.remember(show(turned({}), 1), grid(0), 0);
  // About the picture's middle (160, 120): turned by 100 degrees, scaled by 0.8.
  auto motion = turn(100, 0.8, {});
  motion.shift = cv::Point2d(170, 110) - motion({160, 120});
  const auto frame = show(turned(motion), 4);
  ASSERT_TRUE(recall_.due(frame, {}, 1));
  NeighbourField found;
  ASSERT_EQ(recall_.find(frame, {}, 1, found), 0);
  EXPECT_EQ(found.size(0), 48u);
  for (const cv::Point2d p : {cv::Point2d(160, 120), {120, 90}, {200, 150}})
    EXPECT_LT(cv::norm(found.map_at(p, 0, 0.5, {})(p) - motion(p)), 2);
}

TEST_F(RecallTest, DoesNotTakeAnotherScene) {
  recall_.remember(show(turned({}), 1), grid(0), 0);
  const auto frame = show(MovingScene({320, 240}, 9).render({}), 4);
  NeighbourField found;
  EXPECT_EQ(recall_.find(frame, {}, 1, found), -1);
}

TEST_F(RecallTest, KeepsTheLastFrameInWhichMostWasSeen) {
  recall_.remember(show(turned({}), 1), grid(0), 0);
  const Similarity aside = turn(0, 1, {15, 0});
  recall_.remember(show(turned(aside), 2), grid(0), 0);                              // as much is seen
  recall_.remember(show(MovingScene({320, 240}, 9).render({}), 3), grid(0, 12), 0);  // a quarter is seen
  cv::Mat dim;
  turned(turn(0, 1, {-15, 0})).convertTo(dim, CV_8UC3, 0.2);
  recall_.remember(show(dim, 3.5), grid(0), 0);  // fading out
  const auto frame = show(turned(aside), 4);
  NeighbourField found;
  ASSERT_EQ(recall_.find(frame, {}, 1, found), 0);
  EXPECT_EQ(found.size(0), 48u);
  EXPECT_LT(cv::norm(found.map_at({160, 120}, 0, 0.5, {})({160, 120}) - cv::Point2d(160, 120)), 1);
}

TEST_F(RecallTest, TriesLessOftenWithTimeAndNeverInTheDark) {
  const auto tries = [&](double from, double to, const cv::Mat &bgr, const NeighbourField &present) {
    int n = 0;
    for (double t = from; t < to; t += 1 / fps) n += recall_.due(show(bgr, t), present, 1);
    return n;
  };
  const auto picture = turned({});
  EXPECT_EQ(tries(0, 1, picture, {}), 0) << "nothing to search for";
  recall_.remember(show(picture, 1), grid(0), 0);
  EXPECT_EQ(tries(1.04, 2, picture, grid(0)), 0) << "it is in view";
  EXPECT_EQ(tries(2, 3, cv::Mat(240, 320, CV_8UC3, cv::Scalar(3, 2, 4)), {}), 0);
  EXPECT_NEAR(tries(3, 4, picture, {}), 8, 1);
  EXPECT_NEAR(tries(4, 5, picture, grid(0, 4)), 8, 1) << "so few may match by chance";
  EXPECT_FALSE(recall_.due(show(picture, 5.2), grid(0, 4), 0.5)) << "many points, half of them aligned";
  EXPECT_TRUE(recall_.due(show(picture, 5.3), grid(0, 4), 1));
  EXPECT_NEAR(tries(101, 103, picture, {}), 2, 1) << "once a second after 100 s";
  // Another scene: the first may still come back within ten seconds.
  recall_.remember(show(picture, 103), grid(1), 1);
  EXPECT_GT(tries(103.04, 106, picture, grid(1)), 1);
  EXPECT_EQ(tries(114, 120, picture, grid(1)), 0);
}

TEST_F(RecallTest, KeepsFourScenesTheFirstAmongThem) {
  for (int chart = 0; chart < 6; ++chart) recall_.remember(show(turned({}), chart), grid(chart), chart);
  for (int chart = 0; chart < 6; ++chart) EXPECT_EQ(recall_.knows(chart), chart == 0 || chart >= 3) << chart;
  recall_.forget(0);
  EXPECT_FALSE(recall_.knows(0));
}

}  // namespace
}  // namespace csd
