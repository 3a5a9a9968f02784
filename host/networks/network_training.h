// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/device/executor.h"
#include "host/networks/train_online.h"
#include "nn/metrics.h"
#include "nn/model.h"
#include "nn/train_batch.h"

namespace tactel::host {

/// Networks to train: every topology with every seed at every noise level, on one learning set; pattern by
/// pattern, or by mini-batches.
struct TrainingPlan {
  std::vector<nn::Topology> topologies;
  std::vector<std::uint64_t> seeds;
  std::vector<double> noises{0.0};  ///< standard deviations over the set's largest |stress|; drawn anew for each seed
  nn::ScalingKind scaling = nn::ScalingKind::set;
  nn::OnlineOptions options;
  /// Options of mini-batches. Of the other options only stop_error and the limit of cycles (epochs) then apply.
  std::optional<nn::BatchOptions> batch{};
  nn::InputHistory history{};  ///< of the inputs; the learning set has them already (nn::with_history)
  bool magnitude = false;      ///< learn |S|
  void validate() const;       ///< throws ValueError, keys "network", "seeds", "noise", "training. ..."
};

/// Errors at some cycles: the first ten, then cycles a tenth apart, and the last.
struct LearningCurve {
  std::vector<std::uint64_t> cycle;  ///< counted from 1
  std::vector<float> sse, largest;   ///< of that cycle; the error of a pattern is taken as it is shown
};

/// One network and the state of its training.
struct TrainedNetwork {
  nn::Topology topology;
  std::uint64_t seed = 0;
  double noise = 0;
  nn::TrainStatus status = nn::TrainStatus::running;
  std::uint32_t cycles = 0;
  float sse = 0, largest = 0;  ///< of its last cycle
  double seconds = 0;          ///< of training until its last cycle ended, earlier runs included
  LearningCurve curve;
};

/// Returns all inputs of the networks' bits, as text. Checkpoints of another description are rejected.
template <class Real>
std::string training_description(const Executor& executor, const nn::FrameSet& set, const TrainingPlan& plan);

struct TrainingRunOptions {
  Progress progress;                 ///< weight updates of the most possible; false stops
  std::filesystem::path checkpoint;  ///< file of the state; empty: none
  double checkpoint_seconds = 10;    ///< s between two writings; the state is also written at the end of the run
};

/// Trains many networks at once. The bits of a network depend on its topology, seed, noise, the set and the
/// options. They do not depend on the other networks, interruptions or the number of threads.
template <class Real>
class NetworkTraining {
 public:
  /// Throws ValueError for an invalid plan or set.
  NetworkTraining(Executor& executor, const nn::FrameSet& set, const TrainingPlan& plan);
  ~NetworkTraining();

  /// Trains until every network has stopped and returns true. Returns false where progress stops it; run may be
  /// called again.
  bool run(const TrainingRunOptions& options = {});

  /// In the order topologies, noises, seeds (fastest).
  const std::vector<TrainedNetwork>& networks() const;
  nn::Weights<Real> weights(std::size_t network) const;
  const nn::InputScaling& scaling() const;
  /// Returns the patterns shown so far and their seconds, including those before a loaded checkpoint.
  double patterns() const;
  double seconds() const;

  /// Returns |S of a network - S of the set|: [networks][rows], NaN where the network gave none.
  std::vector<std::vector<double>> absolute_errors(const nn::FrameSet& set) const;
  /// Returns S of one network on a set: [rows], NaN where it gave none.
  std::vector<double> slip_index(std::size_t network, const nn::FrameSet& set) const;
  /// Returns the errors of every network: on a set, or on its own learning set, noise included.
  std::vector<nn::ErrorReport> recall(const nn::FrameSet& set) const;
  std::vector<nn::ErrorReport> recall_learning_set() const;
  /// Returns a network as in a model file. `learning_set`: the name of the set.
  nn::Model model(std::size_t network, const std::string& learning_set) const;
  /// The same with known errors on its learning set.
  nn::Model model(std::size_t network, const std::string& learning_set, const nn::ErrorSummary& learning_errors) const;

  std::string description() const;  ///< training_description

  void save(const std::filesystem::path& checkpoint) const;
  /// Loads a checkpoint. Returns false where there is no such file. Throws ConfigError for a damaged one, or
  /// that of another training.
  bool load(const std::filesystem::path& checkpoint);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

extern template class NetworkTraining<float>;
extern template class NetworkTraining<double>;

}  // namespace tactel::host
