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
       * Since: 0.1
       */
      member_property<V, &V::scenario>(g_param_spec_enum("scenario", "Scenario",
                                                         "What happens in the scene: a set of effects with strengths",
                                                         GST_TYPE_CSD_SIM_SCENARIO, d.scenario, flags)),
      /**
       * GstCsdSimSrc:seed:
       *
       * Since: 0.1
       */
      member_property<V, &V::seed>(g_param_spec_uint64(
          "seed", "Seed", "Seeds each random choice: each seed is another scene, the same on every run", 0, G_MAXUINT64,
          d.seed, flags)),
      /**
       * GstCsdSimSrc:strength:
       *
       * Since: 0.1
       */
      member_property<V, &V::strength>(
          g_param_spec_double("strength", "Strength",
                              "Multiplies the strengths of the scenario's effects, except vignette, noise and chroma",
                              0, sim::strongest, d.strength, flags)),
      /**
       * GstCsdSimSrc:effects:
       *
       * Since: 0.1
       */
      member_property<V, &V::effects>(g_param_spec_string(
          "effects", "Effects",
          "Strengths of your own, 0 to 4: tools=1,specular=.5; a name alone is 1. Each replaces the "
          "scenario's; strength does not apply. There are heart-strong, heart-mild, liver, fold, slide, "
          "tear, grasp, cavity, zoom, rotation, sway, jerk, tools, smoke, specular, blood, irrigation, "
          "wipe, cut, black, field-stop, text, light, exposure, falloff, vignette, low-texture, motion-"
          "blur, focus-blur, noise, chroma, interlacing",
          d.effects.c_str(), flags)),
      /**
       * GstCsdSimSrc:style:
       *
       * Since: 0.1
       */
      member_property<V, &V::style>(
          g_param_spec_enum("style", "Style", "The look of the tissue", GST_TYPE_CSD_SIM_STYLE, d.style, flags)),
      /**
       * GstCsdSimSrc:texture:
       *
       * Since: 0.1
       */
      member_property<V, &V::texture>(g_param_spec_string(
          "texture", "Texture",
          "A picture for the surface instead, in any format that gdk-pixbuf reads, mirrored beyond its "
          "edges. Empty: the style's texture",
          d.texture.c_str(), flags)),
      /**
       * GstCsdSimSrc:features:
       *
       * Since: 0.1
       */
      member_property<V, &V::features>(g_param_spec_uint("features", "Features",
                                                         "Number of points of the truth, detected on the first frame",
                                                         0, static_cast<guint>(max_points), d.features, flags)),
      /**
       * GstCsdSimSrc:points:
       *
       * Since: 0.1
       */
      member_property<V, &V::points>(g_param_spec_string(
          "points", "Points",
          "Instead the points at these pixels of the first frame: x,y;x,y;... with the ids 0, 1, 2... in "
          "that order. Empty: detection",
          d.points.c_str(), flags)),
      /**
       * GstCsdSimSrc:is-live:
       *
       * Since: 0.1
       */
      member_property<V, &V::is_live>(g_param_spec_boolean(
          "is-live", "Is live",
          "Makes frames in real time, as a camera, with a latency of one frame. The element is then not "
          "seekable",
          d.is_live, flags)),
  };
}

}  // namespace csd
