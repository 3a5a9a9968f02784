// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_contact_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "fem/layer/legendre_points.h"
#include "fem/pad/layer_means.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_solver.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

/// Tables that are kept: scenes of a sensor meet some 160 of the ladder, and some 400 around sizes between its rungs.
/// One has 30 kB at 24 cells.
constexpr std::size_t most_kept_numbers = std::size_t{1} << 22;

constexpr int marker_farthest = 12;  ///< H: beyond, displacements are below 1e-4 of those beneath a force

/// To 1e-12; finer where a side is so small that a rounded rung would no longer lie on its rung.
double rounded_side(double side, double thickness) {
  const double unit = std::ldexp(1e-12, std::min(0, std::ilogb(side / thickness) + 7));
  return unit * std::round(side / (unit * thickness));
}

/// A side of a cell on a ladder of sizes with twice the rungs of that of cells: on a rung, or between the rungs first +
/// 1 and first + 2, with the weights of Lagrange's cubic in the logarithm.
struct OnLadder {
  explicit OnLadder(double side) {
    const double rung = steps_an_octave * std::log2(side), nearest = std::round(rung), q = rung - std::floor(rung);
    if (std::abs(rung - nearest) <= 1e-9) {
      first = static_cast<int>(nearest), weights = {1};
    } else {
      first = static_cast<int>(std::floor(rung)) - 1;
      weights = {-q * (q - 1) * (q - 2) / 6, (q + 1) * (q - 1) * (q - 2) / 2, -(q + 1) * q * (q - 2) / 2,
                 (q + 1) * q * (q - 1) / 6};
    }
  }
  bool on_a_rung() const { return weights.size() == 1; }
  /// Of the rung of weight k.
  double side(std::size_t k) const {
    return rounded_side(std::exp2((first + static_cast<double>(k)) / steps_an_octave), 1);
  }

  static constexpr int steps_an_octave = 2 * fem::rungs_an_octave;
  int first;
  std::vector<double> weights;
};

/// Units of the numbers of an entry.
std::array<double, PAD_OWN_INFLUENCE> units(double root_zz, double root_tt) {
  std::array<double, PAD_OWN_INFLUENCE> units{};
  units[PAD_ZZ] = root_zz * root_zz;
  units[PAD_XX] = units[PAD_YY] = units[PAD_XY] = root_tt * root_tt;
  units[PAD_XZ] = units[PAD_YZ] = root_zz * root_tt;
  return units;
}

/// The table of cells of this size that do this to each other.
PadNumbers table_of(const std::vector<fem::CellInfluence>& all, const PadCellSize& size) {
  const fem::CellInfluence& own = all.front();
  const double zz = std::sqrt(own.zz), tt = std::sqrt(std::max(own.xx, own.yy));
  const auto unit = units(zz, tt);
  std::vector<double> table(PAD_TABLE_HEAD + all.size() * PAD_OWN_INFLUENCE);
  table[PAD_ROOT_ZZ] = zz, table[PAD_ROOT_TT] = tt, table[PAD_HX] = size.hx, table[PAD_HY] = size.hy;
  double* row = &table[PAD_TABLE_HEAD];
  for (const fem::CellInfluence& c : all) {
    row[PAD_ZZ] = c.zz, row[PAD_XX] = c.xx, row[PAD_YY] = c.yy, row[PAD_XY] = c.xy;
    row[PAD_XZ] = c.xz, row[PAD_YZ] = c.yz;
    for (int k = 0; k < PAD_OWN_INFLUENCE; ++k) row[k] /= unit[k];
    row += PAD_OWN_INFLUENCE;
  }
  return std::make_shared<const std::vector<double>>(std::move(table));
}

/// The table of cells with x and y exchanged, [side][side] offsets.
PadNumbers turned(const std::vector<double>& of, int side) {
  std::vector<double> table = of;
  std::swap(table[PAD_HX], table[PAD_HY]);
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double* from = &of[PAD_TABLE_HEAD + static_cast<std::size_t>(j * side + i) * PAD_OWN_INFLUENCE];
      double* to = &table[PAD_TABLE_HEAD + static_cast<std::size_t>(i * side + j) * PAD_OWN_INFLUENCE];
      std::copy_n(from, PAD_OWN_INFLUENCE, to);
      std::swap(to[PAD_XX], to[PAD_YY]), std::swap(to[PAD_XZ], to[PAD_YZ]);
    }
  return std::make_shared<const std::vector<double>>(std::move(table));
}

/// A table, and its weight.
using Weighted = std::pair<double, PadNumbers>;

