// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/gray_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "image/samples.h"

namespace csd {
namespace {

constexpr std::int64_t frame = 40'000'000;  // ns

/// A 16-bit picture of little-endian words, on any machine.
struct Gray16 {
  std::vector<std::uint8_t> bytes;
  FrameView view;

  Gray16(int width, int height, const std::function<int(int)> &level) {
    const int pixels = width * height;
    for (int i = 0; i < pixels; ++i)
      for (const int v = std::clamp(level(i), 0, 65535); const int byte : {v & 255, v >> 8})
        bytes.push_back(static_cast<std::uint8_t>(byte));
    view.width = width;
    view.height = view.rows = height;
    view.open_range = true;
    view.component[0] = {.data = bytes.data(), .row_stride = 2 * width, .pixel_stride = 2, .bytes = 2, .shift = 8};
  }
  Gray16(const Gray16 &) = delete;
  Gray16 &operator=(const Gray16 &) = delete;

  std::vector<std::uint8_t> seen(const FrameView &through) const {
    std::vector<std::uint8_t> out(static_cast<std::size_t>(view.width));
    read_samples(through, 0, 0, 0, view.width, out.data());
    return out;
  }
};

/// 100 × 100, so that no pixel is skipped. Levels start at `low`, `step` apart, each in a hundredth of the pixels.
Gray16 hundred(int low, double step) {
  return {100, 100, [=](int i) { return static_cast<int>(std::lround(low + step * (i % 100))); }};
}

TEST(GrayWindow, IsThePicturesRangePlusATwelfthOnEitherSide) {
  // 1000 … 10999, once each. 50 pixels are below the range and 50 above, so it is 1050 … 10949.
  const Gray16 picture(100, 100, [](int i) { return 1000 + i; });
  GrayWindow window;
  const FrameView view = window.look(picture.view, 0);
  EXPECT_DOUBLE_EQ(window.black(), 1050 - 9899 / 12.0);
  EXPECT_DOUBLE_EQ(window.white(), 10949 + 9899 / 12.0);
  EXPECT_EQ(view.component[0].black, 225);
  EXPECT_EQ(view.component[0].gain, 1452);  // 2^24 / 11548.83 = 1452.7
  for (const auto &[level, is] :
       {std::pair{0, 0}, {225, 0}, {270, 0}, {271, 1}, {6000, 127}, {11773, 255}, {65535, 255}}) {
    const Gray16 one(1, 1, [l = level](int) { return l; });
    FrameView through = one.view;
    through.component[0].black = view.component[0].black;
    through.component[0].gain = view.component[0].gain;
    EXPECT_EQ(one.seen(through)[0], is) << level;
  }
}

TEST(GrayWindow, ReadsWordsOfEitherOrder) {
  Gray16 little = hundred(1000, 10), big = hundred(1000, 10);
  for (std::size_t i = 0; i < big.bytes.size(); i += 2) std::swap(big.bytes[i], big.bytes[i + 1]);
  big.view.component[0].big_endian = true;
  GrayWindow one, other;
  const FrameView a = one.look(little.view, 0), b = other.look(big.view, 0);
  EXPECT_EQ(one.black(), other.black());
  EXPECT_EQ(one.white(), other.white());
  EXPECT_EQ(little.seen(a), big.seen(b));
}

TEST(GrayWindow, LeavesOtherPicturesAlone) {
  Gray16 picture = hundred(1000, 10);
  picture.view.open_range = false;
  GrayWindow window;
  EXPECT_EQ(window.look(picture.view, 0).component[0].gain, 0);
  picture.view.open_range = true;
  EXPECT_NE(window.look(picture.view, 0).component[0].gain, 0);
  EXPECT_EQ(window.look(FrameView{.open_range = true}, 0).component[0].gain, 0) << "nothing to look at";
}

TEST(GrayWindow, FewPixelsOfAnyLevelChangeNothing) {
  const auto with = [](int some, int level) {
    return Gray16(100, 100, [=](int i) { return i < some ? level : 1000 + i % 997; });
  };
  GrayWindow usual, glare, mask;
  usual.look(with(0, 0).view, 0);
  glare.look(with(40, 65535).view, 0);
  EXPECT_NEAR(glare.white(), usual.white(), 5);
  // An area of zeros, however large, is a mask and not part of the picture, unless the whole picture is zero.
  mask.look(with(6000, 0).view, 0);
  EXPECT_NEAR(mask.black(), usual.black(), 10);
  EXPECT_NEAR(mask.white(), usual.white(), 10);
  mask.look(with(10000, 0).view, frame);
  EXPECT_EQ(mask.black(), 0);
}

TEST(GrayWindow, LooksAtAGridOfLargePictures) {
  for (const auto &[width, height] : {std::pair{1920, 1080}, {20000, 1}, {1, 20000}, {2, 9000}, {1, 1}}) {
    const Gray16 picture(width, height,
                         [](int i) { return 2000 + static_cast<int>(i * 2654435761u >> 22); });  // … 3023
    GrayWindow window;
    window.look(picture.view, 0);
    if (width * height == 1) continue;
    EXPECT_NEAR(window.black(), 2000 - 85, 12) << width;
    EXPECT_NEAR(window.white(), 3023 + 85, 12) << width;
  }
}

TEST(GrayWindow, NeverStretchesALevelOverMoreThanOne) {
  const auto stretch = [](int levels, int step) {  // of the camera's own levels
    GrayWindow window;
    window.look(Gray16(100, 100, [=](int i) { return (600 + i % levels) * step; }).view, 0);
    return 256 / (window.white() - window.black()) * step;
  };
  EXPECT_DOUBLE_EQ(stretch(30, 1), 1) << "noise behind a lens cap";
  EXPECT_DOUBLE_EQ(stretch(200, 1), 1);
  EXPECT_DOUBLE_EQ(stretch(30, 16), 1) << "12 bit in the upper bits";
  EXPECT_DOUBLE_EQ(stretch(200, 16), 1);
  EXPECT_NEAR(stretch(1000, 1), 0.22, 0.01);
  // 8 bit in the upper bits stays 8 bit.
  GrayWindow window;
  const Gray16 picture(256, 2, [](int i) { return i % 256 << 8; });
  const auto seen = picture.seen(window.look(picture.view, 0));
  for (int i = 0; i < 256; ++i) ASSERT_EQ(seen[static_cast<std::size_t>(i)], i);
  // A dark picture stays dark: it does not move to the middle of its window.
  GrayWindow cap;
  const Gray16 dark(100, 100, [](int i) { return 64 + i % 9; });
  for (const int luma : dark.seen(cap.look(dark.view, 0))) ASSERT_LT(luma, 16);
}

TEST(GrayWindow, IsPerfectlySteadyOnASteadyPicture) {
  std::mt19937 random(1);
  const auto noisy = [&random](double sigma) {
    std::normal_distribution<double> noise(0, sigma);
    return Gray16(100, 100,
                  [&](int i) { return static_cast<int>(std::lround(2001 + 21 * (i % 100) + noise(random))); });
  };
  GrayWindow window;
  const auto first = window.look(noisy(0.001).view, 0).component[0];
  for (int i = 1; i < 200; ++i) {
    // In 8 bit, noise of σ 6.
    const auto now = window.look(noisy(i % 2 ? 0.001 : 50).view, i * frame).component[0];
    ASSERT_EQ(now.black, first.black) << i;
    ASSERT_EQ(now.gain, first.gain) << i;
  }
}

/// Light from glossy tissue, or an instrument's shadow, on 3 % of the pixels in some frames.
TEST(GrayWindow, DoesNotFollowFlicker) {
  for (const int level : {65535, 5000, 100})
    for (const auto &[period, on] : {std::pair{2, 1}, {3, 1}, {3, 2}, {7, 6}}) {
      const auto picture = [&](bool flash) {
        return Gray16(100, 100, [=](int k) { return flash && k % 33 == 0 ? level : 2000 + 26 * (k % 100); });
      };
      GrayWindow window, without;
      without.look(picture(false).view, 0);
      const double width = without.white() - without.black();
      FrameView last;
      for (int i = 0; i < 150; ++i) {
        const FrameView view = window.look(picture(i % period < on).view, i * frame);
        if (i > 50) {
          ASSERT_EQ(view.component[0].black, last.component[0].black) << level << ' ' << period << ' ' << on;
          ASSERT_EQ(view.component[0].gain, last.component[0].gain) << level << ' ' << period << ' ' << on;
        }
        last = view;
      }
      EXPECT_NEAR(window.black(), without.black(), width / 15);
      EXPECT_NEAR(window.white(), without.white(), width / 15);
    }
}

/// Two lights that alternate. No level is in the range of both.
TEST(GrayWindow, CoversAlternatingLights) {
  GrayWindow window;
  window.look(hundred(1000, 79).view, 0);
  double black = 0, white = 0;
  for (int i = 1; i < 100; ++i) {
    window.look(hundred(i % 2 ? 1000 : 5100, 39).view, i * frame);
    if (i > 2) {
      ASSERT_EQ(window.black(), black) << i;
      ASSERT_EQ(window.white(), white) << i;
    }
    black = window.black(), white = window.white();
  }
  EXPECT_LT(black, 1000);
  EXPECT_GT(white, 8600);
}

TEST(GrayWindow, OpensForALastingHighlightWithoutAJump) {
  GrayWindow window;
  window.look(hundred(1000, 26).view, 0);
  for (int i = 1; i < 75; ++i) {
    const double width = window.white() - window.black();
    const Gray16 picture(100, 100, [](int k) { return k % 33 == 0 ? 60000 : 1000 + 26 * (k % 100); });
    window.look(picture.view, i * frame);
    ASSERT_LT(window.white() - window.black(), 1.2 * width) << i;
  }
  EXPECT_GT(window.white(), 58000);
}

TEST(GrayWindow, FollowsADriftWithoutAJump) {
  // Brighter or darker by `drift` a second, for ten seconds; at first 4 % of 16 bit.
  for (const double drift : {0.03, 0.1, -0.1, 0.2}) {
    const double clipped = std::max(2.0, 40 * drift);  // of a hundred
    GrayWindow window;
    FrameView last;
    int moved = 0;
    for (int i = 0; i < 250; ++i) {
      const double gain = std::pow(1 + drift, i / 25.0);
      const Gray16 picture(100, 100, [&](int k) { return static_cast<int>(gain * (500 + 26 * (k % 100))); });
      const FrameView view = window.look(picture.view, i * frame);
      const auto seen = picture.seen(view);
      EXPECT_GT(*std::max_element(seen.begin(), seen.end()) - *std::min_element(seen.begin(), seen.end()), 195) << i;
      EXPECT_LT(std::count(seen.begin(), seen.end(), 255), clipped) << drift << ' ' << i;
      EXPECT_LT(std::count(seen.begin(), seen.end(), 0), 2) << drift << ' ' << i;
      if (i > 0) {
        FrameView as_before = picture.view;
        as_before.component[0].black = last.component[0].black;
        as_before.component[0].gain = last.component[0].gain;
        const auto old = picture.seen(as_before);
        for (std::size_t k = 0; k < seen.size(); ++k) ASSERT_LE(std::abs(seen[k] - old[k]), 3) << i;
        moved += seen != old;
      }
      last = view;
    }
    EXPECT_GT(moved, 20);
    if (drift == 0.03) {
      EXPECT_LT(moved, 125) << "in between it is constant";
    }
  }
}

TEST(GrayWindow, SettlesWithinASecondOfAnotherExposure) {
  for (const double gain : {0.05, 0.4, 0.7, 1.4, 2.0, 8.0}) {
    GrayWindow window, fresh;
    const auto picture = [](double by) { return hundred(static_cast<int>(by * 400), by * 27.3); };
    std::int64_t time = 0;
    for (int i = 0; i < 10; ++i, time += frame) window.look(picture(1).view, time);
    for (int i = 0; i < 25; ++i, time += frame) window.look(picture(gain).view, time);
    fresh.look(picture(gain).view, 0);
    const double width = fresh.white() - fresh.black();
    EXPECT_NEAR(window.black(), fresh.black(), 0.1 * width) << gain;
    EXPECT_NEAR(window.white(), fresh.white(), 0.1 * width) << gain;
  }
  // Content outside the old window needs a new one at once. Half a second of black does not blind it.
  GrayWindow window;
  window.look(hundred(400, 27).view, 0);
  const double white = window.white();
  window.look(hundred(3200, 216).view, frame);
  EXPECT_GT(window.white(), 20000);
  GrayWindow wide;
  wide.look(hundred(100, 540).view, 0);
  wide.look(hundred(100, 100).view, frame);
  EXPECT_LT(wide.white(), 11000) << "only a quarter of it was in use";
  for (int i = 2; i < 14; ++i) window.look(hundred(20, 0.1).view, i * frame);
  window.look(hundred(400, 27).view, 14 * frame);
  EXPECT_NEAR(window.white(), white, 1);
}

/// Steps go by time, not by frames.
TEST(GrayWindow, TakesTheSameTimeAtAnyFrameRate) {
  const auto after = [](int frames) {
    GrayWindow window;
    window.look(hundred(400, 27).view, 0);
    for (int i = 1; i <= frames; ++i) window.look(hundred(500, 35).view, i * 800'000'000LL / frames);
    return window.white();
  };
  GrayWindow fresh;
  fresh.look(hundred(500, 35).view, 0);
  const double way = fresh.white() - after(0);
  EXPECT_NEAR(after(8), after(80), 0.1 * way);
  EXPECT_NEAR(after(8), after(0) + 0.7 * way, 0.2 * way) << "underway";
}

TEST(GrayWindow, StartsOverWithAnotherSizeOrStream) {
  const Gray16 first = hundred(1000, 10), second = hundred(1040, 10);
  const Gray16 larger(100, 101, [&](int i) { return 1040 + 10 * (i % 100); });
  GrayWindow window, fresh;
  window.look(first.view, 0);
  const double before = window.black();
  window.look(second.view, frame);
  EXPECT_EQ(window.black(), before);
  window.look(larger.view, 2 * frame);
  EXPECT_NEAR(window.black(), before + 40, 1);
  window.look(first.view, 3 * frame);
  window.look(second.view, 4 * frame);
  EXPECT_EQ(window.black(), before);
  window.reset();
  window.look(second.view, 5 * frame);
  fresh.look(second.view, 0);
  EXPECT_EQ(window.black(), fresh.black());
}

}  // namespace
}  // namespace csd
