// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/layer_derivatives.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "fem/block.h"
#include "fem/layer/element_compliance.h"
#include "fem/layer/patch_compliance.h"
#include "fem/layer/side_difference.h"

namespace tactel::fem {
namespace {

using Eigen::Index;

/// [2 elements, 2 elements] of equal elements on a layer, in the layout of Condensation.
Eigen::MatrixXd toeplitz(const ElementCompliance& c) {
  const Index n = c.yy.size();
  Eigen::MatrixXd matrix(2 * n, 2 * n);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i) {
      const Index k = std::abs(i - j);
      const double coupling = i < j ? -c.xy[k] : c.xy[k];
      matrix.block<2, 2>(2 * i, 2 * j) << c.xx[k], coupling, -coupling, c.yy[k];
    }
  return matrix;
}

/// d/dnu of element_compliance: c = factor(nu) (singular part + difference of R over the width).
ElementCompliance compliance_by_poisson(const LayerTable& table, const LayerTable& by_poisson, double thickness,
                                        double width, int elements) {
  const double nu = table.poisson(), d = width / thickness;
  const double cy = layer_cy(nu), cx = layer_cx(nu), cy_change = -4 * nu / std::numbers::pi,
               cx_change = 1 / std::numbers::pi;
  ElementCompliance c = element_compliance(table, thickness, width, elements);
  for (int k = 0; k < elements; ++k) {
    const SmoothParts right = by_poisson.smooth_integral((k + 0.5) * d),
                      left = by_poisson.smooth_integral((k - 0.5) * d);
    c.yy[k] = cy_change / cy * c.yy[k] + cy * (right.yy - left.yy) / d;
    c.xx[k] = cy_change / cy * c.xx[k] + cy * (right.xx - left.xx) / d;
    if (k > 0) c.xy[k] = cx_change / cx * c.xy[k] + cx * (-std::numbers::pi + (right.xy - left.xy) / d);
  }
  return c;
}

/// d/d(width / h) of element_compliance.
ElementCompliance compliance_by_width(const LayerTable& table, double thickness, double width, int elements) {
  const double nu = table.poisson(), d = width / thickness, cy = layer_cy(nu), cx = layer_cx(nu);
  ElementCompliance c{Eigen::VectorXd(elements), Eigen::VectorXd(elements), Eigen::VectorXd::Zero(elements)};
  for (int k = 0; k < elements; ++k) {
    const double b = k + 0.5, a = k - 0.5;
    const SmoothParts right = table.smooth_integral(b * d), left = table.smooth_integral(a * d);
    const SmoothParts to = table.smooth(b * d), from = table.smooth(a * d);
    const auto mean = [&](double SmoothParts::*part) {
      return (b * to.*part - a * from.*part) / d - (right.*part - left.*part) / (d * d);
    };
    c.yy[k] = cy * (-1 / d + mean(&SmoothParts::yy));
    c.xx[k] = cy * (-1 / d + mean(&SmoothParts::xx));
    if (k > 0) c.xy[k] = cx * mean(&SmoothParts::xy);
  }
  return c;
}

/// d/dh of BaseStress at `distance` mm from a force, 1/mm^2; of its mean over `width` mm.
BaseStress stress_by_thickness(const LayerTable& table, double distance, double width, double h) {
  const auto combine = [](const BaseStress& s, double fs, const BaseStress& t, double ft) {
    return BaseStress{fs * s.sigma_by_y + ft * t.sigma_by_y, fs * s.tau_by_x + ft * t.tau_by_x,
                      fs * s.tau_by_y + ft * t.tau_by_y, fs * s.sigma_by_x + ft * t.sigma_by_x};
  };
  if (width == 0)
    return combine(table.base(distance / h), -1 / (h * h), table.base_slope(distance / h), -distance / (h * h * h));
  // The mean is the integral between the ends over the width: its ends alone move with h.
  const double to = (distance + width / 2) / h, from = (distance - width / 2) / h;
  return combine(table.base(to), -to / (h * width), table.base(from), from / (h * width));
}

/// A table of the rows that a sensor has, all 0.
BaseStressTable empty_table(const Sensor& sensor) {
  return {sensor,
          BaseStressTable::Rows::Zero(BaseStressTable::places(sensor), BaseStressTable::quantities * sensor.tactels)};
}

/// Stress at the tactels of the layer, by the thickness.
BaseStressTable layer_stress_by_thickness(const Sensor& sensor, const LayerTable& table) {
  const Eigen::VectorXd tactel = tactel_positions(sensor);
  BaseStressTable result = empty_table(sensor);
  result.add([&](double x) {
    Eigen::RowVectorXd row(BaseStressTable::quantities * tactel.size());
    for (Index k = 0; k < tactel.size(); ++k) {
      const BaseStress s = stress_by_thickness(table, tactel[k] - x, sensor.tactel_width, sensor.thickness);
      row[BaseStressTable::sigma_by_pressure * tactel.size() + k] = -s.sigma_by_y;
      row[BaseStressTable::sigma_by_traction * tactel.size() + k] = s.sigma_by_x;
      row[BaseStressTable::tau_by_pressure * tactel.size() + k] = -s.tau_by_y;
      row[BaseStressTable::tau_by_traction * tactel.size() + k] = s.tau_by_x;
    }
    return row;
  });
  return result;
}

/// [2 tactels, 2 elements]: columns of tactel_stress from rows [4 tactels] at the elements' middles.
template <class Row>
Eigen::MatrixXd tactel_stress(const Patch& patch, Index tactels, const Row& row_at) {
  Eigen::MatrixXd stress(2 * tactels, 2 * patch.elements);
  for (int j = 0; j < patch.elements; ++j) {
    const Eigen::RowVectorXd row = row_at(patch.place(j));
    const auto part = [&](BaseStressTable::Quantity q) { return row.segment(q * tactels, tactels).transpose(); };
    stress.col(2 * j) << part(BaseStressTable::sigma_by_traction), part(BaseStressTable::tau_by_traction);
    stress.col(2 * j + 1) << -part(BaseStressTable::sigma_by_pressure), -part(BaseStressTable::tau_by_pressure);
  }
  return stress;
}

/// [2 elements, 2 elements] that the sides add for elements at these places, mm.
Eigen::MatrixXd sides_compliance(const FreeSides& sides, const Eigen::VectorXd& places) {
  const Index n = places.size();
  std::vector<FreeSides::At> modes;
  for (const double x : places) modes.push_back(sides.at(x));
  Eigen::MatrixXd c(2 * n, 2 * n);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i) {
      const FreeSides::At &at = modes[static_cast<std::size_t>(i)], &by = modes[static_cast<std::size_t>(j)];
      c.block<2, 2>(2 * i, 2 * j) << sides.between(at.x, by.x), sides.between(at.x, by.y), sides.between(at.y, by.x),
          sides.between(at.y, by.y);
    }
  return c;
}

}  // namespace

