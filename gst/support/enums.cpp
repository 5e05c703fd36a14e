// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/enums.h"

GType gst_csd_track_algorithm_get_type() {
  static const GEnumValue values[] = {
      {GST_CSD_TRACK_ALGORITHM_CSD,
       "Anchored patches, aligned and checked against the motion of the tissue around them; finds lost features again",
       "csd"},
      {GST_CSD_TRACK_ALGORITHM_CSD_2012, "Context-specific descriptors learnt online (Mountney & Yang 2012)",
       "csd-2012"},
      {GST_CSD_TRACK_ALGORITHM_LK, "Pyramidal Lucas-Kanade, for comparison", "lk"},
      {GST_CSD_TRACK_ALGORITHM_MS1, "Mean shift on colours chosen by variance ratio, for comparison", "ms1"},
      {GST_CSD_TRACK_ALGORITHM_MS2, "Mean shift on colours chosen by peak difference, for comparison", "ms2"},
      {GST_CSD_TRACK_ALGORITHM_SIFT,
       "SIFT keypoints matched with the first frame's, for comparison; too slow for live video", "sift"},
      {GST_CSD_TRACK_ALGORITHM_CSD_FOREST,
       "csd-2012 with several trees per feature, co-trained with its aligned patch: the future work of Mountney & "
       "Yang 2012",
       "csd-forest"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstCsdTrackAlgorithm", values);
  return type;
}

GType gst_csd_track_content_area_get_type() {
  static const GEnumValue values[] = {{GST_CSD_TRACK_CONTENT_AREA_AUTO,
                                       "Everything but the dark border (round, D-shaped, pillar box) and burnt-in "
                                       "graphics, which are found automatically",
                                       "auto"},
                                      {GST_CSD_TRACK_CONTENT_AREA_FULL, "The whole picture", "full"},
                                      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstCsdTrackContentArea", values);
  return type;
}

GType gst_csd_track_learning_get_type() {
  static const GEnumValue values[] = {
      {GST_CSD_TRACK_LEARNING_ASYNC, "Frames never wait for learning", "async"},
      {GST_CSD_TRACK_LEARNING_SYNC,
       "Every frame waits for its learning: without a frame-budget results are the same on every run and for every "
       "n-threads. Not for live video",
       "sync"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstCsdTrackLearning", values);
  return type;
}

GType gst_csd_track_overlay_get_type() {
  static const GEnumValue values[] = {
      {GST_CSD_TRACK_OVERLAY_NONE, "Nothing is shown", "none"},
      {GST_CSD_TRACK_OVERLAY_DRAW, "Markers are drawn into the pixels", "draw"},
      {GST_CSD_TRACK_OVERLAY_META,
       "A GstVideoOverlayComposition is attached and the pixels are left alone (one warning if nothing downstream can "
       "show it)",
       "meta"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstCsdTrackOverlay", values);
  return type;
}

GType gst_csd_track_post_messages_get_type() {
  static const GEnumValue values[] = {
      {GST_CSD_TRACK_POST_MESSAGES_NONE, "Never", "none"},
      {GST_CSD_TRACK_POST_MESSAGES_CHANGE, "When a feature is new or its state has changed", "change"},
      {GST_CSD_TRACK_POST_MESSAGES_FRAME, "With every frame", "frame"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstCsdTrackPostMessages", values);
  return type;
}

GType gst_csd_track_on_error_get_type() {
  static const GEnumValue values[] = {
      {GST_CSD_TRACK_ON_ERROR_ERROR, "Stop with an error message", "error"},
      {GST_CSD_TRACK_ON_ERROR_PASS, "Warn once, let frames through untouched and report features as lost", "pass"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstCsdTrackOnError", values);
  return type;
}

GType gst_csd_track_enc_role_get_type() {
  static const GEnumValue values[] = {
      {GST_CSD_TRACK_ENC_ROLE_TRACK, "The tracks (GstCsdTrackMeta)", "track"},
      {GST_CSD_TRACK_ENC_ROLE_TRUTH, "The simulator's ground truth (GstCsdTruthMeta)", "truth"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstCsdTrackEncRole", values);
  return type;
}

GType gst_csd_sim_scenario_get_type() {
  static const GEnumValue values[] = {
      {GST_CSD_SIM_SCENARIO_DEFORMATION, "Heartbeat and breathing", "deformation"},
      {GST_CSD_SIM_SCENARIO_OCCLUSION, "Two instruments sweep across, with shadows", "occlusion"},
      {GST_CSD_SIM_SCENARIO_ZOOM, "The scope moves closer and away: magnification 0.66 to 2.8", "zoom"},
      {GST_CSD_SIM_SCENARIO_ROTATION, "The scope rolls: -50 to 120 degrees", "rotation"},
      {GST_CSD_SIM_SCENARIO_SMOKE, "Smoke drifts past in two bursts", "smoke"},
      {GST_CSD_SIM_SCENARIO_SPECULAR, "Highlights on the moving surface, under a moving lamp", "specular"},
      {GST_CSD_SIM_SCENARIO_LOW_TEXTURE, "Smooth, faint tissue", "low-texture"},
      {GST_CSD_SIM_SCENARIO_MIXED, "Most of the above at once, with a fold, changing exposure and motion blur",
       "mixed"},
      {GST_CSD_SIM_SCENARIO_CUT, "Another scene for some seconds, and back", "cut"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstCsdSimScenario", values);
  return type;
}

GType gst_csd_sim_style_get_type() {
  static const GEnumValue values[] = {{GST_CSD_SIM_STYLE_HEART, "The heart's surface", "heart"},
                                      {GST_CSD_SIM_STYLE_LIVER, "Liver", "liver"},
                                      {GST_CSD_SIM_STYLE_PERITONEUM, "Peritoneum", "peritoneum"},
                                      {GST_CSD_SIM_STYLE_BOWEL, "Bowel", "bowel"},
                                      {GST_CSD_SIM_STYLE_FAT, "Fat", "fat"},
                                      {GST_CSD_SIM_STYLE_RETINA, "Retina", "retina"},
                                      {GST_CSD_SIM_STYLE_MUCOSA, "Mucosa", "mucosa"},
                                      {GST_CSD_SIM_STYLE_LOBES, "Fat in large lobes", "lobes"},
                                      {GST_CSD_SIM_STYLE_CHARRED, "Charred and bleeding tissue", "charred"},
                                      {GST_CSD_SIM_STYLE_SPECKLE, "White dots on dark grey", "speckle"},
                                      {GST_CSD_SIM_STYLE_PALE, "Cartilage: near white, faintly mottled", "pale"},
                                      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstCsdSimStyle", values);
  return type;
}
