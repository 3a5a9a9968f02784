#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tactel::host {

/// The directory that `tactel train` writes: networks, training.json, learning_curves.svg; and, until it is done, the
/// checkpoint. training.json comes last: where it is, the training is done.
class TrainingDirectory {
 public:
  explicit TrainingDirectory(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path checkpoint() const { return path_ / "checkpoint"; }
  std::filesystem::path report() const { return path_ / "training.json"; }
  std::filesystem::path figure() const { return path_ / "learning_curves.svg"; }
  std::filesystem::path network(const std::string& file) const { return path_ / file; }

  bool finished() const;
  bool interrupted() const;
  /// Makes the directory; throws ConfigError naming --output where it cannot be, or holds what neither --resume nor
  /// --force (if given) may touch. Nothing is removed yet.
  void check(bool resume, bool force) const;
  /// Throws ConfigError when the finished training in here is not the one of this fingerprint.
  void expect_same(const std::string& fingerprint) const;
  /// Removes what an earlier training left.
  void clear() const;
  void remove_checkpoint() const;

 private:
  std::vector<std::string> own_networks() const;

  std::filesystem::path path_;
};

}  // namespace tactel::host
