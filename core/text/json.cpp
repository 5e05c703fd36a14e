// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/json.h"

#include <charconv>
#include <cstdint>

namespace csd {
namespace {

constexpr int max_depth = 16;           // csdtrackenc's lines have 3
constexpr std::size_t max_digits = 19;  // of 64 bits

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Scans a text once; only knows where its strings and numbers are.
class Guard {
 public:
  Guard(std::string_view text, std::size_t max_values) : text_(text), max_values_(max_values) {}

  /// What is wrong with the text; "" if json-glib can read it safely.
  std::string problem() {
    if (text_.find_first_not_of(" \t\r\n") == std::string_view::npos) refuse("it is empty");
    while (at_ < text_.size() && problem_.empty()) {
      const char c = text_[at_];
      if (depth_ == 0 && begun_ && !is_blank(c))
        refuse("there is more behind the object");
      else if (c == '"')
        string();
      else if (c == '-' || is_digit(c))
        number();
      else
        other(c);
    }
    return problem_;
  }

 private:
  void refuse(const std::string &what) { problem_ = "is no JSON: " + what; }

  void string() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (static_cast<unsigned char>(text_[at_]) < 0x20) return refuse("a control character in a string");
      if (text_[at_] == '\\') ++at_;
    }
    ++at_;
  }

  void number() {
    const char *const sign = &text_[at_];
    if (text_[at_] == '-') ++at_;
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
    if (at_ - begin > max_digits) return refuse("a number has more than 19 digits");
    if (at_ - begin > 1 && text_[begin] == '0') return refuse("a number begins with 0");
    const std::size_t end = at_;
    // json-glib judges the rest.
    constexpr std::string_view rest = "0123456789.eE+-";
    while (at_ < text_.size() && rest.find(text_[at_]) != std::string_view::npos) ++at_;
    // json-glib changes these: it flips the sign (1.6), or takes the nearest 64-bit value (1.10).
    std::int64_t value = 0;
    if (at_ == end && std::from_chars(sign, text_.data() + end, value).ec == std::errc::result_out_of_range)
      refuse("a whole number of more than 64 bits");
  }

  void other(char c) {
    constexpr std::string_view others = "{}[],: \t\r\ntruefalsn";
    if (others.find(c) == std::string_view::npos) {
      const bool printable = c > 0x20 && c < 0x7f;
      return refuse(printable ? std::string("unexpected character '") + c + "'" : "an unexpected character");
    }
    // An object has one more member, an array one more element, than commas.
    if ((c == ',' || c == '{' || c == '[') && ++values_ > max_values_)
      problem_ = "holds more than " + std::to_string(max_values_) + " values";
    if (c == '{' || c == '[') {
      begun_ = true;
      if (++depth_ > max_depth) refuse("brackets are nested more than 16 deep");
    } else if (c == '}' || c == ']') {
      --depth_;
    }
    ++at_;
  }

  const std::string_view text_;
  const std::size_t max_values_;
  std::string problem_;
  std::size_t at_ = 0, values_ = 0;
  int depth_ = 0;
  bool begun_ = false;
};

}  // namespace

JsonNode *JsonText::parse(std::string_view text, std::size_t max_values) {
  error_ = Guard(text, max_values).problem();
  if (!error_.empty()) return nullptr;
  GError *error = nullptr;
  if (json_parser_load_from_data(parser_.get(), text.data(), static_cast<gssize>(text.size()), &error))
    return json_parser_get_root(parser_.get());
  // json-glib quotes the text: half a surrogate pair (\ud800) becomes invalid UTF-8, which a message can't contain.
  gchar *valid = g_utf8_make_valid(error->message, -1);
  error_ = std::string("is no JSON: ") + valid;
  g_free(valid);
  g_error_free(error);
  return nullptr;
}

}  // namespace csd
