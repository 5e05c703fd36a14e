// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes a picture of a simulation with six of its frames: those in the environment's FRAMES ("0,65,130,200,270,345").
// With MARKS it also shows the features: green if visible, red if hidden.
//   contact-sheet OUT.jpg SCENARIO [EFFECTS [STYLE [SEED [TEXTURE]]]]
// For viewing only; other programs measure simulations.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/simulator.h"

namespace {

std::array<std::uint64_t, 6> frames_shown() {
  std::array<std::uint64_t, 6> shown{0, 65, 130, 200, 270, 345};  // shows something of each event in most scenarios
  const char *wanted = std::getenv("FRAMES");
  if (!wanted) return shown;
  std::istringstream text(wanted);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    char comma = ',';
    if ((i > 0 && !(text >> comma)) || comma != ',' || !(text >> shown[i]))
      throw std::runtime_error("FRAMES must be six numbers separated by commas, not \"" + std::string(wanted) + "\"");
  }
  return shown;
}

}  // namespace

int main(int argc, char **argv) try {
  if (argc < 3) {
    std::fprintf(stderr, "usage: contact-sheet OUT.jpg SCENARIO [EFFECTS [STYLE [SEED [TEXTURE]]]]\n");
    return 2;
  }
  const std::vector<std::string> args(argv + 1, argv + argc);
  csd::sim::SimSettings settings;
  settings.effects = csd::sim::scenario_effects(csd::sim::parse_scenario(args[1]));
  if (args.size() > 2) settings.effects.set(args[2]);
  if (args.size() > 3) settings.style = csd::sim::parse_style(args[3]);
  if (args.size() > 4) settings.seed = std::strtoull(args[4].c_str(), nullptr, 10);
  if (args.size() > 5) settings.texture = cv::imread(args[5], cv::IMREAD_COLOR);
  const bool marks = std::getenv("MARKS") != nullptr;
  csd::sim::Simulator simulator(settings);
  const auto surface = simulator.on_surface(0, simulator.detect(100));
  cv::Mat sheet(2 * settings.size.height, 3 * settings.size.width, CV_8UC3), picture;
  const auto shown = frames_shown();
  for (int i = 0; i < 6; ++i) {
    const std::uint64_t n = shown[static_cast<std::size_t>(i)];
    simulator.render(n, picture);
    if (marks) {
      for (const auto &p : simulator.truth(n, surface)) {
        const bool seen = p.visibility == csd::sim::Visibility::visible;
        cv::circle(picture, cv::Point2d(p.x, p.y), 3, seen ? cv::Scalar(0, 255, 0) : cv::Scalar(0, 0, 255), 1);
      }
    }
    picture.copyTo(sheet(cv::Rect({i % 3 * settings.size.width, i / 3 * settings.size.height}, settings.size)));
  }
  cv::resize(sheet, sheet, {}, 0.375, 0.375, cv::INTER_AREA);
  if (!cv::imwrite(args[0], sheet, {cv::IMWRITE_JPEG_QUALITY, 85})) throw std::runtime_error("can't write " + args[0]);
  return 0;
} catch (const std::exception &e) {
  std::fprintf(stderr, "contact-sheet: %s\n", e.what());
  return 1;
}
