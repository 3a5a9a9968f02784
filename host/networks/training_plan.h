// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/support/precision.h"
#include "nn/frame_set.h"
#include "nn/train_batch.h"

namespace tactel::host {

/// Networks to train: every topology with every seed at every noise level, on one learning set or stream; pattern by
/// pattern, or by mini-batches.
struct TrainingPlan {
  std::vector<nn::Topology> topologies;
  std::vector<std::uint64_t> seeds;
  std::vector<double> noises{0.0};  ///< standard deviations over the set's largest |stress|; drawn anew for each seed
  nn::ScalingKind scaling = nn::ScalingKind::set;
  nn::OnlineOptions options;
  /// Options of mini-batches. Of the other options only stop_error and the limit of cycles (epochs) then apply.
  std::optional<nn::BatchOptions> batch{};
  /// Rows of a stream to learn from. The learning rate falls linearly to last_rate of its start by then. Of the other
  /// options only `batch` then applies.
  std::optional<std::uint64_t> rows{};
  nn::InputHistory history{};                   ///< of the inputs; the learning set has them already (nn::with_history)
  bool magnitude = false;                       ///< learn |S|
  float alarm_at = 0;                           ///< nn::Learnt::alarm_at of its networks
  nn::Target target = nn::Target::slip_index;   ///< that the learning set has in the place of S
  bool markers = false;                         ///< frames are of markers
  nn::Features features = nn::Features::frame;  ///< before networks, whose topologies have the inputs without them

  /// Rows that judge each network after each of its cycles, of mini-batches alone; its result is then the weights of
  /// the smallest mean error. A network stops after `patience` cycles without a smaller one; 0: never.
  std::shared_ptr<const nn::FrameSet> validation{};
  int patience = 0;

  static constexpr double last_rate = 0.01;
  void validate() const;  ///< throws ValueError, keys "network", "seeds", "noise", "training. ..."
  /// Whether a network learns no more after so many cycles and rows, whatever its errors.
  bool over(const nn::Topology& topology, std::uint64_t cycles, std::uint64_t shown) const {
    return rows ? shown >= *rows : cycles >= static_cast<std::uint64_t>(options.cycles(topology));
  }
};

/// Errors of a cycle: of a pass over a set, or of a block of a stream. The error of a pattern is taken as it is shown.
struct CurvePoint {
  std::uint64_t cycle = 0;  ///< counted from 1
  std::uint64_t rows = 0;   ///< shown until then
  float sse = 0, mean_square = 0, largest = 0;
  float recall = 0;  ///< mean error on the recall set of a stream; NaN of a network that diverged, 0 without such a set
  double validation = 0;  ///< the same on the validation set
  bool operator==(const CurvePoint&) const = default;
};

/// Returns the last point of a curve up to a place, or its first: the errors of a network that has stopped stay.
const CurvePoint& point_at(const std::vector<CurvePoint>& curve, std::uint64_t CurvePoint::*place, std::uint64_t at);

/// One network and the state of its training.
struct TrainedNetwork {
  nn::Topology topology;
  std::uint64_t seed = 0;
  double noise = 0;
  nn::TrainStatus status = nn::TrainStatus::running;
  std::uint32_t cycles = 0;
  std::uint64_t rows = 0;        ///< shown so far
  float sse = 0, largest = 0;    ///< of its last cycle
  double seconds = 0;            ///< of training until its last cycle ended, earlier runs included
  std::uint32_t best_cycle = 0;  ///< of the smallest mean error on the validation set; 0: none
  double best_error = std::numeric_limits<double>::infinity();
  std::vector<CurvePoint> curve{};  ///< of the first ten cycles, then of cycles a tenth apart, and of the last

  bool running() const { return status == nn::TrainStatus::running; }
  /// Adds a cycle of this many rows.
  void note_cycle(const nn::CycleErrors& errors, std::uint32_t its_rows, bool last);
  /// Ends the training after the last cycle, of this many rows.
  void stop_early(std::uint32_t its_rows);
};

/// Returns all inputs of the networks' bits, as text. Checkpoints of another description are rejected. `source`:
/// description of the learning set or the stream.
std::string training_description(const std::string& source, int lanes, Precision precision, const TrainingPlan& plan);
/// Returns the description of a learning set.
std::string set_description(const nn::FrameSet& set);

}  // namespace tactel::host
