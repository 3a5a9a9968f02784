// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>

#include "fem/gap/stress_field.h"
#include "host/figures/plot.h"

namespace tactel::host {

/// Returns a panel of one quantity inside the block, coloured, with contour lines, for a page. `values` [nodes];
/// x from..to of the block, mm.
Panel field_panel(const fem::StressField& field, const Eigen::VectorXd& values, const std::string& title,
                  const std::string& unit, std::pair<double, double> x_range);

}  // namespace tactel::host
