// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string_view>

// The library's header is of 30000 lines: only what reads values includes it.
namespace simdjson::dom {
class element;
class parser;
}  // namespace simdjson::dom

namespace csd {

/// "is no JSON: …", to follow the name of the input.
struct JsonError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A parsed JSON text (RFC 8259). It keeps its memory for the next one: 14 bytes for a byte of the longest.
class JsonText {
 public:
  JsonText();
  ~JsonText();
  JsonText(JsonText &&) noexcept;
  JsonText &operator=(JsonText &&) noexcept;

  /// Returns the root, which is valid until the next text. Throws JsonError if the text is no JSON, nests brackets more
  /// than 16 deep, holds a number that neither 64 bits nor a double can, or more than `max_values` members and
  /// elements.
  simdjson::dom::element parse(std::string_view text, std::size_t max_values);

 private:
  std::unique_ptr<simdjson::dom::parser> parser_;
};

}  // namespace csd
