// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core/types.hpp>

#include <span>
#include <string>
#include <string_view>

#include "base/types.h"
#include "programs/peers/peer.h"
#include "programs/peers/video_source.h"

namespace csd::peers {

/// A JSON line as csdtrackenc writes it (docs/metadata.md), with its newline. `ids` and `reports` correspond. A point
/// that is not seen is `lost`, or `out` if its position is outside the picture.
std::string track_line(std::string_view algorithm, std::uint64_t frame, const Picture &picture,
                       std::span<const FeatureId> ids, std::span<const Report> reports);

}  // namespace csd::peers
