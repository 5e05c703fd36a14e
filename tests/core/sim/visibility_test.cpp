// SPDX-License-Identifier: LGPL-2.1-or-later
// Compares what the truth calls hidden or out with what the pictures show.
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "sim/clock.h"
#include "sim/simulator.h"

namespace csd::sim {
namespace {

/// A simulation with tissue of one flat colour, so that anything in front of it can be told apart.
class Flat {
 public:
  static constexpr int green = 120;

  explicit Flat(const std::string &effects, cv::Size size = {640, 480}) {
    SimSettings s;
    s.effects = Effects();
    s.effects.set(effects);
    s.size = size;
    s.texture = cv::Mat(480, 640, CV_8UC3, cv::Scalar(20, green, 20));
    simulator_.emplace(s);
  }

  cv::Mat render(std::uint64_t n) {
    cv::Mat picture;
    simulator_->render(n, picture);
    return picture;
  }
  /// The surface points that the pixels of frame n show, or would show.
  std::vector<TruthPoint> truth(std::uint64_t n, const std::vector<cv::Point2d> &pixels) {
    return simulator_->truth(n, simulator_->on_surface(n, pixels));
  }
  Simulator &simulator() { return *simulator_; }

 private:
  std::optional<Simulator> simulator_;
};

std::vector<cv::Point2d> lattice(cv::Size size, int step = 12) {
  std::vector<cv::Point2d> points;
  for (int y = 4; y < size.height; y += step)
    for (int x = 4; x < size.width; x += step) points.emplace_back(x, y);
  return points;
}

/// Counts how often the truth agrees with the pixel's colour. In `tissue`, green dominates.
struct Agreement {
  int hidden = 0, visible = 0, wrong = 0;
};
template <class IsTissue>
Agreement compare(Flat &flat, std::uint64_t n, IsTissue is_tissue) {
  const cv::Mat picture = flat.render(n);
  const auto pixels = lattice(picture.size());
  const auto truth = flat.truth(n, pixels);
  Agreement a;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const bool seen = truth[i].visibility == Visibility::visible;
    (seen ? a.visible : a.hidden) += 1;
    a.wrong += seen != is_tissue(picture.at<cv::Vec3b>(cv::Point(pixels[i])));
  }
  return a;
}

bool greenish(const cv::Vec3b &p) {
  return p[1] > 1.7 * p[0] && p[1] > 1.7 * p[2];
}

TEST(Visibility, AToolHides) {
  Flat flat("tools");
  for (const std::uint64_t n : {80U, 150U, 240U, 330U}) {
    const Agreement a = compare(flat, n, greenish);  // a shadow is dark, but still green
    EXPECT_GT(a.hidden, 20) << n;
    EXPECT_GT(a.visible, 1000) << n;
    EXPECT_LE(a.wrong, 8) << n;  // pixels right on the edge
  }
}

TEST(Visibility, AGraspingToolHides) {
  Flat flat("grasp");
  EXPECT_EQ(compare(flat, 0, greenish).hidden, 0);
  for (const std::uint64_t n : {20U, 75U, 150U, 200U}) {
    const Agreement a = compare(flat, n, greenish);
    EXPECT_GT(a.hidden, 15) << n;
    EXPECT_LE(a.wrong, 5) << n;
  }
}

TEST(Visibility, BloodHidesForATime) {
  Flat flat("blood");
  const Agreement pool = compare(flat, 190, greenish);
  EXPECT_GT(pool.hidden, 100);
  EXPECT_LE(pool.wrong, 12);
  const Agreement wiped = compare(flat, 460, [](const cv::Vec3b &p) { return p[1] > p[2]; });
  EXPECT_EQ(wiped.hidden, 0);
  EXPECT_EQ(wiped.wrong, 0);
}

TEST(Visibility, WaterHides) {
  Flat flat("irrigation");
  EXPECT_EQ(compare(flat, 100, greenish).hidden, 0);
  EXPECT_GT(compare(flat, 300, greenish).hidden, 100);
  EXPECT_EQ(compare(flat, 400, greenish).hidden, 0);
}

TEST(Visibility, DenseSmokeHides) {
  Flat clear("smoke=0"), flat("smoke=2");
  const cv::Mat picture = flat.render(130), without = clear.render(130);
  const auto pixels = lattice(picture.size());
  const auto truth = flat.truth(130, pixels);
  int hidden = 0, visible = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    // Smoke's blue is 196: its share in the pixel is its density.
    const cv::Point at(pixels[i]);
    const double base = without.at<cv::Vec3b>(at)[0], density = (picture.at<cv::Vec3b>(at)[0] - base) / (196 - base);
    if (density > 0.77) {
      EXPECT_EQ(truth[i].visibility, Visibility::hidden);
      ++hidden;
    } else if (density < 0.73) {
      EXPECT_EQ(truth[i].visibility, Visibility::visible);
      ++visible;
    }
  }
  EXPECT_GT(hidden, 100);
  EXPECT_GT(visible, 100);
}

