#pragma once
#include <string>
#include <utility>

#include "host/plot.h"
#include "host/stress_field.h"

namespace tactel::host {

/// One quantity inside the block, coloured, with contour lines. `values` [nodes]; x from..to of the block, mm.
Panel field_panel(const StressField& field, const Eigen::VectorXd& values, const std::string& title,
                  const std::string& unit, std::pair<double, double> x_range);

}  // namespace tactel::host