bool LayerDerivatives::has_poisson(const LayerModel& model) {
  const double nu = model.sensor.poisson;
  return nu >= poisson_step && nu + poisson_step <= most_poisson_of_block;
}

LayerDerivatives::LayerDerivatives(const LayerModel& model, const std::filesystem::path& cache_directory)
    : model_(model), cache_directory_(cache_directory) {
  if (model.base.rows().size() == 0) throw std::invalid_argument("LayerDerivatives: a model of a SensorFamily");
}

LayerDerivatives::Neighbours LayerDerivatives::neighbours(const Sensor& block_plus, const Sensor& block_minus,
                                                          double distance) const {
  const auto stress_of = [&](const SideDifference& difference) {
    BaseStressTable table = empty_table(model_.sensor);
    add_free_sides(difference, model_.sensor, table);
    return table;
  };
  const SideDifference plus = side_difference(block_plus, cache_directory_),
                       minus = side_difference(block_minus, cache_directory_);
  return {FreeSides(plus, model_.sensor.length), FreeSides(minus, model_.sensor.length), stress_of(plus),
          stress_of(minus), distance};
}

void LayerDerivatives::add_sides(const Neighbours& beside, const Patch& patch, RubberChange& change) const {
  const Eigen::VectorXd x = places(patch);
  change.compliance += (sides_compliance(beside.plus, x) - sides_compliance(beside.minus, x)) / beside.distance;
  change.tactel_stress += tactel_stress(patch, model_.base.tactels(), [&](double at) -> Eigen::RowVectorXd {
    return (beside.stress_plus.at(at) - beside.stress_minus.at(at)) / beside.distance;
  });
}