TEST(Visibility, AHighlightHides) {
  Flat flat("specular");
  const cv::Mat picture = flat.render(20);
  cv::Mat white, blind;
  cv::inRange(picture, cv::Scalar(235, 235, 235), cv::Scalar(255, 255, 255), white);
  cv::boxFilter(white, blind, CV_8U, {11, 11});  // the share of white pixels around
  const auto pixels = lattice(picture.size(), 3);
  const auto truth = flat.truth(20, pixels);
  int hidden = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const int share = blind.at<std::uint8_t>(cv::Point(pixels[i]));
    if (truth[i].visibility == Visibility::hidden) {
      ++hidden;
      EXPECT_GT(share, 255 * 0.25) << pixels[i];
    } else {
      EXPECT_LT(share, 255 * 0.85) << pixels[i];
    }
  }
  EXPECT_GT(hidden, 5);
}

/// The tissue's colour encodes its place: red grows to the right and blue downwards.
struct Covered {
  int hidden = 0, wrong = 0;
};
Covered covered_by(const std::string &effects, std::uint64_t n, double dim = 1) {
  SimSettings s;
  s.effects = Effects();
  s.effects.set(effects);
  s.texture = cv::Mat(480, 640, CV_8UC3);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x)
      s.texture.at<cv::Vec3b>(y, x) =
          cv::Vec3b(static_cast<std::uint8_t>(40 + y * 200 / 480), 128, static_cast<std::uint8_t>(40 + x * 200 / 640)) *
          dim;
  Simulator simulator(s);
  cv::Mat picture;
  simulator.render(n, picture);
  std::vector<cv::Point2d> texture, surface;
  for (int y = 60; y < 420; y += 5)
    for (int x = 60; x < 580; x += 9) {
      texture.emplace_back(x, y);
      for (const cv::Point2d beside : {cv::Point2d(0, 0), {4, 0}, {0, 4}})
        surface.push_back(simulator.of_texture(texture.back() + beside));
    }
  const auto truth = simulator.truth(n, surface);
  Covered c;
  for (std::size_t i = 0; i < texture.size(); ++i) {
    const TruthPoint &q = truth[3 * i], &right = truth[3 * i + 1], &below = truth[3 * i + 2];
    if (q.visibility == Visibility::out) continue;
    // At a small viewing angle, a pixel shows too much tissue.
    if (std::abs((right.x - q.x) * (below.y - q.y) - (right.y - q.y) * (below.x - q.x)) < 4) continue;
    const cv::Vec3b p = picture.at<cv::Vec3b>(cvRound(q.y), cvRound(q.x));
    if (p[1] < 40 * dim) continue;  // too dark to tell
    // The texture's place that the pixel shows: light scales all channels alike.
    const double row = (128.0 * p[0] / p[1] - 40) * 480 / 200, column = (128.0 * p[2] / p[1] - 40) * 640 / 200;
    const double off = std::hypot(row - texture[i].y, column - texture[i].x);
    const bool elsewhere = off > 12;
    c.hidden += q.visibility == Visibility::hidden;
    c.wrong += elsewhere != (q.visibility == Visibility::hidden) && std::abs(off - 12) > 10;
  }
  return c;
}

