// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "score/types.h"

namespace csd::programs {

/// A folder of files; the destructor removes it.
class TestFolder {
 public:
  TestFolder()
      : path_(std::filesystem::path(testing::TempDir()) /
              ("csd-programs-" + std::to_string(getpid()) + "-" +
               testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(path_);
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  TestFolder(const TestFolder &) = delete;
  TestFolder &operator=(const TestFolder &) = delete;

  std::filesystem::path operator/(const std::string &name) const { return path_ / name; }
  std::string write(const std::string &name, const std::string &content) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

/// The text of the InputError that `read` throws, without the folder.
template <typename Read>
std::string input_error(const std::string &file, Read read) {
  try {
    read();
  } catch (const score::InputError &error) {
    std::string text = error.what();
    if (text.starts_with(file)) text.erase(0, file.size());
    return text;
  }
  return "no error";
}

}  // namespace csd::programs
