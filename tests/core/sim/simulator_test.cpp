// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace csd::sim {
namespace {

const cv::Size small{320, 240};

SimSettings with(const std::string &effects, cv::Size size = small) {
  SimSettings s;
  s.effects = Effects();
  s.effects.set(effects);
  s.size = size;
  return s;
}

/// Coloured blobs, which are quicker to make than tissue.
cv::Mat blobs() {
  cv::Mat noise(480, 640, CV_32FC3), picture;
  cv::RNG(3).fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::GaussianBlur(noise, noise, {}, 3);
  noise.convertTo(picture, CV_8U, 240, 120);
  return picture;
}

cv::Mat frame(Simulator &simulator, std::uint64_t n) {
  cv::Mat picture;
  simulator.render(n, picture);
  return picture;
}

bool same(const cv::Mat &a, const cv::Mat &b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

const char *const everything =
    "heart-strong,heart-mild,liver,fold,slide,tear,grasp,zoom,rotation,sway,jerk,tools,smoke,specular,blood,"
    "irrigation,wipe,cut,black,field-stop,text,light,exposure,falloff,vignette,low-texture,motion-blur,focus-blur,"
    "noise,chroma,interlacing";

TEST(Simulator, AFrameDependsOnlyOnItsNumber) {
  Simulator forward(with(everything)), backward(with(everything));
  const std::uint64_t numbers[] = {0, 3, 70, 112, 129, 160, 215, 300, 1234};
  std::map<std::uint64_t, cv::Mat> pictures;
  for (const auto n : numbers) pictures[n] = frame(forward, n);
  std::vector<cv::Point2d> surface;
  for (int x = 20; x < 300; x += 40) surface.emplace_back(x - 160, 0.3 * x - 60);
  for (auto n = std::rbegin(numbers); n != std::rend(numbers); ++n) {
    const auto before = backward.truth(*n, surface);  // truth needs no picture, and changes none
    EXPECT_TRUE(same(frame(backward, *n), pictures[*n])) << "frame " << *n;
    const auto after = forward.truth(*n, surface);
    for (std::size_t i = 0; i < surface.size(); ++i) {
      EXPECT_EQ(before[i].x, after[i].x);
      EXPECT_EQ(before[i].y, after[i].y);
      EXPECT_EQ(before[i].visibility, after[i].visibility);
      EXPECT_EQ(before[i].id, i);
    }
  }
}

TEST(Simulator, AnotherSeedGivesAnotherScene) {
  SimSettings settings = with("heart-mild");
  Simulator one(settings);
  settings.seed = 2;
  Simulator two(settings);
  EXPECT_GT(cv::norm(frame(one, 0), frame(two, 0), cv::NORM_L1), 5.0 * 3 * small.area());
}

// Each effect shows at strength 1 in at least one of the frames, and not at strength 0.
class EachEffect : public testing::TestWithParam<std::size_t> {};

TEST_P(EachEffect, IsVisibleAndCanBeAbsent) {
  const auto effect = static_cast<Effect>(GetParam());
  // Motion blur and two fields need something that moves; falloff needs tissue and lamp to move apart.
  SimSettings settings = with("heart-strong=1.2,sway");
  settings.texture = blobs();
  SimSettings zero = settings;
  zero.effects.set(std::string(effect_name(effect)) + "=0");
  Simulator absent(zero);
  // For an effect that is off, strength 0 changes nothing. For one that is on, by default or in this test, it does.
  const bool named = settings.effects[effect] != 0;
  Simulator unnamed(settings);
  settings.effects[effect] = 1;
  Simulator present(settings);
  bool differs = false;
  for (const std::uint64_t n : {40U, 105U, 130U, 155U, 170U, 240U, 300U}) {
    const cv::Mat base = frame(absent, n);
    EXPECT_TRUE(named || same(base, frame(unnamed, n)));
    differs |= !same(base, frame(present, n));
  }
  EXPECT_TRUE(differs) << effect_name(effect);
}

INSTANTIATE_TEST_SUITE_P(All, EachEffect, testing::Range(std::size_t{0}, effect_count), [](const auto &effect) {
  std::string name(effect_name(static_cast<Effect>(effect.param)));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(Simulator, CutPulledOrHollowTissueMovesFromRest) {
  Simulator plain(with("", {640, 480}));
  for (const char *effect : {"slide", "tear", "grasp", "cavity"}) {
    Simulator simulator(with(effect, {640, 480}));
    std::vector<cv::Point2d> surface;
    for (double v = -160; v <= 160; v += 20)
      for (double u = -240; u <= 240; u += 20) surface.emplace_back(u, v);
    const auto at = [&](std::uint64_t n) { return simulator.truth(n, surface); };
    const auto farthest = [&](const std::vector<TruthPoint> &a, const std::vector<TruthPoint> &b) {
      double most = 0;
      for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::hypot(a[i].x - b[i].x, a[i].y - b[i].y));
      return most;
    };
    EXPECT_LT(farthest(at(0), at(1)), 0.2) << effect;
    EXPECT_GT(farthest(at(0), at(75)), 12) << effect;
    // A cut and a grip start out as normal tissue.
    const bool later = effect == std::string("tear") || effect == std::string("grasp");
    const auto difference = [&](std::uint64_t n) {  // mean grey levels; their meshes start elsewhere
      return cv::norm(frame(simulator, n), frame(plain, n), cv::NORM_L1) / (3.0 * 640 * 480);
    };
    EXPECT_EQ(difference(0) < 0.1, later) << effect << ' ' << difference(0);
    EXPECT_GT(difference(75), 1) << effect;
  }
}

TEST(Simulator, RefusesWhatItCannotRender) {
  for (const cv::Size size : {cv::Size(0, 0), {15, 100}, {100, 15}, {8193, 100}}) {
    EXPECT_THROW(Simulator{with("", size)}, std::invalid_argument);
  }
  for (const double rate :
       {0.0, -25.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    SimSettings s = with("");
    s.rate = rate;
    EXPECT_THROW(Simulator{s}, std::invalid_argument);
  }
  SimSettings grey = with("");
  grey.texture = cv::Mat(100, 100, CV_8UC1, cv::Scalar(7));
  EXPECT_THROW(Simulator{grey}, std::invalid_argument);
  EXPECT_THROW(Simulator(with("")).of_texture({1, 1}), std::logic_error);
}

TEST(Simulator, RendersAnySize) {
  for (const cv::Size size : {cv::Size(16, 16), {101, 77}, {640, 480}, {720, 1280}}) {
    SimSettings settings = with(everything, size);
    settings.texture = blobs();
    Simulator simulator(settings);
    EXPECT_EQ(frame(simulator, 55).size(), size);
  }
}

// The surface comes through the lens, and noise beyond 64 bits is requested. UBSan found each undefined.
TEST(Simulator, AcceptsTheStrongestEffectsAndTheLatestTimes) {
  std::string strongest;
  for (std::size_t e = 0; e < effect_count; ++e) strongest += std::string(effect_name(static_cast<Effect>(e))) + "=4,";
  strongest.pop_back();
  for (const std::string &effects : {strongest, std::string("zoom=4,heart-strong=4,motion-blur=4")}) {
    SimSettings settings = with(effects.c_str(), {64, 48});
    settings.rate = 3;
    Simulator simulator(settings);
    for (int n = 0; n < 60; ++n) EXPECT_EQ(frame(simulator, n).size(), settings.size);
  }
  SimSettings settings = with("smoke,exposure,light,blood,tools", {64, 48});
  settings.rate = 1e-10;
  Simulator slow(settings);
  for (const std::uint64_t n : {1U, 77U, ~0U}) EXPECT_EQ(frame(slow, n).size(), settings.size);
}

TEST(Simulator, RefusesImpossibleSizes) {
  for (const cv::Size size : {cv::Size(15, 16), {16, 15}, {8193, 8192}, {16 * 16 + 1, 16}, {16, 16 * 16 + 1}})
    EXPECT_THROW(Simulator(with("", size)), std::invalid_argument) << size;
}

TEST(Simulator, TimeGoesBySecondsNotByFrames) {
  SimSettings settings = with("heart-mild,zoom,smoke,tools");
  Simulator at25(settings);
  settings.rate = 50;
  Simulator at50(settings);
  EXPECT_TRUE(same(frame(at25, 60), frame(at50, 120)));
}

TEST(Simulator, GoesOnInTimeAtAnotherRate) {
  // Ten frames in the first second, then fifty a second: frames 10, 15 and 20 are those of 1, 1.1 and 1.2 s.
  SimSettings slow = with("heart-strong,sway,tools,motion-blur"), fast = slow;
  slow.rate = 10;
  fast.rate = 50;
  Simulator changed(slow), even(fast);
  const std::vector<cv::Point2d> surface{{-100, 20}, {0, 0}, {130, -60}};
  changed.truth(10, surface);
  changed.retime(50, 10, 1);
  EXPECT_EQ(changed.settings().rate, 50);
  for (const std::uint64_t n : {10, 15, 20}) {
    const auto a = changed.truth(n, surface), b = even.truth(n + 40, surface);
    for (std::size_t i = 0; i < surface.size(); ++i) {
      EXPECT_NEAR(a[i].x, b[i].x, 1e-9);
      EXPECT_NEAR(a[i].y, b[i].y, 1e-9);
      EXPECT_EQ(a[i].visibility, b[i].visibility);
    }
    // The shutter is the new rate's, too; without noise nothing depends on the number.
    EXPECT_LE(cv::norm(frame(changed, n), frame(even, n + 40), cv::NORM_INF), 1);
  }
  EXPECT_THROW(changed.retime(0, 0, 0), std::invalid_argument);
}

TEST(Simulator, FindsFeaturesInTheFirstFrameAndCastsThemBack) {
  Simulator simulator(with("heart-mild,noise", {640, 480}));
  const auto features = simulator.detect(100);
  EXPECT_GE(features.size(), 80U);
  const auto surface = simulator.on_surface(0, features);
  const auto truth = simulator.truth(0, surface);
  for (std::size_t i = 0; i < features.size(); ++i) {
    EXPECT_NEAR(truth[i].x, features[i].x, 1e-6);
    EXPECT_NEAR(truth[i].y, features[i].y, 1e-6);
    EXPECT_EQ(truth[i].visibility, Visibility::visible);
  }
}

TEST(Simulator, CastsPixelsOfAnyFrameBack) {
  Simulator simulator(with("heart-strong,liver,fold,zoom,rotation,sway", {640, 480}));
  for (const std::uint64_t n : {77U, 200U, 380U}) {
    std::vector<cv::Point2d> pixels;
    for (int y = 5; y < 480; y += 47)
      for (int x = 3; x < 640; x += 53) pixels.emplace_back(x + 0.3, y - 0.2);
    const auto truth = simulator.truth(n, simulator.on_surface(n, pixels));
    int good = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i)
      good += std::hypot(truth[i].x - pixels[i].x, truth[i].y - pixels[i].y) < 1e-6;
    // On the edge of a fold, a pixel shows two places.
    EXPECT_GE(good, static_cast<int>(pixels.size()) - 2) << "frame " << n;
  }
}

TEST(Simulator, RefusesPixelsWithoutTissue) {
  Simulator simulator(with("heart-mild,sway", {640, 480}));
  const auto refused = [&](cv::Point2d pixel) {
    try {
      simulator.on_surface(0, std::vector<cv::Point2d>{{320, 240}, pixel});
      return std::string();
    } catch (const std::invalid_argument &e) {
      return std::string(e.what());
    }
  };
  EXPECT_NE(refused({50, -1e9}).find("50,-1e+09"), std::string::npos) << refused({50, -1e9});
  EXPECT_NE(refused({std::numeric_limits<double>::quiet_NaN(), 3}), "");
  EXPECT_NE(refused({std::numeric_limits<double>::infinity(), 3}), "");
  // Elsewhere it is either refused or exactly in place.
  int found = 0;
  for (double far = 1; far < 1e12; far *= 3) {
    for (const cv::Point2d away : {cv::Point2d(1, 0), {0, 1}, {-1, 0}, {0, -1}, {0.6, -0.8}}) {
      const cv::Point2d pixel = cv::Point2d(320, 240) + far * away;
      if (!refused(pixel).empty()) continue;
      const auto truth = simulator.truth(0, simulator.on_surface(0, std::vector<cv::Point2d>{pixel}));
      EXPECT_NEAR(truth[0].x, pixel.x, 1e-5) << pixel;
      EXPECT_NEAR(truth[0].y, pixel.y, 1e-5) << pixel;
      ++found;
    }
  }
  EXPECT_GT(found, 25);
}

// Tissue as in the clips: around features, a patch's luma has a deviation of 11 to 19 grey levels.
class EachStyle : public testing::TestWithParam<std::size_t> {};

TEST_P(EachStyle, HasTheContrastOfTissue) {
  for (const std::uint64_t seed : {2U, 3U}) {
    SimSettings settings = with("vignette,noise,chroma", {640, 480});
    settings.style = static_cast<Style>(GetParam());
    settings.seed = seed;
    Simulator simulator(settings);
    cv::Mat luma;
    cv::cvtColor(frame(simulator, 0), luma, cv::COLOR_BGR2GRAY);
    const auto features = simulator.detect(100);
    ASSERT_GE(features.size(), 80U);
    for (const int side : {15, 21, 31}) {
      std::vector<double> deviations;
      for (const auto &f : features) {
        const cv::Rect patch(cvRound(f.x) - side / 2, cvRound(f.y) - side / 2, side, side);
        if ((patch & cv::Rect({}, luma.size())) != patch) continue;
        cv::Scalar mean, deviation;
        cv::meanStdDev(luma(patch), mean, deviation);
        deviations.push_back(deviation[0]);
      }
      std::nth_element(deviations.begin(), deviations.begin() + static_cast<std::ptrdiff_t>(deviations.size() / 2),
                       deviations.end());
      const double median = deviations[deviations.size() / 2];
      std::printf("%-10s seed %d, %d px: %.1f\n", std::string(style_name(settings.style)).c_str(),
                  static_cast<int>(seed), side, median);
      EXPECT_GE(median, 11);
      EXPECT_LE(median, settings.style == Style::speckle ? 75 : 19);  // speckle is no tissue
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, EachStyle, testing::Range(std::size_t{0}, style_count),
                         [](const auto &style) { return std::string(style_name(static_cast<Style>(style.param))); });

TEST(Simulator, NoiseMatchesTheClips) {
  Simulator clean(with("vignette", {640, 480})), noisy(with("vignette,noise", {640, 480}));
  cv::Mat a, b, difference;
  cv::cvtColor(frame(clean, 10), a, cv::COLOR_BGR2GRAY);
  cv::cvtColor(frame(noisy, 10), b, cv::COLOR_BGR2GRAY);
  cv::subtract(b, a, difference, cv::noArray(), CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(difference, mean, deviation);
  EXPECT_NEAR(mean[0], 0, 0.05);
  EXPECT_NEAR(deviation[0], 2, 0.4);
}

}  // namespace
}  // namespace csd::sim
