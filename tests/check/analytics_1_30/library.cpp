// SPDX-License-Identifier: LGPL-2.1-or-later
// A gstreamer-analytics for tests on machines without one, or without key points. It stores the values and returns
// them. It does not scale them, or copy them along with a frame.
#include <gst/analytics/gstanalyticskeypointmtd.h>

#include <algorithm>
#include <vector>

namespace {

struct Entry {
  GstAnalyticsMtdType type;
  guint64 tracking_id = 0;
  GstClockTime first = 0, last = 0;
  gboolean lost = FALSE;
  GQuark object = 0;
  gint x = 0, y = 0, w = 0, h = 0, z = 0;
  GstAnalyticsKeypointDimensions dimensions = GST_ANALYTICS_KEYPOINT_DIMENSIONS_2D;
  guint8 visibility = 0;
  gfloat confidence = 0;
};

/// As in GStreamer, the relations are a square matrix with a row for each entry, which grows in steps of its first
/// size.
struct Store {
  std::vector<Entry> entries;
  std::vector<guint8> relations;
  std::size_t order = 0, step = 5;

  guint8 &relation(std::size_t from, std::size_t to) { return relations.at(order * from + to); }
  void grow() {
    std::vector<guint8> before((order + step) * (order + step));
    before.swap(relations);
    for (std::size_t row = 0; row < order; ++row)
      std::copy_n(before.begin() + static_cast<std::ptrdiff_t>(order * row), order,
                  relations.begin() + static_cast<std::ptrdiff_t>((order + step) * row));
    order += step;
  }
};

// Their addresses serve as types.
const char tracking_kind = 't', detection_kind = 'd', point_kind = 'p';

}  // namespace

struct _GstAnalyticsRelationMeta {
  GstMeta meta;
  Store *store;
};

namespace {

const GstMetaInfo *meta_info() {
  static const GstMetaInfo *info = gst_meta_register(
      gst_analytics_relation_meta_api_get_type(), "CsdTestRelationMeta", sizeof(GstAnalyticsRelationMeta),
      [](GstMeta *meta, gpointer params, GstBuffer *) -> gboolean {
        Store *store = reinterpret_cast<GstAnalyticsRelationMeta *>(meta)->store = new Store;
        if (params) store->step = static_cast<GstAnalyticsRelationMetaInitParams *>(params)->initial_relation_order;
        store->grow();
        return TRUE;
      },
      [](GstMeta *meta, GstBuffer *) { delete reinterpret_cast<GstAnalyticsRelationMeta *>(meta)->store; }, nullptr);
  return info;
}

Entry &entry(const GstAnalyticsMtd *mtd) {
  return mtd->meta->store->entries.at(mtd->id);
}

gboolean add(GstAnalyticsRelationMeta *meta, const Entry &entry, GstAnalyticsMtd *added) {
  *added = {static_cast<guint>(meta->store->entries.size()), meta};
  meta->store->entries.push_back(entry);
  if (meta->store->entries.size() > meta->store->order) meta->store->grow();
  return TRUE;
}

/// From index `state` on, the first entry of that type for which `wanted` holds.
template <class Wanted>
gboolean next(GstAnalyticsRelationMeta *meta, gpointer *state, GstAnalyticsMtdType type, GstAnalyticsMtd *found,
              Wanted wanted) {
  for (guint id = GPOINTER_TO_UINT(*state); id < meta->store->entries.size(); ++id) {
    if (meta->store->entries[id].type != type || !wanted(id)) continue;
    *state = GUINT_TO_POINTER(id + 1);
    *found = {id, meta};
    return TRUE;
  }
  return FALSE;
}

}  // namespace

GType gst_analytics_relation_meta_api_get_type() {
  static const gchar *tags[] = {nullptr};
  static const GType type = gst_meta_api_type_register("CsdTestRelationMetaAPI", tags);
  return type;
}

GstAnalyticsRelationMeta *gst_buffer_add_analytics_relation_meta_full(GstBuffer *buffer,
                                                                      GstAnalyticsRelationMetaInitParams *room) {
  if (auto *there = gst_buffer_get_analytics_relation_meta(buffer)) return there;
  return reinterpret_cast<GstAnalyticsRelationMeta *>(gst_buffer_add_meta(buffer, meta_info(), room));
}

GstAnalyticsRelationMeta *gst_buffer_add_analytics_relation_meta(GstBuffer *buffer) {
  return gst_buffer_add_analytics_relation_meta_full(buffer, nullptr);
}

GstAnalyticsRelationMeta *gst_buffer_get_analytics_relation_meta(GstBuffer *buffer) {
  return reinterpret_cast<GstAnalyticsRelationMeta *>(
      gst_buffer_get_meta(buffer, gst_analytics_relation_meta_api_get_type()));
}

gsize gst_analytics_relation_get_length(GstAnalyticsRelationMeta *meta) {
  return meta->store->entries.size();
}

gboolean gst_analytics_relation_meta_set_relation(GstAnalyticsRelationMeta *meta, GstAnalyticsRelTypes type, guint from,
                                                  guint to) {
  meta->store->relation(from, to) = type;
  return TRUE;
}

