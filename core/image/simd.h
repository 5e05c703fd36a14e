// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace csd {

/// The SIMD target that all kernels dispatch to on this machine: "AVX3", "AVX2", "SSE4", … as Highway names them.
const char *simd_target();

}  // namespace csd
