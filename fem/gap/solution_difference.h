// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/gap/contact_solution.h"

namespace tactel::fem {

/// Returns the largest difference of base nodal forces between two solutions of a scene, in each step over the
/// largest base force of `b`. Returns NaN where a force is NaN. Returns infinity where steps or base nodes
/// differ, or where one solution bears a force and `b` bears none.
double base_force_difference(const ContactSolution& a, const ContactSolution& b);

}  // namespace tactel::fem
