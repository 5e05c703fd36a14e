// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/settings.h"

namespace csd {

std::string_view algorithm_name(AlgorithmKind kind) {
  switch (kind) {
    case AlgorithmKind::csd:
      return "csd";
    case AlgorithmKind::csd_2012:
      return "csd-2012";
    case AlgorithmKind::lk:
      return "lk";
    case AlgorithmKind::ms1:
      return "ms1";
    case AlgorithmKind::ms2:
      return "ms2";
    case AlgorithmKind::sift:
      return "sift";
    case AlgorithmKind::csd_forest:
      return "csd-forest";
  }
  return "";
}

}  // namespace csd
