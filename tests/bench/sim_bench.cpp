// SPDX-License-Identifier: LGPL-2.1-or-later
// The simulator's frames a second at 640×480 on one core: the counter items_per_second.
#include <benchmark/benchmark.h>

#include "sim/simulator.h"

namespace {

using csd::sim::Effect;

void render(benchmark::State &state, const csd::sim::Effects &effects) {
  csd::sim::SimSettings settings;
  settings.effects = effects;
  csd::sim::Simulator simulator(settings);
  cv::Mat picture;
  std::uint64_t n = 0;
  for (auto _ : state) {
    simulator.render(n, picture);
    n = (n + 37) % 500;  // frames from a whole cycle of events
    benchmark::DoNotOptimize(picture.data);
  }
  state.SetItemsProcessed(state.iterations());
}

csd::sim::Effects with(csd::sim::Effects effects, std::initializer_list<Effect> more) {
  for (const Effect e : more) effects[e] = 1;
  return effects;
}

void truth(benchmark::State &state) {
  csd::sim::SimSettings settings;
  settings.effects = csd::sim::scenario_effects(csd::sim::Scenario::mixed);
  csd::sim::Simulator simulator(settings);
  const auto surface = simulator.on_surface(0, simulator.detect(100));
  cv::Mat picture;
  simulator.render(1, picture);
  for (auto _ : state) benchmark::DoNotOptimize(simulator.truth(1, surface));
}

void start(benchmark::State &state, csd::sim::Style style) {
  csd::sim::SimSettings settings;
  settings.style = style;
  for (auto _ : state) benchmark::DoNotOptimize(csd::sim::Simulator(settings));
}

const int registered = [] {
  for (std::size_t i = 0; i < csd::sim::scenario_count; ++i) {
    const auto scenario = static_cast<csd::sim::Scenario>(i);
    benchmark::RegisterBenchmark(("render/" + std::string(scenario_name(scenario))).c_str(), render,
                                 scenario_effects(scenario));
  }
  csd::sim::Effects geometry;
  benchmark::RegisterBenchmark("render/all geometry", render,
                               with(geometry, {Effect::heart_strong, Effect::heart_mild, Effect::liver, Effect::fold,
                                               Effect::zoom, Effect::rotation, Effect::sway, Effect::jerk}));
  csd::sim::Effects everything;
  for (std::size_t i = 0; i < csd::sim::effect_count; ++i) everything[static_cast<Effect>(i)] = 1;
  benchmark::RegisterBenchmark("render/every effect", render, everything);
  benchmark::RegisterBenchmark("truth of 100 points", truth);
  for (std::size_t i = 0; i < csd::sim::style_count; ++i) {
    const auto style = static_cast<csd::sim::Style>(i);
    benchmark::RegisterBenchmark(("start/" + std::string(style_name(style))).c_str(), start, style)
        ->Unit(benchmark::kMillisecond);
  }
  return 0;
}();

}  // namespace
