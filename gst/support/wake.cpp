// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/wake.h"

#include "support/lock.h"

namespace csd {

namespace {

constexpr char field[] = "csdtrack-wake";

}  // namespace

void queue_wake(GstAggregator *aggregator, GstAggregatorPad *pad, std::uint64_t what) {
  GstEvent *gap = gst_event_new_gap(0, GST_CLOCK_TIME_NONE);
  gst_structure_set(gst_event_writable_structure(gap), field, G_TYPE_UINT64, what, nullptr);
  GST_AGGREGATOR_GET_CLASS(aggregator)->sink_event_pre_queue(aggregator, pad, gap);
}

std::optional<std::uint64_t> wakes(GstEvent *event) {
  guint64 what = 0;
  const GstStructure *structure = gst_event_get_structure(event);
  return structure && gst_structure_get_uint64(structure, field, &what) ? std::optional<std::uint64_t>(what)
                                                                        : std::nullopt;
}

gboolean take_wake(GstAggregator *aggregator, GstAggregatorPad *pad, GstEvent *wake,
                   decltype(GstAggregatorClass::sink_event) sink_event, std::mutex &segment_mutex) {
  const std::lock_guard no_flush(segment_mutex);
  GstSegment own;
  {
    const ObjectLock lock(pad);
    own = pad->segment;
    gst_segment_init(&pad->segment, GST_FORMAT_TIME);
  }
  const gboolean done = sink_event(aggregator, pad, wake);
  const ObjectLock lock(pad);
  pad->segment = own;
  return done;
}

void drop_all(GstAggregatorPad *pad) {
  while (gst_aggregator_pad_drop_buffer(pad)) continue;
}

}  // namespace csd