GstAnalyticsRelTypes gst_analytics_relation_meta_get_relation(GstAnalyticsRelationMeta *meta, guint from, guint to) {
  return static_cast<GstAnalyticsRelTypes>(meta->store->relation(from, to));
}

gboolean gst_analytics_relation_meta_iterate(GstAnalyticsRelationMeta *meta, gpointer *state, GstAnalyticsMtdType type,
                                             GstAnalyticsMtd *found) {
  return next(meta, state, type, found, [](guint) { return true; });
}

gboolean gst_analytics_relation_meta_get_direct_related(GstAnalyticsRelationMeta *meta, guint id,
                                                        GstAnalyticsRelTypes relation, GstAnalyticsMtdType type,
                                                        gpointer *state, GstAnalyticsMtd *found) {
  return next(meta, state, type, found,
              [=](guint other) { return (gst_analytics_relation_meta_get_relation(meta, id, other) & relation) != 0; });
}

GstAnalyticsMtdType gst_analytics_tracking_mtd_get_mtd_type() {
  return reinterpret_cast<GstAnalyticsMtdType>(&tracking_kind);
}

gboolean gst_analytics_relation_meta_add_tracking_mtd(GstAnalyticsRelationMeta *meta, guint64 tracking_id,
                                                      GstClockTime first_seen, GstAnalyticsTrackingMtd *tracking) {
  Entry entry{gst_analytics_tracking_mtd_get_mtd_type()};
  entry.tracking_id = tracking_id;
  entry.first = entry.last = first_seen;
  return add(meta, entry, tracking);
}

gboolean gst_analytics_tracking_mtd_update_last_seen(GstAnalyticsTrackingMtd *tracking, GstClockTime last_seen) {
  entry(tracking).last = last_seen;
  return TRUE;
}

gboolean gst_analytics_tracking_mtd_set_lost(GstAnalyticsTrackingMtd *tracking) {
  return entry(tracking).lost = TRUE;
}

gboolean gst_analytics_tracking_mtd_get_info(GstAnalyticsTrackingMtd *tracking, guint64 *tracking_id,
                                             GstClockTime *first_seen, GstClockTime *last_seen, gboolean *lost) {
  const Entry &e = entry(tracking);
  *tracking_id = e.tracking_id, *first_seen = e.first, *last_seen = e.last, *lost = e.lost;
  return TRUE;
}

GstAnalyticsMtdType gst_analytics_od_mtd_get_mtd_type() {
  return reinterpret_cast<GstAnalyticsMtdType>(&detection_kind);
}

gboolean gst_analytics_relation_meta_add_od_mtd(GstAnalyticsRelationMeta *meta, GQuark type, gint x, gint y, gint w,
                                                gint h, gfloat confidence, GstAnalyticsODMtd *detection) {
  Entry entry{gst_analytics_od_mtd_get_mtd_type()};
  entry.object = type;
  entry.x = x, entry.y = y, entry.w = w, entry.h = h, entry.confidence = confidence;
  return add(meta, entry, detection);
}

gboolean gst_analytics_relation_meta_get_od_mtd(GstAnalyticsRelationMeta *meta, guint id,
                                                GstAnalyticsODMtd *detection) {
  *detection = {id, meta};
  return id < meta->store->entries.size() && entry(detection).type == gst_analytics_od_mtd_get_mtd_type();
}

GQuark gst_analytics_od_mtd_get_obj_type(GstAnalyticsODMtd *detection) {
  return entry(detection).object;
}

gboolean gst_analytics_od_mtd_get_location(GstAnalyticsODMtd *detection, gint *x, gint *y, gint *w, gint *h,
                                           gfloat *confidence) {
  const Entry &e = entry(detection);
  *x = e.x, *y = e.y, *w = e.w, *h = e.h, *confidence = e.confidence;
  return TRUE;
}

GstAnalyticsMtdType gst_analytics_keypoint_mtd_get_mtd_type() {
  return reinterpret_cast<GstAnalyticsMtdType>(&point_kind);
}

gboolean gst_analytics_relation_meta_add_keypoint_mtd(GstAnalyticsRelationMeta *meta,
                                                      GstAnalyticsKeypointDimensions dimensions, gint x, gint y, gint z,
                                                      guint8 visibility, gfloat confidence,
                                                      GstAnalyticsKeypointMtd *point) {
  Entry entry{gst_analytics_keypoint_mtd_get_mtd_type()};
  entry.dimensions = dimensions;
  entry.x = x, entry.y = y, entry.z = z, entry.visibility = visibility, entry.confidence = confidence;
  return add(meta, entry, point);
}

gboolean gst_analytics_keypoint_mtd_get_position(const GstAnalyticsKeypointMtd *point, gint *x, gint *y, gint *z,
                                                 GstAnalyticsKeypointDimensions *dimensions) {
  const Entry &e = entry(point);
  *x = e.x, *y = e.y, *z = e.z, *dimensions = e.dimensions;
  return TRUE;
}

gboolean gst_analytics_keypoint_mtd_get_confidence(const GstAnalyticsKeypointMtd *point, gfloat *confidence) {
  *confidence = entry(point).confidence;
  return TRUE;
}

gboolean gst_analytics_keypoint_mtd_get_visibility_flags(const GstAnalyticsKeypointMtd *point, guint8 *visibility) {
  *visibility = entry(point).visibility;
  return TRUE;
}
