// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track_format.h"

#include <charconv>
#include <cmath>

#include "csdtrackmeta.h"

namespace csd {
namespace {

// A double of 3 decimals has at most 309 digits before them.
constexpr std::size_t max_number = 320;

template <typename Integer>
void append_integer(std::string &out, Integer value) {
  char buffer[max_number];
  out.append(buffer, std::to_chars(buffer, buffer + max_number, value).ptr);
}

/// 3 decimals: a thousandth of a pixel is below what any tracker resolves. `unknown` stands for what isn't finite.
void append_decimal(std::string &out, double value, std::string_view unknown) {
  if (!std::isfinite(value)) {
    out += unknown;
    return;
  }
  if (std::abs(value) < 0.0005) value = 0;  // never "-0.000"
  char buffer[max_number];
  out.append(buffer, std::to_chars(buffer, buffer + max_number, value, std::chars_format::fixed, 3).ptr);
}

void append_time(std::string &out, GstClockTime time, std::string_view unknown) {
  if (GST_CLOCK_TIME_IS_VALID(time))
    append_integer(out, time);
  else
    out += unknown;
}

/// A size; 0 is unknown.
void append_size(std::string &out, int pixels) {
  if (pixels > 0)
    append_integer(out, pixels);
  else
    out += "null";
}

void append_escaped(std::string &out, std::string_view text) {
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      constexpr char digits[] = "0123456789abcdef";
      out += "\\u00";
      out += digits[c >> 4];
      out += digits[c & 15];
    } else {
      out += c;
    }
  }
}

/// A JSON string. JSON is UTF-8, and so is what a GstStructure holds.
void append_string(std::string &out, const char *text) {
  if (!text) {
    out += "null";
    return;
  }
  out += '"';
  append_escaped(out, text);
  out += '"';
}

/// A field of CSV (RFC 4180): in quotation marks where it must be.
void append_csv_field(std::string &out, std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

void append_json_feature(std::string &out, const GstCsdFeature &feature) {
  out += "{\"id\":";
  append_integer(out, feature.id);
  out += ",\"x\":";
  append_decimal(out, feature.x, "null");
  out += ",\"y\":";
  append_decimal(out, feature.y, "null");
  out += ",\"state\":";
  append_string(out, feature.state);
  out += ",\"confidence\":";
  append_decimal(out, feature.confidence, "null");
  if (!feature.fresh) out += ",\"fresh\":false";
  out += '}';
}

void append_reference(std::string &out, const FrameRecord &record) {
  if (!record.reference_caps) {
    out += "null";
    return;
  }
  out += "{\"caps\":";
  append_string(out, record.reference_caps);
  out += ",\"ns\":";
  append_time(out, record.reference_time, "null");
  out += '}';
}

/// A header of nothing but unknowns where there is no meta, or one that can't be read.
GstCsdHeader header_of(const FrameRecord &record, bool &known) {
  GstCsdHeader header{};
  known = record.tracks && gst_csd_structure_get_header(record.tracks, &header);
  if (known && record.crop) {
    header.width = static_cast<int>(record.crop->width);
    header.height = static_cast<int>(record.crop->height);
  }
  if (known) return header;
  header = {};
  header.width = record.width;
  header.height = record.height;
  return header;
}

bool feature_of(const FrameRecord &record, guint i, GstCsdFeature &feature) {
  if (!gst_csd_structure_get_feature(record.tracks, i, &feature)) return false;
  if (record.crop) {
    feature.x -= record.crop->x;
    feature.y -= record.crop->y;
  }
  return true;
}

}  // namespace

void append_json(std::string &out, const FrameRecord &record) {
  bool known = false;
  const GstCsdHeader header = header_of(record, known);
  out += "{\"schema\":";
  append_integer(out, GST_CSD_META_SCHEMA);
  out += ",\"source\":";
  append_string(out, header.source);
  out += ",\"role\":";
  append_string(out, record.role);
  out += ",\"algorithm\":";
  append_string(out, header.algorithm);
  out += ",\"frame\":";
  if (known)
    append_integer(out, header.frame);
  else
    out += "null";
  out += ",\"pts\":";
  append_time(out, record.pts, "null");
  out += ",\"duration\":";
  append_time(out, record.duration, "null");
  out += ",\"running_time\":";
  append_time(out, record.running_time, "null");
  out += ",\"stream_time\":";
  append_time(out, record.stream_time, "null");
  out += ",\"reference\":";
  append_reference(out, record);
  out += ",\"width\":";
  append_size(out, header.width);
  out += ",\"height\":";
  append_size(out, header.height);
  out += ",\"features\":[";
  bool first = true;
  for (guint i = 0; i < header.n_features; ++i) {
    GstCsdFeature feature;
    if (!feature_of(record, i, feature)) continue;
    if (!first) out += ',';
    first = false;
    append_json_feature(out, feature);
  }
  out += "]}";
}

void append_csv(std::string &out, const FrameRecord &record) {
  bool known = false;
  const GstCsdHeader header = header_of(record, known);
  if (header.n_features == 0) return;
  std::string frame;  // the columns that all rows of a frame share
  append_integer(frame, header.frame);
  frame += ',';
  append_time(frame, record.pts, "");
  frame += ',';
  append_time(frame, record.stream_time, "");
  frame += ',';
  for (guint i = 0; i < header.n_features; ++i) {
    GstCsdFeature feature;
    if (!feature_of(record, i, feature)) continue;
    out += frame;
    append_integer(out, feature.id);
    out += ',';
    append_decimal(out, feature.x, "");
    out += ',';
    append_decimal(out, feature.y, "");
    out += ',';
    append_csv_field(out, feature.state);
    out += ',';
    append_decimal(out, feature.confidence, "");
    out += feature.fresh ? ",true\n" : ",false\n";
  }
}

}  // namespace csd
