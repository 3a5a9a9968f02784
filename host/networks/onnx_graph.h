// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <onnx/onnx_pb.h>

#include <string>

#include "nn/model.h"

namespace tactel::host {

/// Returns the graph of a network: `frame` [batch, inputs] MPa, of several frames the newest first -> scaling -> layers
/// -> `slip_index` [batch, 1]; of one with a bound also bound_outputs (onnx_bound.h).
onnx::GraphProto onnx_graph(const nn::Model& model);

/// Reads the network of a graph: weights and biases by their names in onnx_graph; topology and scaling are given.
/// Returns false where one is missing, or of another type or size.
bool read_weights(const onnx::GraphProto& graph, nn::Weights<float>& weights);

/// Metadata key of the checksum of a file.
inline const std::string checksum_key = "checksum";

/// Returns the checksum of the contents of a file: names, types, dimensions and numbers of all initializers, and
/// the metadata except the checksum itself, sorted. It does not depend on the byte encoding of protobuf.
std::string onnx_checksum(const onnx::ModelProto& model);

}  // namespace tactel::host
