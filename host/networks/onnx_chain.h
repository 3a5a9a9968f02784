// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "host/networks/dense_chain.h"

namespace tactel::host {

/// Reads a chain of dense layers from an ONNX file that another program wrote: Gemm or MatMul, with Sigmoid, Tanh, Relu
/// and LeakyRelu between them. Constants that are added, subtracted, multiplied or divided, and BatchNormalization, go
/// into the next layer; 1/2 + 1/2 tanh at the end is a sigmoid. Identity, Cast, Flatten, Squeeze, Dropout and a Reshape
/// to as many places change nothing; a weight may be an Identity, a Cast or a Transpose of a constant. Numbers may lie
/// in the file or, as PyTorch leaves them, in one beside it. Throws ConfigError with the operation that is none of
/// these.
DenseChain read_onnx_chain(const std::filesystem::path& path);

}  // namespace tactel::host
