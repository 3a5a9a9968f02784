// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <optional>

#include "host/contact/pad_rung.h"

namespace tactel::host {

/// Solves a scene a second time to state the errors of its answers: by the twin, on 24 or more cells with twice as many
/// increments of pressing and drags.
class PadJudge {
 public:
  explicit PadJudge(const fem::PadScene& scene) : scene_(scene) {}

  /// Returns the errors to expect of an answer: its differences from the second solution, times factors, and a little.
  /// They cover 95 % of scenes (bench/pad_study.cpp). None beyond 100 load steps, which would take seconds,
  /// and where the second solution misses its tolerance.
  std::optional<PadError> error(const PadRung& rung, const fem::PadSolution& answer);

 private:
  const fem::PadSolution& finer(int cells);

  fem::PadScene scene_;
  std::map<int, fem::PadSolution> finer_;  ///< by their cells
};

}  // namespace tactel::host
