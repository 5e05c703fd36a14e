// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace csd::programs {

/// Writes JSON, each member and element on a line of its own. Non-finite numbers become null.
class JsonWriter {
 public:
  JsonWriter &begin_object() { return begin('{'); }
  JsonWriter &end_object() { return end('}'); }
  JsonWriter &begin_array() { return begin('['); }
  JsonWriter &end_array() { return end(']'); }
  JsonWriter &key(std::string_view name);
  JsonWriter &value(double number);
  JsonWriter &whole(std::uint64_t number);
  /// A file name may be any bytes, but JSON is UTF-8: what isn't becomes U+FFFD.
  JsonWriter &text(std::string_view string);
  template <typename Numbers>
  JsonWriter &values(const Numbers &numbers) {
    begin_array();
    for (const double number : numbers) value(number);
    return end_array();
  }

  /// The whole, with a newline.
  std::string finish() { return text_ + "\n"; }

 private:
  JsonWriter &begin(char bracket);
  JsonWriter &end(char bracket);
  /// Goes to where a value is written: behind its key, or on the next line.
  void next();

  std::string text_;
  std::size_t depth_ = 0;
  bool first_ = true;  ///< nothing yet in these brackets
  bool keyed_ = false;
};

}  // namespace csd::programs
