// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <mutex>
#include <optional>

namespace csd {

/// The latency of an element with two sink pads, computed like GstAggregator's: the larger minimum, the smaller
/// maximum, live if either is. All functions are thread-safe.
class UpstreamLatency {
 public:
  struct Latency {
    bool live = false;
    GstClockTime min = 0, max = GST_CLOCK_TIME_NONE;
    bool operator==(const Latency &) const = default;
  };

  /// Resets everything except the least.
  void start();
  /// Live, the minimum is at least this: for data later than upstream reports.
  void set_least(GstClockTime least);
  GstClockTime least();
  /// Upstream's answer may have changed: a new link or stream.
  void expire();

  /// Answers the LATENCY query from downstream with the latency upstream of both pads. `second` may be null. A pad
  /// without an answer is ignored; nothing if neither has one. `news`: the answer has changed.
  std::optional<Latency> tell(GstPad *first, GstPad *second, bool &news);
  /// The latency that downstream last got, because it uses that; without one, upstream's. After expire() it queries
  /// upstream again, and posts a LATENCY message from `element` if downstream needs to know.
  std::optional<Latency> current(GstElement *element, GstPad *first, GstPad *second);

 private:
  std::optional<Latency> ask(GstPad *first, GstPad *second);

  std::mutex mutex_;
  // All guarded by mutex_.
  GstClockTime least_ = 0;
  std::optional<Latency> told_, asked_;
  bool expired_ = true;
};

}  // namespace csd