TEST(Visibility, AFoldHides) {
  const Covered c = covered_by("fold", 0);
  EXPECT_GT(c.hidden, 100);
  EXPECT_LE(c.wrong, c.hidden / 20);
}

TEST(Visibility, ASheetThatSlidesOverItHides) {
  for (const std::uint64_t n : {0U, 30U, 90U, 140U}) {
    const Covered c = covered_by("slide", n);
    EXPECT_GT(c.hidden, 100) << n;
    EXPECT_LE(c.wrong, c.hidden / 20) << n;
  }
}

TEST(Visibility, TheFoldsOfACavityHide) {
  for (const std::uint64_t n : {0U, 45U, 130U}) {
    const Covered c = covered_by("cavity", n, 0.7);  // otherwise walls near the lamp would be white
    EXPECT_GT(c.hidden, 40) << n;
    EXPECT_LE(c.wrong, c.hidden / 10) << n;
  }
}

// The bed of a wound is red, although the tissue is grey. No point lies there.
TEST(Visibility, PointsInAnOpenWoundAreHidden) {
  SimSettings s;
  s.effects = Effects();
  s.effects.set("tear");
  s.texture = cv::Mat(480, 640, CV_8UC3, cv::Scalar(150, 150, 150));
  Simulator simulator(s);
  const auto surface = simulator.on_surface(0, lattice({640, 480}, 3));
  std::size_t least = surface.size();
  for (const std::uint64_t n : {0U, 40U, 100U}) {
    cv::Mat picture;
    simulator.render(n, picture);
    const auto is_bed = [&](cv::Point2d p) {
      const cv::Vec3b &c = picture.at<cv::Vec3b>(cvRound(p.y), cvRound(p.x));
      return c[2] > 1.3 * c[1];
    };
    std::size_t visible = 0, bare = 0;
    for (const auto &p : simulator.truth(n, surface)) {
      if (p.visibility != Visibility::visible) continue;
      ++visible;
      EXPECT_FALSE(is_bed({p.x, p.y})) << n << ": " << p.x << "," << p.y;
    }
    for (const auto &p : lattice({640, 480}, 3)) {
      if (!is_bed(p)) continue;
      ++bare;
      EXPECT_THROW(simulator.on_surface(n, std::vector<cv::Point2d>{p}), std::invalid_argument) << n << ": " << p;
    }
    if (n == 0) {
      EXPECT_EQ(bare, 0U);
      EXPECT_EQ(visible, surface.size());
    } else {
      EXPECT_GT(bare, n == 40 ? 50U : 250U) << n;
    }
    least = std::min(least, visible);
  }
  EXPECT_GT(least, surface.size() * 9 / 10);
}

TEST(Visibility, OutOfTheFrameIsOut) {
  Flat flat("sway");
  const auto surface = flat.simulator().on_surface(
      0, std::vector<cv::Point2d>{{-0.4, 5}, {-0.6, 5}, {639.4, 479.4}, {639.6, 5}, {5, -1}, {5, 480}, {-300, 900}});
  const auto truth = flat.simulator().truth(0, surface);
  EXPECT_EQ(truth[0].visibility, Visibility::visible);
  EXPECT_EQ(truth[2].visibility, Visibility::visible);
  for (const std::size_t i : {1U, 3U, 4U, 5U, 6U}) EXPECT_EQ(truth[i].visibility, Visibility::out) << i;
  EXPECT_NEAR(truth[6].x, -300, 1e-6);
  EXPECT_NEAR(truth[6].y, 900, 1e-6);
}

