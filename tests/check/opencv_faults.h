// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <cstdlib>
#include <opencv2/core.hpp>

#include "../faults.h"

namespace {

constexpr const char *kind_names[kinds] = {"operator new", "OpenCV allocation", "thread start"};

/// OpenCV's own, that fails on demand.
class FailingAllocator : public cv::MatAllocator {
 public:
  cv::UMatData *allocate(int dims, const int *sizes, int type, void *data, size_t *step, cv::AccessFlag flags,
                         cv::UMatUsageFlags usage) const override {
    if (fails(opencv_allocation)) CV_Error(cv::Error::StsNoMem, "planted");
    return cv::Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
  }
  bool allocate(cv::UMatData *data, cv::AccessFlag flags, cv::UMatUsageFlags usage) const override {
    return cv::Mat::getStdAllocator()->allocate(data, flags, usage);
  }
  void deallocate(cv::UMatData *data) const override { cv::Mat::getStdAllocator()->deallocate(data); }
};

/// From now on a cv::Mat's memory is an OpenCV allocation that fails() is asked about. OpenCV works in one thread.
[[maybe_unused]] void let_opencv_fail() {
  static FailingAllocator allocator;
  cv::Mat::setDefaultAllocator(&allocator);
  cv::setNumThreads(1);
}

/// What `life` comes to when call number `n` of a kind fails, from 0, and with `last` all later ones.
template <class Life>
auto with_fault(Kind kind, long n, bool last, Life life) {
  left[kind] = n;
  lasting = last;
  auto outcome = life();
  left[kind] = -1;
  lasting = false;
  return outcome;
}

/// Between two faults, so that about $CSDTRACK_FAULTS of the `there` are planted (10; 0: all).
long step_between(long there) {
  const char *wanted = std::getenv("CSDTRACK_FAULTS");
  const long most = wanted ? std::atol(wanted) : 10;
  return most > 0 ? std::max(1L, there / most) : 1;
}

}  // namespace
