// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace csd {

/// A named field of a struct of numbers, so that experiments can set an algorithm's constants.
template <class Numbers>
struct NamedNumber {
  std::string_view name;
  double Numbers::*field;
};

template <class Numbers>
constexpr NamedNumber<Numbers> named(std::string_view name, double Numbers::*field) {
  return {name, field};
}

/// Sets the field in "name=value". Throws std::invalid_argument whose text names the error; `owner`: the owner of the
/// numbers, for that text.
template <class Numbers>
void set_number(Numbers &numbers, std::span<const NamedNumber<Numbers>> fields, std::string_view assignment,
                const std::string &owner) {
  const auto sign = assignment.find('=');
  const auto name = assignment.substr(0, sign);
  if (sign == std::string_view::npos)
    throw std::invalid_argument("\"" + std::string(assignment) + "\" is not NAME=VALUE");
  const auto field = std::find_if(fields.begin(), fields.end(), [name](auto &f) { return f.name == name; });
  if (field == fields.end())
    throw std::invalid_argument("no number of " + owner + " is called \"" + std::string(name) + "\"");
  const std::string text(assignment.substr(sign + 1));
  char *end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value))
    throw std::invalid_argument("\"" + text + "\" is not a number, for " + std::string(name));
  numbers.*field->field = value;
}

}  // namespace csd
