// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "fem/scene_derivatives.h"
#include "host/answers/solve.h"

namespace tactel::host {

/// Derivatives of a solved scene by its numbers.
struct ContactDerivatives {
  std::vector<fem::SceneParameter> parameters;
  std::vector<fem::NoDerivative> missing;        ///< numbers without a derivative, and why
  std::vector<std::vector<fem::PathAnswer>> by;  ///< [parameters][steps] over the parameter's unit
  std::vector<double> distance_to_switch;        ///< [steps] as of fem::PathAnswer
  double answer_difference = 0;  ///< largest difference of S between the answer and the exact path of the derivatives
};

/// Returns the derivatives of an outcome of solve(scene): implicit, of the exact fp64 solution on the same patch or
/// mesh (fem/path_derivatives.h). Throws ConfigError, naming --derivatives, where the model has none: the reference of
/// patches, a mesh of more than 321 columns; and where the exact solution is another than the answer, as with several
/// solutions.
ContactDerivatives derivatives(const fem::Scene& scene, const SolveOutcome& outcome);

}  // namespace tactel::host
