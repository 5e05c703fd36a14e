// SPDX-License-Identifier: LGPL-2.1-or-later
#include "meta/analytics.h"

#include <gst/analytics/analytics.h>
#ifdef CSDTRACK_KEYPOINTS
#include <gst/analytics/gstanalyticskeypointmtd.h>
#endif

#include <algorithm>
#include <span>
#include <stdexcept>
#include <utility>

namespace csd {
namespace {

#ifdef CSDTRACK_KEYPOINTS
constexpr std::size_t per_feature = 3;
#else
constexpr std::size_t per_feature = 2;
#endif

/// The buffer's relation meta, or a new one with room for all features. There is one per buffer:
/// gst_buffer_add_analytics_relation_meta_full() returns the present one, and copying a frame copies no second one.
GstAnalyticsRelationMeta *relations(GstBuffer *buffer, std::size_t features) {
  if (auto *there = gst_buffer_get_analytics_relation_meta(buffer)) return there;
  GstAnalyticsRelationMetaInitParams room{per_feature * features, 64 * per_feature * features};
  return gst_buffer_add_analytics_relation_meta_full(buffer, &room);
}

bool gone(FeatureState state) {
  return state == FeatureState::lost || state == FeatureState::out || state == FeatureState::ended;
}

void relate(GstAnalyticsRelationMeta *meta, const GstAnalyticsMtd &one, const GstAnalyticsMtd &other) {
  gst_analytics_relation_meta_set_relation(meta, GST_ANALYTICS_REL_TYPE_RELATE_TO, one.id, other.id);
  gst_analytics_relation_meta_set_relation(meta, GST_ANALYTICS_REL_TYPE_RELATE_TO, other.id, one.id);
}

#ifdef CSDTRACK_KEYPOINTS
void add_point(GstAnalyticsRelationMeta *meta, const PatchBoxes &boxes, const Feature &f,
               const GstAnalyticsTrackingMtd &tracking) {
  if (gone(f.state)) return;
  constexpr guint8 seen = GST_ANALYTICS_KEYPOINT_VISIBILITY_VISIBLE;
  constexpr guint8 predicted = GST_ANALYTICS_KEYPOINT_VISIBILITY_OCCLUDED | GST_ANALYTICS_KEYPOINT_VISIBILITY_PROJECTED;
  const auto pixel = boxes.pixel(f.x, f.y);
  GstAnalyticsKeypointMtd point;
  if (pixel && gst_analytics_relation_meta_add_keypoint_mtd(meta, GST_ANALYTICS_KEYPOINT_DIMENSIONS_2D, pixel->x,
                                                            pixel->y, 0, claims_position(f.state) ? seen : predicted,
                                                            static_cast<gfloat>(f.confidence), &point))
    relate(meta, point, tracking);
}
#endif

}  // namespace

void Analytics::attach(GstBuffer *buffer, const PatchBoxes &boxes, const Tracks &tracks, GstClockTime running_time) {
  static const GQuark type = g_quark_from_static_string("csdtrack");
  std::unordered_map<FeatureId, Seen> seen;
  if (tracks.features.empty()) {
    seen_ = std::move(seen);
    return;
  }
  const std::size_t written = std::min(tracks.features.size(), max_features);
  if (written < tracks.features.size() && !std::exchange(told_, true))
    GST_WARNING("GstAnalytics metadata only for the first %zu of %zu features", written, tracks.features.size());
  GstAnalyticsRelationMeta *meta = relations(buffer, written);
  if (!meta) throw std::runtime_error("no room for a GstAnalyticsRelationMeta");
  for (const auto &f : std::span(tracks.features).first(written)) {
    const auto before = seen_.find(f.id);
    // Times restart after a flush; with points=truth ids do too.
    const bool known = before != seen_.end() && before->second.last <= running_time;
    Seen &times = seen[f.id] = known ? before->second : Seen{running_time, running_time};
    if (claims_position(f.state)) times.last = running_time;
    GstAnalyticsTrackingMtd tracking;
    if (!gst_analytics_relation_meta_add_tracking_mtd(meta, f.id, times.first, &tracking)) continue;
    gst_analytics_tracking_mtd_update_last_seen(&tracking, times.last);
    if (gone(f.state)) gst_analytics_tracking_mtd_set_lost(&tracking);
#ifdef CSDTRACK_KEYPOINTS
    add_point(meta, boxes, f, tracking);
#endif
    const auto box = claims_position(f.state) ? boxes.around(f.x, f.y) : std::nullopt;
    GstAnalyticsODMtd detection;
    if (box && gst_analytics_relation_meta_add_od_mtd(meta, type, box->x, box->y, box->width, box->height,
                                                      static_cast<gfloat>(f.confidence), &detection))
      relate(meta, detection, tracking);
  }
  seen_ = std::move(seen);
}

}  // namespace csd
