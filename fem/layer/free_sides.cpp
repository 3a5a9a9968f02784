#include "fem/layer/free_sides.h"

#include <algorithm>

namespace tactel::fem {

FreeSides::FreeSides(double left, double right, Eigen::MatrixXd rows, const Modes& sign)
    : left_(left), step_((right - left) / static_cast<double>(rows.rows() - 1)), rows_(std::move(rows)), sign_(sign) {}

FreeSides::At FreeSides::at(double x) const {
  if (endless()) return {};
  const double last = static_cast<double>(rows_.rows() - 1), place = std::clamp((x - left_) / step_, 0.0, last);
  const Eigen::Index row = std::min(static_cast<Eigen::Index>(place), rows_.rows() - 2);
  const double q = place - static_cast<double>(row);
  const auto between = [&](int component) -> Modes {
    const auto from = rows_.row(row).segment<rank>(component * rank).transpose().array();
    const auto to = rows_.row(row + 1).segment<rank>(component * rank).transpose().array();
    return from + q * (to - from);
  };
  return {between(0), between(1)};
}

}  // namespace tactel::fem
