#pragma once
#include <memory>
#include <span>
#include <vector>

#include "host/learning_inputs.h"
#include "host/network_sweep.h"
#include "host/sweep_checkpoint.h"
#include "host/train_online.h"

namespace tactel::host {

/// What a schedule trains: for every topology, networks of these members.
struct SweepMembers {
  std::vector<nn::Topology> topologies;
  std::vector<OnlineMember> members;  ///< of each topology
  std::size_t size() const { return topologies.size() * members.size(); }
};

/// How the networks of a sweep learn. Networks are counted [topologies][members].
template <class Real>
class SweepSchedule {
 public:
  virtual ~SweepSchedule() = default;
  /// Some cycles of every network that is running, and what became of them noted in `networks`. `go_on` is asked now
  /// and then; after its false the round ends early.
  virtual void run_round(std::vector<SweepNetwork>& networks, const std::function<bool()>& go_on) = 0;
  virtual nn::Weights<Real> weights(std::size_t network) const = 0;
  /// Fills in the numbers of a record, whose network is known.
  virtual void store(std::size_t network, NetworkRecord<Real>& record) const = 0;
  /// All networks as records hold them.
  virtual void restore(std::span<const NetworkRecord<Real>> records) = 0;
};

/// Pattern by pattern (train_online.h).
template <class Real>
std::unique_ptr<SweepSchedule<Real>> online_schedule(Executor& executor, const LearningInputs<Real>& inputs,
                                                     const SweepMembers& members, const nn::OnlineOptions& options);
/// Mini-batches (train_batch.h). Of `limits`, stop_error and the limit of cycles count.
template <class Real>
std::unique_ptr<SweepSchedule<Real>> batch_schedule(Executor& executor, const LearningInputs<Real>& inputs,
                                                    const SweepMembers& members, const nn::BatchOptions& options,
                                                    const nn::OnlineOptions& limits);

/// Notes one more cycle of a network; its curve keeps the first ten, then cycles a tenth apart, and the last.
void note_cycle(SweepNetwork& network, const nn::CycleErrors& errors, bool last);

extern template std::unique_ptr<SweepSchedule<float>> online_schedule(Executor&, const LearningInputs<float>&,
                                                                      const SweepMembers&, const nn::OnlineOptions&);
extern template std::unique_ptr<SweepSchedule<double>> online_schedule(Executor&, const LearningInputs<double>&,
                                                                       const SweepMembers&, const nn::OnlineOptions&);
extern template std::unique_ptr<SweepSchedule<float>> batch_schedule(Executor&, const LearningInputs<float>&,
                                                                     const SweepMembers&, const nn::BatchOptions&,
                                                                     const nn::OnlineOptions&);
extern template std::unique_ptr<SweepSchedule<double>> batch_schedule(Executor&, const LearningInputs<double>&,
                                                                      const SweepMembers&, const nn::BatchOptions&,
                                                                      const nn::OnlineOptions&);

}  // namespace tactel::host
