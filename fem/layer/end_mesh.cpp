// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/end_mesh.h"

#include <algorithm>
#include <vector>

#include "fem/layer/patch_compliance.h"
#include "fem/layer/side_difference.h"
#include "fem/mesh/clamped_block.h"

namespace tactel::fem {
namespace {

constexpr double widening = 1.2, widest = 1.0 / 12;  ///< of a column over its neighbour's and over the thickness

/// Places from the end of the contact to an end of the sensor, `length` away, without the first.
std::vector<double> widening_columns(double first_width, double length, double thickness) {
  std::vector<double> places;
  if (length < 1e-9 * thickness) return places;
  double place = 0, width = first_width;
  while (place < length) {
    width = std::min(widening * width, std::max(first_width, widest * thickness));
    places.push_back(place += width);
  }
  for (double& x : places) x *= length / place;
  return places;
}

Mesh graded_mesh(const Sensor& sensor, const Eigen::VectorXd& x) {
  Mesh mesh = make_mesh(sensor);
  for (Eigen::Index node = 0; node < mesh.node.cols(); ++node) mesh.node(0, node) = x[node % x.size()];
  return mesh;
}

}  // namespace

bool near_end(const Sensor& sensor, Interval contact) {
  const double inner = sensor.length / 2 - corner_reach * sensor.thickness;
  return contact.left < -inner || contact.right > inner;
}

Eigen::VectorXd graded_columns(const Sensor& sensor, const Eigen::VectorXd& nodes) {
  const Eigen::Index n = nodes.size();
  const double half = sensor.length / 2, left = nodes[0], right = nodes[n - 1];
  const std::vector<double> before = widening_columns(nodes[1] - left, left + half, sensor.thickness),
                            after = widening_columns(right - nodes[n - 2], half - right, sensor.thickness);
  std::vector<double> x;
  for (auto place = before.rbegin(); place != before.rend(); ++place) x.push_back(left - *place);
  x.insert(x.end(), nodes.begin(), nodes.end());
  for (const double place : after) x.push_back(right + place);
  return Eigen::Map<Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
}

Condensation end_condensation(const LayerModel& model, const Eigen::VectorXd& nodes) {
  const Eigen::VectorXd x = graded_columns(model.sensor, nodes);
  Sensor sensor = with_unit_young(model.sensor, most_poisson_of_block);
  sensor.columns = static_cast<int>(x.size()), sensor.rows = 33, sensor.grading = 64;
  sensor.element = Element::bbar;
  const ClampedBlock block(graded_mesh(sensor, x), sensor);
  const auto first = std::find(x.begin(), x.end(), nodes[0]) - x.begin();
  const std::vector<int>& surface = block.mesh().surface;
  const std::vector<int> loaded = unknowns_of({surface.begin() + first, surface.begin() + first + nodes.size()});
  Condensation result = without_compliance(model, nodes);
  constexpr Eigen::Index width = ClampedBlock::loads_at_a_time;
  for (Eigen::Index from = 0; from < result.compliance.cols(); from += width) {
    const Eigen::Index count = std::min(width, result.compliance.cols() - from);
    Eigen::MatrixXd load = Eigen::MatrixXd::Zero(2 * block.mesh().node.cols(), count);
    for (Eigen::Index j = 0; j < count; ++j) load(loaded[static_cast<std::size_t>(from + j)], j) = 1;
    result.compliance.middleCols(from, count) = block.displacement(load)(loaded, Eigen::all);
  }
  result.compliance = (result.compliance + result.compliance.transpose()).eval() / 2;
  return result;
}

}  // namespace tactel::fem
