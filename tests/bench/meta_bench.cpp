// SPDX-License-Identifier: LGPL-2.1-or-later
//
// The cost per frame of handing on the tracks: as a meta, as a message, as text.
#include <benchmark/benchmark.h>

#include "meta/meta.h"
#include "record/track_format.h"

namespace {

csd::Tracks tracks(int n) {
  csd::Tracks t;
  t.frame = 1234;
  t.width = 1280;
  t.height = 720;
  for (int i = 0; i < n; ++i)
    t.features.push_back({csd::FeatureId(i), 12.3456 * i, 7.89 * i, csd::FeatureState::tracked, 0.931, true});
  return t;
}

/// Adds the meta to a buffer that is then freed, as csdtrack does.
void BM_AddMeta(benchmark::State &state) {
  const csd::Tracks t = tracks(int(state.range(0)));
  for (auto _ : state) {
    GstBuffer *buffer = gst_buffer_new();
    csd::add_track_meta(buffer, t, "csdtrack0", "csd-2012");
    gst_buffer_unref(buffer);
  }
}
BENCHMARK(BM_AddMeta)->Arg(50)->Arg(100)->Unit(benchmark::kMicrosecond);

/// The cost in each element that makes the buffer writable.
void BM_CopyMeta(benchmark::State &state) {
  GstBuffer *buffer = gst_buffer_new();
  csd::add_track_meta(buffer, tracks(int(state.range(0))), "csdtrack0", "csd-2012");
  for (auto _ : state) gst_buffer_unref(gst_buffer_copy(buffer));
  gst_buffer_unref(buffer);
}
BENCHMARK(BM_CopyMeta)->Arg(50)->Arg(100)->Unit(benchmark::kMicrosecond);

void BM_Message(benchmark::State &state) {
  const csd::Tracks t = tracks(int(state.range(0)));
  for (auto _ : state)
    gst_message_unref(
        gst_message_new_element(nullptr, csd::new_tracks_structure("csdtrack", t, "csdtrack0", "csd-2012")));
}
BENCHMARK(BM_Message)->Arg(50)->Arg(100)->Unit(benchmark::kMicrosecond);

template <void (*Append)(std::string &, const csd::FrameRecord &)>
void BM_Text(benchmark::State &state) {
  GstStructure *structure = csd::new_tracks_structure("tracks", tracks(int(state.range(0))), "csdtrack0", "csd-2012");
  csd::FrameRecord record;
  record.tracks = structure;
  record.pts = record.running_time = record.stream_time = 49360000000;
  record.duration = 40000000;
  std::string line;
  for (auto _ : state) {
    line.clear();
    Append(line, record);
    benchmark::DoNotOptimize(line.data());
  }
  state.counters["bytes"] = double(line.size());
  gst_structure_free(structure);
}
BENCHMARK(BM_Text<csd::append_json>)->Name("BM_JsonLine")->Arg(50)->Arg(100)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_Text<csd::append_csv>)->Name("BM_CsvBlock")->Arg(50)->Arg(100)->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  benchmark::Initialize(&argc, argv);
  if (!csd::register_track_metas() || benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
