// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <mutex>
#include <optional>

namespace csd {

/// The latency of an element with two sink pads, as GstAggregator counts it: the larger minimum, the smaller maximum,
/// live if either is. All functions may be called in any thread.
class UpstreamLatency {
 public:
  struct Latency {
    bool live = false;
    GstClockTime min = 0, max = GST_CLOCK_TIME_NONE;
    bool operator==(const Latency &) const = default;
  };

  /// All is as new, but for the least.
  void start();
  /// Live, the minimum is this at least: for what comes later than upstream says.
  void set_least(GstClockTime least);
  GstClockTime least();
  /// What upstream says may have changed: another link, another stream.
  void expire();

  /// The answer to the LATENCY query from downstream, by what is upstream of the two pads. `second` may be null, and a
  /// pad that gets no answer doesn't count; nothing where none does. `news`: it is another one than before.
  std::optional<Latency> tell(GstPad *first, GstPad *second, bool &news);
  /// What downstream was told last, for it reckons with that; what upstream says where it was told nothing yet. After
  /// expire() upstream is asked again, and where that is news for downstream, `element` posts a LATENCY message.
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
