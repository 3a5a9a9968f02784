// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/gap/contact_solution.h"
#include "fem/mesh/condensation.h"
#include "fem/scenes/scene.h"

namespace tactel::host {

/// Recomputes the residuals of a batched answer from its forces and the compliance C in fp64, and keeps the
/// larger of both. This adds the rounding of C to fp32, and the slip of sticking nodes in one increment, which
/// the kernel does not see. (The kernel measures drift from the position at which a node began to stick; in one
/// increment the slip may be twice as large.) Steps whose residual is above `accept`, and later steps, become
/// unsolved. The solution must hold node and base forces. `condensation` is that of its sensor.
void audit_in_fp64(const fem::Scene& scene, const fem::Condensation& condensation, double accept,
                   fem::ContactSolution& solution);

/// Returns an estimate of the error of single base forces over the largest of the step, the largest over the steps.
/// The estimate is the effect of closing the remaining gaps and slips, with the statuses of the answer. Residuals do
/// not show this error: neighbouring nodes of thick, nearly incompressible blocks exchange friction almost freely.
double base_force_error(const fem::Scene& scene, const fem::Condensation& condensation,
                        const fem::ContactSolution& solution);

}  // namespace tactel::host
