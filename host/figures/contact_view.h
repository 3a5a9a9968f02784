// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/scenes/scene.h"
#include "host/figures/view_parts.h"

namespace tactel::host {

/// Returns the view of a contact: indenter, displaced rubber, status, tractions, stress in the rubber and at the
/// tactels, and forces along the path. The stress in the rubber is that of the block of finite elements under the
/// contact's own forces: of a mesh on that mesh, of a patch on a mesh with its tractions. It has 81 x 13 points with
/// 8 bits. A long path is shown at no more than 24 of its steps, always with `shown` and the last.
ContactView contact_view(const fem::Scene& scene, const fem::ContactSolution& solution, std::size_t shown);

/// Returns the force of each element of a patch [elements] N/mm at the nodes of a surface [columns] N/mm, that is the
/// load of a constant traction on each element, consistent with linear interpolation between the nodes.
Eigen::VectorXd nodal_loads(const Eigen::VectorXd& force, const Eigen::VectorXd& place, const Eigen::VectorXd& width,
                            const Eigen::VectorXd& node_x);

/// Returns bytes as base64 text (RFC 4648).
std::string base64(const std::vector<std::uint8_t>& bytes);

}  // namespace tactel::host
