// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/mesh/mesh.h"
#include "fem/scenes/scene.h"

namespace tactel::fem {

/// Strain up to which the rubber is taken as linear, as the paper measured (section IV). It also limits depth
/// over thickness.
inline constexpr double linear_strain_limit = 0.20;

/// Displacement and stress inside the block at the end of a load increment.
struct StressField {
  Mesh mesh;
  Eigen::Matrix2Xd displacement;  ///< [2, nodes] mm
  Eigen::Matrix4Xd stress;        ///< [4, nodes] MPa: sigma_x, sigma_y, tau_xy, sigma_z
  Eigen::VectorXd von_mises;      ///< [nodes] MPa
  Eigen::VectorXd strain;         ///< [nodes] largest principal strain in the plane, by magnitude
};

/// Returns the von Mises stress of stresses [4], ordered as the columns of StressField::stress.
double von_mises(const Eigen::Vector4d& stress);
/// Returns the larger magnitude of the two principal strains in the plane, by the inverse of Hooke's law and
/// Mohr's circle.
double largest_principal_strain(const Eigen::Vector4d& stress, double young, double poisson);

/// Solves the whole block anew under the step's surface forces.
StressField stress_field(const Sensor& sensor, const ContactStep& step);

/// Returns the fields of surface loads [2 columns, loads] N/mm, force on the rubber at surface node i in x at 2i and y
/// at 2i + 1. The block is factored once.
std::vector<StressField> stress_fields(const Sensor& sensor, const Eigen::MatrixXd& surface_loads);

}  // namespace tactel::fem
