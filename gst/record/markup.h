// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>
#include <string_view>

namespace csd {

/// Unescapes Pango markup: &quot; &amp; &lt; &gt; &apos; and numbers, &#39; &#x27;. Anything else stays.
std::string unescape_markup(std::string_view markup);

}  // namespace csd
