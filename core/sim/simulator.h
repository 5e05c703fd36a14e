// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sim/scenario.h"
#include "sim/tissue_texture.h"
#include "track/types.h"

namespace csd::sim {

/// All that a simulation is made from.
struct SimSettings {
  Effects effects = scenario_effects(Scenario::deformation);
  std::uint64_t seed = 1;
  Style style = Style::heart;
  /// CV_8UC3, B G R: the surface's texture instead of the style's, one and a quarter times as high as the picture at
  /// the start, mirrored beyond its edges. Empty: the style's.
  cv::Mat texture;
  cv::Size size{640, 480};
  double rate = 25;  ///< frames a second
};

enum class Visibility : std::uint8_t {
  visible,
  hidden,  ///< by a tool, a fold, a fluid, smoke or a highlight; or there is no picture of it: field stop, text, cut
  out      ///< outside the frame
};

struct TruthPoint {
  FeatureId id = 0;
  double x = 0, y = 0;  ///< pixels, centres at integers: where the point is, seen or not
  Visibility visibility = Visibility::visible;
};

/// Simulated tissue with exact ground truth (§3.1): renders any frame, and says where each point of the surface is in
/// it.
///
/// A frame is a function of the settings and its number: frames may be asked for in any order. The same settings give
/// the same bytes on every machine of an architecture. Not thread safe; simulators share nothing.
class Simulator {
 public:
  /// Throws std::invalid_argument on a size outside 16×16…8192×8192, a rate that isn't above 0, or a texture of
  /// another type.
  explicit Simulator(const SimSettings &settings);
  ~Simulator();
  Simulator(Simulator &&) noexcept;
  Simulator &operator=(Simulator &&) noexcept;

  const SimSettings &settings() const;

  /// Renders frame `n`: `bgr` becomes CV_8UC3 of the size.
  void render(std::uint64_t n, cv::Mat &bgr);

  /// Features that core/detect finds on frame 0, best first: pixels.
  std::vector<cv::Point2d> detect(std::size_t wanted);

  /// The points of the surface (units) that the pixels of frame `n` show; behind a tool or a fluid, the tissue there.
  /// The surface goes on beyond the picture, but not everywhere: throws std::invalid_argument that names a pixel where
  /// there is none of it.
  std::vector<cv::Point2d> on_surface(std::uint64_t n, std::span<const cv::Point2d> pixels);
  /// The point of the surface that a pixel of `settings().texture` colours. Throws std::logic_error without one.
  cv::Point2d of_texture(cv::Point2d pixel) const;

  /// Where points of the surface are in frame `n`; ids are their indices. With interlacing that of the first field.
  /// What is hidden: at least half covered at the point, smoke of density 0.75 and more; a highlight where it blinds
  /// half of a disc of 5 pixels' radius (at 480 lines).
  std::vector<TruthPoint> truth(std::uint64_t n, std::span<const cv::Point2d> surface);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace csd::sim
