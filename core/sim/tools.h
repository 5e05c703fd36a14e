// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/canvas.h"

namespace csd::sim {

/// Instruments between the scope and the tissue at one moment: a shaft that enters from outside the picture, a steel
/// neck, two jaws. Two of them, in turns, up to strength 1; two more come in up to strength 2. Thickness grows with
/// strength.
class Tools {
 public:
  /// The instrument that grasps the tissue, in addition to the others.
  struct Grip {
    cv::Point2d tip, port;  ///< pixels: end of the jaws, and a point far outside the picture
    double open = 0;        ///< 0…1: opening of the jaws
    bool coloured = false;
  };
  Tools(double time, double strength, std::uint64_t seed, cv::Size size, const std::optional<Grip> &grip = {});

  /// Draws the shadows on the tissue, then the instruments.
  void draw(Canvas &canvas) const;
  /// The instruments' coverage of a pixel, 0…1.
  float cover(cv::Point2d pixel) const;

 private:
  enum class Material : std::uint8_t { steel, black, plastic };
  /// A tapered piece of a rod.
  struct Rod {
    cv::Point2f a, b;
    float radius_a, radius_b;
    Material material;
  };
  struct Hit {
    float outside;  // pixels from its edge, negative inside
    float across;   // −1…1 from edge to edge
    float along;    // 0…1
  };

  /// Adds an instrument from `port` to `tip`; each of its jaws is open by `open` turns.
  void add(cv::Point2f port, cv::Point2f tip, float radius, double open, bool coloured);
  static Hit hit(const Rod &rod, float x, float y);
  template <class Paint>
  static void visit(const Rod &rod, float grow, cv::Size size, Paint paint);

  std::vector<Rod> rods_, shadows_;  // one shadow for each instrument
  float scale_;
};

}  // namespace csd::sim
