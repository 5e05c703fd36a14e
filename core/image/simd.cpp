// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "image/simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace csd::HWY_NAMESPACE {

const char *Target() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace csd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd {

HWY_EXPORT(Target);

const char *simd_target() {
  return HWY_DYNAMIC_DISPATCH(Target)();
}

}  // namespace csd
#endif
