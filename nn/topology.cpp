// SPDX-License-Identifier: Apache-2.0
#include "nn/topology.h"

#include <algorithm>
#include <charconv>

#include "fem/numbers/value_error.h"

namespace tactel::nn {
namespace {

const std::string allowed =
    "1 to 6 (the paper's networks), or widths such as 42-42-21-1: inputs, one or two hidden layers, each 1 to " +
    std::to_string(Topology::widest_layer) +
    " wide, one output, or three for a bound; _leaky-relu behind them for other hidden neurons than the paper's";

const std::string leaky_end = std::string("_") + name(Activation::leaky_relu);

std::string joined(const std::vector<int>& widths) {
  std::string text;
  for (const int width : widths) {
    if (!text.empty()) text += '-';
    text += std::to_string(width);
  }
  return text;
}

// The whole of `text` as a number of at most four digits.
bool read_number(std::string_view text, int& number) {
  if (text.empty() || text.size() > 4 || text.front() == '-') return false;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

}  // namespace

const char* name(Activation activation) { return activation == Activation::logistic ? "logistic" : "leaky-relu"; }

Activation parse_activation(std::string_view text) {
  for (const Activation activation : {Activation::logistic, Activation::leaky_relu})
    if (text == name(activation)) return activation;
  throw ValueError("activation", std::string(text), "logistic (the paper's) or leaky-relu");
}

Topology::Topology(std::vector<int> widths, Activation activation)
    : widths_(std::move(widths)), activation_(activation) {
  bool good = widths_.size() == 3 || widths_.size() == 4;
  for (const int width : widths_) good = good && width >= 1 && width <= widest_layer;
  if (!good || (outputs() != 1 && outputs() != heads)) throw ValueError("network", joined(widths_), allowed);
}

Topology Topology::parse(std::string_view text) {
  const bool leaky = text.ends_with(leaky_end);
  const std::string_view layers = text.substr(0, text.size() - (leaky ? leaky_end.size() : 0));
  std::vector<int> widths;
  for (std::size_t begin = 0; begin <= layers.size();) {
    const std::size_t end = std::min(layers.find('-', begin), layers.size());
    int width = 0;
    if (!read_number(layers.substr(begin, end - begin), width)) throw ValueError("network", std::string(text), allowed);
    widths.push_back(width);
    begin = end + 1;
  }
  const Topology topology = widths.size() == 1 ? paper(widths.front()) : Topology(widths);
  return topology.with_activation(leaky ? Activation::leaky_relu : Activation::logistic);
}

Topology Topology::paper(int number) {
  const std::vector<std::vector<int>> papers = {{42, 42, 1},     {42, 84, 1},     {42, 21, 1},
                                                {42, 42, 42, 1}, {42, 42, 82, 1}, {42, 42, 21, 1}};
  if (number < 1 || number > static_cast<int>(papers.size()))
    throw ValueError("network", std::to_string(number), allowed);
  return Topology(papers[static_cast<std::size_t>(number) - 1]);
}

Topology Topology::with_bound() const {
  std::vector<int> widths = widths_;
  widths.back() = heads;
  return Topology(widths, activation_);
}

Topology Topology::with_inputs(int inputs) const {
  std::vector<int> widths = widths_;
  widths.front() = inputs;
  return Topology(widths, activation_);
}

std::size_t Topology::layer_offset(int layer) const {
  std::size_t offset = 0;
  for (int l = 0; l < layer; ++l) offset += static_cast<std::size_t>(fan_out(l)) * (fan_in(l) + 1);
  return offset;
}

std::string Topology::text() const {
  return joined(widths_) + (activation_ == Activation::leaky_relu ? leaky_end : "");
}

}  // namespace tactel::nn
