// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>
// After OpenCV, because its macro fail() collides with streams.
#include <gst/check/gstcheck.h>

#include <algorithm>
#include <cstdlib>

#include "../faults.h"

namespace {

constexpr const char *kind_names[kinds] = {"operator new", "OpenCV allocation", "thread start"};

/// OpenCV's own allocator, which fails on demand.
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

/// From now on, fails() decides about each allocation of a cv::Mat. OpenCV uses one thread.
[[maybe_unused]] void let_opencv_fail() {
  static FailingAllocator allocator;
  cv::Mat::setDefaultAllocator(&allocator);
  cv::setNumThreads(1);
}

/// Runs `life` once for each fault of a kind: call number n fails, and with `last` all later ones, too. Before that, it
/// runs `life` twice without faults, for what a process makes only once, and to count the calls; `fine` checks the
/// second run. `look` gets n and the outcome of each fault, and says whether the fault had an effect; at least one
/// must. $CSDTRACK_FAULTS says about how many faults to plant (10; 0: all), evenly spread.
template <class Life, class Fine, class Look>
void plant_each(const char *name, Kind kind, bool last, Life life, Fine fine, Look look) {
  life();
  for (auto &n : calls) n = 0;
  fine(life());
  const char *wanted = std::getenv("CSDTRACK_FAULTS");
  const long there = calls[kind], most = wanted ? std::atol(wanted) : 10;
  const long step = most > 0 ? std::max(1L, there / most) : 1;
  long planted = 0, showed = 0;
  for (long n = 0; n < there; n += step, ++planted) {
    left[kind] = n;
    lasting = last;
    const auto outcome = life();
    left[kind] = -1;
    lasting = false;
    showed += look(n, outcome);
  }
  g_print("%s, %s%s: %ld of %ld faults planted, %ld showed\n", name, kind_names[kind],
          last ? " and all later ones" : "", planted, there, showed);
  fail_unless(there > 0 && showed > 0, "no fault of %s showed", kind_names[kind]);
}

}  // namespace
