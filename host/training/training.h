// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/support/log.h"
#include "host/support/ranks.h"
#include "host/training/train_request.h"

namespace tactel::host {

/// Callbacks during a training. Empty functions are allowed.
struct TrainingWatch {
  /// Weight updates done and in all, and the mean rate in patterns per second, 0 while unknown. Called from the thread
  /// that runs the training; false stops it.
  std::function<bool(std::size_t done, std::size_t all, double patterns_per_second)> progress{};
  std::function<void(const std::string& stage)> stage{};  ///< what comes before; empty: the training begins
  LogSink log{};
};

enum class TrainingEnd {
  finished,     ///< the directory holds networks and report
  done_before,  ///< the directory held them before the run
  stopped,      ///< by the watch; the state is kept
};

/// Outcome of a training, of all processes.
struct TrainingOutcome {
  TrainingEnd end = TrainingEnd::finished;
  std::size_t networks = 0, diverged = 0;  ///< a network that diverged has no file
  double share = 0;                        ///< where stopped: completed share of the most possible work
  std::filesystem::path checkpoint{};      ///< where stopped: the state for --resume; empty for several processes
  std::string summary{};                   ///< whole lines; of the first process
  std::vector<std::string> tables{};       ///< of errors, each whole lines with a heading; of one process
  std::string undrawn{};                   ///< why learning_curves.svg is missing; empty where it was drawn
};

/// Trains the networks of a request on its set or stream, judges them on its recall set, and writes the directory. Goes
/// on from the directory's checkpoint where there is one to resume. Under mpirun every process calls it and trains the
/// seeds with index mod processes = rank, with a checkpoint of its own; the first one writes report and figure. Throws
/// ConfigError for what the request cannot learn from, and for a checkpoint or directory of another training.
TrainingOutcome train(const TrainRequest& request, const Ranks& ranks, const TrainingWatch& watch);

}  // namespace tactel::host
