// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/csd.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <opencv2/imgproc.hpp>

#include "algorithms/make_algorithm.h"
#include "track/moving_scene.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace csd {
namespace {

constexpr std::int64_t frame_time = second / 25;

cv::Point2d sway(int frame) {
  return {9 * std::sin(frame * 0.15), 6 * std::sin(frame * 0.1)};
}

Settings at(std::vector<cv::Point2d> points) {
  Settings settings;
  settings.algorithm = AlgorithmKind::csd;
  settings.points = std::move(points);
  settings.content_area = ContentArea::full;
  return settings;
}

using Scene = std::function<cv::Mat(int)>;

std::vector<Tracks> run(const Settings &settings, int frames, const Scene &scene, unsigned threads = 1) {
  ThreadPool pool(threads);
  Tracker tracker(settings, make_algorithm(settings, pool));
  std::vector<Tracks> all;
  for (int i = 0; i < frames; ++i) {
    const auto picture = scene(i);
    all.push_back(tracker.process(MovingScene::view(picture), i * frame_time));
  }
  return all;
}

cv::Mat swaying(int frame) {
  static const MovingScene scene;
  return scene.render(sway(frame));
}

bool claims(const Feature &f) {
  return claims_position(f.state);
}

double error(const Feature &f, cv::Point2d start, int frame) {
  const auto there = start + sway(frame) - sway(0);
  return std::hypot(f.x - there.x, f.y - there.y);
}

const std::vector<cv::Point2d> some{{60, 60}, {160, 120}, {250, 70}, {90.5, 180.25}, {240, 170}};

TEST(Csd, FollowsTheTextureClosely) {
  const auto all = run(at(some), 60, swaying);
  for (int i = 0; i < 60; ++i)
    for (const auto &f : all[static_cast<std::size_t>(i)].features) {
      EXPECT_TRUE(claims(f)) << f.id << " in frame " << i;
      EXPECT_LT(error(f, some[f.id], i), 0.3) << f.id << " in frame " << i;
      // Half a second of training ends here.
      if (i != 12 && i != 13) {
        EXPECT_EQ(f.state, i < 12 ? FeatureState::learning : FeatureState::tracked) << i;
      }
    }
}

TEST(Csd, AWetLensHidesAFadeDoesNot) {
  constexpr int begins = 20, ends = 32;
  const auto spoilt = [](auto spoil) {
    return run(at(some), 60, [spoil](int i) {
      cv::Mat picture = swaying(i);
      if (i >= begins && i < ends) spoil(picture, i);
      return picture;
    });
  };
  const auto wet = spoilt([](cv::Mat &p, int i) { cv::GaussianBlur(p, p, {}, std::min(i - begins + 1, 4)); });
  const auto faded = spoilt([](cv::Mat &p, int) { p.convertTo(p, -1, 0.4, 90); });
  for (std::size_t i = 0; i < 60; ++i)
    for (std::size_t k = 0; k < some.size(); ++k) {
      EXPECT_TRUE(claims(faded[i].features[k])) << k << " in frame " << i;
      const auto &f = wet[i].features[k];
      if (i < begins || i >= ends + 3) {
        EXPECT_TRUE(claims(f)) << k << " in frame " << i;
      } else if (i >= begins + 3 && i < ends) {
        EXPECT_FALSE(claims(f)) << k << " in frame " << i;
        EXPECT_EQ(f.confidence, 0);
      }
    }
}

TEST(Csd, OnePointHasTheSameTrackAloneAndAmongMany) {
  std::vector<cv::Point2d> many;
  for (int i = 0; i < 100; ++i) many.emplace_back(25 + 30 * (i % 10), 20 + 22 * (i / 10));
  const auto among = run(at(many), 40, swaying), alone = run(at({many[44]}), 40, swaying);
  for (std::size_t i = 0; i < 40; ++i) {
    const auto &a = among[i].features[44], &b = alone[i].features[0];
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.y, b.y);
    EXPECT_EQ(a.state, b.state);
    EXPECT_EQ(a.confidence, b.confidence);
  }
}

TEST(Csd, ClaimsExactlyWhatItBelieves) {
  // A cover slides over the right half.
  const auto all = run(at(some), 50, [](int frame) {
    auto picture = swaying(frame);
    if (frame >= 20 && frame < 40) picture.colRange(150, 320).setTo(cv::Scalar(60, 60, 60));
    return picture;
  });
  int hidden = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const auto &f : all[i].features) {
      EXPECT_EQ(claims(f), f.confidence >= 0.5);
      if (i >= 20 && i < 40 && some[f.id].x > 200) hidden += !claims(f);
    }
  EXPECT_EQ(hidden, 2 * 20);
  for (const auto &f : all[42].features) {
    EXPECT_TRUE(claims(f)) << f.id;
    EXPECT_LT(error(f, some[f.id], 42), 0.5);
  }
}

