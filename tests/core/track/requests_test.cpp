// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/requests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>

namespace csd {
namespace {

Settings with_points(std::size_t count) {
  Settings settings;
  settings.points.assign(count, {100, 100});
  return settings;
}

// What a new frame takes: the requests since the last one.
Requests::Taken take(Requests &requests) {
  Requests::Taken taken;
  requests.take(taken);
  return taken;
}

std::vector<FeatureId> ids(const std::vector<StartPoint> &points) {
  std::vector<FeatureId> ids;
  for (const auto &p : points) ids.push_back(p.id);
  return ids;
}

TEST(Requests, AreTakenOnce) {
  Requests requests(with_points(2));
  EXPECT_EQ(requests.add({12.5, 13}), 2u);
  EXPECT_EQ(requests.add({14, 15}), 3u);
  EXPECT_TRUE(requests.remove(1));
  const auto taken = take(requests);
  EXPECT_EQ(ids(taken.added), (std::vector<FeatureId>{2, 3}));
  EXPECT_EQ(taken.added[0].position, cv::Point2d(12.5, 13));
  EXPECT_EQ(taken.removed, (std::vector<FeatureId>{1}));
  EXPECT_FALSE(taken.reset);
  const auto nothing = take(requests);
  EXPECT_TRUE(nothing.added.empty() && nothing.removed.empty());
  EXPECT_EQ(requests.take_ids(5), 4u);
  EXPECT_EQ(requests.take_ids(), 9u);
}

TEST(Requests, OnlyExistingPointsCanBeRemovedAndOnlyOnce) {
  Requests requests(with_points(1));
  const auto id = requests.add({12, 13});
  EXPECT_FALSE(requests.remove(77));
  for (const FeatureId each : {FeatureId{0}, id}) {
    EXPECT_TRUE(requests.remove(each)) << each;
    EXPECT_FALSE(requests.remove(each)) << each;
  }
  take(requests);
  requests.report({});
  EXPECT_FALSE(requests.remove(id)) << "ended";
}

// The current frame has taken the request, but has not reported the point yet.
TEST(Requests, APointMayBeRemovedDuringItsFirstFrame) {
  Requests requests(with_points(0));
  const auto id = requests.add({12, 13});
  take(requests);
  EXPECT_EQ(requests.remove_nearest({12, 13}), no_feature) << "not in a picture yet";
  EXPECT_TRUE(requests.remove(id));
  requests.report({{id, {12, 13}, true}});
  EXPECT_FALSE(requests.remove(id)) << "twice";
  EXPECT_EQ(take(requests).removed, (std::vector<FeatureId>{id}));
}

// The current frame will end the point, but has not reported that yet.
TEST(Requests, APointAboutToEndIsGone) {
  Requests requests(with_points(2));
  EXPECT_TRUE(requests.remove(1));
  take(requests);
  EXPECT_FALSE(requests.remove(1)) << "removed before";
  EXPECT_EQ(requests.remove_nearest({100, 100}), 0u) << "not 1 again";
}

TEST(Requests, TheNearestIsFromTheLastPicture) {
  Requests requests(with_points(0));
  requests.report({{3, {10, 10}, true}, {4, {20, 10}, true}, {5, {29, 10}, false}});
  EXPECT_EQ(requests.remove_nearest({30, 10}), 4u) << "5 is outside";
  EXPECT_EQ(requests.remove_nearest({30, 10}), 3u) << "4 is about to end";
  EXPECT_EQ(requests.remove_nearest({30, 10}), no_feature);
}

TEST(Requests, ThereAreAtMostTenThousandPoints) {
  Requests requests(with_points(max_points - 2));
  EXPECT_EQ(requests.add({1, 1}), max_points - 2);
  take(requests);
  EXPECT_EQ(requests.add({1, 1}), max_points - 1) << "during a frame";
  EXPECT_EQ(requests.add({1, 1}), no_feature);
  take(requests);
  EXPECT_EQ(requests.add({1, 1}), no_feature);
}

TEST(Requests, PointsFromTheStartHaveTheFirstIds) {
  Settings settings;
  settings.points_from_start = true;
  Requests requests(settings);
  EXPECT_EQ(requests.add({1, 1}), max_points);
}

TEST(Requests, AResetDropsEarlierRequests) {
  Requests requests(with_points(1));
  Requests::Taken taken;
  requests.add({1, 1});
  requests.take(taken);  // by a frame that fails
  requests.add({2, 2});
  requests.remove(0);
  requests.reset();
  const auto after = requests.add({3, 3});
  requests.take(taken);
  EXPECT_TRUE(taken.reset);
  EXPECT_EQ(ids(taken.added), (std::vector<FeatureId>{after}));
  EXPECT_TRUE(taken.removed.empty());
}

TEST(Requests, TheRequestsOfAFailedFrameComeFirst) {
  Requests requests(with_points(2));
  Requests::Taken taken;
  const auto first = requests.add({1, 1});
  requests.remove(0);
  requests.take(taken);
  const auto second = requests.add({2, 2});
  requests.remove(1);
  requests.take(taken);
  EXPECT_EQ(ids(taken.added), (std::vector<FeatureId>{first, second}));
  EXPECT_EQ(taken.removed, (std::vector<FeatureId>{0, 1}));
}

// Two threads send requests as fast as they can, while frames take them and report.
TEST(Requests, NoneIsLostBetweenThreads) {
  constexpr int each = 2000;
  Requests requests(with_points(0));
  std::atomic<int> at_work = 2;
  std::array<std::vector<FeatureId>, 2> left;
  std::vector<std::thread> threads;
  for (auto &own : left)
    threads.emplace_back([&] {
      for (int i = 0; i < each; ++i) {
        own.push_back(requests.add({1.0 * i, 20}));
        if (i % 10 == 9) {
          EXPECT_TRUE(requests.remove(own.back()));
          own.pop_back();
        }
      }
      --at_work;
    });
  std::vector<Requests::Known> there;
  const auto frame = [&] {
    const auto taken = take(requests);
    for (const auto id : taken.removed) std::erase_if(there, [id](const auto &k) { return k.id == id; });
    for (const auto &p : taken.added)
      if (std::find(taken.removed.begin(), taken.removed.end(), p.id) == taken.removed.end())
        there.push_back({p.id, p.position, true});
    requests.report(there);
  };
  while (at_work > 0) frame();
  for (auto &thread : threads) thread.join();
  frame();
  std::vector<FeatureId> expected, found;
  for (const auto &own : left) expected.insert(expected.end(), own.begin(), own.end());
  for (const auto &k : there) found.push_back(k.id);
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  EXPECT_EQ(expected.size(), 2u * each * 9 / 10);
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace csd
