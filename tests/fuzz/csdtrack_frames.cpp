// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack with caps and frames of any kind: formats, sizes, rates; buffers that are too short or too long, in several
// memories, read-only; with wrong GstVideoMeta and GstVideoCropMeta.
#include "elements.h"

void csd_fuzz::run(std::string_view bytes) {
  Numbers from(reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size());
  Rig rig("csdtrack");
  rig.renders_compositions = from.ConsumeBool();
  // on-error=pass most of the time: otherwise the first bad frame is the last.
  gst_util_set_object_arg(G_OBJECT(rig.element()), "on-error", one_in(from, 4) ? "error" : "pass");
  static const char *const overlays[] = {"none", "draw", "meta"};
  static const char *const algorithms[] = {"csd", "lk", "ms1", "ms2", "sift", "csd-2012"};
  gst_util_set_object_arg(G_OBJECT(rig.element()), "overlay", overlays[choose(from, 2)]);
  gst_util_set_object_arg(G_OBJECT(rig.element()), "algorithm", algorithms[choose(from, 5)]);
  g_object_set(rig.element(), "n-threads", 1u, "max-features", choose(from, 20), "patch-size", choose(from, 15),
               nullptr);
  if (one_in(from, 2)) g_object_set(rig.element(), "points", "5,5;20,10.5;-3,900", nullptr);
  rig.set_state(GST_STATE_PLAYING);
  unsigned index = 0;
  for (unsigned caps = choose(from, 1) + 1; caps > 0; --caps) {
    rig.set_caps(video_caps(from, true));
    for (unsigned frames = choose(from, 2) + 1; frames > 0; --frames) rig.push(frame(from, rig.caps(), index++, true));
  }
}
