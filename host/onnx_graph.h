#pragma once
#include <onnx/onnx_pb.h>

#include "nn/model.h"

namespace tactel::host {

/// The graph of a network: `frame` [batch, inputs] MPa -> scaling -> layers -> `slip_index` [batch, 1].
onnx::GraphProto onnx_graph(const nn::Model& model);

/// The network whose graph this is, weights and biases by their names in onnx_graph; topology and scaling are given.
/// False when one is missing, or of another type or size.
bool read_weights(const onnx::GraphProto& graph, nn::Weights<float>& weights);

}  // namespace tactel::host
