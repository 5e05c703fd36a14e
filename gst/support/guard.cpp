// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/guard.h"

#include <opencv2/core.hpp>

namespace csd {

Failure describe_current_exception() noexcept {
  // Out of memory, allocating a string fails too, unless it fits into the string object itself.
  constexpr const char *no_memory = "out of memory";
  Failure failure;
  try {
    try {
      // cppcheck-suppress rethrowNoCurrentException ; only called in a catch block, as guard.h says
      throw;
    } catch (const Refusal &e) {
      failure.reason = failure.detail = e.what();
      failure.domain = e.domain;
      failure.code = e.code;
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
    failure.domain = 0;
    failure.out_of_memory = true;
    failure.reason = failure.detail = no_memory;
  }
  return failure;
}

Text Guard::text(const Failure &failure) const noexcept {
  if (failure.domain != 0) return {g_strdup(failure.reason.c_str()), g_free};
  if (failure.out_of_memory) return {g_strdup(memory_), g_free};
  return {g_strdup_printf("%s: %s.%s%s", failed_, failure.reason.c_str(), *advice_ ? " " : "", advice_), g_free};
}

void Guard::post(gpointer element, const Failure &failure, Place place) const noexcept {
  GQuark domain = failure.domain;
  int code = failure.code;
  if (domain == 0) {
    // Out of memory is a RESOURCE error, but not NO_SPACE_LEFT, which means a full disk.
    domain = failure.out_of_memory ? GST_RESOURCE_ERROR : GST_LIBRARY_ERROR;
    code = failure.out_of_memory ? static_cast<int>(GST_RESOURCE_ERROR_FAILED)
                                 : static_cast<int>(GST_LIBRARY_ERROR_FAILED);
  }
  gst_element_message_full(GST_ELEMENT(element), GST_MESSAGE_ERROR, domain, code, text(failure).release(),
                           failure.domain == 0 ? g_strdup(failure.detail.c_str()) : nullptr, place.file, place.function,
                           place.line);
}

void Guard::log(gpointer element, const Failure &failure, Place place) const noexcept {
  if (gst_debug_category_get_threshold(*category_) < GST_LEVEL_ERROR) return;
  gst_debug_log(*category_, GST_LEVEL_ERROR, place.file, place.function, place.line, G_OBJECT(element), "%s",
                failure.detail.c_str());
}

}  // namespace csd
