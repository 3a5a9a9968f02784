// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/networks/onnx_builder.h"
#include "nn/bound.h"

namespace tactel::host {

/// An output of a graph with a bound, beside `slip_index`.
struct BoundOutput {
  const char* name;
  int width;
};
/// slip_upper: S is below it; slip_interval: S is within it, lower end first; unlike: 1 where the frame is unlike those
/// of the learning set, else 0.
inline constexpr BoundOutput bound_outputs[] = {{"slip_upper", 1}, {"slip_interval", 2}, {"unlike", 1}};

/// Appends nn::bounded to a graph: from `scaled` [batch, inputs] and the outputs of the last layer `last` [batch, 3] to
/// `slip_index` and bound_outputs. Needs the scalar `half`. Operators of opset 13.
void add_bound(OnnxBuilder& builder, const nn::Bound& bound, const std::string& last);

/// Reads the tables of a bound by their names; `inputs`: of the network. Returns false where one is missing, or of
/// another type or size.
bool read_bound(const onnx::GraphProto& graph, int inputs, nn::Bound& bound);

}  // namespace tactel::host
