// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/support/log.h"

namespace tactel::host {

/// Callbacks during a training.
struct TrainingWatch {
  /// Weight updates (of a stream: rows) done and in all, and the mean rate in patterns per second, 0 while unknown.
  /// Called from the thread that runs the training; false stops it.
  std::function<bool(std::size_t done, std::size_t all, double patterns_per_second)> progress{};
  LogSink log{};
};

enum class TrainingEnd {
  finished,     ///< the directory holds networks and report
  done_before,  ///< the directory held them before the run
  stopped,      ///< by the watch; the state is kept
};

/// Outcome of a training.
struct TrainingOutcome {
  TrainingEnd end = TrainingEnd::finished;
  std::size_t networks = 0, diverged = 0;  ///< a network that diverged has no file
  double share = 0;                        ///< where stopped: completed share of the most possible work
  std::filesystem::path checkpoint{};      ///< where stopped: the state for --resume; empty for several processes
  std::string summary{};                   ///< whole lines
  std::vector<std::string> tables{};       ///< of errors, each whole lines with a heading
  std::string undrawn{};                   ///< why learning_curves.svg is missing; empty where it was drawn
};

/// A prepared training: checked, compiled, on the device.
class TrainingJob {
 public:
  virtual ~TrainingJob() = default;
  /// Trains, from the directory's checkpoint where there is one to resume, and writes the directory. Throws
  /// ConfigError for a checkpoint or directory of another training, and for files that cannot be written.
  virtual TrainingOutcome run(const TrainingWatch& watch) = 0;
};

}  // namespace tactel::host
