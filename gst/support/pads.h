// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/base/gstaggregator.h>

#include <memory>

namespace csd {

struct UnrefObject {
  void operator()(gpointer object) const { gst_object_unref(object); }
};
using PadPtr = std::unique_ptr<GstAggregatorPad, UnrefObject>;

/// A pad of a GstAggregator; null if it has none of this name.
inline PadPtr pad_named(gpointer element, const char *name) {
  GstPad *pad = gst_element_get_static_pad(GST_ELEMENT(element), name);
  return PadPtr(pad ? GST_AGGREGATOR_PAD(pad) : nullptr);
}

inline bool is_request_pad(GstAggregatorPad *pad) {
  return GST_PAD_TEMPLATE_PRESENCE(GST_PAD_PAD_TEMPLATE(pad)) == GST_PAD_REQUEST;
}

}  // namespace csd
