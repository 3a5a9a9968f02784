// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "host/answers/solve.h"

namespace tactel::host {

/// A number of a scene, by which its answer is differentiated.
struct SceneParameter {
  std::string name;  ///< as in scene files: "indenter.radius", "contact.friction", "load.tangential[2]"
  double value = 0;
  std::string unit;  ///< empty: none
};

/// A number of a scene that has no derivative here, and why.
struct NoDerivative {
  std::string name, reason;
};

/// Derivatives of a solved scene by its numbers.
struct ContactDerivatives {
  std::vector<SceneParameter> parameters;
  std::vector<NoDerivative> missing;
  /// [parameters][steps] over the parameter's unit: P, Q, slip_index, indentation, tangential, sigma_y and tau_xy.
  std::vector<std::vector<fem::ContactStep>> by;
  std::vector<double> distance_to_switch;  ///< [steps] relative, to the nearest change of a status up to the step; >= 0
  double answer_difference = 0;            ///< largest difference of S between the answer and the exact one
};

/// Returns the derivatives of an outcome of solve(scene): central differences of exact fp64 solutions beside it, on the
/// same patch or mesh; one-sided at the end of a number's range. Throws ConfigError, naming --derivatives, where the
/// model has none: the reference of patches, a mesh of more than 321 columns; and where the exact solution is another
/// than the answer, as with several solutions.
ContactDerivatives derivatives(const fem::Scene& scene, const SolveOutcome& outcome);

}  // namespace tactel::host
