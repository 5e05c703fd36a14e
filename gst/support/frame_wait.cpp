// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/frame_wait.h"

namespace csd {

void FrameWait::next() {
  ++frame_;
  patience_.end();
}

void FrameWait::stop() {
  patience_.end();
  look_again_.end();
}

void FrameWait::on_over(gpointer data, std::uint64_t frame) {
  auto *const self = static_cast<FrameWait *>(data);
  // A call for an earlier frame may come late.
  for (auto last = self->over_.load(); last < frame && !self->over_.compare_exchange_weak(last, frame);) continue;
  if (self->over()) self->wake_(self->element_);
}

void FrameWait::on_look_again(gpointer data, std::uint64_t) {
  auto *const self = static_cast<FrameWait *>(data);
  self->wake_(self->element_);
}

}  // namespace csd
