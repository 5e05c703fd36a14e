// SPDX-License-Identifier: LGPL-2.1-or-later
// Many test files share one program, since each program links all of OpenCV. Arguments name files, such as
// csd/csd_test.cpp: only their tests run. Without arguments all tests run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <string_view>

namespace {

/// The full names of the tests that `file` defines, as a GoogleTest filter.
std::string tests_of(std::string_view file) {
  const auto &all = *testing::UnitTest::GetInstance();
  const std::string end = "/" + std::string(file);
  std::string names;
  for (int s = 0; s < all.total_test_suite_count(); ++s) {
    const auto &suite = *all.GetTestSuite(s);
    for (int t = 0; t < suite.total_test_count(); ++t) {
      const auto &test = *suite.GetTestInfo(t);
      if (std::string_view(test.file()).ends_with(end)) names += std::string(suite.name()) + "." + test.name() + ":";
    }
  }
  return names;
}

}  // namespace

int main(int argc, char **argv) {
  testing::InitGoogleMock(&argc, argv);  // removes its own options, and registers the parameterised tests
  std::string names;
  for (int i = 1; i < argc; ++i) {
    const std::string more = tests_of(argv[i]);
    if (more.empty()) {
      std::fprintf(stderr, "error: no test in a file %s\n", argv[i]);
      return 2;
    }
    names += more;
  }
  if (!names.empty()) GTEST_FLAG_SET(filter, names);
  return RUN_ALL_TESTS();
}
