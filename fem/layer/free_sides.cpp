// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/free_sides.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "fem/layer/between_nodes.h"
#include "fem/mesh/block.h"
#include "fem/mesh/mesh.h"

namespace tactel::fem {
namespace {

constexpr int rows_a_node = 4;      // of the table of modes to one of the block
constexpr int points_a_tactel = 8;  // over which the mean over a tactel's width is taken
/// Stress at the corner of the base is large without bound: a cubic that takes the last node's into the cell before it
/// would lose up to 0.7 % of the force on the base.
constexpr Eigen::Index linear_base_cells = 2;

/// A place in the block for one on a sensor of another length: as far from the nearer end; none beyond the block's
/// half.
class ToBlock {
 public:
  ToBlock(double block_length, double sensor_length) : shift_((sensor_length - block_length) / 2) {}
  struct Place {
    double x;
    int side;  ///< -1, +1: nearer end; 0: the block is the sensor
  };
  std::optional<Place> operator()(double x) const {
    if (shift_ < 1e-9) return Place{x, 0};
    const double in_block = std::abs(x) - shift_;
    if (in_block < 0) return std::nullopt;
    return Place{std::copysign(in_block, x), x < 0 ? -1 : 1};
  }

 private:
  double shift_;
};

/// The largest eigenvalues by magnitude of W B W, their vectors scaled by the root of it and divided by W: [2 nodes,
/// rank].
struct LowRank {
  Eigen::MatrixXd vectors;
  FreeSides::Modes sign;
};

LowRank largest_modes(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& weight) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(weight.asDiagonal() * symmetric * weight.asDiagonal());
  std::vector<Eigen::Index> order(static_cast<std::size_t>(symmetric.rows()));
  std::iota(order.begin(), order.end(), 0);
  const auto size = [&](Eigen::Index k) { return std::abs(eigen.eigenvalues()[k]); };
  std::partial_sort(order.begin(), order.begin() + FreeSides::rank, order.end(),
                    [&](Eigen::Index a, Eigen::Index b) { return size(a) > size(b); });
  LowRank low{Eigen::MatrixXd(symmetric.rows(), FreeSides::rank), FreeSides::Modes::Zero(FreeSides::rank)};
  for (int r = 0; r < FreeSides::rank; ++r) {
    const Eigen::Index k = order[static_cast<std::size_t>(r)];
    low.vectors.col(r) = weight.cwiseInverse().asDiagonal() * eigen.eigenvectors().col(k) * std::sqrt(size(k));
    low.sign[r] = eigen.eigenvalues()[k] < 0 ? -1 : 1;
  }
  return low;
}

double block_length(const SideDifference& difference) {
  return difference.base_x[difference.base_x.size() - 1] - difference.base_x[0];
}

/// Share of each unknown in the choice of modes, [2 nodes]: the root of the distance from the nearer end, full from two
/// thicknesses on. The corner is singular; without a weight the modes would serve it alone.
Eigen::VectorXd end_weights(const SideDifference& difference) {
  const double half = block_length(difference) / 2;
  Eigen::VectorXd weight(difference.compliance.rows());
  for (Eigen::Index i = 0; i < weight.size(); ++i)
    weight[i] = std::sqrt(std::min(1.0, (half - std::abs(difference.x[i / 2])) / (2 * difference.thickness)));
  return weight;
}

/// [tactels, base nodes]: mean over the width of every tactel of a quantity at the block's base nodes, and on which
/// side the tactel lies.
struct TactelWeights {
  Eigen::MatrixXd weight;
  std::vector<int> side;
};

TactelWeights tactel_weights(const SideDifference& difference, const Sensor& sensor, const ToBlock& to_block) {
  const Eigen::VectorXd middle = tactel_positions(sensor);
  const Eigen::Index nodes = difference.base_x.size();
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(nodes, nodes);
  TactelWeights tactels{Eigen::MatrixXd::Zero(middle.size(), nodes), {}};
  for (Eigen::Index k = 0; k < middle.size(); ++k) {
    const auto place = to_block(middle[k]);
    tactels.side.push_back(place ? place->side : 2);
    if (!place) continue;
    const int points = sensor.tactel_width > 0 ? points_a_tactel : 1;
    for (int p = 0; p < points; ++p) {
      const double x = place->x + ((p + 0.5) / points - 0.5) * sensor.tactel_width;
      tactels.weight.row(k) += between_nodes(difference.base_x, unit, x, linear_base_cells) / points;
    }
  }
  return tactels;
}

}  // namespace

