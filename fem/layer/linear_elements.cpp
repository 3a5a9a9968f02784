// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/linear_elements.h"

#include <algorithm>
#include <cmath>

#include "fem/scenes/rubber.h"

namespace tactel::fem {
namespace {

constexpr double widest_part = 0.25;  ///< of the thickness: parts of an element, on which the pressure is constant

struct Parts {
  UnequalElements strips;
  Eigen::MatrixXd force;  ///< [strips][elements]: of a unit force on each element
};

Parts parts_of(const UnequalElements& elements, double thickness) {
  const Eigen::Index n = elements.middle.size();
  std::vector<double> middle, width;
  for (Eigen::Index k = 0; k < n; ++k) {
    const int parts = std::max(2, static_cast<int>(std::ceil(elements.width[k] / (widest_part * thickness))));
    for (int part = 0; part < parts; ++part) {
      width.push_back(elements.width[k] / parts);
      middle.push_back(elements.middle[k] + ((part + 0.5) / parts - 0.5) * elements.width[k]);
    }
  }
  const auto strips = static_cast<Eigen::Index>(middle.size());
  Parts result{{Eigen::Map<Eigen::VectorXd>(middle.data(), strips), Eigen::Map<Eigen::VectorXd>(width.data(), strips)},
               Eigen::MatrixXd::Zero(strips, n)};
  for (Eigen::Index i = 0, k = 0; i < strips; ++i) {
    while (k + 2 < n && middle[i] > elements.middle[k + 1]) ++k;  // between the middles of elements k and k + 1
    const double from = elements.middle[k], to = elements.middle[k + 1];
    const double share = std::clamp((middle[i] - from) / (to - from), 0.0, 1.0);
    result.force(i, k) = (1 - share) * width[i];
    result.force(i, k + 1) = share * width[i];
  }
  for (Eigen::Index k = 0; k < n; ++k) result.force.col(k) /= result.force.col(k).sum();
  return result;
}

}  // namespace

bool needs_linear_pressure(const Sensor& sensor, double width) {
  const double thickness = soft_thickness(sensor.layers) * sensor.thickness;
  return largest_poisson(sensor) > hardly_compressible && width > widest_constant_element * thickness;
}

Condensation linear_condensation(const LayerModel& model, const UnequalElements& elements) {
  const Eigen::Index n = elements.middle.size();
  const Parts parts = parts_of(elements, soft_thickness(model.sensor.layers) * model.sensor.thickness);
  const Condensation strips = elements_condensation(model, parts.strips);
  Eigen::MatrixXd force = Eigen::MatrixXd::Zero(strips.compliance.rows(), 2 * n);
  for (Eigen::Index k = 0; k < n; ++k)
    for (Eigen::Index i = 0; i < parts.force.rows(); ++i)
      force(2 * i, 2 * k) = force(2 * i + 1, 2 * k + 1) = parts.force(i, k);
  Condensation result = strips;
  result.surface_x = elements.middle;
  result.compliance = force.transpose() * strips.compliance * force;
  result.base_force = strips.base_force * force;
  result.tactel_stress = strips.tactel_stress * force;
  return result;
}

}  // namespace tactel::fem
