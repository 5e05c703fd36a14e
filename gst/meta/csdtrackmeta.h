/* SPDX-License-Identifier: LGPL-2.1-or-later */

/**
 * SECTION:csdtrackmeta
 * @title: Track metadata
 * @short_description: reads and writes the metadata that csdtrack attaches to frames
 *
 * #GST_CSD_TRACK_META_NAME holds the features as an element tracks them, #GST_CSD_TRUTH_META_NAME their true state from
 * a simulator. Both are a #GstCustomMeta with the same structure. The bus message `csdtrack` has the same fields, so
 * gst_csd_structure_get_header() and gst_csd_structure_get_feature() also read gst_message_get_structure().
 *
 * |[
 * GstCsdHeader header = { 0, };
 * GstCsdFeature feature = { 0, };
 * const GstStructure *tracks = gst_buffer_get_csd_tracks (buffer, GST_CSD_TRACK_META_NAME, NULL);
 *
 * if (tracks && gst_csd_structure_get_header (tracks, &header))
 *   for (guint i = 0; i < header.n_features; i++)
 *     if (gst_csd_structure_get_feature (tracks, i, &feature))
 *       g_print ("%u at %.3f,%.3f is %s\n", feature.id, feature.x, feature.y, feature.state);
 * ]|
 *
 * All functions are inline: a program needs this header and GStreamer >= 1.22, but no library. Loading the plugin
 * registers the two names: `gst_plugin_load_by_name ("csdtrack")`, or creating one of its elements.
 *
 * Returned strings belong to the buffer or the message.
 *
 * ## Versions
 *
 * The header has the version of the project it comes with: #GST_CSD_META_CHECK_VERSION. Later versions take
 * nothing away, and the two structs only grow at their end. That breaks no compiled program: its copies of the
 * functions and of the structs come from the same header, and the metadata itself has no structs, but named fields. So:
 *
 * * Zero a struct before you fill it: in a new field zero means "not said".
 * * Don't hand the structs, or arrays of them, to a module that may be compiled with another version of this header.
 *   Hand over the #GstBuffer or the #GstStructure.
 *
 * Since: 0.1
 */

#ifndef GST_CSD_TRACK_META_H
#define GST_CSD_TRACK_META_H

#include <gst/gst.h>

G_BEGIN_DECLS

/**
 * GST_CSD_META_VERSION_MAJOR:
 *
 * The first number of this header's version, which is csdtrack's.
 *
 * Since: 0.1
 */
#define GST_CSD_META_VERSION_MAJOR 0
/**
 * GST_CSD_META_VERSION_MINOR:
 *
 * The second number of this header's version.
 *
 * Since: 0.1
 */
#define GST_CSD_META_VERSION_MINOR 1
/**
 * GST_CSD_META_VERSION_MICRO:
 *
 * The third number of this header's version.
 *
 * Since: 0.1
 */
#define GST_CSD_META_VERSION_MICRO 0
/**
 * GST_CSD_META_CHECK_VERSION:
 * @major: a number
 * @minor: a number
 * @micro: a number
 *
 * Whether this header is of that version or a later one. For `#if`, too. The plugin at run time may be of another:
 * gst_plugin_get_version() tells.
 *
 * Since: 0.1
 */
#define GST_CSD_META_CHECK_VERSION(major, minor, micro)                               \
  (GST_CSD_META_VERSION_MAJOR > (major) ||                                            \
   (GST_CSD_META_VERSION_MAJOR == (major) && GST_CSD_META_VERSION_MINOR > (minor)) || \
   (GST_CSD_META_VERSION_MAJOR == (major) && GST_CSD_META_VERSION_MINOR == (minor) && \
    GST_CSD_META_VERSION_MICRO >= (micro)))

/**
 * GST_CSD_TRACK_META_NAME:
 *
 * Name of a tracker's meta.
 *
 * Since: 0.1
 */
