// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>
#include <optional>

#include "track/tracker.h"

namespace csd {

/// What a user wants who clicks into a video sink's window, or presses a key there.
struct NavigationCommand {
  enum class Kind : std::uint8_t { add, remove, reset } kind;
  double x = 0, y = 0;  ///< pixels of the picture that the event is about; none for reset
};

const char *command_name(NavigationCommand::Kind kind);

/// A press of the first button adds a point, of the third removes the nearest; the key `r` resets. All else is none.
std::optional<NavigationCommand> read_command(GstEvent *event);

/// From the next frame on.
void apply(const NavigationCommand &command, Tracker &tracker);

}  // namespace csd
