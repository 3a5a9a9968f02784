#pragma once
#include <string>

#include "fem/contact_solution.h"
#include "fem/mesh.h"
#include "fem/scene.h"

namespace tactel::host {

/// Rubber is taken as linear; the paper measured that to hold up to this strain (section IV), and to this share of the
/// thickness.
inline constexpr double linear_strain_limit = 0.20;

/// Displacement and stress inside the block at the end of a load increment.
struct StressField {
  fem::Mesh mesh;
  Eigen::Matrix2Xd displacement;  ///< [2, nodes] mm
  Eigen::Matrix4Xd stress;        ///< [4, nodes] MPa: sigma_x, sigma_y, tau_xy, sigma_z
  Eigen::VectorXd von_mises;      ///< [nodes] MPa
  Eigen::VectorXd strain;         ///< [nodes] largest principal strain in the plane, by magnitude
};

/// Stresses [4] as the columns of StressField::stress.
double von_mises(const Eigen::Vector4d& stress);
/// Hooke's law backwards, then Mohr's circle: the larger magnitude of the two principal strains in the plane.
double largest_principal_strain(const Eigen::Vector4d& stress, double young, double poisson);

/// A fresh solve of the whole block under the step's surface forces.
StressField stress_field(const fem::Sensor& sensor, const fem::ContactStep& step);

/// The field as a VTK XML UnstructuredGrid (.vtu), for ParaView; `beyond_linear` is 1 where the strain passes the
/// limit.
std::string to_vtu(const StressField& field);

}  // namespace tactel::host
