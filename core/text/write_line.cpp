// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/write_line.h"

#include <charconv>
#include <cmath>

namespace csd {
namespace {

// A double of 3 decimals has at most 309 digits before them.
constexpr std::size_t max_number = 320;

template <typename Integer>
void append_integer(std::string &out, Integer value) {
  char buffer[max_number];
  out.append(buffer, std::to_chars(buffer, buffer + max_number, value).ptr);
}

/// 3 decimals: a thousandth of a pixel is below any tracker's resolution. `unknown` is for non-finite values.
void append_decimal(std::string &out, double value, std::string_view unknown) {
  if (!std::isfinite(value)) {
    out += unknown;
    return;
  }
  if (std::abs(value) < 0.0005) value = 0;  // never "-0.000"
  char buffer[max_number];
  out.append(buffer, std::to_chars(buffer, buffer + max_number, value, std::chars_format::fixed, 3).ptr);
}

void append_whole(std::string &out, std::optional<std::uint64_t> value, std::string_view unknown) {
  if (value)
    append_integer(out, *value);
  else
    out += unknown;
}

void append_size(std::string &out, int pixels) {
  if (pixels > 0)
    append_integer(out, pixels);
  else
    out += "null";
}

void append_string(std::string &out, std::optional<std::string_view> text) {
  if (text)
    append_json_string(out, *text);
  else
    out += "null";
}

/// A CSV field (RFC 4180), quoted if necessary.
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

void append_reference(std::string &out, const LineHead &head) {
  if (!head.reference_caps) {
    out += "null";
    return;
  }
  out += "{\"caps\":";
  append_string(out, head.reference_caps);
  out += ",\"ns\":";
  append_whole(out, head.reference_time, "null");
  out += '}';
}

}  // namespace

void append_json_string(std::string &out, std::string_view text) {
  out += '"';
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
  out += '"';
}

JsonLine::JsonLine(std::string &out, const LineHead &head) : out_(out) {
  out += "{\"schema\":1,\"source\":";
  append_string(out, head.source);
  out += ",\"role\":";
  append_string(out, head.role);
  out += ",\"algorithm\":";
  append_string(out, head.algorithm);
  out += ",\"frame\":";
  append_whole(out, head.frame, "null");
  out += ",\"pts\":";
  append_whole(out, head.pts, "null");
  out += ",\"duration\":";
  append_whole(out, head.duration, "null");
  out += ",\"running_time\":";
  append_whole(out, head.running_time, "null");
  out += ",\"stream_time\":";
  append_whole(out, head.stream_time, "null");
  out += ",\"reference\":";
  append_reference(out, head);
  out += ",\"width\":";
  append_size(out, head.width);
  out += ",\"height\":";
  append_size(out, head.height);
  if (head.pixel_aspect_n > 0 && head.pixel_aspect_d > 0) {
    out += ",\"pixel_aspect\":[";
    append_integer(out, head.pixel_aspect_n);
    out += ',';
    append_integer(out, head.pixel_aspect_d);
    out += ']';
  }
  out += ",\"features\":[";
}

void JsonLine::add(const LineFeature &feature) {
  if (!first_) out_ += ',';
  first_ = false;
  out_ += json_feature_begin;
  append_integer(out_, feature.id);
  out_ += ",\"x\":";
  append_decimal(out_, feature.x, "null");
  out_ += ",\"y\":";
  append_decimal(out_, feature.y, "null");
  out_ += ",\"state\":";
  append_string(out_, feature.state);
  out_ += ",\"confidence\":";
  append_decimal(out_, feature.confidence, "null");
  if (!feature.fresh) out_ += ",\"fresh\":false";
  out_ += '}';
}

void JsonLine::end() {
  out_ += "]}";
}

CsvRows::CsvRows(std::string &out, const LineHead &head) : out_(out) {
  append_whole(frame_, head.frame, "");
  frame_ += ',';
  append_whole(frame_, head.pts, "");
  frame_ += ',';
  append_whole(frame_, head.stream_time, "");
  frame_ += ',';
}

void CsvRows::add(const LineFeature &feature) {
  out_ += frame_;
  append_integer(out_, feature.id);
  out_ += ',';
  append_decimal(out_, feature.x, "");
  out_ += ',';
  append_decimal(out_, feature.y, "");
  out_ += ',';
  append_csv_field(out_, feature.state);
  out_ += ',';
  append_decimal(out_, feature.confidence, "");
  out_ += feature.fresh ? ",true\n" : ",false\n";
}

}  // namespace csd
