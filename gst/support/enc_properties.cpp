// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/enc_properties.h"

namespace csd {

std::vector<Property<EncValues>> enc_properties() {
  constexpr auto flags =
      static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_PLAYING);
  using V = EncValues;
  const V d;
  return {
      /**
       * GstCsdTrackEnc:role:
       *
       * Whether to write what csdtrack found, or the ground truth that csdsimsrc attached.
       *
       * Since: 0.1
       */
      member_property<V, &V::role>(g_param_spec_enum("role", "Role",
                                                     "Whether to write the tracks or the simulator's ground truth",
                                                     GST_TYPE_CSD_TRACK_ENC_ROLE, d.role, flags)),
      /**
       * GstCsdTrackEnc:source:
       *
       * The name of the element whose tracks to write, when several have tracked the same frame. Empty: the last
       * one.
       *
       * Since: 0.1
       */
      member_property<V, &V::source>(g_param_spec_string(
          "source", "Source",
          "Name of the element whose tracks to write, if several track the same frame (empty = the last one)",
          d.source.c_str(), flags)),
  };
}

}  // namespace csd
