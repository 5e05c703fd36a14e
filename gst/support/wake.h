// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/base/gstaggregator.h>

#include <cstdint>
#include <mutex>
#include <optional>

namespace csd {

/// A wake is an event on a GstAggregator's sink pad that makes the pad count as ready. It is a GAP, because
/// GstAggregator turns these into empty buffers without waiting for room in the queue.

/// Queues a wake that says `what`. From any thread; never blocks.
void queue_wake(GstAggregator *aggregator, GstAggregatorPad *pad, std::uint64_t what);

/// What an event says, if it is a wake.
std::optional<std::uint64_t> wakes(GstEvent *event);

/// For sink_event(): makes the wake's empty buffer by the base class's `sink_event`. The pad may have any segment; it
/// is changed meanwhile, so a flush, which resets it from another thread, must hold the same `segment_mutex`.
gboolean take_wake(GstAggregator *aggregator, GstAggregatorPad *pad, GstEvent *wake,
                   decltype(GstAggregatorClass::sink_event) sink_event, std::mutex &segment_mutex);

/// Empties the front of a pad's queue: its thread must not wait for room that nobody will make.
void drop_all(GstAggregatorPad *pad);

}  // namespace csd