#define GST_CSD_TRACK_META_NAME "GstCsdTrackMeta"
/**
 * GST_CSD_TRUTH_META_NAME:
 *
 * Name of a simulator's meta.
 *
 * Since: 0.1
 */
#define GST_CSD_TRUTH_META_NAME "GstCsdTruthMeta"
/**
 * GST_CSD_META_SCHEMA:
 *
 * The schema version that this header writes, and the highest that it reads. New fields don't change it; a new meaning
 * of a field does.
 *
 * Since: 0.1
 */
#define GST_CSD_META_SCHEMA 1

/**
 * GST_CSD_STATE_LEARNING:
 *
 * Seen, in the first `training-time` of a feature; the position is claimed.
 *
 * Since: 0.1
 */
#define GST_CSD_STATE_LEARNING "learning"
/**
 * GST_CSD_STATE_TRACKED:
 *
 * Seen; the position is claimed.
 *
 * Since: 0.1
 */
#define GST_CSD_STATE_TRACKED "tracked"
/**
 * GST_CSD_STATE_OCCLUDED:
 *
 * Hidden for less than a second; the position is a prediction.
 *
 * Since: 0.1
 */
#define GST_CSD_STATE_OCCLUDED "occluded"
/**
 * GST_CSD_STATE_LOST:
 *
 * Hidden for longer; the position is the last claimed one.
 *
 * Since: 0.1
 */
#define GST_CSD_STATE_LOST "lost"
/**
 * GST_CSD_STATE_OUT:
 *
 * Left the picture; the position is the last claimed one.
 *
 * Since: 0.1
 */
#define GST_CSD_STATE_OUT "out"
/**
 * GST_CSD_STATE_ENDED:
 *
 * Reported once and then dropped; the position is the last claimed one.
 *
 * Since: 0.1
 */
#define GST_CSD_STATE_ENDED "ended"

/**
 * GstCsdHeader:
 * @source: name of the element that wrote it
 * @algorithm: "csd", "csd-2012", "lk", …; "truth" in a truth meta
 * @frame: number of the frame since that element left READY, from 0
 * @width: width, in pixels, of the picture that x refers to
 * @height: height, in pixels, of the picture that y refers to
 * @tracked_width: width of the picture in which the features were tracked; unlike @width it doesn't change when the
 *   frame is scaled
 * @tracked_height: height of the picture in which the features were tracked
 * @n_features: how many features there are
 *
 * What the metadata says about a frame besides its features.
 *
 * Since: 0.1
 */
typedef struct {
  const gchar *source;
  const gchar *algorithm;
  guint64 frame;
  gint width;
  gint height;
  gint tracked_width;
  gint tracked_height;
  guint n_features;
} GstCsdHeader;

/**
 * GstCsdFeature:
 * @id: not reused until the element goes to READY
 * @x: pixels; the centre of the leftmost pixel is 0
 * @y: pixels; the centre of the topmost pixel is 0
 * @state: one of the GST_CSD_STATE_ words; only "learning" and "tracked" claim a position
 * @confidence: probability that the feature is visible and near x,y: 0 to 1
 * @fresh: %FALSE if the feature had to wait for the next frame
 *
 * One feature in one frame.
 *
 * Since: 0.1
 */
typedef struct {
  guint id;
  gdouble x;
  gdouble y;
  const gchar *state;
  gdouble confidence;
  gboolean fresh;
} GstCsdFeature;

/**
 * gst_buffer_iterate_csd_tracks:
 * @buffer: a #GstBuffer
 * @iter: (inout): an iteration pointer, to be %NULL at first
 * @name: #GST_CSD_TRACK_META_NAME or #GST_CSD_TRUTH_META_NAME
 *
 * Each tracking element adds its own meta. This iterates over those called @name in the order they were added.
 *
 * Returns: (transfer none) (nullable): the structure of the next one, %NULL after the last
 *
 * Since: 0.1
 */
