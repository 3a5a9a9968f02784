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
  /// Weight updates (of a stream: rows) done of all, and the pace so far in patterns a second, 0 where none is known.
  /// Called from the thread that runs the training; false stops it.
  std::function<bool(std::size_t done, std::size_t all, double patterns_per_second)> progress{};
  LogSink log{};
};

enum class TrainingEnd {
  finished,     ///< the directory holds networks and report
  done_before,  ///< it held them already
  stopped,      ///< by the watch; what is done is kept
};

/// Outcome of a training.
struct TrainingOutcome {
  TrainingEnd end = TrainingEnd::finished;
  std::size_t networks = 0, diverged = 0;  ///< a network that diverged has no file
  double share = 0;                        ///< stopped: of the work, at most
  std::filesystem::path checkpoint{};      ///< stopped: what --resume goes on from; empty for several processes
  std::string summary{};                   ///< whole lines
  std::vector<std::string> tables{};       ///< of errors, each whole lines with a heading
};

/// A prepared training: checked, compiled, on the device.
class TrainingJob {
 public:
  virtual ~TrainingJob() = default;
  /// Trains from the directory's checkpoint if need be, and writes the directory. Throws ConfigError for a checkpoint
  /// or directory that is another training's, and for files that cannot be written.
  virtual TrainingOutcome run(const TrainingWatch& watch) = 0;
};

}  // namespace tactel::host
