// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <string>

namespace csd_check {

/// The text of the next error or warning of these `types`; "" if there is none. Drops earlier messages of other types.
inline std::string said(GstBus *bus, GstMessageType types) {
  GstMessage *message = gst_bus_pop_filtered(bus, types);
  if (!message) return "";
  g_autoptr(GError) error = nullptr;
  (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR ? gst_message_parse_error : gst_message_parse_warning)(
      message, &error, nullptr);
  gst_message_unref(message);
  return error->message;
}

}  // namespace csd_check
