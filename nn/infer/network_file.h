// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nn/frame_history.h"

namespace tactel::infer {

/// A layer of a network file.
struct FileLayer {
  int inputs = 0, outputs = 0;
  bool leaky = false;          ///< leaky rectifiers, else logistic neurons
  std::vector<float> weights;  ///< [outputs, inputs]
  std::vector<float> bias;     ///< [outputs]
};

inline constexpr float touching_share = 0.05f;  ///< nn::Bound::touching_share
inline constexpr int heads = 3;  ///< outputs of a network with a bound: S and the widths of two quantiles

/// Tables of a bound, as nn::Bound (nn/bound.h).
struct FileBound {
  std::vector<float> touching, slip_index, width, distance;  ///< edges of the classes; of the distance perhaps none
  std::vector<float> upper_correction;                       ///< [classes]
  std::vector<float> interval_correction;                    ///< [classes]
  std::size_t tactels = 0;                                   ///< normal stresses that a scaled frame begins with
  std::vector<float> centre;                                 ///< [inputs]
  std::vector<float> whitening;                              ///< [inputs, inputs]
  float unlike_above = 0;
};

/// Contents of a network file.
struct NetworkFile {
  std::vector<FileLayer> layers;
  bool by_frame = false;  ///< divide a frame by its own largest |normal stress|; else multiply it by `factor`
  float factor = 0;       ///< 1/MPa
  nn::InputHistory history;
  std::optional<FileBound> bound;
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
