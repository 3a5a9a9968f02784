// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "host/device/executor.h"
#include "host/networks/frame_stream.h"
#include "host/networks/learning_inputs.h"
#include "host/networks/training_checkpoint.h"
#include "host/support/log.h"
#include "nn/metrics.h"
#include "nn/model.h"

namespace tactel::host {

struct TrainingRunOptions {
  Progress progress;                     ///< weight updates of the most possible; false stops
  std::filesystem::path checkpoint;      ///< file of the state; empty: none
  double checkpoint_seconds = 10;        ///< s between two writings; the state is also written at the end of the run
  const nn::FrameSet* recall = nullptr;  ///< rows that judge the networks of a stream at each point of their curves
  LogSink log{};
};

/// Returns the device that trains a plan's networks for this one: itself where it is a processor, and where a
/// work-group of its own holds each of them (group_items); else Device::for_training.
Device training_device(const Device& device, const TrainingPlan& plan);

template <class T>
class MadeAhead;
template <class Real>
class TrainingSchedule;
template <class Real>
class Validation;

/// Time of a run, s, summed over threads; the rest of `all` they waited.
struct TrainingStages {
  double rows = 0, inputs = 0, training = 0, all = 0;
};

/// Trains many networks at once. The bits of a network depend on its topology, seed, noise, the set or stream and the
/// options. They do not depend on the other networks, interruptions or the number of threads. A set is one block of
/// rows that every cycle shows again; a stream gives new rows for every cycle, made ahead on its threads.
template <class Real>
class NetworkTraining {
 public:
  /// Throws ValueError for an invalid plan or set.
  NetworkTraining(Executor& executor, const nn::FrameSet& set, const TrainingPlan& plan);
  /// The same on the blocks of a stream, plan.rows of them: mini-batches. The frames are scaled by the first block that
  /// has rows. Throws ConfigError for a stream without.
  NetworkTraining(Executor& executor, FrameStream& stream, const TrainingPlan& plan);
  ~NetworkTraining();

  /// Trains until every network has stopped and returns true. Returns false where progress stops it; run may be
  /// called again. Throws ConfigError for a block that cannot be learnt.
  bool run(const TrainingRunOptions& options = {});

  /// In the order topologies, noises, seeds (fastest).
  const std::vector<TrainedNetwork>& networks() const { return networks_; }
  /// Returns what a network has learnt; with a validation set its best weights by that.
  nn::Weights<Real> weights(std::size_t network) const;
  const nn::InputScaling& scaling() const { return scaling_; }
  /// Returns the patterns shown so far and their seconds, including those before a loaded checkpoint.
  double patterns() const;
  double seconds() const { return seconds_; }
  const TrainingStages& stages() const { return stages_; }
  std::uint64_t blocks() const { return stream_ != nullptr ? block_ : 1; }  ///< taken so far
  std::uint64_t rows() const;                                               ///< of these blocks

  /// Returns |S of a network - S of the set|: [networks][rows], NaN where the network gave none.
  std::vector<std::vector<double>> absolute_errors(const nn::FrameSet& set) const;
  /// Returns S of one network on a set: [rows], NaN where it gave none.
  std::vector<double> slip_index(std::size_t network, const nn::FrameSet& set) const;
  /// Returns the errors of every network: on a set, or on its own learning set, noise included. The rows of a stream
  /// are counted alone.
  std::vector<nn::ErrorReport> recall(const nn::FrameSet& set) const;
  std::vector<nn::ErrorReport> recall_learning_set() const;
  /// Returns a network as in a model file. `learning_set`: the name of the set; `learning_errors`: on it.
  nn::Model model(std::size_t network, const std::string& learning_set, const nn::ErrorSummary& learning_errors) const;

  /// Returns all inputs of the bits of this plan's networks as text, or of another plan's.
  std::string description() const { return description(plan_); }
  std::string description(const TrainingPlan& plan) const;

  void save(const std::filesystem::path& checkpoint) const;
  /// Loads a checkpoint. Returns false where there is no such file. Throws ConfigError for a damaged one, or
  /// that of another training.
  bool load(const std::filesystem::path& checkpoint) { return load(checkpoint, plan_.seeds); }
  /// The same for the networks of these seeds, from the checkpoint of a training of them alone.
  bool load(const std::filesystem::path& checkpoint, const std::vector<std::uint64_t>& seeds);

 private:
  /// Rows as networks learn them, and the time that their parts took, s.
  struct Block {
    std::optional<LearningInputs<Real>> inputs{};  ///< none: no row has an answer
    double rows_seconds = 0, inputs_seconds = 0;
  };

  NetworkTraining(Executor& executor, FrameStream* stream, const nn::FrameSet* set, const TrainingPlan& plan);
  void take_first_block();
  Block made_block(std::uint64_t k);
  bool take(const Block& block, const LogSink& log);
  bool run_round(MadeAhead<Block>& blocks, const TrainingRunOptions& options);
  void validate(std::span<const std::uint32_t> cycles, std::uint32_t rows);
  void judge(std::span<const std::uint32_t> cycles, const nn::FrameSet& recall_set);
  nn::Weights<Real> last_weights(std::size_t network) const;
  template <class WeightsOf>
  std::vector<std::vector<double>> absolute_errors(const nn::FrameSet& set, const WeightsOf& weights_of) const;
  bool running() const;
  std::size_t work(bool of_all) const;
  nn::Bound bound_of(double noise, std::uint64_t seed) const;
  std::vector<NetworkRecord<Real>> records() const;
  bool possible(std::span<const NetworkRecord<Real>> records) const;

  Executor& executor_;
  TrainingPlan plan_;                    ///< its topologies as networks have them, behind their features
  FrameStream* stream_;                  ///< none: a set
  std::string source_;                   ///< description of the set or stream
  nn::FrameSet set_;                     ///< the learning set; of a stream its first rows, until they are learnt
  std::uint64_t first_ = 0, block_ = 0;  ///< the stream's first block that has rows, and its next
  double first_seconds_ = 0;             ///< s until the first rows were there
  nn::InputScaling scaling_;
  nn::LearningView view_;
  nn::Learnt learnt_;
  std::optional<nn::Bound> bound_;        ///< of a stream, before its calibration
  std::vector<TrainedNetwork> networks_;  ///< [topologies][noises][seeds]
  std::unique_ptr<TrainingSchedule<Real>> schedule_;
  std::unique_ptr<Validation<Real>> validation_;  ///< none without such a set
  double seconds_ = 0;
  TrainingStages stages_;
};

extern template class NetworkTraining<float>;
extern template class NetworkTraining<double>;

}  // namespace tactel::host
