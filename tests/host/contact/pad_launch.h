// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <limits>
#include <span>

#include "host/contact/pads/pad_contact.h"
#include "tests/host/device/test_device.h"

namespace tactel::host {

/// The batch of one launch; outputs and all unused inputs hold NaN before it.
template <class Real>
typename PadContact<Real>::Batch ran(const PadContact<Real>& contact, std::span<const fem::PadScene> scenes,
                                     std::span<const fem::PadCells> cells = {}) {
  auto batch = contact.prepare(scenes, cells);
  batch.fill_unused(std::numeric_limits<Real>::quiet_NaN());
  batch.fill_outputs(std::numeric_limits<Real>::quiet_NaN());
  batch.run();
  return batch;
}

/// The same on 8 x 8 cells.
template <class Real>
typename PadContact<Real>::Batch ran(std::span<const fem::PadScene> scenes, double tolerance) {
  return ran(PadContact<Real>(executor(), {.cells = 8, .tolerance = tolerance}), scenes);
}

}  // namespace tactel::host
