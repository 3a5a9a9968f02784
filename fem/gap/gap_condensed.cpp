// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/gap_condensed.h"

#include <algorithm>
#include <cmath>

namespace tactel::fem {
namespace {

/// u = C f / E. Open nodes bear what is given (nothing, but for the offsets of follow_path); the forces of those that
/// touch are the unknowns. A state is displacement, then force, of the surface nodes: [4 columns, k].
class CondensedSystem : public GapSystem {
 public:
  CondensedSystem(const Extended& compliance, const Extended& base_force, double young)
      : compliance_(compliance / static_cast<long double>(young)), base_force_(base_force) {}

  int columns() const override { return int(compliance_.rows() / 2); }
  Eigen::Index state_size() const override { return 2 * compliance_.rows(); }
  std::optional<Extended> solve(const std::vector<Trial>& trial, double mu, const Extended& right_side) override;
  Extended surface_displacement(const Extended& state) const override { return state.topRows(compliance_.rows()); }
  Extended surface_force(const Extended& state) const override { return state.bottomRows(compliance_.rows()); }
  Extended base_force(const Extended& state) const override { return base_force_ * surface_force(state); }
  double typical_stiffness() const override { return double(compliance_.rows() / compliance_.trace()); }

 private:
  Extended matrix(const std::vector<Trial>& trial, double mu, const std::vector<int>& unknowns) const;

  Extended compliance_;         ///< [2 columns, 2 columns] mm/(N/mm)
  const Extended& base_force_;  ///< [2 base nodes, 2 columns]
};

/// Rows: displacement where it is prescribed, forces on the cone's edge (in units of a displacement) where the node
/// slips.
Extended CondensedSystem::matrix(const std::vector<Trial>& trial, double mu, const std::vector<int>& unknowns) const {
  Extended matrix = compliance_(unknowns, unknowns);
  for (int k = 0; k < int(unknowns.size()); k += 2) {
    const Trial here = trial[unknowns[k] / 2];
    if (!slips(here)) continue;
    const long double scale = compliance_(unknowns[k], unknowns[k]);
    matrix.row(k).setZero();
    matrix(k, k) = scale;
    matrix(k, k + 1) = scale * friction_sign(here) * mu;
  }
  return matrix;
}

/// Factored in double; passes of refinement take displacements to extended precision.
std::optional<Extended> refined_solution(const Extended& matrix, const Extended& right_side) {
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(matrix.cast<double>());
  const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > 1e-15 * pivots.maxCoeff())) return std::nullopt;
  Extended x = Extended::Zero(matrix.rows(), right_side.cols());
  for (int pass = 0; pass < 4; ++pass) x += lu.solve((right_side - matrix * x).cast<double>()).cast<long double>();
  return x;
}

std::optional<Extended> CondensedSystem::solve(const std::vector<Trial>& trial, double mu, const Extended& right_side) {
  std::vector<int> unknowns;  // components of force
  for (int i = 0; i < columns(); ++i) {
    if (touches(trial[i])) unknowns.insert(unknowns.end(), {2 * i, 2 * i + 1});
  }
  Extended force = right_side;
  force(unknowns, Eigen::all).setZero();
  if (!unknowns.empty()) {
    const Extended by_open = force.isZero(0) ? Extended::Zero(unknowns.size(), force.cols()).eval()
                                             : (compliance_(unknowns, Eigen::all) * force).eval();
    Extended wanted = right_side(unknowns, Eigen::all) - by_open;
    for (int k = 0; k < int(unknowns.size()); k += 2) {
      if (slips(trial[unknowns[k] / 2]))
        wanted.row(k) = compliance_(unknowns[k], unknowns[k]) * right_side.row(unknowns[k]);
    }
    const auto found = refined_solution(matrix(trial, mu, unknowns), wanted);
    if (!found) return std::nullopt;
    force(unknowns, Eigen::all) = *found;
  }
  Extended state(state_size(), right_side.cols());
  state << compliance_ * force, force;
  return state;
}

}  // namespace

GapCondensed::GapCondensed(const Condensation& condensation, const GapReferenceOptions& options)
    : condensation_(condensation),
      options_(options),
      compliance_(condensation.compliance.cast<long double>()),
      base_force_(condensation.base_force.cast<long double>()) {}

ContactSolution GapCondensed::solve(const Scene& scene) const {
  CondensedSystem system(compliance_, base_force_, scene.sensor.young);
  const auto stress = [&](const Extended& state, const Eigen::VectorXd&) -> Eigen::VectorXd {
    return condensation_.tactel_stress * system.surface_force(state).cast<double>();
  };
  return step_load_path(system, scene,
                        {condensation_.surface_x, condensation_.base_x, condensation_.tactel_x, {}, false}, options_,
                        stress);
}

}  // namespace tactel::fem
