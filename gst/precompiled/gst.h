// SPDX-License-Identifier: LGPL-2.1-or-later
// The headers that most plugin sources include, precompiled (meson's b_pch). Each file still includes what it needs:
// `tests/more clang` compiles without this one.
#include <gst/base/gstbasetransform.h>
#include <gst/video/video.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>
