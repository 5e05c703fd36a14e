// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace csd {

/// The SIMD target of all kernels on this machine, by Highway's name: "AVX3", "AVX2", "SSE4", …
const char *simd_target();

}  // namespace csd
