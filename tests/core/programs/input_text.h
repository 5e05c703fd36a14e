// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gmock/gmock.h>

#include <string>
#include <variant>
#include <vector>

#include "programs/file.h"
#include "programs/read_input.h"

namespace csd::programs {

/// What read_input() returns for a file with this content. Without `notes`, expects that there are none.
template <typename Kind>
Kind read(const std::string &content, std::vector<std::string> *notes = nullptr) {
  const TestFolder folder;
  std::vector<std::string> unasked;
  Kind read = std::get<Kind>(read_input(folder.write("input", content), notes ? *notes : unasked));
  if (!notes) {
    EXPECT_THAT(unasked, testing::IsEmpty());
  }
  return read;
}

/// The error of read_input() on a file with this content.
inline std::string error_of(const std::string &content) {
  const TestFolder folder;
  const std::string file = folder.write("input", content);
  std::vector<std::string> notes;
  return input_error(file, [&] { read_input(file, notes); });
}

}  // namespace csd::programs
