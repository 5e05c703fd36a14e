// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "track/algorithm.h"
#include "track/moving_scene.h"
#include "track/tracker.h"

namespace csd {

/// What Scripted says, and what it was given.
struct Script {
  std::map<FeatureId, Claim::Kind> kinds;  // all others are tracked
  std::map<FeatureId, double> confidences;
  std::vector<FeatureId> waiting;
  cv::Point2d motion{0, 0};
  bool replenishes = false;
  std::function<void()> tracking;  // runs in the middle of a frame
  bool throws = false;             // then throws
  FeatureId cannot_begin = no_feature, cannot_end = no_feature;
  bool cannot_forget = false;
  std::int64_t time = -1;  // of the last tracked frame
  bool jumped = false;     // in the last tracked frame
  cv::Mat luma;            // of the last tracked frame
  std::vector<FeatureId> begun, ended;
  int finished = 0, forgotten = 0;
};
inline Script *script = nullptr;

class Scripted final : public Algorithm {
 public:
  bool replenishes() const override { return script->replenishes; }
  void track(const FrameContext &context, std::vector<Claim> &claims) override {
    if (script->tracking) script->tracking();
    if (script->throws) throw std::runtime_error("planted");
    EXPECT_TRUE(std::is_sorted(claims.begin(), claims.end(), [](auto &a, auto &b) { return a.id < b.id; }));
    script->time = context.time;
    script->jumped = context.jumped;
    context.frame.luma().copyTo(script->luma);
    for (auto &claim : claims) {
      const auto kind = script->kinds.find(claim.id);
      claim.kind = kind == script->kinds.end() ? Claim::Kind::tracked : kind->second;
      if (const auto c = script->confidences.find(claim.id); c != script->confidences.end())
        claim.confidence = c->second;
      claim.fresh = std::find(script->waiting.begin(), script->waiting.end(), claim.id) == script->waiting.end();
      claim.position += script->motion;
      if (!context.bounds().contains(claim.position)) claim.kind = Claim::Kind::out;
    }
  }
  Claim::Kind begin(FeatureId id, cv::Point2d, const FrameContext &) override {
    if (id == script->cannot_begin) throw std::runtime_error("planted");
    script->begun.push_back(id);
    return Claim::Kind::learning;
  }
  void end(FeatureId id) override {
    if (id == script->cannot_end) throw std::runtime_error("planted");
    script->ended.push_back(id);
  }
  void finish(const FrameContext &) override { ++script->finished; }
  void forget() override {
    if (script->cannot_forget) throw std::runtime_error("planted");
    ++script->forgotten;
  }
  void add_to(Stats &) const override {}
};

class NoExecutor final : public Executor {
  void post(std::function<void()>) override {}
};

/// A tracker with Scripted as its algorithm, and a texture at 25 frames a second.
class TrackerLife : public testing::Test {
 protected:
  TrackerLife() {
    script = &script_;
    cv::Mat noise(240, 320, CV_8UC1);
    cv::RNG rng(7);
    rng.fill(noise, cv::RNG::UNIFORM, 40, 220);
    cv::GaussianBlur(noise, texture_, {0, 0}, 3);
    cv::normalize(texture_, texture_, 40, 220, cv::NORM_MINMAX);
  }
  const Tracks &next(Tracker &tracker) { return next(tracker, texture_); }
  const Tracks &next(Tracker &tracker, const cv::Mat &gray) {
    const auto &tracks = tracker.process(MovingScene::gray_view(gray), pts_, second / 25);
    pts_ += second / 25;
    return tracks;
  }
  static const Feature *find(const Tracks &tracks, FeatureId id) {
    for (const auto &f : tracks.features)
      if (f.id == id) return &f;
    return nullptr;
  }
  static std::vector<FeatureId> ids(const Tracks &tracks) {
    std::vector<FeatureId> ids;
    for (const auto &f : tracks.features) ids.push_back(f.id);
    return ids;
  }
  static Settings with_points(std::vector<cv::Point2d> points) {
    Settings settings;
    settings.points = std::move(points);
    return settings;
  }

  Script script_;
  cv::Mat texture_;
  std::int64_t pts_ = 0;
};

}  // namespace csd
