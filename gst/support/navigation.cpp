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

namespace {

std::optional<NavigationCommand> read_press(GstEvent *event) {
  gint button = 0;
  NavigationCommand command{NavigationCommand::Kind::add};
  if (!gst_navigation_event_parse_mouse_button_event(event, &button, &command.x, &command.y)) return {};
  if ((button != 1 && button != 3) || !std::isfinite(command.x) || !std::isfinite(command.y)) return {};
  if (button == 3) command.kind = NavigationCommand::Kind::remove;
  return command;
}

std::optional<NavigationCommand> read_touch(GstEvent *event) {
  guint finger = 0;
  gdouble pressure = 0;
  NavigationCommand command{NavigationCommand::Kind::add};
  if (!gst_navigation_event_parse_touch_event(event, &finger, &command.x, &command.y, &pressure)) return {};
  if (!std::isfinite(command.x) || !std::isfinite(command.y)) return {};
  return command;
}

}  // namespace

/// The toolkit copies the finger's position. So a press that the user means is hardly ever taken for it.
bool Navigation::is_of_finger(const NavigationCommand &press) {
  constexpr double same = 1;  // px
  if (!touch_ || press.kind != NavigationCommand::Kind::add) return false;
  if (std::abs(press.x - touch_->x) > same || std::abs(press.y - touch_->y) > same) return false;
  touch_.reset();
  return true;
}

std::optional<NavigationCommand> Navigation::read(GstEvent *event) {
  const std::lock_guard lock(mutex_);
  switch (gst_navigation_event_get_type(event)) {
    case GST_NAVIGATION_EVENT_MOUSE_BUTTON_PRESS: {
      const auto press = read_press(event);
      if (press && is_of_finger(*press)) return {};
      return press;
    }
    case GST_NAVIGATION_EVENT_TOUCH_DOWN: {
      const auto touch = read_touch(event);
      if (touch) touch_ = touch;
      return touch;
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