static inline const GstStructure *gst_buffer_iterate_csd_tracks(GstBuffer *buffer, gpointer *iter, const gchar *name) {
  const GstMetaInfo *info = gst_meta_get_info(name);
  GstMeta *meta;

  if (info == NULL || !gst_meta_info_is_custom(info)) return NULL;
  while ((meta = gst_buffer_iterate_meta(buffer, iter)) != NULL)
    if (meta->info == info) return gst_custom_meta_get_structure((GstCustomMeta *)meta);
  return NULL;
}

/**
 * gst_buffer_get_csd_tracks:
 * @buffer: a #GstBuffer
 * @name: #GST_CSD_TRACK_META_NAME or #GST_CSD_TRUTH_META_NAME
 * @source: (nullable): name of the element that wrote it; %NULL or "" for any
 *
 * Returns: (transfer none) (nullable): the structure of the last meta added with that name and source, or %NULL
 *
 * Since: 0.1
 */
static inline const GstStructure *gst_buffer_get_csd_tracks(GstBuffer *buffer, const gchar *name, const gchar *source) {
  const GstStructure *structure, *last = NULL;
  gpointer iter = NULL;

  while ((structure = gst_buffer_iterate_csd_tracks(buffer, &iter, name)) != NULL)
    if (source == NULL || *source == '\0' || g_strcmp0(gst_structure_get_string(structure, "source"), source) == 0)
      last = structure;
  return last;
}

/**
 * gst_csd_structure_get_header:
 * @structure: of a meta or of a `csdtrack` message
 * @header: (out caller-allocates): where to write
 *
 * Returns: %TRUE if @structure has all the fields of #GstCsdHeader and a schema that this header knows; otherwise
 *   @header is undefined
 *
 * Since: 0.1
 */
static inline gboolean gst_csd_structure_get_header(const GstStructure *structure, GstCsdHeader *header) {
  const GValue *features = gst_structure_get_value(structure, "features");
  gint schema;

  if (features == NULL || !GST_VALUE_HOLDS_ARRAY(features)) return FALSE;
  header->n_features = gst_value_array_get_size(features);
  header->source = gst_structure_get_string(structure, "source");
  header->algorithm = gst_structure_get_string(structure, "algorithm");
  return header->source != NULL && header->algorithm != NULL && gst_structure_get_int(structure, "schema", &schema) &&
         schema >= 1 && schema <= GST_CSD_META_SCHEMA && gst_structure_get_uint64(structure, "frame", &header->frame) &&
         gst_structure_get_int(structure, "width", &header->width) &&
         gst_structure_get_int(structure, "height", &header->height) &&
         gst_structure_get_int(structure, "tracked-width", &header->tracked_width) &&
         gst_structure_get_int(structure, "tracked-height", &header->tracked_height);
}

/**
 * gst_csd_structure_get_feature:
 * @structure: of a meta or of a `csdtrack` message
 * @i: which one, 0 to #GstCsdHeader.n_features - 1; features are sorted by ascending id
 * @feature: (out caller-allocates): where to write
 *
 * Returns: %TRUE if there is an @i-th feature with all the fields of #GstCsdFeature; otherwise @feature is undefined
 *
 * Since: 0.1
 */
static inline gboolean gst_csd_structure_get_feature(const GstStructure *structure, guint i, GstCsdFeature *feature) {
  const GValue *value = gst_structure_get_value(structure, "features");
  const GstStructure *fields;

  if (value == NULL || !GST_VALUE_HOLDS_ARRAY(value) || i >= gst_value_array_get_size(value)) return FALSE;
  value = gst_value_array_get_value(value, i);
  if (!GST_VALUE_HOLDS_STRUCTURE(value) || (fields = gst_value_get_structure(value)) == NULL) return FALSE;
  feature->state = gst_structure_get_string(fields, "state");
  return feature->state != NULL && gst_structure_get_uint(fields, "id", &feature->id) &&
         gst_structure_get_double(fields, "x", &feature->x) && gst_structure_get_double(fields, "y", &feature->y) &&
         gst_structure_get_double(fields, "confidence", &feature->confidence) &&
         gst_structure_get_boolean(fields, "fresh", &feature->fresh);
}

