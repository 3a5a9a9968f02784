// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "nn/model.h"

namespace tactel::host {

/// A layer of a network that another program trained: activation(weights x + bias).
struct DenseLayer {
  enum class Activation { sigmoid, tanh, leaky_relu };

  nn::RowMatrix<double> weights;  ///< [out, in]
  nn::Vector<double> bias;        ///< [out]
  Activation activation = Activation::sigmoid;
  double slope = 0;  ///< of leaky_relu below 0; 0: relu
};

/// A chain of dense layers; the last gives S.
using DenseChain = std::vector<DenseLayer>;

/// Returns the weights of the same function in tactel's neurons, f(z) = 1/2 tanh(z/2) and the leaky rectifier of slope
/// a = 0.01. With z the sum of a neuron:
///   sigmoid(z) = f(z) + 1/2,  tanh(z) = 2 f(2z),
///   leaky_b(z) = ((1 - ab) leaky_a(z) + (a - b) leaky_a(-z)) / (1 - a^2): two neurons, unless b = a.
/// Throws ValueError, key "network", for a chain without one or two hidden layers of one kind, rectifiers or not, for
/// one that does not end in a single sigmoid, for layers wider than nn::Topology::widest_layer, and for numbers that
/// are not finite in fp32.
nn::Weights<float> weights_of_chain(const DenseChain& chain);

/// Returns the network of a chain: its scaling, its history, to which `rest` adds a frame, `name` as its learning set,
/// and what it answers. Throws ValueError as above, and where these do not fit.
nn::Model model_of_chain(const DenseChain& chain, nn::InputScaling scaling, nn::InputHistory history,
                         const std::string& name, nn::Target target);

}  // namespace tactel::host
