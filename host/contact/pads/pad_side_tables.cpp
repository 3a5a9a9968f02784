// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_side_tables.h"

#include <algorithm>
#include <span>
#include <utility>

#include "fem/pad/pad_solver.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
template <class Real>
Buffer<Real> PadSideTables<Real>::between(const fem::PadSides& sides) {
  return blocks_.get(sides.kernel, [&] {
    // Of zn zx zy xx xy xn yx yy yn: by and to which component (x, y, z), and the sign of a pressure in place of a
    // force.
    constexpr int to[] = {2, 2, 2, 0, 0, 0, 1, 1, 1}, by[] = {2, 0, 1, 0, 1, 2, 0, 1, 2};
    constexpr double sign[] = {1, -1, -1, 1, 1, 1, 1, 1, 1};
    const Eigen::MatrixXd& all = sides.kernel->displacement();
    const Eigen::Index nodes = all.rows() / 3;
    std::vector<Real> numbers(static_cast<std::size_t>(nodes * nodes) * PAD_BLOCK);
    auto entry = numbers.begin();
    for (Eigen::Index i = 0; i < nodes; ++i)
      for (Eigen::Index j = 0; j < nodes; ++j, entry += PAD_BLOCK)
        for (int k = 0; k < 9; ++k) entry[k] = static_cast<Real>(sign[k] * all(3 * i + to[k], 3 * j + by[k]));
    return Buffer<Real>(device_, std::span<const Real>(numbers));
  });
}

template <class Real>
std::shared_ptr<const std::vector<Real>> PadSideTables<Real>::response(const fem::PadSensor& sensor,
                                                                       const fem::PadSides& sides) {
  const Place place(sides.kernel, sides.middle[0], sides.middle[1], sensor.tactels, sensor.pitch, sensor.tactel_size,
                    sensor.thickness);
  return responses_.get(place, [&] {
    const fem::TactelPoints points(sensor);
    const auto parts = static_cast<Eigen::Index>(points.weights.size()), tactels = points.places.rows() / parts;
    const Eigen::Index rows = sides.kernel->displacement().rows(),
                       width = (3 * tactels + PAD_BLOCK - 1) / PAD_BLOCK * PAD_BLOCK;
    std::vector<Real> numbers(static_cast<std::size_t>(rows * width));
    for (Eigen::Index tactel = 0; tactel < tactels; ++tactel) {
      Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(3, rows);
      for (Eigen::Index p = 0; p < parts; ++p) {
        const Eigen::Vector2d at = sides.in_block(points.places.row(tactel * parts + p).transpose());
        sum += points.weights[static_cast<std::size_t>(p)] * sides.base->stress(at[0], at[1]);
      }
      for (Eigen::Index m = 0; m < rows; ++m)
        for (Eigen::Index r = 0; r < 3; ++r)
          numbers[static_cast<std::size_t>(m * width + r * tactels + tactel)] = static_cast<Real>(sum(r, m));
    }
    return std::make_shared<const std::vector<Real>>(std::move(numbers));
  });
}

template <class Real>
std::shared_ptr<const Buffer<Real>> PadSideTables<Real>::borrow(std::size_t size) {
  const std::lock_guard lock(turn_);
  auto found = std::ranges::find_if(free_, [&](const auto& buffer) { return buffer->size() >= size; });
  if (found == free_.end()) found = free_.insert(found, std::make_unique<Buffer<Real>>(device_, size));
  auto taken = std::move(*found);
  free_.erase(found);
  return {taken.release(), [this](const Buffer<Real>* buffer) {
            const std::lock_guard back(turn_);
            free_.emplace_back(buffer);
          }};
}

template class PadSideTables<float>;
template class PadSideTables<double>;

}  // namespace tactel::host
