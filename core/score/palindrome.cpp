// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/palindrome.h"

#include "base/find_id.h"

namespace csd::score {
namespace {

/// The feature's claim in this frame; null without one.
const Feature *claim_of(const TrackFrame &frame, FeatureId id) {
  const auto found = find_id(frame.features, id, &Feature::id);
  return found != frame.features.end() && claims_position(found->state) ? &*found : nullptr;
}

double distance(const Feature &a, const Feature &b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// A missing frame would pair each image with another one.
void check(const Recording &tracks) {
  if (tracks.sparse)
    throw InputError(tracks.file, 0, "doesn't say how many frames there were; a palindrome wants csdtrackenc's .jsonl");
  tracks.check_one_size();
  for (std::size_t i = 0; i < tracks.frames.size(); ++i) {
    const TrackFrame &frame = tracks.frames[i];
    if (!frame.numbered) throw InputError(tracks.file, frame.line, "has no `frame`");
    const std::uint64_t expected = tracks.frames.front().frame + i;
    if (frame.frame != expected)
      throw InputError(tracks.file, frame.line,
                       "is frame " + std::to_string(frame.frame) + ", not " + std::to_string(expected));
  }
  if (tracks.frames.size() < 3)
    throw InputError(tracks.file, 0,
                     "has " + std::to_string(tracks.frames.size()) + " frames; a palindrome has 3 or more");
  if (tracks.height < 1) throw InputError(tracks.file, 0, "doesn't say the picture's height");
}

}  // namespace

PalindromeScore score_palindrome(const Recording &tracks) {
  check(tracks);
  const double near = tolerance(tracks.height, returned_pixels), far = tolerance(tracks.height, apart_pixels);
  const std::size_t length = tracks.frames.size();
  PalindromeScore score;
  score.frames = length;
  for (const Feature &start : tracks.frames.front().features) {
    if (!claims_position(start.state)) continue;
    ++score.features;
    for (std::size_t i = 0; i < (length + 1) / 2; ++i) {
      const std::size_t mirror = length - 1 - i;
      const Feature *const there = claim_of(tracks.frames[i], start.id);
      if (there) ++score.claims;
      if (mirror == i) continue;  // the turning point, seen once
      const Feature *const back = claim_of(tracks.frames[mirror], start.id);
      if (back) ++score.claims;
      if (!there || !back) continue;
      ++score.pairs;
      if (distance(*there, *back) > far) ++score.apart;
    }
    if (const Feature *const end = claim_of(tracks.frames.back(), start.id)) {
      if (distance(start, *end) <= near) ++score.returned;
      if (distance(start, *end) > far) ++score.falsely_returned;
    }
  }
  if (score.features == 0)
    throw InputError(tracks.file, tracks.frames.front().line, "claims nothing in its first frame");
  return score;
}

}  // namespace csd::score
