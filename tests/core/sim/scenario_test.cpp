// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/scenario.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

namespace csd::sim {
namespace {

std::string error_of(std::string_view text) {
  Effects effects;
  try {
    effects.set(text);
  } catch (const std::invalid_argument &e) {
    return e.what();
  }
  return "";
}

TEST(Effects, AreSetByName) {
  Effects effects;
  for (std::size_t i = 0; i < effect_count; ++i) EXPECT_EQ(effects[static_cast<Effect>(i)], 0);
  effects.set("tools=1, specular=.5 ,\tzoom , noise = 4,heart-strong=0.25");
  EXPECT_EQ(effects[Effect::tools], 1);
  EXPECT_EQ(effects[Effect::specular], 0.5);
  EXPECT_EQ(effects[Effect::zoom], 1);
  EXPECT_EQ(effects[Effect::noise], 4);
  EXPECT_EQ(effects[Effect::heart_strong], 0.25);
  EXPECT_EQ(effects[Effect::smoke], 0);
  effects.set("tools=0");
  EXPECT_EQ(effects[Effect::tools], 0);
  EXPECT_EQ(effects[Effect::specular], 0.5);
  effects.set("  ");
  EXPECT_EQ(effects[Effect::specular], 0.5);
}

TEST(Effects, HaveDistinctNamesThatCanBeSet) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < effect_count; ++i) {
    const auto effect = static_cast<Effect>(i);
    EXPECT_TRUE(names.insert(effect_name(effect)).second);
    Effects effects;
    effects.set(std::string(effect_name(effect)) + "=2");
    EXPECT_EQ(effects[effect], 2);
  }
}

TEST(Effects, ErrorsSayWhatIsWrong) {
  const std::string unknown = error_of("tools=1,smok=1");
  EXPECT_NE(unknown.find("\"smok\""), unknown.npos) << unknown;
  for (std::size_t i = 0; i < effect_count; ++i) {
    EXPECT_NE(unknown.find(effect_name(static_cast<Effect>(i))), unknown.npos) << unknown;
  }
  for (const char *bad :
       {"tools=", "tools=x", "tools=1x", "tools=-1", "tools=4.01", "tools=nan", "tools=inf", "tools=1=2"}) {
    const std::string what = error_of(bad);
    EXPECT_NE(what.find("tools"), what.npos) << bad << ": " << what;
    EXPECT_NE(what.find("from 0 to 4"), what.npos) << bad << ": " << what;
  }
  for (const char *bad : {",", "tools,,zoom", "tools,", "=1", "Tools=1"}) EXPECT_NE(error_of(bad), "") << bad;
  EXPECT_EQ(error_of("tools=1,zoom, tools=2"), "the effect tools is named twice");
  // The text goes into messages, which must be UTF-8.
  EXPECT_EQ(error_of("\xffx").find("no effect \"?x\"; there are"), 0u);
  EXPECT_EQ(error_of("tools=\xe9"), "the strength of tools must be a number from 0 to 4, not \"?\"");
}

TEST(Effects, AnErrorChangesNothing) {
  Effects effects;
  effects.set("tools=1");
  EXPECT_THROW(effects.set("tools=3,zoom=2,nothing=1"), std::invalid_argument);
  EXPECT_EQ(effects[Effect::tools], 1);
  EXPECT_EQ(effects[Effect::zoom], 0);
}

TEST(Scenario, NamesAreParsedBack) {
  for (std::size_t i = 0; i < scenario_count; ++i) {
    const auto scenario = static_cast<Scenario>(i);
    EXPECT_EQ(parse_scenario(scenario_name(scenario)), scenario);
  }
  try {
    parse_scenario("zooom");
    FAIL();
  } catch (const std::invalid_argument &e) {
    const std::string what = e.what();
    for (std::size_t i = 0; i < scenario_count; ++i) {
      EXPECT_NE(what.find(scenario_name(static_cast<Scenario>(i))), what.npos) << what;
    }
  }
}

TEST(Scenario, HasTheEffectsOfItsName) {
  EXPECT_EQ(scenario_effects(Scenario::occlusion)[Effect::tools], 1);
  EXPECT_EQ(scenario_effects(Scenario::zoom)[Effect::zoom], 1);
  EXPECT_EQ(scenario_effects(Scenario::rotation)[Effect::rotation], 1);
  EXPECT_EQ(scenario_effects(Scenario::smoke)[Effect::smoke], 1);
  EXPECT_EQ(scenario_effects(Scenario::specular)[Effect::specular], 1);
  EXPECT_EQ(scenario_effects(Scenario::low_texture)[Effect::low_texture], 1);
  EXPECT_EQ(scenario_effects(Scenario::cut)[Effect::cut], 1);
  // The paper's simulation (§3.1) has neither highlights nor changes of light.
  const Effects paper = scenario_effects(Scenario::deformation);
  EXPECT_GT(paper[Effect::heart_mild], 0);
  EXPECT_GT(paper[Effect::liver], 0);
  for (const Effect e : {Effect::specular, Effect::light, Effect::exposure, Effect::falloff}) EXPECT_EQ(paper[e], 0);
}

TEST(Scenario, StrengthMultiplies) {
  const Effects one = scenario_effects(Scenario::mixed), half = scenario_effects(Scenario::mixed, 0.5);
  EXPECT_EQ(half[Effect::tools], 0.5 * one[Effect::tools]);
  EXPECT_EQ(half[Effect::noise], one[Effect::noise]);
  EXPECT_EQ(scenario_effects(Scenario::occlusion, 1000)[Effect::tools], strongest);
  const Effects none = scenario_effects(Scenario::mixed, 0);
  for (std::size_t i = 0; i < effect_count; ++i) {
    const auto e = static_cast<Effect>(i);
    const bool always = e == Effect::vignette || e == Effect::noise || e == Effect::chroma;
    EXPECT_EQ(none[e], always ? 1 : 0) << effect_name(e);
  }
}

}  // namespace
}  // namespace csd::sim
