// SPDX-License-Identifier: Apache-2.0
#include "host/networks/dense_chain.h"

#include <fmt/format.h>

#include <cmath>

#include "fem/numbers/value_error.h"

namespace tactel::host {
namespace {

using Activation = DenseLayer::Activation;
using Matrix = nn::RowMatrix<double>;

[[noreturn]] void refuse(const std::string& problem, const std::string& allowed) {
  throw ValueError("network", problem, allowed);
}

/// A layer's answers by tactel's neurons: mix * neurons + shift. The neurons take the sums of the layer times
/// `of_sums`.
struct Neurons {
  Matrix of_sums, mix;
  nn::Vector<double> shift;
};

Neurons neurons_of(const DenseLayer& layer) {
  const Eigen::Index n = layer.weights.rows();
  const Matrix identity = Matrix::Identity(n, n);
  const nn::Vector<double> none = nn::Vector<double>::Zero(n);
  if (layer.activation == Activation::sigmoid) return {identity, identity, nn::Vector<double>::Constant(n, 0.5)};
  if (layer.activation == Activation::tanh) return {2 * identity, 2 * identity, none};
  const double a = nn::leak, b = layer.slope;
  if (std::abs(a - b) < 1e-7) return {identity, identity, none};
  Neurons two{Matrix(2 * n, n), Matrix(n, 2 * n), none};
  two.of_sums << identity, -identity;
  two.mix << (1 - a * b) / (1 - a * a) * identity, (a - b) / (1 - a * a) * identity;
  return two;
}

bool rectifies(const DenseLayer& layer) { return layer.activation == Activation::leaky_relu; }

void check(const DenseChain& chain) {
  if (chain.size() < 2 || chain.size() > 3)
    refuse(fmt::format("{} dense layers", chain.size()), "a chain of one or two hidden layers and an output");
  for (std::size_t l = 0; l < chain.size(); ++l) {
    const auto& [weights, bias, activation, slope] = chain[l];
    if (bias.size() != weights.rows() || (l > 0 && weights.cols() != chain[l - 1].weights.rows()))
      refuse(fmt::format("layer {} of [{}, {}] with {} biases", l + 1, weights.rows(), weights.cols(), bias.size()),
             "layers [out, in] that fit each other, with a bias for each output");
    if (!std::isfinite(slope) || std::abs(slope) >= 1)
      refuse(fmt::format("a slope of {:g}", slope), "a rectifier's slope below 0, above -1 and below 1");
  }
  if (chain.back().activation != Activation::sigmoid || chain.back().weights.rows() != 1)
    refuse(fmt::format("{} outputs of another kind", chain.back().weights.rows()),
           "one output through a sigmoid: S lies between 0 and 1");
  if (chain.size() == 3 && rectifies(chain[0]) != rectifies(chain[1]))
    refuse("a rectifier beside another hidden layer", "hidden layers that all rectify, or none");
}

}  // namespace

nn::Weights<float> weights_of_chain(const DenseChain& chain) {
  check(chain);
  std::vector<int> widths{static_cast<int>(chain.front().weights.cols())};
  std::vector<Matrix> layers;  // [out, in + 1], the bias in the last column
  const Eigen::Index inputs = chain.front().weights.cols();
  Neurons before{{}, Matrix::Identity(inputs, inputs), nn::Vector<double>::Zero(inputs)};
  for (std::size_t l = 0; l < chain.size(); ++l) {
    const DenseLayer& layer = chain[l];
    Matrix sums(layer.weights.rows(), before.mix.cols() + 1);
    sums << layer.weights * before.mix, layer.bias + layer.weights * before.shift;
    before = neurons_of(layer);
    layers.push_back(before.of_sums * sums);
    widths.push_back(static_cast<int>(layers.back().rows()));
  }
  const bool rectifiers = rectifies(chain.front());
  nn::Weights<float> made(nn::Topology(widths, rectifiers ? nn::Activation::leaky_relu : nn::Activation::logistic));
  for (std::size_t l = 0; l < layers.size(); ++l) made.layer(static_cast<int>(l)) = layers[l].cast<float>();
  if (!nn::all_finite(made)) refuse("a weight that is NaN or infinite", "a network with finite weights");
  return made;
}

nn::Model model_of_chain(const DenseChain& chain, nn::InputScaling scaling, nn::InputHistory history,
                         const std::string& name, nn::Target target) {
  nn::Weights<float> weights = weights_of_chain(chain);
  history.rest = scaling.kind == nn::ScalingKind::rest;
  history.frames += history.rest;
  scaling.history = history.frames;
  scaling.validate();
  if (weights.topology.inputs() % (scaling.axes * scaling.shown()) != 0)
    refuse(fmt::format("{} inputs for a history of {} frames with {} stresses a tactel", weights.topology.inputs(),
                       scaling.shown(), scaling.axes),
           "inputs of so many equal frames");
  nn::Model model{std::move(weights), scaling, 0, 0, name, 0, {}, history};
  model.target = target;
  return model;
}

}  // namespace tactel::host
