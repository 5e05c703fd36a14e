// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/snapshot.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <thread>
#include <vector>

#include "csd2012/smoothed.h"
#include "image/convert.h"
#include "image/patch.h"
#include "track/moving_scene.h"

namespace csd {
namespace {

constexpr ColourSpace intensity{1, 1, 1}, red_less_blue{1, 0, -1};

// A cut-out equals the smoothed patch, also over the edge.
TEST(Snapshot, ACutOutOfTheChannelIsTheSmoothedPatch) {
  Snapshot snapshot;
  snapshot.bgr = MovingScene().render({0, 0});
  const int margin = csd2012::smoothing_margin(2);
  for (const auto &space : {intensity, red_less_blue}) {
    const auto &[raw, smoothed] = snapshot.in(space, 2, 10);
    cv::Mat channel, grown, patch;
    to_space(snapshot.bgr, space, channel);
    EXPECT_EQ(cv::norm(raw, channel, cv::NORM_INF), 0);
    for (const auto p : {cv::Point(160, 120), cv::Point(1, 2), cv::Point(0, 0)}) {
      sample_patch(channel, p, 21 + 2 * margin, grown);
      csd2012::smooth(grown, 2, patch);
      EXPECT_EQ(cv::norm(smoothed({p.x, p.y, 21, 21}), patch, cv::NORM_INF), 0) << p;
    }
  }
}

TEST(Snapshot, AllLearnersShareOneChannel) {
  Snapshot snapshot;
  snapshot.bgr = MovingScene().render({0, 0});
  std::vector<const Snapshot::Channel *> seen(8);
  std::vector<std::thread> learners;
  for (std::size_t i = 0; i < seen.size(); ++i)
    learners.emplace_back([&, i] { seen[i] = &snapshot.in(i % 2 == 0 ? intensity : red_less_blue, 2, 10); });
  for (auto &learner : learners) learner.join();
  for (std::size_t i = 2; i < seen.size(); ++i) EXPECT_EQ(seen[i], seen[i % 2]);
  EXPECT_NE(seen[0], seen[1]);
  EXPECT_EQ(seen[0]->smoothed.rows, snapshot.bgr.rows + 20);
}

}  // namespace
}  // namespace csd
