// SPDX-License-Identifier: LGPL-2.1-or-later
#include "navigation.h"

#include <gst/video/video.h>

#include <cmath>
#include <cstring>

namespace csd {

const char *wish_name(Wish::What what) {
  switch (what) {
    case Wish::What::add:
      return "add";
    case Wish::What::remove:
      return "remove";
    case Wish::What::reset:
      break;
  }
  return "reset";
}

std::optional<Wish> read_wish(GstEvent *event) {
  switch (gst_navigation_event_get_type(event)) {
    case GST_NAVIGATION_EVENT_MOUSE_BUTTON_PRESS: {
      gint button = 0;
      Wish wish{Wish::What::add};
      if (!gst_navigation_event_parse_mouse_button_event(event, &button, &wish.x, &wish.y)) return {};
      if ((button != 1 && button != 3) || !std::isfinite(wish.x) || !std::isfinite(wish.y)) return {};
      if (button == 3) wish.what = Wish::What::remove;
      return wish;
    }
    case GST_NAVIGATION_EVENT_KEY_PRESS: {
      const gchar *key = nullptr;
      if (!gst_navigation_event_parse_key_event(event, &key) || !key || std::strcmp(key, "r") != 0) return {};
      return Wish{Wish::What::reset};
    }
    default:
      return {};
  }
}

void grant(const Wish &wish, Tracker &tracker) {
  switch (wish.what) {
    case Wish::What::add:
      tracker.add_point(wish.x, wish.y);
      break;
    case Wish::What::remove:
      tracker.remove_nearest(wish.x, wish.y);
      break;
    case Wish::What::reset:
      tracker.reset();
      break;
  }
}

}  // namespace csd
