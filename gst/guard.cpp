// SPDX-License-Identifier: LGPL-2.1-or-later
#include "guard.h"

#include <opencv2/core.hpp>

namespace csd {

Failure describe_current_exception() noexcept {
  // Where memory is short a string fails too, unless it is as short as the first.
  constexpr const char *no_memory = "out of memory";
  Failure failure;
  try {
    try {
      // cppcheck-suppress rethrowNoCurrentException ; only called in a catch block, as guard.h says
      throw;
    } catch (const cv::Exception &e) {
      failure.out_of_memory = e.code == cv::Error::StsNoMem;
      failure.reason = failure.out_of_memory ? no_memory : "OpenCV failed: " + e.err;
      failure.detail = e.what();
    } catch (const std::bad_alloc &) {
      failure.out_of_memory = true;
      failure.reason = failure.detail = no_memory;
    } catch (const std::exception &e) {
      failure.reason = failure.detail = e.what();
    } catch (...) {
      failure.reason = failure.detail = "an exception of unknown type";
    }
  } catch (...) {
    failure.out_of_memory = true;
    failure.reason = failure.detail = no_memory;
  }
  return failure;
}

}  // namespace csd
