// SPDX-License-Identifier: LGPL-2.1-or-later
//
// The enumerations of the elements' properties. Only the description of a value documents it; gst-inspect-1.0 shows it.
// The GTypes are written by hand because glib-mkenums doesn't support descriptions.
#pragma once

#include <glib-object.h>

enum GstCsdTrackAlgorithm {
  GST_CSD_TRACK_ALGORITHM_CSD,
  GST_CSD_TRACK_ALGORITHM_CSD_2012,
  GST_CSD_TRACK_ALGORITHM_LK,
  GST_CSD_TRACK_ALGORITHM_MS1,
  GST_CSD_TRACK_ALGORITHM_MS2,
  GST_CSD_TRACK_ALGORITHM_SIFT,
  GST_CSD_TRACK_ALGORITHM_CSD_FOREST
};
#define GST_TYPE_CSD_TRACK_ALGORITHM (gst_csd_track_algorithm_get_type())
GType gst_csd_track_algorithm_get_type();

enum GstCsdTrackContentArea { GST_CSD_TRACK_CONTENT_AREA_AUTO, GST_CSD_TRACK_CONTENT_AREA_FULL };
#define GST_TYPE_CSD_TRACK_CONTENT_AREA (gst_csd_track_content_area_get_type())
GType gst_csd_track_content_area_get_type();

enum GstCsdTrackLearning { GST_CSD_TRACK_LEARNING_ASYNC, GST_CSD_TRACK_LEARNING_SYNC };
#define GST_TYPE_CSD_TRACK_LEARNING (gst_csd_track_learning_get_type())
GType gst_csd_track_learning_get_type();

enum GstCsdTrackOverlay { GST_CSD_TRACK_OVERLAY_NONE, GST_CSD_TRACK_OVERLAY_DRAW, GST_CSD_TRACK_OVERLAY_META };
#define GST_TYPE_CSD_TRACK_OVERLAY (gst_csd_track_overlay_get_type())
GType gst_csd_track_overlay_get_type();

enum GstCsdTrackPostMessages {
  GST_CSD_TRACK_POST_MESSAGES_NONE,
  GST_CSD_TRACK_POST_MESSAGES_CHANGE,
  GST_CSD_TRACK_POST_MESSAGES_FRAME
};
#define GST_TYPE_CSD_TRACK_POST_MESSAGES (gst_csd_track_post_messages_get_type())
GType gst_csd_track_post_messages_get_type();

enum GstCsdTrackOnError { GST_CSD_TRACK_ON_ERROR_ERROR, GST_CSD_TRACK_ON_ERROR_PASS };
#define GST_TYPE_CSD_TRACK_ON_ERROR (gst_csd_track_on_error_get_type())
GType gst_csd_track_on_error_get_type();

enum GstCsdTrackEncRole { GST_CSD_TRACK_ENC_ROLE_TRACK, GST_CSD_TRACK_ENC_ROLE_TRUTH };
#define GST_TYPE_CSD_TRACK_ENC_ROLE (gst_csd_track_enc_role_get_type())
GType gst_csd_track_enc_role_get_type();

enum GstCsdSimScenario {
  GST_CSD_SIM_SCENARIO_DEFORMATION,
  GST_CSD_SIM_SCENARIO_OCCLUSION,
  GST_CSD_SIM_SCENARIO_ZOOM,
  GST_CSD_SIM_SCENARIO_ROTATION,
  GST_CSD_SIM_SCENARIO_SMOKE,
  GST_CSD_SIM_SCENARIO_SPECULAR,
  GST_CSD_SIM_SCENARIO_LOW_TEXTURE,
  GST_CSD_SIM_SCENARIO_MIXED,
  GST_CSD_SIM_SCENARIO_CUT
};
#define GST_TYPE_CSD_SIM_SCENARIO (gst_csd_sim_scenario_get_type())
GType gst_csd_sim_scenario_get_type();

enum GstCsdSimStyle {
  GST_CSD_SIM_STYLE_HEART,
  GST_CSD_SIM_STYLE_LIVER,
  GST_CSD_SIM_STYLE_PERITONEUM,
  GST_CSD_SIM_STYLE_BOWEL,
  GST_CSD_SIM_STYLE_FAT,
  GST_CSD_SIM_STYLE_RETINA,
  GST_CSD_SIM_STYLE_MUCOSA,
  GST_CSD_SIM_STYLE_LOBES,
  GST_CSD_SIM_STYLE_CHARRED,
  GST_CSD_SIM_STYLE_SPECKLE,
  GST_CSD_SIM_STYLE_PALE
};
#define GST_TYPE_CSD_SIM_STYLE (gst_csd_sim_style_get_type())
GType gst_csd_sim_style_get_type();
