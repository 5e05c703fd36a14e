// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <map>
#include <stdexcept>
#include <vector>

#include "track/algorithm.h"

namespace csd {

/// What Scripted is to say, and what it was told.
struct Script {
  std::map<FeatureId, Claim::Kind> kinds;  // the rest is tracked
  cv::Point2d motion{0, 0};
  bool replenishes = false;
  bool throws = false;
  std::int64_t time = -1;  // of the last frame to track
  std::vector<FeatureId> begun, ended;
  int forgotten = 0;
};
inline Script *script = nullptr;

class Scripted final : public Algorithm {
 public:
  bool replenishes() const override { return script->replenishes; }
  void track(const FrameContext &context, std::vector<Claim> &claims) override {
    if (script->throws) throw std::runtime_error("planted");
    script->time = context.time;
    for (auto &claim : claims) {
      const auto kind = script->kinds.find(claim.id);
      claim.kind = kind == script->kinds.end() ? Claim::Kind::tracked : kind->second;
      claim.position += script->motion;
      if (!context.bounds().contains(claim.position)) claim.kind = Claim::Kind::out;
    }
  }
  Claim::Kind begin(FeatureId id, cv::Point2d, const FrameContext &) override {
    script->begun.push_back(id);
    return Claim::Kind::learning;
  }
  void end(FeatureId id) override { script->ended.push_back(id); }
  void finish(const FrameContext &) override {}
  void forget() override { ++script->forgotten; }
  void add_to(Stats &) const override {}
};

class NoExecutor final : public Executor {
  void post(std::function<void()>) override {}
};

}  // namespace csd
