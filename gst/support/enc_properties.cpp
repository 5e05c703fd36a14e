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
       * Since: 0.1
       */
      member_property<V, &V::role>(g_param_spec_enum(
          "role", "Role",
          "What is written. track: what csdtrack found. truth: a simulator's ground truth, for csd-score",
          GST_TYPE_CSD_TRACK_ENC_ROLE, d.role, flags)),
      /**
       * GstCsdTrackEnc:source:
       *
       * Since: 0.1
       */
      member_property<V, &V::source>(g_param_spec_string(
          "source", "Source", "If several csdtracks tracked the frame, the name of the one to write. Empty: the last",
          d.source.c_str(), flags)),
  };
}

}  // namespace csd
