// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace csd::sim {

/// The effects in a simulated operation. A scenario is a set of effects with strengths.
enum class Effect : std::uint8_t {
  // Tissue and camera motion.
  heart_strong,  ///< an unstabilised beating heart: the surface moves by up to 40 px
  heart_mild,    ///< a stabilised heart, or tissue near one
  liver,         ///< breathing: slow shift and bulging
  fold,          ///< a fold that leans over the tissue behind it and breathes
  slide,         ///< a sheet of tissue slides over another
  tear,          ///< a cut opens and its edges part
  grasp,         ///< an instrument grasps the tissue, stretches it and lets go
  cavity,        ///< the scope moves in a hollow organ: near walls, a far end, ring-like folds
  zoom,          ///< the scope moves near and far: magnification 0.66…2.8
  rotation,      ///< the scope rolls: −50…120°
  sway,          ///< the scope drifts and trembles with the hand
  jerk,          ///< sudden camera moves
  // Occlusion.
  tools,       ///< instruments sweep in front and cast shadows
  smoke,       ///< drifts in two bursts
  specular,    ///< highlights that follow the surface normal and the lamp on the scope
  blood,       ///< oozes, is wiped away, and permanently changes the look of the tissue
  irrigation,  ///< water runs over the tissue and permanently changes its look
  wipe,        ///< the lens is wiped
  cut,         ///< another scene for some seconds, then back
  black,       ///< no picture for some seconds, while the view moves
  field_stop,  ///< the round edge of the scope's picture
  text,        ///< a clock burnt into the picture
  // Lighting.
  light,        ///< the lamp moves and changes colour; shading follows the moving surface
  exposure,     ///< the camera's exposure jumps
  falloff,      ///< light falls off with distance, so tissue that breathes towards the lamp gets brighter
  vignette,     ///< the picture's corners are darker
  low_texture,  ///< smooth, faint tissue
  // Sensor and optics.
  motion_blur,  ///< blur during the exposure
  focus_blur,   ///< out of focus now and then
  noise,        ///< sensor noise, depends on the signal: σ ≈ 2 at strength 1
  chroma,       ///< colour is softer than luma, like after demosaicing
  interlacing,  ///< two fields, half a frame apart
};
inline constexpr std::size_t effect_count = static_cast<std::size_t>(Effect::interlacing) + 1;
inline constexpr double strongest = 4;  ///< upper limit of strengths

/// "heart-strong", "heart-mild", …
std::string_view effect_name(Effect effect);

/// A strength, 0…4, for each effect: 0 is off, 1 is like a hard but ordinary operation.
class Effects {
 public:
  double operator[](Effect e) const { return strength_[static_cast<std::size_t>(e)]; }
  double &operator[](Effect e) { return strength_[static_cast<std::size_t>(e)]; }

  /// Sets the effects in `text`: "tools=1,specular=.5"; a name alone means 1, an empty text changes nothing. Ignores
  /// spaces. Throws std::invalid_argument that says what is wrong (duplicate names are, too) and, for an unknown name,
  /// lists the names; then nothing has been set.
  void set(std::string_view text);

 private:
  std::array<double, effect_count> strength_{};
};

enum class Scenario : std::uint8_t { deformation, occlusion, zoom, rotation, smoke, specular, low_texture, mixed, cut };
inline constexpr std::size_t scenario_count = static_cast<std::size_t>(Scenario::cut) + 1;

/// "deformation", "occlusion", …
std::string_view scenario_name(Scenario scenario);
/// Throws std::invalid_argument that lists the names.
Scenario parse_scenario(std::string_view name);

/// The effects of a scenario, each multiplied by `strength` (0…4; results are at most 4). Effects of every picture
/// (vignette, noise, soft chroma) are not scaled.
Effects scenario_effects(Scenario scenario, double strength = 1);

}  // namespace csd::sim