FreeSides::FreeSides(std::shared_ptr<const Ends> ends) : ends_(std::move(ends)) {}

namespace {

/// Rows of a table over `length` for nodes that are `spacing` apart, both mm.
Eigen::Index places_over(double length, double spacing) {
  return static_cast<Eigen::Index>(std::ceil(length / spacing * rows_a_node)) + 1;
}

}  // namespace

Eigen::Index FreeSides::places(const Sensor& side_block, double length) {
  const Eigen::VectorXd x = surface_positions(side_block);
  return places_over(length, x[2] - x[1]);  // x[0] is the end, where a SideDifference has no node
}

FreeSides::FreeSides(double length, Rows rows, Modes sign)
    : sign_(std::move(sign)),
      left_(-length / 2),
      step_(length / static_cast<double>(rows.rows() - 1)),
      rows_(std::move(rows)) {}

FreeSides::FreeSides(const SideDifference& difference, double length)
    : FreeSides(length, Rows::Zero(places_over(length, difference.x[1] - difference.x[0]), 2 * rank),
                Modes::Zero(rank)) {
  const LowRank low = largest_modes(difference.compliance, end_weights(difference));
  const Eigen::Index nodes = difference.x.size();
  Eigen::MatrixXd at_nodes(nodes, 2 * rank);
  at_nodes << low.vectors(Eigen::seq(1, Eigen::last, 2), Eigen::all),
      low.vectors(Eigen::seq(0, Eigen::last, 2), Eigen::all);
  const ToBlock to_block(block_length(difference), length);
  sign_ = low.sign;
  for (Eigen::Index row = 0; row < rows_.rows(); ++row)
    if (const auto place = to_block(left_ + static_cast<double>(row) * step_))
      rows_.row(row) = between_nodes(difference.x, at_nodes, place->x);
}

FreeSides::At FreeSides::at(double x) const {
  if (ends_) return ends_->at(x);
  if (endless()) return {};
  const double last = static_cast<double>(rows_.rows() - 1), place = std::clamp((x - left_) / step_, 0.0, last);
  const Eigen::Index row = std::min(static_cast<Eigen::Index>(place), rows_.rows() - 2);
  const double q = place - static_cast<double>(row);
  const auto between = [&](int component) -> Modes {
    const Modes from = rows_.row(row).segment<rank>(component * rank).transpose().array();
    const Modes to = rows_.row(row + 1).segment<rank>(component * rank).transpose().array();
    return from + q * (to - from);
  };
  return {between(0), between(1)};
}

double FreeSides::between(const Modes& to, const Modes& by) const {
  if (ends_) return ends_->between(to, by);
  double sum = 0;
  for (Eigen::Index r = 0; r < to.size(); ++r) sum += sign_[r] * to[r] * by[r];
  return sum;
}

void add_free_sides(const SideDifference& difference, const Sensor& sensor, BaseStressTable& table) {
  const ToBlock to_block(block_length(difference), sensor.length);
  const TactelWeights tactels = tactel_weights(difference, sensor, to_block);
  const Eigen::Index count = sensor.tactels, nodes = difference.x.size();
  const auto at_tactels = [&](int component) -> Eigen::MatrixXd {
    const Eigen::MatrixXd at_nodes = difference.base(Eigen::seq(component, Eigen::last, 2), Eigen::all);
    return tactels.weight * at_nodes;
  };
  const Eigen::MatrixXd tau = at_tactels(0), sigma = at_tactels(1);
  const auto by = [](const Eigen::MatrixXd& stress, int component) -> Eigen::MatrixXd {
    const Eigen::MatrixXd by_component = stress(Eigen::all, Eigen::seq(component, Eigen::last, 2));
    return by_component.transpose();
  };
  Eigen::MatrixXd rows(nodes, BaseStressTable::quantities * count);
  rows << -by(sigma, 1), by(sigma, 0), -by(tau, 1), by(tau, 0);  // in the table's order; pressure is -f_y
  table.add([&](double x) -> Eigen::RowVectorXd {
    const auto place = to_block(x);
    if (!place) return Eigen::RowVectorXd::Zero(rows.cols());
    Eigen::RowVectorXd row = between_nodes(difference.x, rows, place->x);
    for (Eigen::Index k = 0; k < row.size(); ++k)
      if (tactels.side[static_cast<std::size_t>(k % count)] != place->side) row[k] = 0;
    return row;
  });
}

}  // namespace tactel::fem
