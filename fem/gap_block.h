#pragma once
#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <cstdint>
#include <optional>
#include <vector>

#include "fem/mesh.h"
#include "fem/open_columns.h"

namespace tactel::fem {

/// Displacements and the sums over them are kept in extended precision (64 bits of mantissa on x86): near nu = 0.5
/// forces are small differences of large products K_ij u_j, and rounding of u alone would cost them four digits at nu =
/// 0.4999.
using Extended = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// What a gap element is assumed to do in one trial; slip_plus: friction on the rubber points to +x and has reached its
/// limit.
enum class Trial : std::uint8_t { open, stick, slip_plus, slip_minus };

inline bool touches(Trial trial) { return trial != Trial::open; }
inline bool slips(Trial trial) { return trial == Trial::slip_plus || trial == Trial::slip_minus; }
/// Sign of the friction on the rubber: +1, -1, 0 where the node does not slip.
inline double friction_sign(Trial trial) { return trial == Trial::slip_plus ? 1 : trial == Trial::slip_minus ? -1 : 0; }

/// The whole block as a linear system whose surface rows depend on what each gap element does:
///   open   f_x = r_x                  f_y = r_y
///   stick  u_x = r_x                  u_y = r_y
///   slip   f_x + sigma mu f_y = r_x   u_y = r_y        sigma = friction_sign
/// with f = K u the force on the rubber. What r is, is the caller's affair: the system is linear in it. Unknowns are
/// eliminated from both ends of the block towards the columns in contact; what is found about the ends is kept, so one
/// object serves one thread.
class GapBlock {
 public:
  /// `stiffness` [2 nodes, 2 nodes] with the base not yet clamped, as stiffness() returns it. Throws
  /// std::invalid_argument where it resists rigid translations by more than rounding.
  GapBlock(Mesh mesh, Eigen::SparseMatrix<double> stiffness);

  const Mesh& mesh() const { return mesh_; }
  int columns() const { return int(mesh_.surface.size()); }

  /// Displacements of all nodes [2 nodes, k] mm for k right sides r [2 columns, k] (x at 2i, y at 2i + 1); none where
  /// the system is singular. Factored in double, refined to extended precision.
  std::optional<Extended> displacement(const std::vector<Trial>& trial, double mu, const Extended& right_side);

  /// K u at the surface nodes: force on the rubber [2 columns, k] N/mm.
  Extended surface_force(const Extended& displacement) const;

  /// -K u at the base nodes: force of the rubber on the base [2 base nodes, k] N/mm.
  Extended base_force(const Extended& displacement) const;

  /// [2 columns, k] of displacements [2 nodes, k].
  Extended surface_part(const Extended& displacement) const;

  /// Mean of K's diagonal at the surface nodes, N/mm per mm.
  double typical_stiffness() const;

 private:
  int unknown_of(int column) const { return order_.place[2 * mesh_.surface[column]]; }  ///< its surface node's x
  class System;                                                                         ///< one trial's factored system

  long double force(int dof, const Extended& displacement, Eigen::Index side) const;
  Extended forces(const std::vector<int>& nodes, const Extended& displacement) const;

  Mesh mesh_;
  Eigen::SparseMatrix<double> stiffness_;
  Eigen::SparseMatrix<long double, Eigen::RowMajor> exact_stiffness_;  ///< rigid translations cost nothing, to 1e-19
  ColumnOrder order_;
  int band_;                  ///< diagonals of the system on either side of the main one
  OpenColumns left_, right_;  ///< grow as trials ask for more
};

}  // namespace tactel::fem
