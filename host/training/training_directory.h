// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/figures/plot.h"

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

}  // namespace tactel::host
