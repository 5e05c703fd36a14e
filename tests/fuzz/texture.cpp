// SPDX-License-Identifier: LGPL-2.1-or-later
// The file of csdsimsrc's property `texture`: decoded by the same elements, laid on a surface that is smaller.
#include <gst/gst.h>

#include <stdexcept>

#include "fuzz.h"
#include "sim/texture_map.h"
#include "sim_texture.h"

namespace {

/// What decodes PNG, and no more: start() has hidden all plugins. Not JPEG: jpegdec (1.22) never comes back from some
/// 18 bytes.
bool load_decoders() {
  csd_fuzz::ignore_criticals();  // pngdec's base class (1.22) on a picture of 2^31 bytes and more, to begin with
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
