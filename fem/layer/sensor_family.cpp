// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/sensor_family.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/mesh/block.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem {
namespace {

constexpr double room_beyond = 1.5;  // a patch may be as wide as the sensor, and the certificate looks beyond its ends

void check(const SensorRange& range) {
  if (!(range.poisson_low >= 0 && range.poisson_low <= range.poisson_high && range.poisson_high < 0.5))
    throw ValueError("sensor.poisson", number_text(range.poisson_low) + " to " + number_text(range.poisson_high),
                     "within 0 <= poisson < 0.5");
  if (!(range.longest >= shortest_of_family && range.longest <= longest_sensor))
    throw ValueError("sensor.length", number_text(range.longest) + " thicknesses",
                     "within " + number_text(shortest_of_family) + " to " + number_text(longest_sensor) +
                         " times sensor.thickness where each contact draws its own sensor");
}

/// Weights with which values at the Chebyshev points give the polynomial through them at any place (barycentric).
std::vector<double> polynomial_weights(const std::vector<double>& points, double at) {
  const std::size_t count = points.size();
  std::vector<double> weights(count, 0);
  double sum = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (at == points[k]) {
      std::ranges::fill(weights, 0);
      weights[k] = 1;
      return weights;
    }
    const double angle = std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(count);
    weights[k] = (k % 2 ? -1 : 1) * std::sin(angle) / (at - points[k]);
    sum += weights[k];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

EndModes::Core blend(const std::vector<EndModes::Core>& cores, const std::vector<double>& weights) {
  EndModes::Core sum = EndModes::Core::Zero();
  for (std::size_t k = 0; k < cores.size(); ++k) sum += weights[k] * cores[k];
  return sum;
}

}  // namespace

struct SensorFamily::Tables {
  SensorRange range;
  std::vector<LayerTable> layer;  ///< [poisson rows]
  std::optional<EndModes> ends;
  std::vector<EndModes::Core> compliance, base_stress;  ///< [poisson rows]

  double row_width() const { return (range.poisson_high - range.poisson_low) / static_cast<double>(layer.size() - 1); }
};

namespace {

/// A row of Poisson's ratios and how far the sensor's own lies beyond it, in rows.
struct Between {
  int row;
  double part;
};

Between rows_around(const SensorFamily& family, double poisson) {
  const double place = family.place(poisson);
  const int row = std::min(static_cast<int>(place), family.poisson_rows() - 2);
  return {row, place - row};
}

LayerTable layer_between(const SensorFamily& family, double poisson) {
  const auto [row, part] = rows_around(family, poisson);
  const LayerTable* const rows[] = {&family.table(row), &family.table(row + 1)};
  const double weights[] = {1 - part, part};
  return LayerTable::blend(poisson, rows, weights);
}

/// Both ends of one sensor. Modes: those of the left end, then those of the right.
class BothEnds : public FreeSides::Ends {
 public:
  BothEnds(const SensorFamily& family, const Sensor& sensor)
      : family_(family), length_(sensor.length), thickness_(sensor.thickness) {
    const auto [row, part] = rows_around(family, sensor.poisson);
    compliance = family.compliance(row) + part * (family.compliance(row + 1) - family.compliance(row));
    base_stress = family.base_stress(row) + part * (family.base_stress(row + 1) - family.base_stress(row));
  }

  FreeSides::At at(double x) const override {
    const auto [left, right] = rows(family_.ends().displacement, x);
    FreeSides::At at{FreeSides::Modes(2 * rank), FreeSides::Modes(2 * rank)};
    at.y << left.head<rank>().transpose().array(), right.head<rank>().transpose().array();
    at.x << left.tail<rank>().transpose().array(), -right.tail<rank>().transpose().array();
    return at;
  }

  double between(const FreeSides::Modes& to, const FreeSides::Modes& by) const override {
    double sum = 0;
    for (const int end : {0, rank})
      for (int r = 0; r < rank; ++r)
        for (int q = 0; q < rank; ++q) sum += to[end + r] * compliance(r, q) * by[end + q];
    return sum;
  }

  /// Adds to [4 tactels] of BaseStressTable what both ends change for forces at x.
  void add_stress(double x, const Eigen::VectorXd& tactels, Eigen::RowVectorXd& row) const {
    const auto forces = rows(family_.ends().force, x);
    for (const double sign : {1.0, -1.0}) {
      const Eigen::RowVectorXd& force = sign > 0 ? forces.left : forces.right;
      const Eigen::MatrixXd K = base_stress / thickness_;
      const Eigen::VectorXd by_y = K * force.head(rank).transpose(), by_x = sign * (K * force.tail(rank).transpose());
      for (Eigen::Index k = 0; k < tactels.size(); ++k) {
        const auto ends = rows(family_.ends().stress, tactels[k]);
        const Eigen::RowVectorXd& at = sign > 0 ? ends.left : ends.right;
        const auto put = [&](BaseStressTable::Quantity quantity, double value) {
          row[quantity * tactels.size() + k] += value;
        };
        put(BaseStressTable::sigma_by_pressure, -at.head(rank).dot(by_y));
        put(BaseStressTable::sigma_by_traction, at.head(rank).dot(by_x));
        put(BaseStressTable::tau_by_pressure, -sign * at.tail(rank).dot(by_y));
        put(BaseStressTable::tau_by_traction, sign * at.tail(rank).dot(by_x));
      }
    }
  }