TEST(Csd, ClaimsNothingInBlackOrInAnotherScene) {
  const MovingScene other({320, 240}, 9);
  const auto all = run(at(some), 80, [&](int frame) {
    if (frame >= 20 && frame < 40) return cv::Mat(cv::Mat::zeros(240, 320, CV_8UC3));
    return frame >= 40 && frame < 70 ? other.render(sway(frame)) : swaying(frame);
  });
  for (std::size_t i = 20; i < 70; ++i)
    for (const auto &f : all[i].features) EXPECT_FALSE(claims(f)) << f.id << " in frame " << i;
  for (const auto &f : all[75].features) {
    EXPECT_TRUE(claims(f)) << f.id;
    EXPECT_LT(error(f, some[f.id], 75), 0.5);
  }
}

TEST(Csd, ClaimsAFeatureInTheFrameInWhichTheSceneComesBack) {
  constexpr int begin = 30, end = 40;
  const auto all = run(at(some), end + 1, [](int frame) {
    return frame >= begin && frame < end ? cv::Mat(cv::Mat::zeros(240, 320, CV_8UC3)) : swaying(frame);
  });
  for (const auto &f : all[end - 1].features) EXPECT_FALSE(claims(f)) << f.id;
  for (const auto &f : all[end].features) {
    EXPECT_TRUE(claims(f)) << f.id;
    EXPECT_LT(error(f, some[f.id], end), 0.5) << f.id;
  }
}

// The pictures have the sensor's noise throughout.
TEST(Csd, SurvivesAMinuteOfBlack) {
  constexpr int begin = 30, end = begin + 60 * 25, frames = end + 15;
  cv::RNG rng(5);
  cv::Mat noise(240, 320, CV_8UC3);
  const auto all = run(at(some), frames, [&](int frame) {
    if (frame < begin || frame >= end) return swaying(frame);
    rng.fill(noise, cv::RNG::NORMAL, 12, 2);
    return noise;
  });
  for (std::size_t i = begin; i < end; ++i)
    for (const auto &f : all[i].features) ASSERT_FALSE(claims(f)) << f.id << " in frame " << i;
  for (const auto &f : all[frames - 1].features) {
    EXPECT_TRUE(claims(f)) << f.id;
    EXPECT_LT(error(f, some[f.id], frames - 1), 0.5);
  }
}

TEST(Csd, TracksTheSameFrom240To960Lines) {
  const auto small = run(at(some), 40, swaying);
  for (const int times : {2, 4}) {
    std::vector<cv::Point2d> larger;
    for (const auto &p : some) larger.push_back(times * p + cv::Point2d(times - 1, times - 1) / 2);
    const auto large = run(at(larger), 40, [times](int frame) {
      cv::Mat out;
      cv::resize(swaying(frame), out, {}, times, times, cv::INTER_CUBIC);
      return out;
    });
    for (std::size_t i = 0; i < 40; ++i)
      for (std::size_t k = 0; k < some.size(); ++k) {
        const auto &a = small[i].features[k], &b = large[i].features[k];
        EXPECT_EQ(a.state, b.state) << k << " in frame " << i << " at " << times;
        const double off = (times - 1) / 2.0;
        EXPECT_LT(std::hypot((b.x - off) / times - a.x, (b.y - off) / times - a.y), 0.15)
            << k << " in frame " << i << " at " << times;
      }
  }
}

TEST(Csd, TracksTheSameFrom15To100FramesASecond) {
  // Half a second of training ends between the second and the third of these samples.
  constexpr std::int64_t apart = second / 5;
  for (const int rate : {15, 25, 100}) {
    ThreadPool pool(1);
    Tracker tracker(at(some), make_algorithm(at(some), pool));
    const auto where = [](std::int64_t time) {
      const double t = static_cast<double>(time) / static_cast<double>(second);
      return cv::Point2d(9 * std::sin(4 * t), 6 * std::sin(2.5 * t));
    };
    const MovingScene scene;
    for (int i = 0; i <= 2 * rate; ++i) {
      const auto time = i * second / rate;
      const auto picture = scene.render(where(time));
      const auto &tracks = tracker.process(MovingScene::view(picture), time, second / rate);
      if (i % (rate / 5) != 0) continue;
      for (const auto &f : tracks.features) {
        const auto there = some[f.id] + where(time);
        EXPECT_LT(std::hypot(f.x - there.x, f.y - there.y), 0.15) << f.id << " at " << i << " of " << rate;
        EXPECT_EQ(f.state, time < 3 * apart ? FeatureState::learning : FeatureState::tracked) << i << " of " << rate;
        EXPECT_GT(f.confidence, 0.9) << f.id << " at " << i << " of " << rate;
      }
    }
  }
}

