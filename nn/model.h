// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "nn/bound.h"
#include "nn/input_scaling.h"
#include "nn/metrics.h"
#include "nn/weights.h"

namespace tactel::nn {

/// A network with its scaling and origin: the contents of a model file. scaling.history equals history.frames.
struct Model {
  Weights<float> weights;
  InputScaling scaling;
  std::uint64_t seed = 0;        ///< of initial weights, order and noise
  double noise = 0;              ///< fraction of the largest stress
  std::string learning_set;      ///< name of the learning set, as the user gave it
  std::uint32_t cycles = 0;      ///< cycles or epochs of its training
  ErrorSummary learning_errors;  ///< on its learning set
  InputHistory history{};        ///< which earlier frames its input has
  bool magnitude = false;        ///< its answer is |S|: it learnt from drags to both sides
  std::optional<Bound> bound{};  ///< of a network with the heads of a bound
};

}  // namespace tactel::nn
