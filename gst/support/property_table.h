// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "support/lock.h"

namespace csd {

/// A property of an element, all in one place. `Values` holds the element's values.
template <class Values>
struct Property {
  GParamSpec *spec;  ///< name, texts, range, default, flags
  void (*get)(const Values &values, GValue *value);
  void (*set)(Values &values, const GValue *value);  ///< null for a read-only property
};

/// A property's text, which is never null.
inline std::string text_of(const GValue *value) {
  const gchar *text = g_value_get_string(value);
  return text ? text : "";
}

/// The properties of an element class: installs them, and reads and writes an object's values under its object lock.
/// An id is the property's place in the table, from 1 on.
template <class Values>
class PropertyTable {
 public:
  /// Call once, in class_init.
  PropertyTable(GObjectClass *klass, std::vector<Property<Values>> properties) : properties_(std::move(properties)) {
    for (std::size_t i = 0; i < properties_.size(); ++i)
      g_object_class_install_property(klass, static_cast<guint>(i + 1), properties_[i].spec);
  }

  void get(gpointer object, const Values &values, guint id, GValue *value) const {
    const ObjectLock lock(object);
    properties_[id - 1].get(values, value);
  }

  /// Returns false, with a warning in the log, if the property can be set in NULL and READY only and the element is
  /// `running`: the value then stays. `running` is guarded by the object lock, too.
  bool set(gpointer object, Values &values, const bool &running, guint id, const GValue *value) const {
    const Property<Values> &property = properties_[id - 1];
    {
      const ObjectLock lock(object);
      if (!running || !(property.spec->flags & GST_PARAM_MUTABLE_READY)) {
        property.set(values, value);
        return true;
      }
    }
    GST_WARNING_OBJECT(object, "%s can be set in NULL and READY only: it stays as it was", property.spec->name);
    return false;
  }

 private:
  std::vector<Property<Values>> properties_;
};

}  // namespace csd
