// SPDX-License-Identifier: LGPL-2.1-or-later
// The part of gstreamer-analytics 1.24 and later that csdtrack and its tests use, with the same signatures.
// ../../library.cpp implements it.
#pragma once

#include <gst/gst.h>

G_BEGIN_DECLS

typedef guintptr GstAnalyticsMtdType;
typedef struct _GstAnalyticsRelationMeta GstAnalyticsRelationMeta;

typedef struct _GstAnalyticsMtd {
  guint id;
  GstAnalyticsRelationMeta *meta;
} GstAnalyticsMtd;
typedef struct _GstAnalyticsMtd GstAnalyticsTrackingMtd;
typedef struct _GstAnalyticsMtd GstAnalyticsODMtd;

typedef struct {
  gsize initial_relation_order;
  gsize initial_buf_size;
} GstAnalyticsRelationMetaInitParams;

typedef enum { GST_ANALYTICS_REL_TYPE_NONE = 0, GST_ANALYTICS_REL_TYPE_RELATE_TO = 1 << 3 } GstAnalyticsRelTypes;

#define GST_ANALYTICS_RELATION_META_API_TYPE (gst_analytics_relation_meta_api_get_type())
GType gst_analytics_relation_meta_api_get_type(void);

GstAnalyticsRelationMeta *gst_buffer_add_analytics_relation_meta(GstBuffer *buffer);
GstAnalyticsRelationMeta *gst_buffer_add_analytics_relation_meta_full(GstBuffer *buffer,
                                                                      GstAnalyticsRelationMetaInitParams *room);
GstAnalyticsRelationMeta *gst_buffer_get_analytics_relation_meta(GstBuffer *buffer);

gsize gst_analytics_relation_get_length(GstAnalyticsRelationMeta *meta);
gboolean gst_analytics_relation_meta_set_relation(GstAnalyticsRelationMeta *meta, GstAnalyticsRelTypes type, guint from,
                                                  guint to);
GstAnalyticsRelTypes gst_analytics_relation_meta_get_relation(GstAnalyticsRelationMeta *meta, guint from, guint to);
gboolean gst_analytics_relation_meta_iterate(GstAnalyticsRelationMeta *meta, gpointer *state, GstAnalyticsMtdType type,
                                             GstAnalyticsMtd *found);
gboolean gst_analytics_relation_meta_get_direct_related(GstAnalyticsRelationMeta *meta, guint id,
                                                        GstAnalyticsRelTypes relation, GstAnalyticsMtdType type,
                                                        gpointer *state, GstAnalyticsMtd *found);

GstAnalyticsMtdType gst_analytics_tracking_mtd_get_mtd_type(void);
gboolean gst_analytics_relation_meta_add_tracking_mtd(GstAnalyticsRelationMeta *meta, guint64 tracking_id,
                                                      GstClockTime first_seen, GstAnalyticsTrackingMtd *tracking);
gboolean gst_analytics_tracking_mtd_update_last_seen(GstAnalyticsTrackingMtd *tracking, GstClockTime last_seen);
gboolean gst_analytics_tracking_mtd_set_lost(GstAnalyticsTrackingMtd *tracking);
gboolean gst_analytics_tracking_mtd_get_info(GstAnalyticsTrackingMtd *tracking, guint64 *tracking_id,
                                             GstClockTime *first_seen, GstClockTime *last_seen, gboolean *lost);

GstAnalyticsMtdType gst_analytics_od_mtd_get_mtd_type(void);
gboolean gst_analytics_relation_meta_add_od_mtd(GstAnalyticsRelationMeta *meta, GQuark type, gint x, gint y, gint w,
                                                gint h, gfloat confidence, GstAnalyticsODMtd *detection);
gboolean gst_analytics_relation_meta_get_od_mtd(GstAnalyticsRelationMeta *meta, guint id, GstAnalyticsODMtd *detection);
GQuark gst_analytics_od_mtd_get_obj_type(GstAnalyticsODMtd *detection);
gboolean gst_analytics_od_mtd_get_location(GstAnalyticsODMtd *detection, gint *x, gint *y, gint *w, gint *h,
                                           gfloat *confidence);

G_END_DECLS