 private:
  static constexpr int rank = EndModes::rank;
  struct Pair {
    Eigen::RowVectorXd left, right;
  };
  Pair rows(const EndModes::Rows& table, double x) const {
    return {EndModes::at(table, (length_ / 2 + x) / thickness_), EndModes::at(table, (length_ / 2 - x) / thickness_)};
  }

  SensorFamily family_;
  double length_, thickness_;
  EndModes::Core compliance, base_stress;
};

/// Stress of the layer at a distance in thicknesses, linear between its cells and between rows of Poisson's ratios.
BaseStress stress_between(const SensorFamily& family, Between poisson, double distance) {
  constexpr int per = SensorFamily::stress_cells_a_thickness;
  const double place = std::min(std::abs(distance) * per, SensorFamily::stress_reach * per);
  const double cell = std::min(std::floor(place), SensorFamily::stress_reach * per - 1), part = place - cell;
  const auto at = [&](int row) {
    const BaseStress from = family.table(row).base(cell / per), to = family.table(row).base((cell + 1) / per);
    return Eigen::Array4d{from.sigma_by_y + part * (to.sigma_by_y - from.sigma_by_y),
                          from.tau_by_x + part * (to.tau_by_x - from.tau_by_x),
                          from.tau_by_y + part * (to.tau_by_y - from.tau_by_y),
                          from.sigma_by_x + part * (to.sigma_by_x - from.sigma_by_x)};
  };
  const Eigen::Array4d low = at(poisson.row), value = low + poisson.part * (at(poisson.row + 1) - low);
  const double sign = distance < 0 ? -1 : 1;
  return {value[0], value[1], sign * value[2], sign * value[3]};
}

/// Places over the width of a tactel, in widths from its middle, and their weights in the mean: Gauss's rule, exact to
/// degree 7.
constexpr double gauss_place[] = {-0.43056815579702629, -0.16999052179242813, 0.16999052179242813, 0.43056815579702629};
constexpr double gauss_weight[] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};

BaseStressTable stress_of(const SensorFamily& family, const Sensor& sensor,
                          const std::shared_ptr<const BothEnds>& ends) {
  const Eigen::VectorXd tactels = tactel_positions(sensor);
  const Between poisson = rows_around(family, sensor.poisson);
  const double h = sensor.thickness;
  const auto at_points = [=](double x, const Eigen::VectorXd& points) {
    const Eigen::Index count = points.size();
    Eigen::RowVectorXd row(BaseStressTable::quantities * count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const BaseStress s = stress_between(family, poisson, (points[k] - x) / h);
      row[BaseStressTable::sigma_by_pressure * count + k] = -s.sigma_by_y / h;
      row[BaseStressTable::sigma_by_traction * count + k] = s.sigma_by_x / h;
      row[BaseStressTable::tau_by_pressure * count + k] = -s.tau_by_y / h;
      row[BaseStressTable::tau_by_traction * count + k] = s.tau_by_x / h;
    }
    if (ends) ends->add_stress(x, points, row);
    return row;
  };
  const double width = sensor.tactel_width;
  if (width == 0) return {sensor.tactels, [=](double x) { return at_points(x, tactels); }};
  return {sensor.tactels, [=](double x) {
            Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(BaseStressTable::quantities * tactels.size());
            for (std::size_t p = 0; p < std::size(gauss_place); ++p)
              mean += gauss_weight[p] * at_points(x, tactels.array() + gauss_place[p] * width);
            return mean;
          }};
}

}  // namespace

std::vector<double> SensorFamily::node_poissons(const SensorRange& range) {
  check(range);
  if (range.poisson_low == range.poisson_high) return {range.poisson_low};
  const double middle = (range.poisson_low + range.poisson_high) / 2,
               half = (range.poisson_high - range.poisson_low) / 2;
  std::vector<double> points;
  points.reserve(nodes);
  for (int k = 0; k < nodes; ++k)
    points.push_back(middle + half * std::cos(std::numbers::pi * (k + 0.5) / static_cast<double>(nodes)));
  return points;
}

