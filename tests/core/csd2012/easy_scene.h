// SPDX-License-Identifier: LGPL-2.1-or-later
// A swaying scene, and csd-2012's tracks of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "csd2012/csd2012.h"
#include "track/moving_scene.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace csd {

inline constexpr std::int64_t frame_time = second / 25;

/// The scene sways by a few pixels, at most 1 px from frame to frame.
inline cv::Point2d sway(int frame) {
  return {6 * std::sin(frame * 0.15), 4 * std::sin(frame * 0.1)};
}

inline Settings few_features() {
  Settings settings;
  settings.algorithm = AlgorithmKind::csd_2012;
  settings.max_features = 12;
  settings.learn_synchronously = true;
  settings.training_time = second / 5;  // below the minimum of 8 frames, which applies
  settings.content_area = ContentArea::full;
  return settings;
}

/// The tracks of `frames` frames.
inline std::vector<Tracks> run(const Settings &settings, unsigned threads, int frames,
                               const csd2012::Choices &choices = {}) {
  const MovingScene scene;
  ThreadPool pool(threads);
  Tracker tracker(settings, std::make_unique<Csd2012>(settings, pool, choices));
  std::vector<Tracks> all;
  for (int i = 0; i < frames; ++i) {
    const auto picture = scene.render(sway(i));
    all.push_back(tracker.process(MovingScene::view(picture), i * frame_time));
  }
  return all;
}

/// Byte for byte.
inline bool same_tracks(const std::vector<Tracks> &a, const std::vector<Tracks> &b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Tracks &p, const Tracks &q) {
    return std::equal(p.features.begin(), p.features.end(), q.features.begin(), q.features.end(),
                      [](const Feature &f, const Feature &g) {
                        return f.id == g.id && f.state == g.state && f.x == g.x && f.y == g.y;
                      });
  });
}

}  // namespace csd
