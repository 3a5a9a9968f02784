#pragma once
#include <optional>
#include <string>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/support/precision.h"

namespace tactel::host {

/// Model of a contact: mesh, element, load steps, precision and tolerance. Numbers of nodes are for the default
/// sensor, 20 mm of rubber 1.5 mm thick; other sensors have the same number of nodes to a thickness.
struct Rung {
  std::string name;
  int columns = 41;  ///< gap elements
  int rows = 11;     ///< nodes through the thickness
  int spread = 1;    ///< columns of the block to one gap element (fem/spread.h)
  int steps = 1;     ///< increments to each requested indentation or normal force; drags are unchanged
  Precision precision = Precision::fp64;
  double tolerance = 1e-7;  ///< GapSweepOptions::tolerance
  fem::Element element = fem::Element::bbar;
};

/// Returns the named rungs, cheapest first. The last is the reference of the others.
const std::vector<Rung>& ladder();
/// Throws ConfigError naming --rung.
const Rung& rung_named(const std::string& name);
std::vector<std::string> rung_names();
/// Returns "41 x 11 bbar, 1 step, fp32 1e-4"; with spread: "41 on 81 x 11".
std::string description(const Rung& rung);
/// The same with the columns for this sensor.
std::string description(const Rung& rung, const fem::Sensor& sensor);

/// Returns the gap elements of the rung on this sensor.
int columns_of(const Rung& rung, const fem::Sensor& sensor);

/// Returns true where the rung's mesh on this sensor stays within fem::most_columns. Longer sensors of equal
/// thickness have fewer rungs.
bool carries(const fem::Sensor& sensor, const Rung& rung);

/// Returns the scene as the rung models it: the mesh of its sensor, with fem::most_columns at most, and its
/// increments.
fem::Scene on_rung(const fem::Scene& scene, const Rung& rung);
/// Returns the indices of the requested increments in a solution, at which rungs are compared. Only existing
/// increments are returned (a path may end with sliding).
std::vector<std::size_t> asked_steps(const fem::Load& load, std::size_t steps_made);

}  // namespace tactel::host
