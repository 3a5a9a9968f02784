// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace tactel::fem {

/// Returns what a condensation's last bits owe to the processor that runs: its model, whose instructions the C library
/// chooses by, and the sizes of its caches, by which Eigen blocks products and so orders their sums. One line.
std::string processor_text();

}  // namespace tactel::fem
