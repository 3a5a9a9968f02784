// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <list>
#include <memory>
#include <mutex>
#include <tuple>
#include <vector>

#include "fem/numbers/last_used.h"
#include "fem/pad/side_kernel.h"
#include "host/device/buffer.h"

namespace tactel::host {

/// What kernels with free sides need of a block (kernels/pad/free_sides.h), kept for the next launches, and memory to
/// work in. Threads may use it at once.
template <class Real>
class PadSideTables {
 public:
  explicit PadSideTables(const Device& device) : device_(device) {}

  /// The side part between the nodes of a block: `between` of SidePart.
  Buffer<Real> between(const fem::PadSides& sides);

  /// What free sides add to the stress of tactels by unit forces on the nodes: of `responses` of pad_side_stress those
  /// of one place, [3 nodes][3 tactels, filled up].
  std::shared_ptr<const std::vector<Real>> response(const fem::PadSensor& sensor, const fem::PadSides& sides);

  /// Memory of at least so many numbers for one run, until the pointer ends: launches that wait have none.
  std::shared_ptr<const Buffer<Real>> borrow(std::size_t size);

 private:
  using Kernel = std::shared_ptr<const fem::SideKernel>;
  /// Kernel, middle of the block, tactels, pitch, their size, thickness.
  using Place = std::tuple<Kernel, double, double, std::array<int, 2>, std::array<double, 2>, double, double>;

  const Device device_;
  fem::LastUsed<Kernel, Buffer<Real>> blocks_{8};
  fem::LastUsed<Place, std::shared_ptr<const std::vector<Real>>> responses_{64};
  std::mutex turn_;  ///< of the next
  std::list<std::unique_ptr<const Buffer<Real>>> free_;
};

}  // namespace tactel::host
