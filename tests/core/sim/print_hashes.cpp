// SPDX-License-Identifier: LGPL-2.1-or-later
// Prints a hash of the bytes of simulated pictures and of their truth, for `same_bytes` to compare.
//   print_hashes [small-vectors]   small-vectors: without AVX2 and beyond
#include <hwy/targets.h>

#include <cstdio>
#include <cstring>

#include "sim/simulator.h"

namespace {

struct Hash {  // FNV-1a
  std::uint64_t value = 14695981039346656037u;
  void add(const void *data, std::size_t n) {
    const auto *p = static_cast<const unsigned char *>(data);
    for (std::size_t i = 0; i < n; ++i) value = (value ^ p[i]) * 1099511628211u;
  }
};

}  // namespace

int main(int argc, char **argv) {
  if (argc > 1 && std::strcmp(argv[1], "small-vectors") == 0) hwy::DisableTargets(HWY_AVX2 | HWY_AVX3 | HWY_AVX3_DL);
  for (std::size_t style = 0; style < csd::sim::style_count; ++style) {
    csd::sim::SimSettings settings;
    settings.style = static_cast<csd::sim::Style>(style);
    settings.effects = csd::sim::scenario_effects(csd::sim::Scenario::mixed);
    // Two styles get every effect, the others the usual ones.
    if (style % 2 == 0) {
      for (std::size_t i = 0; i < csd::sim::effect_count; ++i) settings.effects[static_cast<csd::sim::Effect>(i)] = 1;
    }
    csd::sim::Simulator simulator(settings);
    std::vector<cv::Point2d> pixels;
    for (int x = 10; x < 640; x += 50) pixels.emplace_back(x, 0.7 * x + 3);
    const auto surface = simulator.on_surface(0, pixels);
    Hash pictures, truth;
    cv::Mat picture;
    for (const std::uint64_t n : {0U, 71U, 133U, 248U}) {
      simulator.render(n, picture);
      for (int y = 0; y < picture.rows; ++y) pictures.add(picture.ptr(y), static_cast<std::size_t>(picture.cols) * 3);
      for (const auto &p : simulator.truth(n, surface)) {
        truth.add(&p.x, sizeof p.x);
        truth.add(&p.y, sizeof p.y);
        truth.add(&p.visibility, sizeof p.visibility);
      }
    }
    std::printf("%-10s pictures %016llx truth %016llx\n", std::string(style_name(settings.style)).c_str(),
                static_cast<unsigned long long>(pictures.value), static_cast<unsigned long long>(truth.value));
  }
  return 0;
}
