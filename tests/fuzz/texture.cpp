// SPDX-License-Identifier: LGPL-2.1-or-later
// The file of csdsimsrc's property `texture`: decoded by the same elements and laid on a smaller surface.
#include <gst/gst.h>

#include <stdexcept>

#include "fuzz.h"
#include "sim/texture_map.h"
#include "support/sim_texture.h"

namespace {

/// Loads what decodes PNG, and no more: start() has hidden all plugins. Not JPEG: jpegdec (1.22) never returns from
/// some 18-byte inputs.
bool load_decoders() {
  csd_fuzz::ignore_criticals();  // pngdec's base class (1.22) has one for pictures of 2^31 bytes and more, for example
  for (const char *name : {"coreelements", "typefindfunctions", "playback", "app", "videoconvertscale", "png"}) {
    const std::string file = std::string(FUZZ_PLUGINS "/libgst") + name + ".so";
    GstPlugin *plugin = gst_plugin_load_file(file.c_str(), nullptr);
    if (!plugin) return false;
    gst_object_unref(plugin);
  }
  return true;
}

}  // namespace

void csd_fuzz::run(std::string_view bytes) {
  static const bool loaded = load_decoders();
  expect(loaded);
  const MemoryFile file(bytes);
  try {
    const cv::Mat picture = csd::load_picture(file.path());
    csd::sim::texture_of_picture(picture, 10, 6.4, 0, 1);
  } catch (const std::invalid_argument &error) {
    expect(is_utf8(error.what()));
  }
}
