#pragma once
#include <cstdint>
#include <string>

#include "nn/input_scaling.h"
#include "nn/metrics.h"
#include "nn/weights.h"

namespace tactel::nn {

/// A network ready for use, and where it comes from: what a model file holds.
struct Model {
  Weights<float> weights;
  InputScaling scaling;
  std::uint64_t seed = 0;        ///< of initial weights, order and noise
  double noise = 0;              ///< fraction of the largest stress
  std::string learning_set;      ///< which set it learnt, as the user named it
  std::uint32_t cycles = 0;      ///< cycles or epochs it learnt for
  ErrorSummary learning_errors;  ///< on the set that it learnt
};

}  // namespace tactel::nn
