// SPDX-License-Identifier: LGPL-2.1-or-later
#include "guard.h"

#include <opencv2/core.hpp>

namespace csd {

Failure describe_current_exception() noexcept {
  // A string that does not fit the small-string buffer may itself fail to be made when memory is short; the empty
  // Failure then still reports the error, without its words.
  Failure failure;
  try {
    try {
      // cppcheck-suppress rethrowNoCurrentException ; only called in a catch block, as guard.h says
      throw;
    } catch (const cv::Exception &e) {
      failure.out_of_memory = e.code == cv::Error::StsNoMem;
      failure.text = failure.out_of_memory ? "Out of memory while tracking. Track fewer features (max-features), or "
                                             "smaller pictures."
                                           : "OpenCV failed while tracking: " + e.err + ".";
      failure.detail = e.what();
    } catch (const std::bad_alloc &e) {
      failure.out_of_memory = true;
      failure.text = "Out of memory while tracking. Track fewer features (max-features), or smaller pictures.";
      failure.detail = e.what();
    } catch (const std::exception &e) {
      failure.text = std::string("Tracking failed: ") + e.what() + ".";
      failure.detail = e.what();
    } catch (...) {
      failure.text = "Tracking failed.";
      failure.detail = "an exception of unknown type";
    }
  } catch (...) {
    failure.out_of_memory = true;
  }
  return failure;
}

}  // namespace csd
