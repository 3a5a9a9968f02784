// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/infer.h>

#include <map>
#include <string>
#include <string_view>

#include "nn/network.h"

namespace tactel::infer {

using Metadata = std::map<std::string, std::string, std::less<>>;

/// A network that was read from a file.
struct NetworkFile {
  nn::Model model;
  Metadata metadata;
};

inline constexpr std::size_t most_network_bytes = 4 << 20;  ///< of a file; the largest topology's weights take 0.5 MB

/// Returns the file of a network: ONNX, opset 13, the graph of nn/infer/network_graph.h. Metadata: topology, seed,
/// noise, learning set, cycles, errors, scaling, version and a checksum; history, stride and history_change of several
/// frames; magnitude; target, where it is not S; the ranges of nn::Learnt; what a bound was calibrated on.
std::string network_bytes(const nn::Model& model);

/// Reads what network_bytes wrote. The bytes are read by name, written again, and
/// compared: they hold the one graph that this reader knows, and nothing else of ONNX. Throws ValueError, key
/// "network", whose value is the problem: truncated or damaged bytes, or another graph.
NetworkFile read_network(std::string_view bytes);

/// Returns the network for frames one by one, as SlipEstimator::parse does of its file.
SlipEstimator estimator_of(const nn::Model& model);

}  // namespace tactel::infer
