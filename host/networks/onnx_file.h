// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "nn/model.h"

namespace tactel::host {

/// Writes a network as ONNX (nn/infer/network_file.h): input `frame` [batch, inputs] in MPa, output `slip_index`
/// [batch, 1] in 0..1; of a network with a bound also `slip_upper` [batch, 1], `slip_interval` [batch, 2] and `unlike`
/// [batch, 1]. The graph contains the scaling and the shift by 0.5, so that any ONNX runtime gives the S of tactel, to
/// rounding. The file is written under a temporary name, then renamed. Throws ConfigError where it cannot be written.
void write_onnx(const std::filesystem::path& path, const nn::Model& model);

/// Reads a network that write_onnx wrote, or one of the library by its name, "uskin-4x4". Throws ConfigError, with the
/// reason, for a file that cannot be read, is truncated or damaged, or holds another graph.
nn::Model read_onnx(const std::filesystem::path& path);

/// Returns "42-42-21-1_noise0.1_seed7.onnx".
std::string network_file_name(const nn::Topology& topology, double noise, std::uint64_t seed);

}  // namespace tactel::host
