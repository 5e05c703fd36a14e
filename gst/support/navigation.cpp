// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/navigation.h"

#include <gst/video/video.h>

#include <cmath>
#include <cstring>

namespace csd {

const char *command_name(NavigationCommand::Kind kind) {
  switch (kind) {
    case NavigationCommand::Kind::add:
      return "add";
    case NavigationCommand::Kind::remove:
      return "remove";
    case NavigationCommand::Kind::reset:
      break;
  }
  return "reset";
}

std::optional<NavigationCommand> read_command(GstEvent *event) {
  switch (gst_navigation_event_get_type(event)) {
    case GST_NAVIGATION_EVENT_MOUSE_BUTTON_PRESS: {
      gint button = 0;
      NavigationCommand command{NavigationCommand::Kind::add};
      if (!gst_navigation_event_parse_mouse_button_event(event, &button, &command.x, &command.y)) return {};
      if ((button != 1 && button != 3) || !std::isfinite(command.x) || !std::isfinite(command.y)) return {};
      if (button == 3) command.kind = NavigationCommand::Kind::remove;
      return command;
    }
    case GST_NAVIGATION_EVENT_KEY_PRESS: {
      const gchar *key = nullptr;
      if (!gst_navigation_event_parse_key_event(event, &key) || !key || std::strcmp(key, "r") != 0) return {};
      return NavigationCommand{NavigationCommand::Kind::reset};
    }
    default:
      return {};
  }
}

void apply(const NavigationCommand &command, Tracker &tracker) {
  switch (command.kind) {
    case NavigationCommand::Kind::add:
      tracker.add_point(command.x, command.y);
      break;
    case NavigationCommand::Kind::remove:
      tracker.remove_nearest(command.x, command.y);
      break;
    case NavigationCommand::Kind::reset:
      tracker.reset();
      break;
  }
}

}  // namespace csd
