// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "support/lock.h"

namespace csd {

/// A property of an element, all in one place. `Values` holds the element's values.
template <class Values>
struct Property {
  GParamSpec *spec;  ///< name, texts, range, default, flags
  void (*get)(const Values &values, GValue *value) = nullptr;
  void (*set)(Values &values, const GValue *value) = nullptr;  ///< null for a read-only property
  /// Called after each setting, from the setter's thread, without the object lock.
  void (*changed)(gpointer object) = nullptr;
  /// Instead of `get`, for what is no setting. Called without the object lock.
  void (*compute)(gpointer object, GValue *value) = nullptr;
};

inline void to_value(GValue *value, const std::string &text) {
  g_value_set_string(value, text.c_str());
}
template <class T>
void to_value(GValue *value, T from) {
  if constexpr (std::is_enum_v<T>)
    g_value_set_enum(value, from);
  else if constexpr (std::is_same_v<T, bool>)
    g_value_set_boolean(value, from);
  else if constexpr (std::is_same_v<T, guint>)
    g_value_set_uint(value, from);
  else if constexpr (std::is_same_v<T, guint64>)
    g_value_set_uint64(value, from);
  else if constexpr (std::is_same_v<T, gint64>)
    g_value_set_int64(value, from);
  else {
    static_assert(std::is_same_v<T, gdouble>, "no property has this type yet");
    g_value_set_double(value, from);
  }
}

/// A property's text, which is never null.
inline std::string text_of(const GValue *value) {
  const gchar *text = g_value_get_string(value);
  return text ? text : "";
}

inline void from_value(const GValue *value, std::string &text) {
  text = text_of(value);
}
template <class T>
void from_value(const GValue *value, T &to) {
  if constexpr (std::is_enum_v<T>)
    to = static_cast<T>(g_value_get_enum(value));
  else if constexpr (std::is_same_v<T, bool>)
    to = g_value_get_boolean(value);
  else if constexpr (std::is_same_v<T, guint>)
    to = g_value_get_uint(value);
  else if constexpr (std::is_same_v<T, guint64>)
    to = g_value_get_uint64(value);
  else if constexpr (std::is_same_v<T, gint64>)
    to = g_value_get_int64(value);
  else {
    static_assert(std::is_same_v<T, gdouble>, "no property has this type yet");
    to = g_value_get_double(value);
  }
}

/// The property whose value is the member of `Values` at `Path`: a pointer to a member, for a member of a member two.
template <class Values, auto... Path>
Property<Values> member_property(GParamSpec *spec) {
  return {.spec = spec,
          .get = [](const Values &values, GValue *value) { to_value(value, (values.*....*Path)); },
          .set = [](Values &values, const GValue *value) { from_value(value, (values.*....*Path)); }};
}

/// The properties of an element class: installs them, and reads and writes an object's values under its object lock.
/// An id is the property's place in the table, from 1 on.
template <class Values>
class PropertyTable {
 public:
  /// Call once, in class_init. `category` is for a refused setting's warning.
  PropertyTable(GObjectClass *klass, std::vector<Property<Values>> properties, GstDebugCategory *category)
      : properties_(std::move(properties)), category_(category) {
    for (std::size_t i = 0; i < properties_.size(); ++i)
      g_object_class_install_property(klass, static_cast<guint>(i + 1), properties_[i].spec);
  }

  void get(gpointer object, const Values &values, guint id, GValue *value) const {
    const Property<Values> &property = properties_[id - 1];
    if (property.compute) return property.compute(object, value);
    const ObjectLock lock(object);
    property.get(values, value);
  }

  /// Returns false, with a warning in the log, if the property can be set in NULL and READY only
  /// (GST_PARAM_MUTABLE_READY) and the element is `running`: the value then stays. `running` is guarded by the object
  /// lock, too.
  bool set(gpointer object, Values &values, const bool &running, guint id, const GValue *value) const {
    const Property<Values> &property = properties_[id - 1];
    if (!set_value(object, values, running, property, value)) {
      GST_CAT_WARNING_OBJECT(category_, object, "%s can be set in NULL and READY only: it stays as it was",
                             property.spec->name);
      return false;
    }
    if (property.changed) property.changed(object);
    return true;
  }

 private:
  static bool set_value(gpointer object, Values &values, const bool &running, const Property<Values> &property,
                        const GValue *value) {
    const ObjectLock lock(object);
    if (running && property.spec->flags & GST_PARAM_MUTABLE_READY) return false;
    property.set(values, value);
    return true;
  }

  std::vector<Property<Values>> properties_;
  GstDebugCategory *category_;
};

}  // namespace csd
