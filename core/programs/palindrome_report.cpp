// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/palindrome_report.h"

#include <algorithm>
#include <array>

#include "programs/decimal.h"
#include "programs/json_writer.h"
#include "programs/table.h"
#include "score/quantile.h"

namespace csd::programs {
namespace {

/// The shares, in the order of the table's columns.
struct Share {
  const char *key, *title;
  double (score::PalindromeScore::*of)() const;
};
constexpr std::array<Share, 4> shares = {
    {{"claimed", "claimed", &score::PalindromeScore::claimed_share},
     {"apart", "> 5 px apart", &score::PalindromeScore::apart_share},
     {"returned", "returned", &score::PalindromeScore::returned_share},
     {"falsely_returned", "falsely returned", &score::PalindromeScore::falsely_returned_share}}};

struct Mean {
  std::string tracker;
  std::size_t clips = 0;
  std::array<double, shares.size()> values{};
};

/// For each tracker with several rows, all clips weighted equally.
std::vector<Mean> means(const PalindromeReport &report) {
  std::vector<Mean> all;
  for (const PalindromeRow &first : report) {
    if (std::any_of(all.begin(), all.end(), [&](const Mean &mean) { return mean.tracker == first.tracker; })) continue;
    Mean mean{first.tracker};
    for (std::size_t i = 0; i < shares.size(); ++i) {
      std::vector<double> values;
      for (const PalindromeRow &row : report)
        if (row.tracker == first.tracker) values.push_back((row.score.*shares[i].of)());
      mean.clips = values.size();
      mean.values[i] = score::mean_of_known(values);
    }
    all.push_back(mean);
  }
  all.erase(std::remove_if(all.begin(), all.end(), [](const Mean &mean) { return mean.clips < 2; }), all.end());
  return all;
}

Table table(const PalindromeReport &report) {
  Table table{"Forward and backward: shares; px at 576 lines or less", {{"tracks", "tracker", "features", "frames"}}};
  for (const Share &share : shares) table.rows.front().push_back(share.title);
  for (const PalindromeRow &row : report) {
    table.rows.push_back(
        {row.tracks, row.tracker, std::to_string(row.score.features), std::to_string(row.score.frames)});
    for (const Share &share : shares) table.rows.back().push_back(decimal((row.score.*share.of)(), 3, "—"));
  }
  for (const Mean &mean : means(report)) {
    table.rows.push_back({"mean of " + std::to_string(mean.clips), mean.tracker, "", ""});
    for (const double value : mean.values) table.rows.back().push_back(decimal(value, 3, "—"));
  }
  return table;
}

}  // namespace

std::string as_text(const PalindromeReport &report) {
  return as_text(table(report));
}

std::string as_markdown(const PalindromeReport &report) {
  return as_markdown(table(report));
}

std::string as_json(const PalindromeReport &report) {
  JsonWriter out;
  out.begin_object().key("schema").whole(1).key("palindromes").begin_array();
  for (const PalindromeRow &row : report) {
    const score::PalindromeScore &score = row.score;
    out.begin_object().key("tracks").text(row.tracks).key("tracker").text(row.tracker);
    for (const Share &share : shares) out.key(share.key).value((score.*share.of)());
    out.key("counts").begin_object().key("frames").whole(score.frames).key("features").whole(score.features);
    out.key("claims").whole(score.claims).key("pairs").whole(score.pairs).key("apart").whole(score.apart);
    out.key("returned").whole(score.returned).key("falsely_returned").whole(score.falsely_returned).end_object();
    out.end_object();
  }
  out.end_array().key("means").begin_array();
  for (const Mean &mean : means(report)) {
    out.begin_object().key("tracker").text(mean.tracker).key("clips").whole(mean.clips);
    for (std::size_t i = 0; i < shares.size(); ++i) out.key(shares[i].key).value(mean.values[i]);
    out.end_object();
  }
  out.end_array().end_object();
  return out.finish();
}

}  // namespace csd::programs
