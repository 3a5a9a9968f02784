// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "host/networks/training_plan.h"

namespace tactel::host {

/// State of one network for a bit-identical resumption of a training.
template <class Real>
struct NetworkRecord {
  TrainedNetwork network;      ///< topology, seed and noise are the plan's and not stored
  nn::BatchState<Real> state;  ///< pattern by pattern: `first` holds the momentum's steps, `second` is empty
  std::vector<Real> best{};    ///< weights of network.best_cycle; empty where there is none
};

/// Writes records under a temporary name, then renames. `plan` is all inputs of the records, as text. Throws
/// ConfigError where the file cannot be written.
template <class Real>
void write_checkpoint(const std::filesystem::path& path, const std::string& plan,
                      std::span<const NetworkRecord<Real>> records);

/// Throws ConfigError where such a file exists and is damaged, truncated, or of another plan.
void expect_checkpoint_of(const std::filesystem::path& path, const std::string& plan);

/// Fills records; their sizes must be those of the file. Returns false where there is no such file. Throws
/// ConfigError for a file that is damaged, truncated, or of another plan.
template <class Real>
bool read_checkpoint(const std::filesystem::path& path, const std::string& plan,
                     std::span<NetworkRecord<Real>> records);

}  // namespace tactel::host
