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
  /// `seed`: of the noise; `channels`: 2 tactels. Throws ValueError for settings out of bounds.
  TransducerChain(Executor& executor, const nn::Transducer& transducer, std::uint64_t seed, int channels);

  struct Contact {
    std::uint64_t number = 0;  ///< in the sweep
    std::uint32_t steps = 0;   ///< load steps, from its first on
  };
  /// Replaces stresses by readings in signal [load steps of all contacts, channels] MPa, normal stresses of all
  /// tactels first. Not thread-safe.
  void run(std::span<const Contact> contacts, std::span<float> signal);

 private:
  Executor* executor_;
  std::uint32_t channels_, vectors_;
  bool neighbours_, relative_;
  Buffer<float> signal_, stress_;  ///< [steps][vectors_ * lanes]; one buffer where neighbours do not count
  Launch launch_;
};

}  // namespace tactel::host
