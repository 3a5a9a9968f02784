// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "nn/activation.h"

namespace tactel::nn {

/// Widths of a network's layers, inputs first, and the activation of the hidden ones. The constructor requires 1 or 2
/// hidden layers (the paper's two families), and one output, or three: the heads of a bound (nn/quantile_heads.h).
class Topology {
 public:
  static constexpr int widest_layer = 384;
  static constexpr int heads = 3;  ///< outputs of a network with a bound

  /// Throws ValueError, key "network".
  explicit Topology(std::vector<int> widths, Activation activation = Activation::logistic);
  /// Returns the topology of a number of the paper, "1" ... "6", or of widths joined by hyphens, "42-42-21-1"; with
  /// hidden neurons other than the paper's their name follows, "42-96-96-1_leaky-relu". Throws ValueError, key
  /// "network".
  static Topology parse(std::string_view text);
  /// Returns network 1 ... 6 of the paper (section V.A). Throws ValueError, key "network".
  static Topology paper(int number);

  const std::vector<int>& widths() const { return widths_; }
  int inputs() const { return widths_.front(); }
  int outputs() const { return widths_.back(); }  ///< 1 or `heads`
  bool has_bound() const { return outputs() == heads; }
  /// Returns the same hidden layers with the heads of a bound.
  Topology with_bound() const;
  /// Returns the same layers behind another number of inputs, or with another activation.
  Topology with_inputs(int inputs) const;
  Topology with_activation(Activation activation) const { return Topology(widths_, activation); }
  int layers() const { return static_cast<int>(widths_.size()) - 1; }  ///< of weights: hidden layers + 1
  int hidden_layers() const { return layers() - 1; }
  Activation hidden_activation() const { return activation_; }
  Activation activation(int layer) const { return layer < hidden_layers() ? activation_ : Activation::logistic; }
  int fan_in(int layer) const { return widths_[layer]; }
  int fan_out(int layer) const { return widths_[layer + 1]; }

  /// Returns the index of the first weight of a layer. Weights are stored [layer][out][in + 1], the bias last.
  std::size_t layer_offset(int layer) const;
  std::size_t weight_count() const { return layer_offset(layers()); }

  /// Returns the paper's limit of learning cycles: 10 000, or 15 000 with two hidden layers (section V.B).
  int cycle_limit() const { return hidden_layers() > 1 ? 15000 : 10000; }
  /// "42-42-21-1", "42-96-96-1_leaky-relu".
  std::string text() const;
  bool operator==(const Topology&) const = default;

 private:
  std::vector<int> widths_;
  Activation activation_;
};

}  // namespace tactel::nn
