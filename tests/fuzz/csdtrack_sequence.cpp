// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack's properties and signals, mixed with frames, events, queries and changes of state in any order.
#include "elements.h"

namespace {

using namespace csd_fuzz;

void signal(Numbers &from, GstElement *element) {
  guint id = 0;
  switch (choose(from, 2)) {
    case 0: {
      const double x = one_in(from, 4) ? from.ConsumeFloatingPoint<double>() : choose(from, 80);
      g_signal_emit_by_name(element, "add-point", x, from.ConsumeProbability<double>() * 64, &id);
      break;
    }
    case 1:
      g_signal_emit_by_name(element, "remove-point",
                            one_in(from, 8) ? from.ConsumeIntegral<guint>() : choose(from, 20));
      break;
    default:
      g_signal_emit_by_name(element, "reset");
  }
}

void step(Numbers &from, Rig &rig, unsigned &index) {
  switch (choose(from, 11)) {
    case 0:
      set_property(from, rig.element());
      break;
    case 1:
      signal(from, rig.element());
      break;
    case 2:
      rig.some_event(from, index);
      break;
    case 3:
      rig.some_query(from);
      break;
    case 4:
      rig.set_caps(video_caps(from, one_in(from, 8)));
      break;
    case 5:
      rig.set_state(static_cast<GstState>(GST_STATE_NULL + choose(from, GST_STATE_PLAYING - GST_STATE_NULL)));
      break;
    case 6:
      get_properties(rig.element());
      break;
    case 7:
      rig.renders_compositions = !rig.renders_compositions;
      break;
    default:
      rig.push(frame(from, rig.caps(), index++, one_in(from, 16)));
  }
}

}  // namespace

void csd_fuzz::run(std::string_view bytes) {
  Numbers from(reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size());
  Rig rig("csdtrack");
  g_object_set(rig.element(), "n-threads", 1u, nullptr);
  // Mostly the fastest algorithm: this tests the element, and csdtrack_frames tests csd's frames.
  if (!one_in(from, 4)) gst_util_set_object_arg(G_OBJECT(rig.element()), "algorithm", "lk");
  for (unsigned properties = choose(from, 5); properties > 0; --properties) set_property(from, rig.element());
  rig.set_state(GST_STATE_PLAYING);
  rig.set_caps(video_caps(from, false));
  unsigned index = 0;
  for (int steps = 0; steps < 12 && from.remaining_bytes() > 0; ++steps) step(from, rig, index);
}
