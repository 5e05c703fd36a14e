// SPDX-License-Identifier: LGPL-2.1-or-later
// The file of csdsimsrc's property `texture`: decoded by gdk-pixbuf and laid on a smaller surface.
#include <stdexcept>

#include "fuzz.h"
#include "sim/texture_map.h"
#include "support/sim_texture.h"

void csd_fuzz::run(std::string_view bytes) {
  ignore_criticals();  // the loaders may have their own
  const MemoryFile file(bytes);
  try {
    const cv::Mat picture = csd::load_picture(file.path());
    csd::sim::texture_of_picture(picture, 10, 6.4, 0, 1);
  } catch (const std::invalid_argument &error) {
    expect(is_utf8(error.what()));
  }
}
