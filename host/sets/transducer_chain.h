// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "host/device/buffer.h"
#include "host/device/executor.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// Launcher of kernels/transducer_chain.cl: the readings of many contacts, in single precision. The readings of a
/// contact depend on the settings, the seed, its number and its stresses alone.
class TransducerChain {
 public:
  /// `seed`: of the noise; channels, axes and rows as in nn::transducer_chain. Throws ValueError for settings out of
  /// bounds, std::invalid_argument for channels that are not whole axes and rows.
  TransducerChain(Executor& executor, const nn::Transducer& transducer, std::uint64_t seed, int channels, int axes = 2,
                  int rows = 1);

  struct Contact {
    std::uint64_t number = 0;  ///< in the sweep
    std::uint32_t steps = 0;   ///< load steps, from its first on
  };
  /// Replaces stresses by readings in signal [load steps of all contacts, channels] MPa, normal stresses of all tactels
  /// first. Not thread-safe.
  void run(std::span<const Contact> contacts, std::span<float> signal);

 private:
  Executor* executor_;
  std::uint32_t channels_, tactels_, vectors_;
  bool others_, relative_;
  Buffer<float> signal_, stress_;  ///< [steps][vectors_ * lanes]; one buffer where other channels do not count
  Launch launch_;
};

}  // namespace tactel::host
