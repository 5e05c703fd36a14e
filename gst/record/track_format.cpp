// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/track_format.h"

#include "meta/csdtrackmeta.h"

static_assert(GST_CSD_META_SCHEMA == 1, "JsonLine writes another schema");

namespace csd {
namespace {

std::optional<std::uint64_t> known(GstClockTime time) {
  return GST_CLOCK_TIME_IS_VALID(time) ? std::optional<std::uint64_t>(time) : std::nullopt;
}

std::optional<std::string_view> known(const char *text) {
  return text ? std::optional<std::string_view>(text) : std::nullopt;
}

/// `n_features`: number of features in the meta; 0 if it is missing or unreadable.
LineHead head_of(const FrameRecord &record, guint &n_features) {
  LineHead head;
  head.role = record.role;
  head.pts = known(record.pts);
  head.duration = known(record.duration);
  head.running_time = known(record.running_time);
  head.stream_time = known(record.stream_time);
  head.reference_caps = known(record.reference_caps);
  head.reference_time = known(record.reference_time);
  head.width = record.width;
  head.height = record.height;
  head.pixel_aspect_n = record.pixel_aspect_n;
  head.pixel_aspect_d = record.pixel_aspect_d;
  n_features = 0;
  GstCsdHeader header{};
  if (!record.tracks || !gst_csd_structure_get_header(record.tracks, &header)) return head;
  n_features = header.n_features;
  head.source = known(header.source);
  head.algorithm = known(header.algorithm);
  head.frame = header.frame;
  head.width = record.crop ? static_cast<int>(record.crop->width) : header.width;
  head.height = record.crop ? static_cast<int>(record.crop->height) : header.height;
  return head;
}

template <class Lines>
void add_features(Lines &lines, const FrameRecord &record, guint n_features) {
  for (guint i = 0; i < n_features; ++i) {
    GstCsdFeature feature;
    if (!gst_csd_structure_get_feature(record.tracks, i, &feature)) continue;
    if (record.crop) {
      feature.x -= record.crop->x;
      feature.y -= record.crop->y;
    }
    lines.add({feature.id, feature.x, feature.y, feature.state, feature.confidence, feature.fresh != 0});
  }
}

}  // namespace

void append_json(std::string &out, const FrameRecord &record) {
  guint n_features;
  JsonLine line(out, head_of(record, n_features));
  add_features(line, record, n_features);
  line.end();
}

void append_csv(std::string &out, const FrameRecord &record) {
  guint n_features;
  CsvRows rows(out, head_of(record, n_features));
  add_features(rows, record, n_features);
}

}  // namespace csd
