#include "fem/spread.h"

#include <stdexcept>

namespace tactel::fem {
namespace {

/// The hats for both directions: [2 block columns, 2 gap elements].
Eigen::MatrixXd for_both_directions(const Eigen::MatrixXd& weight) {
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(2 * weight.rows(), 2 * weight.cols());
  for (Eigen::Index j = 0; j < weight.cols(); ++j)
    for (Eigen::Index i = 0; i < weight.rows(); ++i) both(2 * i, 2 * j) = both(2 * i + 1, 2 * j + 1) = weight(i, j);
  return both;
}

}  // namespace

Eigen::MatrixXd spread_weights(Eigen::Index block_columns, int columns) {
  if (columns < 1 || (block_columns - 1) % columns != 0)
    throw std::invalid_argument("spread: the block's columns less one must be a multiple of those to a gap element");
  Eigen::MatrixXd weight = Eigen::MatrixXd::Zero(block_columns, (block_columns - 1) / columns + 1);
  const Eigen::Index last = block_columns - 1;
  for (Eigen::Index j = 0; j < weight.cols(); ++j) {
    const Eigen::Index middle = j * columns;
    for (Eigen::Index i = std::max<Eigen::Index>(0, middle - columns + 1);
         i <= std::min<Eigen::Index>(last, middle + columns - 1); ++i) {
      const double share = i == 0 || i == last ? 0.5 : 1;  // half a column of the block lies at its ends
      weight(i, j) = share * static_cast<double>(columns - std::abs(i - middle));
    }
    weight.col(j) /= weight.col(j).sum();
  }
  return weight;
}

Condensation spread(const Condensation& block, int columns) {
  if (columns == 1) return block;
  const Eigen::MatrixXd weight = for_both_directions(spread_weights(block.surface_x.size(), columns));
  Condensation result = block;
  result.compliance = weight.transpose() * block.compliance * weight;
  result.compliance = (result.compliance + result.compliance.transpose()).eval() / 2;
  result.base_force = block.base_force * weight;
  result.tactel_stress = block.tactel_stress * weight;
  result.surface_x = block.surface_x(Eigen::seq(0, Eigen::last, columns));
  return result;
}

}  // namespace tactel::fem
