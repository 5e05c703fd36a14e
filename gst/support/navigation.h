// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>
#include <mutex>
#include <optional>

#include "track/tracker.h"

namespace csd {

/// What a click, a touch or a key press in a video sink's window means.
struct NavigationCommand {
  enum class Kind : std::uint8_t { add, remove, reset } kind;
  double x = 0, y = 0;  ///< pixels of the picture in the event; none for reset
};

const char *command_name(NavigationCommand::Kind kind);

/// Reads the events of a video sink's window. Thread-safe.
class Navigation {
 public:
  /// The first button or a finger adds a point, the third button removes the nearest, the key `r` resets. Nothing for
  /// other events.
  ///
  /// A finger adds when it comes down, as a button does: its place is that of the picture shown then, and by the time
  /// it is lifted the tissue has moved. So moving, lifting and cancelling mean nothing, and each finger adds its own
  /// point. Some toolkits (GTK) send a press of the first button, too, for the same finger: it adds nothing.
  std::optional<NavigationCommand> read(GstEvent *event);

 private:
  bool is_of_finger(const NavigationCommand &press);

  std::mutex mutex_;
  std::optional<NavigationCommand> touch_;  ///< the last one, until a press at its place
};

/// Takes effect with the next frame.
void apply(const NavigationCommand &command, Tracker &tracker);

}  // namespace csd
