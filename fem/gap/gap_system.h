// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <vector>

namespace tactel::fem {

/// Displacements and sums over them are in extended precision (64 bits of mantissa on x86). Near nu = 0.5, forces
/// are small differences of large products K_ij u_j. Rounding of u alone would cost four digits of the forces at
/// nu = 0.4999.
using Extended = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// Assumed status of a gap element in a trial. slip_plus: friction on the rubber points to +x and has reached its
/// limit.
enum class Trial : std::uint8_t { open, stick, slip_plus, slip_minus };

inline bool touches(Trial trial) { return trial != Trial::open; }
inline bool slips(Trial trial) { return trial == Trial::slip_plus || trial == Trial::slip_minus; }
/// Returns the sign of the friction on the rubber: +1, -1, or 0 where the node does not slip.
inline double friction_sign(Trial trial) { return trial == Trial::slip_plus ? 1 : trial == Trial::slip_minus ? -1 : 0; }

/// Interface of the active-set method to the rubber: a linear system whose surface rows depend on the status of
/// each gap element.
///     open   f_x = r_x                  f_y = r_y
///     stick  u_x = r_x                  u_y = r_y
///     slip   f_x + sigma mu f_y = r_x   u_y = r_y        sigma = friction_sign
/// f is the force on the rubber. The caller chooses r; the system is linear in it. A state holds one solution as
/// the system needs it, and is also linear in r.
class GapSystem {
 public:
  virtual ~GapSystem() = default;
  virtual int columns() const = 0;
  virtual Eigen::Index state_size() const = 0;

  /// Returns the states [state_size, k] for k right-hand sides r [2 columns, k] (x at 2i, y at 2i + 1). Returns
  /// none where the system is singular.
  virtual std::optional<Extended> solve(const std::vector<Trial>& trial, double mu, const Extended& right_side) = 0;

  /// Return the displacement [2 columns, k] mm and force [2 columns, k] N/mm of the surface nodes, and the
  /// force of the rubber on the base [2 base nodes, k] N/mm.
  virtual Extended surface_displacement(const Extended& state) const = 0;
  virtual Extended surface_force(const Extended& state) const = 0;
  virtual Extended base_force(const Extended& state) const = 0;

  /// Returns the order of magnitude of force over displacement at a surface node, N/mm per mm.
  virtual double typical_stiffness() const = 0;
};

}  // namespace tactel::fem
