#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/network_sweep.h"

namespace tactel::host {

/// All of one network that a stopped sweep needs to go on to the same bits.
template <class Real>
struct NetworkRecord {
  SweepNetwork network;                 ///< topology, seed and noise are the plan's and not stored
  std::vector<Real> weights;            ///< [layer][out][in + 1]
  std::vector<Real> first, second{};    ///< the same: momentum's steps, or a BatchState's moments; second may be empty
  std::uint64_t rows = 0, updates = 0;  ///< of a training on a stream: seen and made so far
};

/// Writes under a temporary name, then renames. `plan` is all that the records depend on, as text. Throws ConfigError
/// when the file cannot be written.
template <class Real>
void write_checkpoint(const std::filesystem::path& path, const std::string& plan,
                      std::span<const NetworkRecord<Real>> records);

/// Fills records that have the sizes that the file's must have. False when there is no such file. Throws ConfigError
/// for a file that is damaged, cut short, or of another plan.
template <class Real>
bool read_checkpoint(const std::filesystem::path& path, const std::string& plan,
                     std::span<NetworkRecord<Real>> records);

extern template void write_checkpoint(const std::filesystem::path&, const std::string&,
                                      std::span<const NetworkRecord<float>>);
extern template void write_checkpoint(const std::filesystem::path&, const std::string&,
                                      std::span<const NetworkRecord<double>>);
extern template bool read_checkpoint(const std::filesystem::path&, const std::string&, std::span<NetworkRecord<float>>);
extern template bool read_checkpoint(const std::filesystem::path&, const std::string&,
                                     std::span<NetworkRecord<double>>);

}  // namespace tactel::host
