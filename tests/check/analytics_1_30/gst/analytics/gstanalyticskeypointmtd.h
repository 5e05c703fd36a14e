// SPDX-License-Identifier: LGPL-2.1-or-later
// The part of gstreamer-analytics 1.30's key points that csdtrack and its tests use, with the same signatures (its main
// branch, 2026).
#pragma once

#include <gst/analytics/analytics.h>

G_BEGIN_DECLS

typedef struct _GstAnalyticsMtd GstAnalyticsKeypointMtd;

typedef enum {
  GST_ANALYTICS_KEYPOINT_DIMENSIONS_2D = 2,
  GST_ANALYTICS_KEYPOINT_DIMENSIONS_3D = 3,
} GstAnalyticsKeypointDimensions;

typedef enum {
  GST_ANALYTICS_KEYPOINT_VISIBILITY_UNKNOWN = 0,
  GST_ANALYTICS_KEYPOINT_VISIBILITY_VISIBLE = 1,
  GST_ANALYTICS_KEYPOINT_VISIBILITY_OCCLUDED = 1 << 2,
  GST_ANALYTICS_KEYPOINT_VISIBILITY_PROJECTED = 1 << 3,
} GstAnalyticsKeypointVisibility;

GstAnalyticsMtdType gst_analytics_keypoint_mtd_get_mtd_type(void);
gboolean gst_analytics_relation_meta_add_keypoint_mtd(GstAnalyticsRelationMeta *meta,
                                                      GstAnalyticsKeypointDimensions dimensions, gint x, gint y, gint z,
                                                      guint8 visibility, gfloat confidence,
                                                      GstAnalyticsKeypointMtd *point);
gboolean gst_analytics_keypoint_mtd_get_position(const GstAnalyticsKeypointMtd *point, gint *x, gint *y, gint *z,
                                                 GstAnalyticsKeypointDimensions *dimensions);
gboolean gst_analytics_keypoint_mtd_get_confidence(const GstAnalyticsKeypointMtd *point, gfloat *confidence);
gboolean gst_analytics_keypoint_mtd_get_visibility_flags(const GstAnalyticsKeypointMtd *point, guint8 *visibility);

G_END_DECLS
