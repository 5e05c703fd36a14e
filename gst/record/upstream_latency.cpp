// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/upstream_latency.h"

#include <algorithm>

namespace csd {

namespace {

using Latency = UpstreamLatency::Latency;

std::optional<Latency> latency_above(GstPad *pad) {
  if (!pad) return std::nullopt;
  GstQuery *query = gst_query_new_latency();
  std::optional<Latency> latency;
  if (gst_pad_peer_query(pad, query)) {
    gboolean live = FALSE;
    latency = Latency{};
    gst_query_parse_latency(query, &live, &latency->min, &latency->max);
    latency->live = live != 0;
    if (!GST_CLOCK_TIME_IS_VALID(latency->min)) latency->min = 0;
  }
  gst_query_unref(query);
  return latency;
}

Latency of_both(const Latency &a, const Latency &b) {
  // GST_CLOCK_TIME_NONE, no limit, is the largest value.
  return {a.live || b.live, std::max(a.min, b.min), std::min(a.max, b.max)};
}

}  // namespace

void UpstreamLatency::start() {
  const std::lock_guard lock(mutex_);
  told_.reset();
  asked_.reset();
  expired_ = true;
}

void UpstreamLatency::set_least(GstClockTime least) {
  const std::lock_guard lock(mutex_);
  least_ = least;
  expired_ = true;
}

GstClockTime UpstreamLatency::least() {
  const std::lock_guard lock(mutex_);
  return least_;
}

void UpstreamLatency::expire() {
  const std::lock_guard lock(mutex_);
  expired_ = true;
}

/// Called without the lock: upstream may take its own.
std::optional<Latency> UpstreamLatency::ask(GstPad *first, GstPad *second) {
  GstClockTime least = 0;
  {
    const std::lock_guard lock(mutex_);
    expired_ = false;  // from here on, expire() causes another query
    least = least_;
  }
  const auto a = latency_above(first), b = latency_above(second);
  std::optional<Latency> latency = a && b ? of_both(*a, *b) : a ? a : b;
  if (latency && latency->live && least > latency->min) {
    const GstClockTime more = least - latency->min;
    latency->min = least;
    // As if upstream started earlier by this much and buffered the data.
    if (GST_CLOCK_TIME_IS_VALID(latency->max)) latency->max += std::min(more, GST_CLOCK_TIME_NONE - 1 - latency->max);
  }
  const std::lock_guard lock(mutex_);
  asked_ = latency;
  if (!latency) expired_ = true;
  return latency;
}

std::optional<Latency> UpstreamLatency::tell(GstPad *first, GstPad *second, bool &news) {
  const auto latency = ask(first, second);
  const std::lock_guard lock(mutex_);
  news = latency && told_ != latency;
  if (latency) told_ = latency;
  return latency;
}

std::optional<Latency> UpstreamLatency::current(GstElement *element, GstPad *first, GstPad *second) {
  const auto known = [&] {
    const std::lock_guard lock(mutex_);
    return std::make_pair(expired_, told_ ? told_ : asked_);
  };
  if (const auto [expired, latency] = known(); !expired) return latency;
  const auto asked = ask(first, second);
  const auto latency = known().second;
  // Compares with what downstream last got, unless that has just changed.
  if (asked && latency && *asked != *latency)
    gst_element_post_message(element, gst_message_new_latency(GST_OBJECT(element)));
  return latency;
}

}  // namespace csd
