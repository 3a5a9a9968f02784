// SPDX-License-Identifier: Apache-2.0
#include "fem/scenes/rubber.h"

#include <tactel/pad_scene.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"
#include "fem/scenes/sensor.h"

namespace tactel::fem {
namespace {

double sum_of(const std::vector<RubberLayer>& layers) {
  double sum = 0;
  for (const RubberLayer& layer : layers) sum += layer.thickness;
  return sum;
}

/// Puts tactels at a height over the thickness, below 1: between two layers, of which one may be a part of another.
void put_tactels(Rubber& rubber, double height) {
  constexpr double least = 1e-9;
  if (height <= least) return;
  if (rubber.layers.empty()) rubber.layers = {{1, 1, rubber.poisson}};
  double from = 0;
  for (auto layer = rubber.layers.begin(); height > from + least; ++layer, ++rubber.below) {
    const double to = from + layer->thickness;
    if (height < to - least) {
      RubberLayer lower = *layer;
      lower.thickness = height - from, layer->thickness = to - height;
      layer = rubber.layers.insert(layer, lower);
    }
    from += layer->thickness;
  }
}

}  // namespace

Rubber rubber(const std::vector<RubberLayer>& layers, double thickness, double young, double poisson) {
  Rubber all{poisson};
  for (const RubberLayer& layer : layers) {
    RubberLayer* below = all.layers.empty() ? nullptr : &all.layers.back();
    const RubberLayer scaled{layer.thickness / thickness, layer.young / young, layer.poisson};
    if (below != nullptr && below->young == scaled.young && below->poisson == scaled.poisson)
      below->thickness += scaled.thickness;
    else
      all.layers.push_back(scaled);
  }
  if (all.layers.size() == 1) all.layers.clear();
  return all;
}

Rubber rubber(const Sensor& line) { return rubber(line.layers, line.thickness, line.young, line.poisson); }

Rubber rubber(const Pad& pad) {
  Rubber all = rubber(pad.layers, pad.thickness, pad.young, pad.poisson);
  put_tactels(all, pad.depth / pad.thickness);
  return all;
}

double height_above(std::span<const RubberLayer> layers, int below) {
  double all = 0, above = 0;
  for (const RubberLayer& layer : layers) all += layer.thickness, above += below > 0 ? 0 : layer.thickness, --below;
  return above / all;
}

void check_layers(const std::vector<RubberLayer>& layers, double thickness, double young, double poisson) {
  if (layers.empty()) return;
  constexpr std::size_t most_layers = 8;
  constexpr double thinnest = 0.002, largest_ratio = 1e4;
  require(layers.size() <= most_layers, "sensor.layers", static_cast<double>(layers.size()), "8 layers at most");
  const double sum = sum_of(layers), softest = std::ranges::min(layers, {}, &RubberLayer::young).young;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const auto& [t, E, nu] = layers[k];
    const std::string place = "sensor.layers[" + std::to_string(k) + "].";
    require(t >= 1e-6 && t <= 1e6, place + "thickness", t, "a length in mm, between 1e-6 and 1e6");
    require(t >= thinnest * sum, place + "thickness", t, "0.002 of the sum of all or more");
    require(E >= 1e-9 && E <= 1e12, place + "young", E, "a Young's modulus in MPa, 1e-9 to 1e12");
    require(E <= largest_ratio * softest, place + "young", E, "1e4 times that of the softest layer or less");
    require(nu >= 0 && nu <= 0.5, place + "poisson", nu, "a Poisson's ratio, 0 <= poisson <= 0.5");
  }
  for (const auto& [member, number, given] :
       {std::tuple{"sensor.thickness", thickness, sum}, std::tuple{"sensor.young", young, layers.back().young},
        std::tuple{"sensor.poisson", poisson, layers.back().poisson}})
    require(number == given, member, number, "left out beside sensor.layers");
}

double shear_length(const std::vector<RubberLayer>& layers) {
  double longest = 0, below = 0;
  for (std::size_t k = 0; k + 1 < layers.size(); ++k) {
    below += 2 * (1 + layers[k].poisson) * layers[k].thickness / layers[k].young;
    double above = 0;
    for (std::size_t upper = k + 1; upper < layers.size(); ++upper)
      above += layers[upper].young * layers[upper].thickness / (1 - std::pow(layers[upper].poisson, 2));
    longest = std::max(longest, above * below);
  }
  return layers.empty() ? 0 : std::sqrt(longest) / sum_of(layers);
}

double soft_thickness(const std::vector<RubberLayer>& layers) {
  constexpr double least = 0.1;
  if (layers.empty()) return 1;
  double soft = 0;
  for (const RubberLayer& layer : layers)
    soft += layer.thickness *
            std::min(1.0, layers.back().young * (1 + layer.poisson) / (layer.young * (1 + layers.back().poisson)));
  return std::max(soft / sum_of(layers), least);
}

}  // namespace tactel::fem
