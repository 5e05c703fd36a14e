// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrackenc with frames whose metas differ from csdtrack's, in each of its forms, with events and changes of state in
// between.
#include <cmath>
#include <iterator>

#include "elements.h"
#include "meta/csdtrackmeta.h"

namespace {

using namespace csd_fuzz;

double number(Numbers &from) {
  static const double odd[] = {NAN, INFINITY, -INFINITY, G_MAXDOUBLE, -G_MAXDOUBLE, -0.0, 1e-310};
  const unsigned which = choose(from, 15);
  return which < std::size(odd) ? odd[which]
         : which < 12           ? choose(from, 255) / 3.0
                                : from.ConsumeFloatingPoint<double>();
}

/// Text in UTF-8, as all text in a GstStructure must be.
std::string word(Numbers &from) {
  const std::string any = text(from, 24);
  gchar *valid = g_utf8_make_valid(any.c_str(), -1);
  const std::string word = valid;
  g_free(valid);
  return word;
}

/// Changes a field's value or type, or removes the field.
void spoil(Numbers &from, GstStructure *structure) {
  static const char *const fields[] = {"schema",        "source",         "algorithm", "frame", "width", "height",
                                       "tracked-width", "tracked-height", "features",  "id",    "x",     "y",
                                       "state",         "confidence",     "fresh"};
  const char *field = fields[choose(from, std::size(fields) - 1)];
  switch (choose(from, 4)) {
    case 0:
      gst_structure_remove_field(structure, field);
      break;
    case 1:
      gst_structure_set(structure, field, G_TYPE_INT, from.ConsumeIntegral<int>(), nullptr);
      break;
    case 2:
      gst_structure_set(structure, field, G_TYPE_STRING, one_in(from, 2) ? nullptr : word(from).c_str(), nullptr);
      break;
    case 3: {
      GstStructure *inner =
          gst_structure_new("feature", "id", G_TYPE_UINT, 1u, "x", G_TYPE_DOUBLE, number(from), nullptr);
      gst_structure_set(structure, field, GST_TYPE_STRUCTURE, inner, nullptr);
      gst_structure_free(inner);
      break;
    }
    default: {
      GValue array = G_VALUE_INIT, value = G_VALUE_INIT;
      g_value_init(&array, GST_TYPE_ARRAY);
      g_value_init(&value, G_TYPE_INT);
      gst_value_array_append_and_take_value(&array, &value);
      gst_structure_take_value(structure, field, &array);
    }
  }
}

void attach(Numbers &from, GstBuffer *buffer) {
  GstCsdFeature features[4];
  const std::string source = word(from), algorithm = word(from);
  static const char *const states[] = {"learning", "tracked", "occluded", "lost", "out", "ended", "\"\n,\\", ""};
  GstCsdHeader header{};
  header.source = source.c_str();
  header.algorithm = algorithm.c_str();
  header.frame = one_in(from, 4) ? from.ConsumeIntegral<guint64>() : 1;
  for (gint *size : {&header.width, &header.height, &header.tracked_width, &header.tracked_height})
    *size = one_in(from, 8) ? from.ConsumeIntegral<gint>() : static_cast<gint>(choose(from, 80));
  header.n_features = choose(from, 4);
  for (guint i = 0; i < header.n_features; ++i)
    features[i] = {choose(from, 255),       number(from), number(from),
                   states[choose(from, 7)], number(from), one_in(from, 2)};
  const char *name = one_in(from, 4) ? GST_CSD_TRUTH_META_NAME : GST_CSD_TRACK_META_NAME;
  GstCustomMeta *meta = gst_buffer_add_csd_tracks(buffer, name, &header, features);
  for (unsigned faults = choose(from, 2); faults > 0; --faults) spoil(from, gst_custom_meta_get_structure(meta));
}

GstBuffer *tracked_frame(Numbers &from, const Rig &rig, unsigned index) {
  GstBuffer *buffer = frame(from, rig.caps(), index, one_in(from, 2));
  for (unsigned metas = choose(from, 2); metas > 0; --metas) attach(from, buffer);
  if (one_in(from, 4)) {
    GstCaps *reference = gst_caps_new_simple("timestamp/x-ntp", "a", G_TYPE_STRING, word(from).c_str(), nullptr);
    gst_buffer_add_reference_timestamp_meta(buffer, reference, from.ConsumeIntegralInRange<guint64>(0, G_MAXUINT64 - 1),
                                            GST_CLOCK_TIME_NONE);
    gst_caps_unref(reference);
  }
  return buffer;
}

void step(Numbers &from, Rig &rig, unsigned &index) {
  switch (choose(from, 9)) {
    case 0:
      set_property(from, rig.element());
      break;
    case 1:
      rig.some_event(from, index);
      break;
    case 2:
      rig.some_query(from);
      break;
    case 3:
      rig.set_caps(video_caps(from, true));
      break;
    case 4:
      rig.set_state(static_cast<GstState>(GST_STATE_NULL + choose(from, GST_STATE_PLAYING - GST_STATE_NULL)));
      break;
    case 5:
      get_properties(rig.element());
      break;
    default:
      rig.push(tracked_frame(from, rig, index++));
  }
}

}  // namespace

void csd_fuzz::run(std::string_view bytes) {
  Numbers from(reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size());
  static const char *const forms[] = {"ANY", "text/csv", "text/x-raw,format=utf8", "application/x-ndjson",
                                      "video/x-raw"};
  const unsigned form = choose(from, 4);
  Rig rig("csdtrackenc", form > 0 ? gst_caps_from_string(forms[form]) : nullptr);
  if (one_in(from, 4)) gst_util_set_object_arg(G_OBJECT(rig.element()), "role", "truth");
  rig.set_state(GST_STATE_PLAYING);
  rig.set_caps(video_caps(from, false));
  unsigned index = 0;
  for (int steps = 0; steps < 24 && from.remaining_bytes() > 0; ++steps) step(from, rig, index);
}