RubberChange LayerDerivatives::by_poisson(const Patch& patch) {
  const Sensor& sensor = model_.sensor;
  if (!table_by_poisson_) {
    table_by_poisson_ = LayerTable::by_poisson(sensor.poisson);
    stress_by_poisson_.emplace(sensor, *table_by_poisson_);
  }
  RubberChange change{toeplitz(compliance_by_poisson(model_.table, *table_by_poisson_, sensor.thickness, patch.width(),
                                                     patch.elements)),
                      tactel_stress(patch, sensor.tactels, [&](double x) { return stress_by_poisson_->at(x); })};
  if (model_.sides.endless()) return change;
  if (!by_poisson_) {
    Sensor plus = side_block(sensor), minus = plus;
    plus.poisson = sensor.poisson + poisson_step;
    minus.poisson = sensor.poisson - poisson_step;
    by_poisson_.emplace(neighbours(plus, minus, 2 * poisson_step));
  }
  add_sides(*by_poisson_, patch, change);
  return change;
}

RubberChange LayerDerivatives::by_thickness(const Patch& patch) {
  const Sensor& sensor = model_.sensor;
  const double h = sensor.thickness;
  if (!stress_by_thickness_) stress_by_thickness_.emplace(layer_stress_by_thickness(sensor, model_.table));
  RubberChange change{
      -patch.width() / (h * h) * toeplitz(compliance_by_width(model_.table, h, patch.width(), patch.elements)),
      tactel_stress(patch, sensor.tactels, [&](double x) { return stress_by_thickness_->at(x); })};
  if (model_.sides.endless()) return change;
  if (!by_thickness_) {
    const Sensor block = side_block(sensor);
    const double step = thickness_step * h;
    const auto of = [&](double thickness) {
      Sensor changed = block;  // the same columns, so that the mesh's own error changes smoothly
      changed.thickness = thickness;
      if (block.length < sensor.length) changed.length *= thickness / h;
      return changed;
    };
    by_thickness_.emplace(neighbours(of(h + step), of(h - step), 2 * step));
  }
  add_sides(*by_thickness_, patch, change);
  return change;
}

RubberChange LayerDerivatives::by_ends(const Patch& patch, double left, double right) const {
  constexpr double step = 1e-6;  // mm: tables are linear over it, but for their rows
  const double h = model_.sensor.thickness;
  RubberChange change{Eigen::MatrixXd::Zero(2 * patch.elements, 2 * patch.elements), {}};
  if (left != right)
    change.compliance += (right - left) / (patch.elements * h) *
                         toeplitz(compliance_by_width(model_.table, h, patch.width(), patch.elements));
  const auto moved = [&](double by) {
    Patch result = patch;
    result.left += by * left;
    result.right += by * right;
    return result;
  };
  const Patch plus = moved(step), minus = moved(-step);
  const auto stress = [&](const Patch& at) {
    return tactel_stress(at, model_.base.tactels(), [&](double x) { return model_.base.at(x); });
  };
  change.tactel_stress = (stress(plus) - stress(minus)) / (2 * step);
  if (!model_.sides.endless())
    change.compliance +=
        (sides_compliance(model_.sides, places(plus)) - sides_compliance(model_.sides, places(minus))) / (2 * step);
  return change;
}

}  // namespace tactel::fem
