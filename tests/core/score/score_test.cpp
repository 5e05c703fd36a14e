// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/score.h"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>

#include "base/random.h"
#include "score/align.h"

namespace csd::score {
namespace {

constexpr auto sensitivity = static_cast<std::size_t>(Headline::sensitivity);
constexpr auto k = static_cast<std::size_t>(Headline::k);
constexpr auto delta_avg = static_cast<std::size_t>(Headline::delta_avg);
constexpr auto aj = static_cast<std::size_t>(Headline::aj);
constexpr auto oa = static_cast<std::size_t>(Headline::oa);
constexpr auto survival = static_cast<std::size_t>(Headline::survival);

/// Features that move right, a pixel a frame. The odd ones are hidden in every third frame.
Truth moving(int width, int height, std::size_t features, std::size_t frames, bool hiding = false) {
  Truth truth;
  truth.file = "truth";
  truth.width = width;
  truth.height = height;
  for (std::size_t f = 0; f < features; ++f) truth.ids.push_back(static_cast<FeatureId>(f));
  for (std::size_t t = 0; t < frames; ++t) {
    TruthFrame frame{t, static_cast<std::int64_t>(t) * 40000000, t + 1, {}};
    for (std::size_t f = 0; f < features; ++f) {
      const bool hidden = hiding && f % 2 == 1 && t % 3 == 2;
      frame.points.push_back({hidden ? Presence::hidden : Presence::visible,
                              {10. + static_cast<double>(t), 10. + static_cast<double>(f)}});
    }
    truth.frames.push_back(std::move(frame));
  }
  return truth;
}

using Report = std::function<Feature(FeatureId id, const TruthPoint &point, std::size_t frame)>;

TrackerScore score_of(const Truth &truth, const Report &report) {
  Recording tracks;
  tracks.file = "tracks";
  for (const TruthFrame &frame : truth.frames) {
    tracks.frames.push_back({true, frame.frame, frame.pts, frame.line, {}});
    for (std::size_t f = 0; f < truth.ids.size(); ++f)
      tracks.frames.back().features.push_back(report(truth.ids[f], frame.points[f], frame.frame));
  }
  std::vector<std::string> notes;
  const std::vector<Clip> clips{align(truth, tracks, {}, notes)};
  return score("tracker", clips, 0, 1);
}

Feature at(FeatureId id, cv::Point2d position) {
  return {id, position.x, position.y, FeatureState::tracked, 1, true};
}

TEST(Score, OfTheTruthItself) {
  const TrackerScore found = score_of(moving(640, 480, 4, 30, true), [](FeatureId id, const TruthPoint &point, auto) {
    const bool visible = point.presence == Presence::visible;
    return Feature{id,
                   point.position.x,
                   point.position.y,
                   visible ? FeatureState::tracked : FeatureState::occluded,
                   visible ? 1. : 0.,
                   true};
  });
  EXPECT_EQ(found.headline[sensitivity], 1);
  EXPECT_EQ(found.headline[k], 0);
  for (const CurvePoint &point : found.curve) {
    EXPECT_EQ(point.paper.sensitivity, 1);
    EXPECT_EQ(point.paper.k, 0);
  }
  EXPECT_EQ(found.headline[delta_avg], 1);
  EXPECT_EQ(found.headline[aj], 1);
  EXPECT_EQ(found.headline[oa], 1);
  EXPECT_EQ(found.headline[survival], 1);
  EXPECT_EQ(found.stir_2026.aj, 1);
  EXPECT_EQ(found.stir_2024.delta_avg, 1);
  EXPECT_EQ(found.error_95, 0);
  EXPECT_EQ(found.drift(), 0);
  // Two features are hidden in frames 2, 5, … 29: 10 times each, and return 9 times.
  EXPECT_EQ(found.returns, 18u);
  EXPECT_EQ(found.recovered, 18u);
  EXPECT_EQ(found.recovery_median_frames, 0);
  EXPECT_EQ(found.reliability.ece(), 0);
}

TEST(Score, OfATrackerThatNeverMoves) {
  // 256×256, so that TAP-Vid's pixels are the picture's. In 11 frames, the errors are 0, 1, … 10.
  const auto still = [](FeatureId id, const TruthPoint &, auto) { return at(id, {10, 10}); };
  const TrackerScore found = score_of(moving(256, 256, 1, 11), still);
  EXPECT_DOUBLE_EQ(found.headline[sensitivity], 6. / 11) << "0…5 px";
  EXPECT_DOUBLE_EQ(found.headline[k], 5. / 11);
  EXPECT_DOUBLE_EQ(found.curve[1].paper.sensitivity, 3. / 11) << "0, 1 and 2 px";
  EXPECT_DOUBLE_EQ(found.headline[delta_avg], (0 + .1 + .3 + .7 + 1) / 5) << "strictly below, without frame 0";
  EXPECT_DOUBLE_EQ(found.headline[aj], (0. / 20 + 1. / 19 + 3. / 17 + 7. / 13 + 10. / 10) / 5);
  EXPECT_EQ(found.headline[oa], 1);
  EXPECT_EQ(found.headline[survival], 1);
  EXPECT_EQ(found.error_median, 5);
  EXPECT_DOUBLE_EQ(found.error_95, 9.5);
  EXPECT_EQ(found.drift(), 9 - 1) << "medians of 8, 9, 10 and of 0, 1, 2";
  EXPECT_DOUBLE_EQ(found.stir_2024.delta_avg, 3. / 5) << "10 px off at the end: within 16, 32 and 64";
  EXPECT_DOUBLE_EQ(found.stir_2024_control.delta_avg, 3. / 5) << "it is the control";
  EXPECT_DOUBLE_EQ(found.reliability.ece(), 5. / 11) << "always sure, right in 6 of 11";
}

TEST(Score, OfATrackerThatIsSixPixelsOff) {
  const Report shifted = [](FeatureId id, const TruthPoint &point, auto) {
    return at(id, point.position + cv::Point2d(6, 0));
  };
  const TrackerScore found = score_of(moving(256, 256, 3, 10), shifted);
  EXPECT_EQ(found.headline[sensitivity], 0);
  EXPECT_EQ(found.headline[k], 1);
  const std::vector<double> curve{0, 0, 0, 0, 1, 1, 1};
  for (std::size_t i = 0; i < curve.size(); ++i) EXPECT_EQ(found.curve[i].paper.sensitivity, curve[i]) << i;
  EXPECT_DOUBLE_EQ(found.headline[delta_avg], 2. / 5);
  EXPECT_DOUBLE_EQ(found.headline[aj], 2. / 5);
  EXPECT_EQ(found.error_median, 6);
  EXPECT_DOUBLE_EQ(found.stir_2024.delta_avg, 4. / 5);
  EXPECT_EQ(found.stir_2024_median, 6);
  EXPECT_DOUBLE_EQ(found.stir_2024_control.delta_avg, 3. / 5) << "9 px";
  EXPECT_EQ(found.headline[survival], 1);
  // At 1152 lines τ is 10 px.
  EXPECT_EQ(score_of(moving(1000, 1152, 3, 10), shifted).headline[sensitivity], 1);
}

TEST(Score, OfATrackerThatReportsAtRandom) {
  // In 64×64 pixels, a disc of radius r inside the picture has a probability of πr²/4096. All truth is in 10…50.
  constexpr std::size_t features = 40, frames = 40;
  Random random(3);
  const TrackerScore found = score_of(moving(64, 64, features, frames), [&](FeatureId id, const TruthPoint &, auto) {
    return at(id, {random.uniform(-0.5, 63.5), random.uniform(-0.5, 63.5)});
  });
  const double hit = std::numbers::pi * 25 / 4096;
  const double error = std::sqrt(hit * (1 - hit) / (features * frames));
  EXPECT_NEAR(found.headline[sensitivity], hit, 4 * error);
  EXPECT_NEAR(found.headline[k], 1 - hit, 4 * error);
  // TAP-Vid's thresholds are a quarter here.
  const double within_16 = std::numbers::pi * 16 / 4096;
  EXPECT_NEAR(found.tap_vid_within[4], within_16, 4 * std::sqrt(within_16 / (features * (frames - 1))));
}

TEST(Score, OfATrackerThatNeverRecovers) {
  // Feature 1 is hidden in frames 2, 5, … 14, and returns 4 times; so does feature 3.
  const TrackerScore found = score_of(moving(640, 480, 4, 15, true), [](FeatureId id, const TruthPoint &point, auto t) {
    Feature feature = at(id, point.position);
    if (t > 1) feature.state = FeatureState::lost;
    return feature;
  });
  EXPECT_EQ(found.returns, 8u);
  EXPECT_EQ(found.recovered, 0u);
  EXPECT_TRUE(std::isinf(found.recovery_median_frames));
  EXPECT_TRUE(std::isinf(found.recovery_median_seconds));
}

TEST(Score, MeansAreOverClipsAndErrorsArePooled) {
  const auto clip = [](double off, std::size_t frames) {
    const Truth truth = moving(256, 256, 1, frames);
    Recording tracks;
    tracks.file = "tracks";
    for (const TruthFrame &frame : truth.frames)
      tracks.frames.push_back(
          {true, frame.frame, frame.pts, 1, {at(0, frame.points[0].position + cv::Point2d(off, 0))}});
    std::vector<std::string> notes;
    return align(truth, tracks, {}, notes);
  };
  const std::vector<Clip> clips{clip(0, 2), clip(10, 6)};
  const TrackerScore found = score("tracker", clips, 0, 1);
  EXPECT_EQ(found.headline[sensitivity], .5);
  EXPECT_DOUBLE_EQ(found.headline[delta_avg], (1 + .2) / 2);
  EXPECT_DOUBLE_EQ(found.stir_2026.delta_avg, (1. + 1. + 1. + 6. + 6.) / (5 * 6)) << "1 and 5 samples";
  EXPECT_EQ(found.error_median, 10) << "of 2 and 6";
  EXPECT_EQ(found.total.correct, 2u);
  EXPECT_EQ(found.total.wrong, 6u);
}

}  // namespace
}  // namespace csd::score
