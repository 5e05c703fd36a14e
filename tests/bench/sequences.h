// SPDX-License-Identifier: LGPL-2.1-or-later
// Sequences of simulated tissue for csd-accuracy: their list, their pictures and their truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/scenario.h"
#include "sim/simulator.h"
#include "sim/tissue_texture.h"

namespace csd::bench {

struct Sequence {
  std::string name;
  sim::Scenario scenario;
  const char *effects;
  sim::Style style;
  std::string clip = {};  ///< picture or video whose first frame is the texture; the rendered video is then compressed
};

/// Sequences that need no folder, and those on first frames of the folder `clips`; "" leaves the latter out.
std::vector<Sequence> known_sequences(const std::string &clips);
/// Each kind of sequence on each picture and video of the folders, named KIND/PICTURE and sorted by kind. Throws
/// std::runtime_error if there is none.
std::vector<Sequence> on_tissue(const std::vector<std::string> &folders);

inline const cv::Size picture_size{640, 480};
inline constexpr std::size_t frame_bytes = std::size_t{640} * 480 * 3 / 2;  ///< I420

/// A rendered sequence: pictures on disk, truth in memory.
struct Rendered {
  std::vector<std::vector<sim::TruthPoint>> truth;  ///< by frame; ids are indices
  std::string file;                                 ///< raw I420
};

/// Renders the sequence into `folder`, or finds it there. Throws std::runtime_error on failure.
Rendered render(const Sequence &sequence, std::uint64_t seed, std::uint64_t frames, std::size_t features,
                const std::string &folder);

}  // namespace csd::bench
