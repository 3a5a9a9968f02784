#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/executor.h"
#include "host/train_online.h"
#include "nn/metrics.h"
#include "nn/model.h"
#include "nn/train_batch.h"

namespace tactel::host {

/// Which networks a sweep trains: every topology with every seed at every noise level, on one learning set; pattern by
/// pattern, or by mini-batches.
struct SweepPlan {
  std::vector<nn::Topology> topologies;
  std::vector<std::uint64_t> seeds;
  std::vector<double> noises{0.0};  ///< standard deviations over the set's largest |stress|; drawn anew for each seed
  nn::ScalingKind scaling = nn::ScalingKind::set;
  nn::OnlineOptions options;
  /// Mini-batches by these options; of the others only stop_error and the limit of cycles (epochs) count then.
  std::optional<nn::BatchOptions> batch{};
  void validate() const;  ///< throws ValueError, keys "network", "seeds", "noise", "training. ..."
};

/// Errors at some cycles: the first ten, then cycles a tenth apart, and the last.
struct LearningCurve {
  std::vector<std::uint32_t> cycle;  ///< counted from 1
  std::vector<float> sse, largest;   ///< of that cycle, each pattern's as it was shown
};

/// One network of a sweep and how far it is.
struct SweepNetwork {
  nn::Topology topology;
  std::uint64_t seed = 0;
  double noise = 0;
  nn::TrainStatus status = nn::TrainStatus::running;
  std::uint32_t cycles = 0;
  float sse = 0, largest = 0;  ///< of its last cycle
  double seconds = 0;          ///< that the sweep had run for after its last cycle, earlier runs included
  LearningCurve curve;
};

struct SweepRunOptions {
  Progress progress;                 ///< weight updates done of the most that there can be; false stops
  std::filesystem::path checkpoint;  ///< where to keep the state; empty: nowhere
  double checkpoint_seconds = 10;    ///< between two writings; one more at the end of the run
};

/// Trains many networks at once. Each network's bits depend on its topology, seed, noise, the set and the options: not
/// on what else the sweep holds, how often it was stopped, or the number of threads.
template <class Real>
class NetworkSweep {
 public:
  /// Throws ValueError for a plan or set that cannot work.
  NetworkSweep(Executor& executor, const nn::FrameSet& set, const SweepPlan& plan);
  ~NetworkSweep();

  /// Trains until every network has stopped: true; or until progress says no: false, and run may be called again.
  bool run(const SweepRunOptions& options = {});

  /// In the order topologies, noises, seeds (fastest).
  const std::vector<SweepNetwork>& networks() const;
  nn::Weights<Real> weights(std::size_t network) const;
  const nn::InputScaling& scaling() const;
  /// Patterns shown so far, and the seconds that they took; with those before a checkpoint that was loaded.
  double patterns() const;
  double seconds() const;

  /// |S of a network - S of the set|: [networks][rows], NaN where the network gave none.
  std::vector<std::vector<double>> absolute_errors(const nn::FrameSet& set) const;
  /// Errors of every network: on a set, or each on the set that it learnt, noise included.
  std::vector<nn::ErrorReport> recall(const nn::FrameSet& set) const;
  std::vector<nn::ErrorReport> recall_learning_set() const;
  /// A network as a model file holds it. `learning_set`: the set's name.
  nn::Model model(std::size_t network, const std::string& learning_set) const;
  /// The same where its errors on the set that it learnt are known.
  nn::Model model(std::size_t network, const std::string& learning_set, const nn::ErrorSummary& learning_errors) const;

  /// All that the networks' bits depend on, as text: checkpoints of another description are refused.
  std::string description() const;

  void save(const std::filesystem::path& checkpoint) const;
  /// False when there is no such file. Throws ConfigError for one that is damaged, or another sweep's.
  bool load(const std::filesystem::path& checkpoint);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

extern template class NetworkSweep<float>;
extern template class NetworkSweep<double>;

}  // namespace tactel::host
