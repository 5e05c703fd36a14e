// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/motion.h"

#include <algorithm>
#include <numeric>

namespace csd::motion {
namespace {

bool shows(const Rhythms &feature, const Rhythm &scene, double window) {
  return std::any_of(feature.rhythms.begin(), feature.rhythms.end(), [&](const Rhythm &own) {
    return same_rate(scene, own, 1, window) ||
           std::any_of(own.harmonics.begin(), own.harmonics.end(),
                       [&](const Harmonic &harmonic) { return same_rate(scene, own, harmonic.multiple, window); });
  });
}

}  // namespace

Motion analyse(Series series, const SearchOptions &options) {
  Motion motion;
  motion.scene = scene_motion(series);
  std::vector<std::size_t> all(series.paths.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::vector<std::vector<std::size_t>> groups{all};
  for (const std::size_t path : all) groups.push_back({path});
  motion.rhythms = find_rhythms(series, groups, options);
  const Rhythms scene = std::move(motion.rhythms.front());
  motion.rhythms.erase(motion.rhythms.begin());
  const double window = std::min(options.window, series.times.back() - series.times.front());
  for (const Rhythm &rhythm : scene.rhythms) {
    SceneRhythm one{rhythm};
    for (const Rhythms &feature : motion.rhythms) {
      one.judged += feature.windows > 0;
      one.agreeing += shows(feature, rhythm, window);
    }
    motion.scene_rhythms.push_back(std::move(one));
  }
  motion.series = std::move(series);
  return motion;
}

}  // namespace csd::motion
