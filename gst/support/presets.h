// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <string>

namespace csd {

/// For G_IMPLEMENT_INTERFACE(GST_TYPE_PRESET, …): a preset holds all writable properties but the element's name and
/// parent, and the `-array` twins of text properties: a value that is saved twice may come back as the wrong one.
void init_preset(gpointer interface, gpointer);

/// The text of a property whose values contain no backslash. GStreamer (to 1.28 at least) saves a preset's text escaped
/// twice and reads it escaped once, so `1,2` comes back as `1\,2`: backslashes are left out. Null gives "".
std::string preset_text(const gchar *text);

}  // namespace csd