FamilyNode SensorFamily::node(const SensorRange& range, double poisson, bool sides,
                              const std::filesystem::path& cache_directory) {
  check(range);
  const double wanted = std::max(room_beyond * range.longest, stress_reach);
  FamilyNode node{LayerTable(poisson, std::min(std::ceil(wanted), LayerTable::default_range)), std::nullopt};
  if (!sides) return node;
  Sensor block;
  block.thickness = 1;
  block.length = 2 * EndModes::reach;
  block.poisson = poisson;
  node.sides = side_difference(side_block(block), cache_directory);
  return node;
}

SensorFamily::SensorFamily(const SensorRange& range, const std::vector<FamilyNode>& made) {
  const std::vector<double> points = node_poissons(range);
  auto tables = std::make_shared<Tables>();
  tables->range = range;
  const double width = range.poisson_high - range.poisson_low;
  const int rows = 1 + std::max(1, static_cast<int>(std::ceil(width / widest_poisson_cell)));
  if (made.front().sides) {
    std::vector<SideDifference> differences;
    differences.reserve(made.size());
    for (const FamilyNode& node : made) differences.push_back(*node.sides);
    tables->ends.emplace(differences);
  }
  std::vector<const LayerTable*> layers;
  layers.reserve(made.size());
  for (const FamilyNode& node : made) layers.push_back(&node.table);
  for (int row = 0; row < rows; ++row) {
    const double poisson = range.poisson_low + width * row / (rows - 1);
    const std::vector<double> weights = polynomial_weights(points, points.size() == 1 ? points[0] : poisson);
    tables->layer.push_back(LayerTable::blend(poisson, layers, weights));
    if (!tables->ends) continue;
    tables->compliance.push_back(blend(tables->ends->compliance, weights));
    tables->base_stress.push_back(blend(tables->ends->base_stress, weights));
  }
  tables_ = std::move(tables);
}

namespace {

std::vector<FamilyNode> all_nodes(const SensorRange& range, bool sides) {
  std::vector<FamilyNode> made;
  for (const double poisson : SensorFamily::node_poissons(range))
    made.push_back(SensorFamily::node(range, poisson, sides));
  return made;
}

}  // namespace

SensorFamily::SensorFamily(const SensorRange& range, bool sides) : SensorFamily(range, all_nodes(range, sides)) {}

const SensorRange& SensorFamily::range() const { return tables_->range; }
bool SensorFamily::sides() const { return tables_->ends.has_value(); }
int SensorFamily::poisson_rows() const { return static_cast<int>(tables_->layer.size()); }
const LayerTable& SensorFamily::table(int row) const { return tables_->layer[static_cast<std::size_t>(row)]; }
const EndModes& SensorFamily::ends() const { return *tables_->ends; }

const EndModes::Core& SensorFamily::compliance(int row) const {
  return tables_->compliance[static_cast<std::size_t>(row)];
}

const EndModes::Core& SensorFamily::base_stress(int row) const {
  return tables_->base_stress[static_cast<std::size_t>(row)];
}

double SensorFamily::place(double poisson) const {
  const SensorRange& range = tables_->range;
  if (range.poisson_low == range.poisson_high) return 0;
  return (poisson - range.poisson_low) / tables_->row_width();
}

void SensorFamily::require(const Sensor& sensor) const {
  validate(sensor);
  if (!sensor.layers.empty())
    throw ValueError("sensor.layers", std::to_string(sensor.layers.size()) + " layers",
                     "left out where each contact draws its own sensor");
  const SensorRange& r = range();
  constexpr double rounding = 1e-12;
  if (!(sensor.poisson >= r.poisson_low && sensor.poisson <= r.poisson_high))
    throw ValueError("sensor.poisson", number_text(sensor.poisson),
                     number_text(r.poisson_low) + " to " + number_text(r.poisson_high) + ", as the family's tables");
  const double ratio = sensor.length / sensor.thickness;
  if (!(ratio >= shortest_of_family * (1 - rounding) && ratio <= r.longest * (1 + rounding)))
    throw ValueError("sensor.length", number_text(sensor.length),
                     number_text(shortest_of_family) + " to " + number_text(r.longest) + " times sensor.thickness");
  if (sensor.tactel_width != 0)
    throw ValueError("sensor.tactel_width", number_text(sensor.tactel_width),
                     "0 where each contact draws its own sensor; [sweep] sensors = n draws n sensors instead");
  if (sensor.tactels != r.tactels)
    throw ValueError("sensor.tactels", std::to_string(sensor.tactels), std::to_string(r.tactels) + ", as the others");
}

LayerModel SensorFamily::model(const Sensor& sensor) const {
  validate(sensor);
  Sensor points = sensor;
  points.tactel_span = sensor.span();
  points.tactel_width = 0;
  require(points);
  std::shared_ptr<const BothEnds> ends;
  if (sides()) ends = std::make_shared<const BothEnds>(*this, sensor);
  return {ends ? FreeSides(ends) : FreeSides(), layer_between(*this, sensor.poisson), stress_of(*this, sensor, ends),
          sensor};
}

}  // namespace tactel::fem
