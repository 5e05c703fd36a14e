// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <glib.h>

#include <memory>
#include <string>

namespace csd {

/// A file's name in quotation marks, for a message: the name may be any bytes, but a message is UTF-8.
inline std::string quoted(const std::string &path) {
  const std::unique_ptr<gchar, decltype(&g_free)> name(g_filename_display_name(path.c_str()), g_free);
  return std::string("\"") + name.get() + "\"";
}

}  // namespace csd
