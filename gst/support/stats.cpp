// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/stats.h"

#include "image/simd.h"

namespace csd {

GstStructure *stats_structure(const Stats &stats, const Latency &latency, guint64 failed_frames) {
  GstStructure *s = gst_structure_new(
      "application/x-csdtrack-stats", "frames", G_TYPE_UINT64, latency.count(), "failed-frames", G_TYPE_UINT64,
      failed_frames, "time-p50", G_TYPE_UINT64, latency.quantile(0.5), "time-p95", G_TYPE_UINT64,
      latency.quantile(0.95), "time-max", G_TYPE_UINT64, latency.max(), "detected", G_TYPE_UINT64, stats.detected,
      "learning-time", G_TYPE_UINT64, static_cast<guint64>(stats.learning_time), "learned", G_TYPE_UINT64,
      stats.learned, "retrainings", G_TYPE_UINT64, stats.retrainings, "false-correspondences", G_TYPE_UINT64,
      stats.false_correspondences, "queue", G_TYPE_UINT64, stats.queue, "waited", G_TYPE_UINT64, stats.waited, "simd",
      G_TYPE_STRING, csd::simd_target(), nullptr);
  for (std::size_t i = 0; i < csd::feature_states; ++i)
    gst_structure_set(s, csd::state_name(static_cast<csd::FeatureState>(i)).data(), G_TYPE_UINT64, stats.features[i],
                      nullptr);
  return s;
}

}  // namespace csd