/// How many points are claimed in the frame after the view jumps, at frame 30. Each claim must be right.
std::size_t claims_after_a_jump(bool discont, std::int64_t gap) {
  ThreadPool pool(1);
  Tracker tracker(at(some), make_algorithm(at(some), pool));
  std::size_t claimed = 0;
  for (int i = 0; i <= 30; ++i) {
    const cv::Point2d jump = i < 30 ? cv::Point2d() : cv::Point2d(16, -16);
    const auto picture = MovingScene().render(sway(i) + jump);
    const auto &tracks = tracker.process(MovingScene::view(picture), i * frame_time + (i < 30 ? 0 : gap), frame_time,
                                         discont && i == 30);
    if (i == 30)
      for (const auto &f : tracks.features)
        if (claims(f)) {
          ++claimed;
          EXPECT_LT(error(f, some[f.id] + jump, i), 0.3) << f.id;
        }
  }
  return claimed;
}

TEST(Csd, AfterAJumpItSearchesForEachPointAgain) {
  // The jump is larger than the expected motion of a frame. Most points claim nothing; the unmistakable ones are right.
  EXPECT_LT(claims_after_a_jump(false, 0), some.size() / 2);
  EXPECT_EQ(claims_after_a_jump(true, 0), some.size());
  EXPECT_EQ(claims_after_a_jump(false, second), some.size()) << "the stamps jump";
  EXPECT_EQ(claims_after_a_jump(false, 20 * second), some.size()) << "longer than lost points are kept";
}

TEST(Csd, PastTheBudgetTheLeastUrgentWaitButNotForEver) {
  std::vector<cv::Point2d> many;
  for (int i = 0; i < 60; ++i) many.emplace_back(30 + 28 * (i % 10), 30 + 36 * (i / 10));
  Settings settings = at(many);
  std::int64_t now = 0;
  settings.clock = [&now] { return now += 1000; };  // a microsecond a point
  settings.frame_budget = 100 * 1000;
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  std::vector<int> waits(many.size());
  std::vector<double> seen_with(many.size(), 1);
  std::uint64_t waited = 0;
  for (int i = 0; i < 60; ++i) {
    const auto picture = swaying(i);
    std::size_t aligned = 0;
    for (const auto &f : tracker.process(MovingScene::view(picture), i * frame_time, frame_time).features) {
      aligned += f.fresh;
      waited += !f.fresh;
      waits[f.id] = f.fresh ? 0 : waits[f.id] + 1;
      EXPECT_LE(waits[f.id], 5) << f.id << " in frame " << i;
      EXPECT_TRUE(claims(f)) << f.id << " in frame " << i;
      EXPECT_LT(error(f, many[f.id], i), 1) << f.id << " in frame " << i;
      EXPECT_TRUE(f.fresh || f.confidence < seen_with[f.id]) << "confidence fades";
      seen_with[f.id] = f.confidence;
    }
    if (i > 0) {
      EXPECT_GE(aligned, 20u) << i;
      EXPECT_LT(aligned, many.size()) << i;
    }
  }
  EXPECT_EQ(tracker.stats().waited, waited);
}

TEST(Csd, AnExhaustedBudgetStillAlignsOneFeatureAFrame) {
  std::vector<cv::Point2d> many;
  for (int i = 0; i < 20; ++i) many.emplace_back(40 + 50 * (i % 5), 40 + 50 * (i / 5));
  Settings settings = at(many);
  settings.frame_budget = 1;
  settings.training_time = 10 * second;  // otherwise none would end it
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  std::vector<int> times(many.size());
  for (int i = 0; i <= 40; ++i) {
    const auto picture = swaying(i);
    std::size_t aligned = 0;
    for (const auto &f : tracker.process(MovingScene::view(picture), i * frame_time, frame_time).features) {
      aligned += f.fresh;
      times[f.id] += i > 0 && f.fresh;
    }
    EXPECT_EQ(aligned, i == 0 ? many.size() : 1) << i;
  }
  // Unreliable or fast features are twice as urgent: each is aligned within two rounds.
  for (std::size_t k = 0; k < many.size(); ++k) EXPECT_GE(times[k], 1) << k;
}