/// The sum of tables, as that of cells of this size.
PadNumbers sum(const std::vector<Weighted>& tables, const PadCellSize& size) {
  std::vector<double> table(tables.front().second->size());
  const auto each = [&](const auto& change) {
    for (std::size_t at = PAD_TABLE_HEAD; at < table.size(); at += PAD_OWN_INFLUENCE)
      for (int k = 0; k < PAD_OWN_INFLUENCE; ++k) change(at + k, k);
  };
  for (const auto& [weight, other] : tables) {
    const double* from = other->data();
    auto part = units(from[PAD_ROOT_ZZ], from[PAD_ROOT_TT]);
    for (double& number : part) number *= weight;
    each([&](std::size_t at, int k) { table[at] += part[k] * from[at]; });
  }
  const double* own = &table[PAD_TABLE_HEAD];
  const double zz = std::sqrt(own[PAD_ZZ]), tt = std::sqrt(std::max(own[PAD_XX], own[PAD_YY]));
  table[PAD_ROOT_ZZ] = zz, table[PAD_ROOT_TT] = tt, table[PAD_HX] = size.hx, table[PAD_HY] = size.hy;
  auto per = units(zz, tt);
  for (double& number : per) number = 1 / number;
  each([&](std::size_t at, int k) { table[at] *= per[k]; });
  return std::make_shared<const std::vector<double>>(std::move(table));
}

/// Quadratics of five functions of rho, which are 0 from the last row on.
template <class Functions>
std::vector<double> quadratics(int rows, int rows_a_thickness, const Functions& at) {
  using Values = Eigen::Array<double, 5, 1>;
  std::vector<double> table(static_cast<std::size_t>(rows) * PAD_BLOCK);
  const double step = 1.0 / rows_a_thickness;
  for (int row = 0; row + 1 < rows; ++row) {
    const Values left = at(row * step), middle = at((row + 0.5) * step), right = at((row + 1) * step);
    for (int f = 0; f < 5; ++f) {
      double* c =
          &table[static_cast<std::size_t>(row) * PAD_BLOCK + static_cast<std::size_t>(f) * PAD_STRESS_COEFFICIENTS];
      c[0] = left[f], c[2] = 2 * (left[f] - 2 * middle[f] + right[f]), c[1] = right[f] - left[f] - c[2];
    }
  }
  return table;
}

}  // namespace

PadCellSize cell_size(const fem::PadCells& cells, double thickness) {
  return {rounded_side(cells.hx, thickness), rounded_side(cells.hy, thickness)};
}

int PadTables::stress_rows_of(const fem::PadLayer& layer) {
  return static_cast<int>((12 * stress_rows_at(layer.deep()) + 1) * layer.reach() / fem::PadLayer::range);
}

int PadTables::stress_rows_at(double deep) {
  return static_cast<int>(std::ceil(stress_rows_a_thickness / deep - 1e-9));
}

PadTables::PadTables(const fem::Rubber& rubber, int cells, bool exact, bool means)
    : rubber_(rubber),
      cells_(cells),
      exact_(exact),
      means_(means),
      layer_(std::make_shared<const fem::PadLayer>(fem::pad_layer(rubber))),
      stress_(quadratics(stress_rows_of(*layer_), stress_rows_at(layer_->deep()),
                         [this](double rho) { return layer_->stresses(rho); })) {}

PadTables::PadTables(double poisson, std::vector<std::shared_ptr<const PadTables>> points)
    : rubber_{poisson}, cells_(points.front()->cells_), exact_(points.front()->exact_), points_(std::move(points)) {}

std::vector<double> PadTables::stress() const {
  if (points_.empty()) return stress_;
  const std::vector<double> shares = fem::poisson_shares(rubber_.poisson);
  std::vector<double> all(points_.front()->stress_.size());
  for (std::size_t p = 0; p < points_.size(); ++p)
    for (std::size_t k = 0; k < all.size(); ++k) all[k] += shares[p] * points_[p]->stress_[k];
  return all;
}

PadNumbers PadTables::make_influence(const fem::PadLayer& layer, const PadCellSize& size) const {
  return table_of(
      means_ ? fem::layer_means(layer, 1, size.hx, size.hy, cells_) : layer.influences(1, size.hx, size.hy, cells_),
      size);
}

PadNumbers PadTables::influence(const PadCellSize& size, const fem::SoftObject& object) const {
  if (!(object.softness > 0)) return of_layer(size);
  if (means_) return make_influence(layer_->beside(object), size);
  std::vector<fem::CellInfluence> all = object.influences(1, size.hx, size.hy, cells_);
  const PadNumbers layer = of_layer(size);
  const auto unit = units((*layer)[PAD_ROOT_ZZ], (*layer)[PAD_ROOT_TT]);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const double* row = &(*layer)[PAD_TABLE_HEAD + k * PAD_OWN_INFLUENCE];
    const auto number = [&](int which) { return row[which] * unit[static_cast<std::size_t>(which)]; };
    all[k] += {number(PAD_ZZ), number(PAD_XX), number(PAD_YY), number(PAD_XY), number(PAD_XZ), number(PAD_YZ)};
  }
  return table_of(all, size);
}

