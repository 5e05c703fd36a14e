// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/presets.h"

#include <cstring>

namespace csd {
namespace {

bool is_kept(GObjectClass *klass, const gchar *name) {
  constexpr const char *twin = "-array";
  if (g_str_equal(name, "name") || g_str_equal(name, "parent")) return false;
  if (!g_str_has_suffix(name, twin)) return true;
  gchar *text = g_strndup(name, std::strlen(name) - std::strlen(twin));
  const bool has_text = g_object_class_find_property(klass, text) != nullptr;
  g_free(text);
  return !has_text;
}

gchar **property_names(GstPreset *preset) {
  const auto *usual = static_cast<GstPresetInterface *>(g_type_default_interface_peek(GST_TYPE_PRESET));
  gchar **names = usual->get_property_names(preset);
  if (!names) return nullptr;
  gchar **kept = names;
  for (gchar **name = names; *name; ++name) {
    if (is_kept(G_OBJECT_GET_CLASS(preset), *name))
      *kept++ = *name;
    else
      g_free(*name);
  }
  *kept = nullptr;
  return names;
}

}  // namespace

void init_preset(gpointer interface, gpointer) {
  static_cast<GstPresetInterface *>(interface)->get_property_names = property_names;
}

std::string preset_text(const gchar *text) {
  std::string plain = text ? text : "";
  std::erase(plain, '\\');
  return plain;
}

}  // namespace csd
