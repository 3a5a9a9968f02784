#pragma once
#include <filesystem>
#include <string>

#include "nn/model.h"

namespace tactel::host {

/// Writes a network as ONNX, opset 13: input `frame` [batch, inputs] in MPa, output `slip_index` [batch, 1] in 0..1;
/// scaling and the shift by 0.5 are in the graph, so that any ONNX runtime gives the S that tactel gives, to rounding.
/// Metadata: topology, seed, noise, learning set, cycles, errors, scaling, version, and a checksum. Under
/// a temporary name first, then renamed. Throws ConfigError when the file cannot be written.
void write_onnx(const std::filesystem::path& path, const nn::Model& model);

/// Reads a network that write_onnx wrote. Throws ConfigError, saying which, for a file that cannot be read, is cut
/// short or damaged, or holds another graph.
nn::Model read_onnx(const std::filesystem::path& path);

/// The file's bytes.
std::string onnx_bytes(const nn::Model& model);

}  // namespace tactel::host