PadNumbers PadTables::of_layer(const PadCellSize& size) const {
  std::vector<Weighted> tables;
  if (!points_.empty()) {
    const std::vector<double> shares = fem::poisson_shares(rubber_.poisson);
    for (std::size_t p = 0; p < points_.size(); ++p) tables.emplace_back(shares[p], points_[p]->of_layer(size));
    return sum(tables, size);
  }
  const OnLadder x(size.hx), y(size.hy);
  if (x.on_a_rung() && y.on_a_rung()) return on_rungs(size);
  if (exact_) return make_influence(*layer_, size);
  for (std::size_t i = 0; i < x.weights.size(); ++i)
    for (std::size_t j = 0; j < y.weights.size(); ++j)
      tables.emplace_back(x.weights[i] * y.weights[j], on_rungs({x.side(i), y.side(j)}));
  return sum(tables, size);
}

PadNumbers PadTables::on_rungs(const PadCellSize& size) const {
  {
    const std::lock_guard lock(making_);
    if (const auto kept = influence_.find(size); kept != influence_.end()) return kept->second;
  }
  const bool turns = means_ && size.hx > size.hy;  // a mean takes a millisecond: the table of turned cells has it, too
  PadNumbers made = turns ? turned(*on_rungs({size.hy, size.hx}), cells_ + 1) : make_influence(*layer_, size);
  const std::lock_guard lock(making_);
  if ((influence_.size() + 1) * made->size() <= most_kept_numbers) influence_.emplace(size, made);
  return made;
}

std::vector<double> PadTables::shared_influence(const PadCellSize& size, const fem::SoftObject& object, int nx,
                                                int ny) const {
  const int span = 2 * ny + 1;
  const PadNumbers own = influence(size, object);
  std::vector<double> table(PAD_TABLE_HEAD + std::size_t{PAD_INFLUENCE} * (2 * nx + 1) * span);
  std::copy_n(own->begin(), PAD_TABLE_HEAD, table.begin());
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j <= ny; ++j)
      for (const int sx : {-1, 1})
        for (const int sy : {-1, 1}) {  // the place lies at +(sx i, sy j) from the source
          double* row = &table[PAD_TABLE_HEAD + std::size_t{PAD_INFLUENCE} * ((nx - sx * i) * span + ny - sy * j)];
          std::copy_n(&(*own)[PAD_TABLE_HEAD + std::size_t{PAD_OWN_INFLUENCE} * (i * (cells_ + 1) + j)],
                      PAD_OWN_INFLUENCE, row);
          row[PAD_XY] *= sx * sy, row[PAD_XZ] *= sx, row[PAD_YZ] *= sy;
        }
  return table;
}

int marker_rows_a_thickness(double depth) { return std::clamp(static_cast<int>(std::ceil(6 / depth)), 32, 512); }
int marker_rows(double depth) { return marker_farthest * marker_rows_a_thickness(depth) + 1; }

std::vector<double> displacement_table(double poisson, double depth) {
  const fem::LayerAtDepth layer(poisson, depth, marker_farthest, StopScope::checker());
  const double side = 0.02 * depth;  // of a cell that acts as a point
  return quadratics(marker_rows(depth), marker_rows_a_thickness(depth), [&](double rho) {
    const Eigen::Matrix3d u = layer.displacement(side, side, rho, 0) / (side * side);
    return Eigen::Array<double, 5, 1>(u(2, 2), (u(0, 0) + u(1, 1)) / 2, (u(1, 1) - u(0, 0)) / 2, -u(0, 2), -u(2, 0));
  });
}

double marker_depth(const fem::PadScene& scene) {
  return scene.markers ? scene.markers->depth / scene.sensor.thickness : 0;
}

std::shared_ptr<const PadTables> PadRubbers::tables(const fem::Rubber& rubber, bool means) {
  if (any_poisson_ && !means && rubber.layers.empty()) {
    std::call_once(once_, [this] {
      std::vector<std::shared_ptr<const PadTables>> all;
      all.reserve(fem::poisson_points);
      for (int k = 0; k < fem::poisson_points; ++k)
        all.push_back(std::make_shared<const PadTables>(fem::Rubber{fem::poisson_point(k)}, cells_, exact_));
      points_ = std::move(all);
    });
    return std::make_shared<const PadTables>(rubber.poisson, points_);
  }
  return tables_.get({rubber, means}, [&] { return std::make_shared<const PadTables>(rubber, cells_, exact_, means); });
}

std::vector<double> PadRubbers::markers(double poisson, double depth) {
  return markers_.get({poisson, depth}, [&] { return displacement_table(poisson, depth); });
}

}  // namespace tactel::host
