// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/json_writer.h"

#include <glib.h>

#include <charconv>
#include <cmath>
#include <memory>

#include "text/write_line.h"

namespace csd::programs {

JsonWriter &JsonWriter::key(std::string_view name) {
  next();
  append_json_string(text_, name);
  text_ += ": ";
  keyed_ = true;
  return *this;
}

JsonWriter &JsonWriter::value(double number) {
  next();
  if (!std::isfinite(number)) {
    text_ += "null";
    return *this;
  }
  char buffer[32];
  const std::string_view digits(buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr);
  text_ += digits;
  // It stays a number with decimals for those who tell the two apart.
  if (digits.find_first_of(".e") == digits.npos) text_ += ".0";
  return *this;
}

JsonWriter &JsonWriter::whole(std::uint64_t number) {
  next();
  text_ += std::to_string(number);
  return *this;
}

JsonWriter &JsonWriter::text(std::string_view string) {
  next();
  const std::unique_ptr<char, decltype(&g_free)> valid(
      g_utf8_make_valid(std::string(string).c_str(), static_cast<gssize>(string.size())), g_free);
  append_json_string(text_, valid.get());
  return *this;
}

JsonWriter &JsonWriter::begin(char bracket) {
  next();
  text_ += bracket;
  ++depth_;
  first_ = true;
  return *this;
}

JsonWriter &JsonWriter::end(char bracket) {
  --depth_;
  if (!first_) text_.append("\n").append(depth_, ' ');
  text_ += bracket;
  first_ = false;
  return *this;
}

void JsonWriter::next() {
  if (!keyed_ && depth_ > 0) text_.append(first_ ? "\n" : ",\n").append(depth_, ' ');
  first_ = keyed_ = false;
}

}  // namespace csd::programs
