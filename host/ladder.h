#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/executor.h"

namespace tactel::host {

/// How finely a contact is modelled: a choice of mesh, element, load steps, precision and tolerance. Counts of nodes
/// are for the default sensor, 20 mm of rubber 1.5 mm thick; others get as many nodes to a thickness.
struct Rung {
  std::string name;
  int columns = 41;  ///< gap elements
  int rows = 11;     ///< nodes through the thickness
  int spread = 1;    ///< columns of the block to one gap element (fem/spread.h)
  int steps = 1;     ///< increments to an indentation, or normal force, that is asked for; drags are taken as they are
  Precision precision = Precision::fp64;
  double tolerance = 1e-7;  ///< GapSweepOptions::tolerance
  fem::Element element = fem::Element::bbar;
};

/// The rungs that have a name, cheapest first; the last is the reference that the others are judged by.
const std::vector<Rung>& ladder();
/// Throws ConfigError naming --rung.
const Rung& rung_named(const std::string& name);
std::vector<std::string> rung_names();
/// "41 x 11 bbar, 1 step, fp32 1e-4"; with spread: "41 on 81 x 11".
std::string description(const Rung& rung);

/// The scene as the rung models it: its sensor's mesh and its increments.
fem::Scene on_rung(const fem::Scene& scene, const Rung& rung);
/// `nodes`: forces and statuses of the gap elements are wanted, too.
std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, std::span<const fem::Scene> scenes,
                                                const Rung& rung, bool nodes = true);

/// Places in a solution of the increments that a load asks for: what rungs can be compared at. Those that were made (a
/// path may end with sliding).
std::vector<std::size_t> asked_steps(const fem::Load& load, std::size_t steps_made);

}  // namespace tactel::host
