// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <vector>

#include "image/patch.h"

namespace csd {

// The geometric model of §2.1.2.2: rotation, scale and perspective, each applied alone. All angles in degrees.

/// −45, −43, … 45: 46 angles ("from −45° to 45° at 2° intervals"). 0, the original example, is not among them.
inline constexpr double rotation_limit = 45, rotation_step = 2;
/// From 0.8 to 3, in 12 logarithmic steps.
inline constexpr double smallest_scale = 0.8, largest_scale = 3;
inline constexpr int scale_steps = 12;
/// Tilts about the horizontal and the vertical axis (the paper names no range).
inline constexpr double tilts[] = {-35, -25, 25, 35};
/// Distance of the tilts' camera from the patch, in sides of the patch. Close enough that a tilt and its opposite
/// differ: the near edge is then up to 1.3 times as long as the far one. The paper gives no value; this is our choice.
inline constexpr double camera_distance = 2;

/// Rotates the scene by `degrees`: the patch shows source offset R(degrees)·u.
Warp rotation_warp(double degrees);
/// Magnifies the scene by `magnification`: source offset u / magnification.
Warp scale_warp(double magnification);
/// Tilts the plane through the patch's centre out of the image plane by `degrees` about the axis (0: horizontal, 1:
/// vertical), seen by a pinhole camera at camera_distance · `side` pixels. The centre stays.
Warp tilt_warp(double degrees, int axis, int side);

/// All 66 warps for patches of `side` pixels, in this order: 46 rotations, 12 scales, 8 tilts (for each angle, first
/// about the horizontal axis, then the vertical).
std::vector<Warp> geometric_warps(int side);

}  // namespace csd
