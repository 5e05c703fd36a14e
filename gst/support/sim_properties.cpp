// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/sim_properties.h"

#include "base/types.h"
#include "sim/scenario.h"

namespace csd {

std::vector<Property<SimValues>> sim_properties() {
  constexpr auto flags = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_READY);
  using V = SimValues;
  const V d;
  return {
      /**
       * GstCsdSimSrc:scenario:
       *
       * A scenario is a set of effects with strengths. #GstCsdSimSrc:strength multiplies them,
       * #GstCsdSimSrc:effects changes single ones.
       *
       * Since: 0.1
       */
      member_property<V, &V::scenario>(
          g_param_spec_enum("scenario", "Scenario", "What happens in the scene: a set of effects and their strengths",
                            GST_TYPE_CSD_SIM_SCENARIO, d.scenario, flags)),
      /**
       * GstCsdSimSrc:seed:
       *
       * Seeds every random choice. Each seed gives a different scene, the same one on every run.
       *
       * Since: 0.1
       */
      member_property<V, &V::seed>(g_param_spec_uint64("seed", "Seed",
                                                       "Seeds every random choice; each seed gives a different scene",
                                                       0, G_MAXUINT64, d.seed, flags)),
      /**
       * GstCsdSimSrc:strength:
       *
       * Multiplies the strengths of the scenario's effects.
       *
       * Since: 0.1
       */
      member_property<V, &V::strength>(g_param_spec_double("strength", "Strength",
                                                           "Multiplies the strengths of the scenario's effects", 0,
                                                           sim::strongest, d.strength, flags)),
      /**
       * GstCsdSimSrc:effects:
       *
       * Effects and their strengths, 0 to 4: `tools=1,specular=.5`. They add to the scenario's effects or replace
       * their strengths. Text that can't be parsed is an error on the way to PAUSED.
       *
       * Since: 0.1
       */
      member_property<V, &V::effects>(g_param_spec_string(
          "effects", "Effects",
          "Effects and their strengths, 0 to 4, added to the scenario's effects or replacing their strengths: "
          "\"tools=1,specular=.5\". There are heart-strong, heart-mild, liver, fold, slide, tear, grasp, cavity, "
          "zoom, rotation, sway, jerk, tools, smoke, specular, blood, irrigation, wipe, cut, black, field-stop, text, "
          "light, exposure, falloff, vignette, low-texture, motion-blur, focus-blur, noise, chroma, interlacing",
          d.effects.c_str(), flags)),
      /**
       * GstCsdSimSrc:style:
       *
       * What the tissue looks like.
       *
       * Since: 0.1
       */
      member_property<V, &V::style>(
          g_param_spec_enum("style", "Style", "What the tissue looks like", GST_TYPE_CSD_SIM_STYLE, d.style, flags)),
      /**
       * GstCsdSimSrc:texture:
       *
       * A picture in any format that gdk-pixbuf has a loader for. It covers the surface instead of the style's
       * texture.
       *
       * Since: 0.1
       */
      member_property<V, &V::texture>(g_param_spec_string(
          "texture", "Texture",
          "A picture, in any format that gdk-pixbuf reads, that covers the surface (empty = the style's texture)",
          d.texture.c_str(), flags)),
      /**
       * GstCsdSimSrc:features:
       *
       * How many features to detect in the first frame and report in the truth meta.
       *
       * Since: 0.1
       */
      member_property<V, &V::features>(g_param_spec_uint(
          "features", "Features", "Number of features that the truth meta reports, detected on the first frame", 0,
          static_cast<guint>(max_points), d.features, flags)),
      /**
       * GstCsdSimSrc:points:
       *
       * Reports these pixels of the first frame instead: `x,y;x,y;…`, with the ids 0, 1, 2… in that order.
       *
       * Since: 0.1
       */
      member_property<V, &V::points>(
          g_param_spec_string("points", "Points",
                              "Report these pixels of the first frame instead: \"x,y;x,y;...\", ids 0, 1, "
                              "2... in that order (empty = detect)",
                              d.points.c_str(), flags)),
      /**
       * GstCsdSimSrc:is-live:
       *
       * Whether to produce frames in real time, as a camera does. The element is then not seekable.
       *
       * Since: 0.1
       */
      member_property<V, &V::is_live>(g_param_spec_boolean(
          "is-live", "Is live", "Produce frames in real time, as a camera does", d.is_live, flags)),
  };
}

}  // namespace csd
