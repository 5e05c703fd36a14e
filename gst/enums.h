// SPDX-License-Identifier: LGPL-2.1-or-later
//
// The enumerations of the elements' properties. glib-mkenums makes their GTypes (enumtypes.h); what a value does is
// told by the blurb of its property. Plain C: glib-mkenums reads it.
#pragma once

#include <glib-object.h>

G_BEGIN_DECLS

// glib-mkenums reads the comment behind a value: none may move.
// clang-format off
typedef enum {
  GST_CSD_TRACK_ALGORITHM_CSD = 0, /*< nick=csd >*/
  GST_CSD_TRACK_ALGORITHM_CSD_2012 = 1, /*< nick=csd-2012 >*/
  GST_CSD_TRACK_ALGORITHM_LK = 2, /*< nick=lk >*/
  GST_CSD_TRACK_ALGORITHM_MS1 = 3, /*< nick=ms1 >*/
  GST_CSD_TRACK_ALGORITHM_MS2 = 4, /*< nick=ms2 >*/
  GST_CSD_TRACK_ALGORITHM_SIFT = 5, /*< nick=sift >*/
} GstCsdTrackAlgorithm;

typedef enum {
  GST_CSD_TRACK_CONTENT_AREA_AUTO, /*< nick=auto >*/
  GST_CSD_TRACK_CONTENT_AREA_FULL, /*< nick=full >*/
} GstCsdTrackContentArea;

typedef enum {
  GST_CSD_TRACK_LEARNING_ASYNC, /*< nick=async >*/
  GST_CSD_TRACK_LEARNING_SYNC, /*< nick=sync >*/
} GstCsdTrackLearning;

typedef enum {
  GST_CSD_TRACK_OVERLAY_NONE, /*< nick=none >*/
  GST_CSD_TRACK_OVERLAY_DRAW, /*< nick=draw >*/
  GST_CSD_TRACK_OVERLAY_META, /*< nick=meta >*/
} GstCsdTrackOverlay;

typedef enum {
  GST_CSD_TRACK_POST_MESSAGES_NONE, /*< nick=none >*/
  GST_CSD_TRACK_POST_MESSAGES_CHANGE, /*< nick=change >*/
  GST_CSD_TRACK_POST_MESSAGES_FRAME, /*< nick=frame >*/
} GstCsdTrackPostMessages;

typedef enum {
  GST_CSD_TRACK_ON_ERROR_ERROR, /*< nick=error >*/
  GST_CSD_TRACK_ON_ERROR_PASS, /*< nick=pass >*/
} GstCsdTrackOnError;

typedef enum {
  GST_CSD_SIM_SCENARIO_DEFORMATION, /*< nick=deformation >*/
  GST_CSD_SIM_SCENARIO_OCCLUSION, /*< nick=occlusion >*/
  GST_CSD_SIM_SCENARIO_ZOOM, /*< nick=zoom >*/
  GST_CSD_SIM_SCENARIO_ROTATION, /*< nick=rotation >*/
  GST_CSD_SIM_SCENARIO_SMOKE, /*< nick=smoke >*/
  GST_CSD_SIM_SCENARIO_SPECULAR, /*< nick=specular >*/
  GST_CSD_SIM_SCENARIO_LOW_TEXTURE, /*< nick=low-texture >*/
  GST_CSD_SIM_SCENARIO_MIXED, /*< nick=mixed >*/
  GST_CSD_SIM_SCENARIO_CUT, /*< nick=cut >*/
} GstCsdSimScenario;

typedef enum {
  GST_CSD_SIM_STYLE_HEART, /*< nick=heart >*/
  GST_CSD_SIM_STYLE_LIVER, /*< nick=liver >*/
  GST_CSD_SIM_STYLE_PERITONEUM, /*< nick=peritoneum >*/
  GST_CSD_SIM_STYLE_BOWEL, /*< nick=bowel >*/
  GST_CSD_SIM_STYLE_FAT, /*< nick=fat >*/
} GstCsdSimStyle;
// clang-format on

G_END_DECLS
