// SPDX-License-Identifier: LGPL-2.1-or-later
// What most tests include, compiled once (meson's b_pch). Each file still includes what it needs: `tests/more clang`
// compiles without this header.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
