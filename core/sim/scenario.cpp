// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/scenario.h"

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/setting_text.h"

namespace csd::sim {
namespace {

constexpr std::array<std::string_view, effect_count> effect_names = {
    "heart-strong", "heart-mild", "liver",       "fold",        "slide",      "tear",  "grasp",    "cavity",
    "zoom",         "rotation",   "sway",        "jerk",        "tools",      "smoke", "specular", "blood",
    "irrigation",   "wipe",       "cut",         "black",       "field-stop", "text",  "light",    "exposure",
    "falloff",      "vignette",   "low-texture", "motion-blur", "focus-blur", "noise", "chroma",   "interlacing"};

constexpr std::array<std::string_view, scenario_count> scenario_names = {
    "deformation", "occlusion", "zoom", "rotation", "smoke", "specular", "low-texture", "mixed", "cut"};

using Set = std::initializer_list<std::pair<Effect, double>>;

Set effects_of(Scenario scenario) {
  using E = Effect;
  // The paper's simulation (§3.1): cardiac and respiratory deformation and noise, without highlights or changes of
  // light.
  static constexpr Set deformation = {{E::heart_mild, 1}, {E::liver, 0.5}};
  static constexpr Set occlusion = {{E::tools, 1}, {E::heart_mild, 0.7}, {E::liver, 0.5}, {E::specular, 0.5}};
  static constexpr Set zoom = {{E::zoom, 1}, {E::heart_mild, 0.5}, {E::sway, 0.4}, {E::specular, 0.4}};
  static constexpr Set rotation = {{E::rotation, 1}, {E::heart_mild, 0.5}, {E::sway, 0.4}, {E::specular, 0.4}};
  static constexpr Set smoke = {{E::smoke, 1}, {E::heart_mild, 0.5}, {E::liver, 0.4}, {E::specular, 0.4}};
  static constexpr Set specular = {{E::specular, 1}, {E::light, 0.7}, {E::heart_mild, 1}, {E::sway, 0.5}};
  static constexpr Set low_texture = {{E::low_texture, 1}, {E::heart_mild, 1}, {E::liver, 0.5}, {E::specular, 0.7}};
  static constexpr Set mixed = {{E::heart_mild, 0.8}, {E::liver, 0.4},    {E::fold, 0.5},     {E::tools, 0.8},
                                {E::zoom, 0.6},       {E::rotation, 0.5}, {E::sway, 0.6},     {E::smoke, 0.6},
                                {E::specular, 0.8},   {E::light, 0.6},    {E::exposure, 0.3}, {E::falloff, 0.3},
                                {E::motion_blur, 0.5}};
  static constexpr Set cut = {{E::cut, 1}, {E::heart_mild, 0.7}, {E::sway, 0.7}, {E::specular, 0.5}};
  switch (scenario) {
    case Scenario::deformation:
      return deformation;
    case Scenario::occlusion:
      return occlusion;
    case Scenario::zoom:
      return zoom;
    case Scenario::rotation:
      return rotation;
    case Scenario::smoke:
      return smoke;
    case Scenario::specular:
      return specular;
    case Scenario::low_texture:
      return low_texture;
    case Scenario::mixed:
      return mixed;
    case Scenario::cut:
      return cut;
  }
  return {};
}

template <std::size_t N>
std::string list(const std::array<std::string_view, N> &names) {
  std::string all;
  for (const auto name : names) {
    if (!all.empty()) all += ", ";
    all += name;
  }
  return all;
}

template <std::size_t N>
std::optional<std::size_t> find(const std::array<std::string_view, N> &names, std::string_view name) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) return {};
  return static_cast<std::size_t>(at - names.begin());
}

[[noreturn]] void fail(const std::string &what) {
  throw std::invalid_argument(what);
}

double parse_strength(std::string_view name, std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  // The comparison is false for NaN too.
  if (error != std::errc{} || end != text.data() + text.size() || !(value >= 0 && value <= strongest)) {
    fail("the strength of " + std::string(name) + " must be a number from 0 to 4, not " + shown_text(text));
  }
  return value;
}

}  // namespace

std::string_view effect_name(Effect effect) {
  return effect_names.at(static_cast<std::size_t>(effect));
}

void Effects::set(std::string_view text) {
  auto result = strength_;
  std::array<bool, effect_count> named{};
  if (trimmed(text).empty()) return;
  for (bool more = true; more;) {
    const auto comma = text.find(',');
    more = comma != text.npos;
    const std::string_view item = trimmed(text.substr(0, comma));
    if (more) text.remove_prefix(comma + 1);
    const auto equals = item.find('=');
    const std::string_view name = trimmed(item.substr(0, equals));
    const auto effect = find(effect_names, name);
    if (!effect) fail("no effect " + shown_text(name) + "; there are " + list(effect_names));
    if (std::exchange(named[*effect], true)) fail("the effect " + std::string(name) + " is named twice");
    result[*effect] = equals == item.npos ? 1 : parse_strength(name, trimmed(item.substr(equals + 1)));
  }
  strength_ = result;
}

std::string_view scenario_name(Scenario scenario) {
  return scenario_names.at(static_cast<std::size_t>(scenario));
}

Scenario parse_scenario(std::string_view name) {
  const auto index = find(scenario_names, trimmed(name));
  if (!index) fail("no scenario " + shown_text(name) + "; there are " + list(scenario_names));
  return static_cast<Scenario>(*index);
}

Effects scenario_effects(Scenario scenario, double strength) {
  Effects effects;
  for (const auto &[effect, value] : effects_of(scenario)) {
    effects[effect] = std::clamp(value * strength, 0.0, strongest);
  }
  effects[Effect::vignette] = effects[Effect::noise] = effects[Effect::chroma] = 1;
  return effects;
}

}  // namespace csd::sim
