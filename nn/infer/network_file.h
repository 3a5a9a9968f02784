// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "nn/frame_history.h"

namespace tactel::infer {

/// A layer of a network file.
struct FileLayer {
  int inputs = 0, outputs = 0;
  std::vector<float> weights;  ///< [outputs, inputs]
  std::vector<float> bias;     ///< [outputs]
};

/// Contents of a network file.
struct NetworkFile {
  std::vector<FileLayer> layers;
  bool by_frame = false;  ///< divide a frame by its own largest |normal stress|; else multiply it by `factor`
  float factor = 0;       ///< 1/MPa
  nn::InputHistory history;
  std::map<std::string, std::string, std::less<>> metadata;
};

inline constexpr int widest_layer = 256;

/// Reads the bytes of a network file that tactel wrote (host/networks/onnx_graph.h); errors name `place`. Throws
/// InputError where the bytes are truncated or damaged (their checksum), or hold another graph.
///
/// The reader is our own, so that a robot's controller needs no protobuf: it reads the one graph that our exporter
/// writes, and nothing else of ONNX.
NetworkFile read_network_file(std::string_view bytes, const std::string& place);

/// Returns the bytes of a file. Throws InputError where it cannot be read or is no network by its size.
std::string read_network_bytes(const std::string& path);

}  // namespace tactel::infer