TEST(Csd, ReplacesAndForgetsFeatures) {
  Settings settings = at({});
  settings.max_features = 20;
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  for (int i = 0; i < 5; ++i) {
    const auto picture = swaying(i);
    tracker.process(MovingScene::view(picture), i * frame_time);
  }
  const auto first = tracker.stats().detected;
  EXPECT_EQ(first, 20u);
  tracker.reset();
  for (int i = 5; i < 8; ++i) {
    const auto picture = swaying(i);
    const auto &tracks = tracker.process(MovingScene::view(picture), i * frame_time);
    if (i == 7) {
      ASSERT_FALSE(tracks.features.empty());
      for (const auto &f : tracks.features) EXPECT_TRUE(f.id >= first && claims(f)) << f.id;
    }
  }
}

/// 40 frames of 30 detected features. `change` alters each picture.
std::vector<Tracks> detected(bool replenish, const std::function<void(int, cv::Mat &)> &change) {
  Settings settings = at({});
  settings.max_features = 30;
  settings.replenish = replenish;
  return run(settings, 40, [&](int i) {
    cv::Mat bgr = swaying(i);
    change(i, bgr);
    return bgr;
  });
}

/// Where the ended features had begun.
std::vector<double> ended(const std::vector<Tracks> &all) {
  std::map<FeatureId, double> starts;
  std::vector<double> out;
  for (const auto &tracks : all)
    for (const auto &f : tracks.features) {
      starts.emplace(f.id, f.x);
      if (f.state == FeatureState::ended) out.push_back(starts[f.id]);
    }
  return out;
}

TEST(Csd, AFeatureHiddenAloneWhileLearningEndsAndIsReplaced) {
  const auto covered_from = [](int begin) {
    return [begin](int i, cv::Mat &bgr) {
      if (i >= begin) bgr(cv::Rect(0, 0, 160, 240)).setTo(cv::Scalar(70, 90, 150));
    };
  };
  const auto all = detected(true, covered_from(5));
  const auto gone = ended(all);
  EXPECT_GE(gone.size(), 8u);
  for (const double x : gone) EXPECT_LT(x, 175);
  EXPECT_GE(std::count_if(all.back().features.begin(), all.back().features.end(),
                          [](const Feature &f) { return f.id >= 30 && f.x > 150 && claims(f); }),
            5);
  EXPECT_TRUE(ended(detected(true, covered_from(20))).empty()) << "learnt by then";
  EXPECT_TRUE(ended(detected(false, covered_from(5))).empty()) << "nothing would replace them";
  const auto black = [](int i, cv::Mat &bgr) {
    if (i >= 5 && i < 8) bgr.setTo(cv::Scalar::all(3));
  };
  EXPECT_TRUE(ended(detected(true, black)).empty()) << "everything is hidden";
}

TEST(Csd, NoFeatureBeginsOnATool) {
  cv::Mat bgr = swaying(0), gray;
  auto tool = bgr(cv::Rect(0, 0, 160, 240));
  cv::cvtColor(tool, gray, cv::COLOR_BGR2GRAY);
  cv::cvtColor(gray, tool, cv::COLOR_GRAY2BGR);
  const auto on_tool = [&](AlgorithmKind kind) {
    Settings settings = at({});
    settings.algorithm = kind;
    const auto features = run(settings, 1, [&](int) { return bgr; })[0].features;
    EXPECT_GT(features.size(), 20u);
    return std::count_if(features.begin(), features.end(), [](const Feature &f) { return f.x < 160; });
  };
  EXPECT_GT(on_tool(AlgorithmKind::lk), 5);
  EXPECT_EQ(on_tool(AlgorithmKind::csd), 0);
}

TEST(Csd, TracksAreTheSameForAnyNumberOfThreads) {
  const auto one = run(at(some), 60, swaying), five = run(at(some), 60, swaying, 5);
  for (std::size_t i = 0; i < one.size(); ++i)
    for (std::size_t k = 0; k < some.size(); ++k) {
      const auto &a = one[i].features[k], &b = five[i].features[k];
      ASSERT_TRUE(a.x == b.x && a.y == b.y && a.state == b.state && a.confidence == b.confidence) << i << ' ' << k;
    }
}

}  // namespace
}  // namespace csd
