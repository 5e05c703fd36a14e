// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/json.h"

#include <simdjson.h>

#include <new>
#include <string>

namespace csd {
namespace {

constexpr std::size_t max_depth = 16;  // csdtrackenc's lines have 3

std::string reason_of(simdjson::error_code error) {
  switch (error) {
    case simdjson::EMPTY:
      return "it is empty";
    case simdjson::DEPTH_ERROR:
      return "brackets are nested more than " + std::to_string(max_depth) + " deep";
    case simdjson::STRING_ERROR:
      return "a wrong escape in a string, or half a surrogate pair";
    case simdjson::UNESCAPED_CHARS:
      return "a control character in a string";
    case simdjson::UNCLOSED_STRING:
      return "a string has no end";
    case simdjson::UTF8_ERROR:
      return "it is not UTF-8";
    case simdjson::MEMALLOC:
      throw std::bad_alloc();
    default:  // which of these it is differs between 3.0 and 3.12
      return "a value is misspelt or too large, or a bracket, comma or colon is not where one belongs";
  }
}

/// Members and elements below a value.
std::size_t values_of(simdjson::dom::element value) {
  std::size_t count = 0;
  if (simdjson::dom::array array; value.get(array) == simdjson::SUCCESS)
    for (const auto element : array) count += 1 + values_of(element);
  else if (simdjson::dom::object object; value.get(object) == simdjson::SUCCESS)
    for (const auto member : object) count += 1 + values_of(member.value);
  return count;
}

}  // namespace

JsonText::JsonText() : parser_(std::make_unique<simdjson::dom::parser>()) {
  // simdjson counts what is in brackets as one deeper, and empty ones not at all.
  if (const auto error = parser_->allocate(simdjson::dom::MINIMAL_DOCUMENT_CAPACITY, max_depth + 1))
    throw JsonError("is no JSON: " + reason_of(error));
}

JsonText::~JsonText() = default;
JsonText::JsonText(JsonText &&) noexcept = default;
JsonText &JsonText::operator=(JsonText &&) noexcept = default;

simdjson::dom::element JsonText::parse(std::string_view text, std::size_t max_values) {
  // simdjson 3.12 (Debian 13) skips it, 3.0 (Debian 12) doesn't: line_text() alone does.
  if (text.starts_with("\xef\xbb\xbf")) throw JsonError("is no JSON: a byte order mark");
  simdjson::dom::element root;
  if (const auto error = parser_->parse(text.data(), text.size()).get(root))
    throw JsonError("is no JSON: " + reason_of(error));
  // A value and what parts it from the next are two bytes at least.
  if (text.size() / 2 > max_values && values_of(root) > max_values)
    throw JsonError("holds more than " + std::to_string(max_values) + " values");
  return root;
}

}  // namespace csd
