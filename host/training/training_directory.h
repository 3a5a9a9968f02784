// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "host/figures/plot.h"
#include "host/networks/training_plan.h"

namespace tactel::host {

/// The directory that `tactel train` writes: networks, training.json, learning_curves.svg and .jsonl, and during
/// training the checkpoint. training.json is written last: its presence means that the training is complete.
class TrainingDirectory {
 public:
  explicit TrainingDirectory(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path checkpoint() const { return path_ / "checkpoint"; }
  /// Returns the checkpoint of one of several processes.
  std::filesystem::path checkpoint(int rank) const { return path_ / ("checkpoint-" + std::to_string(rank)); }
  std::filesystem::path report() const { return path_ / "training.json"; }
  std::filesystem::path figure() const { return path_ / "learning_curves.svg"; }
  std::filesystem::path curves() const { return path_ / "learning_curves.jsonl"; }
  std::filesystem::path network(const std::string& file) const { return path_ / file; }

  bool finished() const;
  bool interrupted() const;
  /// Creates the directory and locks it until the process ends. Throws ConfigError naming --output where that fails, or
  /// where it holds files that neither --resume nor --force (if given) may change. Removes nothing.
  void check(bool resume, bool force) const;
  /// Throws ConfigError where the finished training of this directory has another fingerprint.
  void expect_same(const std::string& fingerprint) const;
  /// Removes the files of an earlier training.
  void clear() const;
  void remove_checkpoints() const;
  /// Draws learning_curves.svg. Returns why that failed, or an empty text: no training is lost for a picture.
  std::string draw(const Figure& curves) const;

 private:
  std::vector<std::string> own_networks() const;
  std::vector<std::filesystem::path> checkpoints() const;  ///< and what a writing that was killed left of one

  std::filesystem::path path_;
};

/// Returns the text of a training.json; empty where there is none. Throws ConfigError for what is no regular file, or
/// larger than 1 GiB.
std::string read_report(const std::filesystem::path& path);

/// What the curves of a training show.
struct CurveKind {
  bool stream = false;     ///< over rows seen, else over cycles
  bool judged = false;     ///< of a stream: with the mean error on a recall set
  bool validated = false;  ///< with the mean error on a validation set
  double stop_error = 0;   ///< of a set: a line where the training stops
};

/// Returns a figure of errors on logarithmic axes; two panels for each level of noise. Of a set: the sum of squared
/// errors and the largest error of a cycle. Of a stream: the root mean square error of a block before the networks
/// learned it, and the mean error on the recall set. That on a validation set is dashed, in a panel with the recall
/// set's or in a third one. Each topology has a curve: that of its network, or the median over
/// seeds in a band from the 5 to the 95 % quantile. A stopped network keeps the errors of its last cycle.
Figure learning_curves(std::span<const TrainedNetwork> networks, const CurveKind& kind);

}  // namespace tactel::host