TEST(Visibility, BlackoutsCutsClothsAndOverlaysHide) {
  Flat black("black"), cut("cut"), stop("field-stop"), text("text"), wipe("wipe");
  const std::vector<cv::Point2d> middle{{320, 240}, {200, 300}};
  const auto hidden = [&](Flat &flat, std::uint64_t n, std::size_t i) {
    return flat.truth(n, middle)[i].visibility == Visibility::hidden;
  };
  // Black from 6 s for 2.5 s.
  EXPECT_FALSE(hidden(black, 149, 0));
  EXPECT_TRUE(hidden(black, 150, 0));
  EXPECT_TRUE(hidden(black, 212, 0));
  EXPECT_FALSE(hidden(black, 213, 0));
  EXPECT_EQ(cv::norm(black.render(180), cv::NORM_INF), 0);
  // Another scene from 4 s to 6 s.
  EXPECT_FALSE(hidden(cut, 99, 1));
  EXPECT_TRUE(hidden(cut, 100, 1));
  EXPECT_TRUE(hidden(cut, 149, 1));
  EXPECT_FALSE(hidden(cut, 150, 1));
  EXPECT_FALSE(greenish(cut.render(120).at<cv::Vec3b>(240, 320)));
  // A cloth is on the lens at 5.3 s. A second and a half later it is only wet, and at 7.5 s dry.
  EXPECT_TRUE(hidden(wipe, 132, 0));
  EXPECT_FALSE(hidden(wipe, 187, 0));

  const auto corner = stop.truth(0, {{4, 4}, {320, 240}});
  EXPECT_EQ(corner[0].visibility, Visibility::hidden);
  EXPECT_EQ(corner[1].visibility, Visibility::visible);
  EXPECT_EQ(stop.render(0).at<cv::Vec3b>(4, 4), cv::Vec3b(0, 0, 0));

  const cv::Rect box = clock_box({640, 480});
  const cv::Point2d inside(box.x + box.width / 2, box.y + box.height / 2);
  const auto clock = text.truth(0, {inside, {inside.x, box.y - 3.0}});
  EXPECT_EQ(clock[0].visibility, Visibility::hidden);
  EXPECT_EQ(clock[1].visibility, Visibility::visible);
}

/// The shares of features that the truth calls hidden, over 20 s.
struct Shares {
  double mean = 0, most = 0;
};
Shares hidden_shares(const std::string &effects, std::uint64_t seed) {
  SimSettings s;
  s.effects = scenario_effects(Scenario::occlusion);
  s.effects.set(effects);
  s.seed = seed;
  s.size = {320, 240};
  s.style = Style::liver;
  Simulator simulator(s);
  const auto surface = simulator.on_surface(0, simulator.detect(50));
  Shares shares;
  constexpr std::uint64_t frames = 500, step = 10;
  for (std::uint64_t n = 0; n < frames; n += step) {
    const auto truth = simulator.truth(n, surface);
    const auto hidden = std::count_if(truth.begin(), truth.end(),
                                      [](const TruthPoint &p) { return p.visibility == Visibility::hidden; });
    const double share = static_cast<double>(hidden) / static_cast<double>(truth.size());
    shares.mean += share * step / frames;
    shares.most = std::max(shares.most, share);
  }
  return shares;
}

// The paper's three occlusion sequences (§3.2.2): few regions are hidden, then more, then the majority.
TEST(Visibility, ClassesOfOcclusionAreInOrder) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Shares few = hidden_shares("tools=0.8", seed), more = hidden_shares("tools=2", seed),
                 irrigation = hidden_shares("tools=0.7,blood=1,irrigation=1", seed);
    EXPECT_GT(few.mean, 0.01) << "seed " << seed;
    EXPECT_GT(more.mean, 1.5 * few.mean) << "seed " << seed;
    EXPECT_GT(more.most, few.most) << "seed " << seed;
    EXPECT_GT(irrigation.most, 0.5) << "seed " << seed;
    EXPECT_GT(irrigation.mean, more.mean) << "seed " << seed;
  }
}

}  // namespace
}  // namespace csd::sim
