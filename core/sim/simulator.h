// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/types.h"
#include "sim/scenario.h"
#include "sim/tissue_texture.h"

namespace csd::sim {

/// The settings of a simulation.
struct SimSettings {
  Effects effects = scenario_effects(Scenario::deformation);
  std::uint64_t seed = 1;
  Style style = Style::heart;
  /// CV_8UC3, B G R: the surface's texture instead of the style's, 1.25 times as high as the initial picture, mirrored
  /// beyond its edges. Empty: the style's.
  cv::Mat texture;
  cv::Size size{640, 480};
  double rate = 25;  ///< frames per second
};

enum class Visibility : std::uint8_t {
  visible,
  hidden,  ///< by a tool, a fold, a fluid, smoke or a highlight, or not in the picture: field stop, text, cut
  out      ///< outside the frame
};

struct TruthPoint {
  FeatureId id = 0;
  double x = 0, y = 0;  ///< pixels, centres at integers: the true position, visible or not
  Visibility visibility = Visibility::visible;
};

/// Simulated tissue with exact ground truth (§3.1): renders any frame and gives the position of each surface point in
/// it.
///
/// A frame depends only on the settings and its number, so frames may be requested in any order. The same settings give
/// the same bytes on every machine of an architecture. Not thread-safe; simulators share nothing.
class Simulator {
 public:
  /// Throws std::invalid_argument for a size outside 16×16…8192×8192, a rate that isn't above 0, or a texture of
  /// another type.
  explicit Simulator(const SimSettings &settings);
  ~Simulator();
  Simulator(Simulator &&) noexcept;
  Simulator &operator=(Simulator &&) noexcept;

  const SimSettings &settings() const;

  /// Sets the rate in mid-stream: frame `first` is at `seconds`, and from there on `rate` frames follow each second.
  /// The scene and its surface points stay. At the start frame 0 is at 0 s. Throws std::invalid_argument for a rate
  /// that isn't above 0.
  void retime(double rate, std::uint64_t first, double seconds);

  /// Renders frame `n`: `bgr` becomes CV_8UC3 of the size.
  void render(std::uint64_t n, cv::Mat &bgr);

  /// The features that core/detect finds in frame 0, best first: pixels.
  std::vector<cv::Point2d> detect(std::size_t wanted);

  /// The surface points (units) under the pixels of frame `n`; under a tool or a fluid, those of the tissue there. The
  /// surface extends beyond the picture, but not without limit: throws std::invalid_argument that names a pixel without
  /// surface.
  std::vector<cv::Point2d> on_surface(std::uint64_t n, std::span<const cv::Point2d> pixels);
  /// The surface point coloured by a pixel of `settings().texture`. Throws std::logic_error without a texture.
  cv::Point2d of_texture(cv::Point2d pixel) const;

  /// The positions of surface points in frame `n`; ids are their indices. With interlacing they are those of the first
  /// field. A point is hidden if it is at least half covered, under smoke of density 0.75 and more, or if a highlight
  /// saturates half of a disc of 5 pixels' radius (at 480 lines).
  std::vector<TruthPoint> truth(std::uint64_t n, std::span<const cv::Point2d> surface);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace csd::sim
