#pragma once
#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <vector>

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

/// The rubber as the status iteration sees it: a linear system whose surface rows depend on what each gap element does,
///   open   f_x = r_x                  f_y = r_y
///   stick  u_x = r_x                  u_y = r_y
///   slip   f_x + sigma mu f_y = r_x   u_y = r_y        sigma = friction_sign
/// with f the force on the rubber. What r is, is the caller's affair: the system is linear in it. A state holds what
/// the system needs to know of one solution; it is linear in r, too.
class GapSystem {
 public:
  virtual ~GapSystem() = default;
  virtual int columns() const = 0;
  virtual Eigen::Index state_size() const = 0;

  /// States [state_size, k] for k right sides r [2 columns, k] (x at 2i, y at 2i + 1); none where the system is
  /// singular.
  virtual std::optional<Extended> solve(const std::vector<Trial>& trial, double mu, const Extended& right_side) = 0;

  /// Displacement [2 columns, k] mm and force [2 columns, k] N/mm of the surface nodes; force of the rubber on the base
  /// [2 base nodes, k] N/mm.
  virtual Extended surface_displacement(const Extended& state) const = 0;
  virtual Extended surface_force(const Extended& state) const = 0;
  virtual Extended base_force(const Extended& state) const = 0;

  /// Force that goes with a displacement at a surface node, about, N/mm per mm.
  virtual double typical_stiffness() const = 0;
};

}  // namespace tactel::fem
