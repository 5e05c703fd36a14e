// SPDX-License-Identifier: LGPL-2.1-or-later
// csdsimsrc with any properties and caps, for a few frames.
#include "elements.h"

void csd_fuzz::run(std::string_view bytes) {
  Numbers from(reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size());
  GstCaps *caps = video_caps(from, false);
  // Small, because a frame is slow to render.
  gst_caps_set_simple(caps, "width", G_TYPE_INT, 16 + static_cast<int>(choose(from, 8)), "height", G_TYPE_INT,
                      16 + static_cast<int>(choose(from, 8)), nullptr);
  Rig rig("csdsimsrc", caps);
  for (unsigned properties = choose(from, 5); properties > 0; --properties) set_property(from, rig.element());
  g_object_set(rig.element(), "num-buffers", static_cast<int>(1 + choose(from, 2)), "is-live", FALSE, nullptr);
  rig.set_state(GST_STATE_PLAYING);
  rig.wait();
  get_properties(rig.element());
}
