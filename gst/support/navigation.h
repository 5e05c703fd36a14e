// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>
#include <optional>

#include "track/tracker.h"

namespace csd {

/// What a click or a key press in a video sink's window means.
struct NavigationCommand {
  enum class Kind : std::uint8_t { add, remove, reset } kind;
  double x = 0, y = 0;  ///< pixels of the picture in the event; none for reset
};

const char *command_name(NavigationCommand::Kind kind);

/// The first button adds a point, the third removes the nearest, the key `r` resets. Nothing for other events.
std::optional<NavigationCommand> read_command(GstEvent *event);

/// Takes effect with the next frame.
void apply(const NavigationCommand &command, Tracker &tracker);

}  // namespace csd
