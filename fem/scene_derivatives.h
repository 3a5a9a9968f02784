// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "fem/condensation.h"
#include "fem/load_stepping.h"
#include "fem/path_derivatives.h"

namespace tactel::fem {

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

/// A solved path of a scene and the directions of its numbers.
struct SceneDerivatives {
  PathDerivatives path;
  std::vector<SceneParameter> parameters;
  std::vector<PathDirection> directions;  ///< [parameters] over the parameter's unit
  std::vector<NoDerivative> missing;

  /// Adds a parameter and its direction.
  void add(SceneParameter parameter, PathDirection direction);
};

/// Adds the numbers whose directions do not depend on the model of the rubber: those of the shape (of elements that
/// stay in place at x [elements] mm), friction, young, and the load's. `targets` returns the targets of the path's
/// increments for a load.
void add_common_parameters(const Scene& scene, const Eigen::VectorXd& x,
                           const std::function<std::vector<LoadStep>(const Load&)>& targets, SceneDerivatives& result);

/// Throws PathError where the statuses of a path are not those of a solution: sweeps that have not converged,
/// or several solutions.
void require_solution(const PathDerivatives& path);

/// Solves a scene exactly on its mesh (gap_condensed.h), each pressing step in `parts`, and returns its derivatives.
/// Those of the rubber by poisson and thickness are central differences of condensations, of order 2. Throws ValueError
/// for an invalid scene, and PathError where the active-set method fails.
SceneDerivatives mesh_derivatives(const Scene& scene, int parts = 1,
                                  const std::filesystem::path& cache_directory = default_cache_directory());

}  // namespace tactel::fem