/**
 * gst_csd_structure_set_features:
 * @structure: a writable structure
 * @features: (array length=n_features): in ascending order of their ids
 * @n_features: how many
 *
 * Replaces only the features. Their states are interned: pass the GST_CSD_STATE_ words, not ever new strings.
 *
 * Since: 0.1
 */
static inline void gst_csd_structure_set_features(GstStructure *structure, const GstCsdFeature *features,
                                                  guint n_features) {
  GValue array = G_VALUE_INIT;
  guint i;

  gst_value_array_init(&array, n_features);
  for (i = 0; i < n_features; i++) {
    GValue value = G_VALUE_INIT;
    GValue state = G_VALUE_INIT;
    GstStructure *fields = gst_structure_new("feature", "id", G_TYPE_UINT, features[i].id, "x", G_TYPE_DOUBLE,
                                             features[i].x, "y", G_TYPE_DOUBLE, features[i].y, NULL);

    /* Interned: copying the meta then allocates no string per feature. */
    g_value_init(&state, G_TYPE_STRING);
    g_value_set_interned_string(&state, g_intern_string(features[i].state));
    gst_structure_take_value(fields, "state", &state);
    gst_structure_set(fields, "confidence", G_TYPE_DOUBLE, features[i].confidence, "fresh", G_TYPE_BOOLEAN,
                      features[i].fresh, NULL);

    g_value_init(&value, GST_TYPE_STRUCTURE);
    g_value_take_boxed(&value, fields);
    gst_value_array_append_and_take_value(&array, &value);
  }
  gst_structure_take_value(structure, "features", &array);
}

/**
 * gst_csd_structure_set:
 * @structure: a writable structure
 * @header: what to write; n_features says how many @features there are
 * @features: (array): in ascending order of their ids, see gst_csd_structure_set_features()
 *
 * Writes all the fields of a track meta, with the schema #GST_CSD_META_SCHEMA.
 *
 * Since: 0.1
 */
static inline void gst_csd_structure_set(GstStructure *structure, const GstCsdHeader *header,
                                         const GstCsdFeature *features) {
  gst_structure_set(structure, "schema", G_TYPE_INT, GST_CSD_META_SCHEMA, "source", G_TYPE_STRING, header->source,
                    "algorithm", G_TYPE_STRING, header->algorithm, "frame", G_TYPE_UINT64, header->frame, "width",
                    G_TYPE_INT, header->width, "height", G_TYPE_INT, header->height, "tracked-width", G_TYPE_INT,
                    header->tracked_width, "tracked-height", G_TYPE_INT, header->tracked_height, NULL);
  gst_csd_structure_set_features(structure, features, header->n_features);
}

/**
 * gst_buffer_add_csd_tracks:
 * @buffer: (transfer none): a writable #GstBuffer
 * @name: #GST_CSD_TRACK_META_NAME or #GST_CSD_TRUTH_META_NAME
 * @header: what to write
 * @features: (array): in ascending order of their ids
 *
 * Adds a meta. Existing ones stay.
 *
 * Returns: (transfer none) (nullable): the new meta, %NULL if the plugin isn't loaded
 *
 * Since: 0.1
 */
static inline GstCustomMeta *gst_buffer_add_csd_tracks(GstBuffer *buffer, const gchar *name, const GstCsdHeader *header,
                                                       const GstCsdFeature *features) {
  GstCustomMeta *meta;

  if (gst_meta_get_info(name) == NULL || (meta = gst_buffer_add_custom_meta(buffer, name)) == NULL) return NULL;
  gst_csd_structure_set(gst_custom_meta_get_structure(meta), header, features);
  return meta;
}

G_END_DECLS

#endif /* GST_CSD_TRACK_META_H */
