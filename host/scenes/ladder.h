// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/scenes/scene.h"
#include "host/support/precision.h"

namespace tactel::host {

/// Model of a contact: the scene's own patch or a mesh, load steps, precision and tolerance. Numbers of nodes are for
/// the default sensor, 20 mm of rubber 1.5 mm thick; other sensors have the same number of nodes to a thickness.
struct Rung {
  std::string name;
  int elements = 0;  ///< of the scene's own patch (fem/layer); 0: a mesh. Of a patch, the mesh below answers the scenes
                     ///< that a patch cannot serve
  int columns = 41;  ///< gap elements
  int rows = 11;     ///< nodes through the thickness
  int steps = 1;     ///< increments to each requested indentation or normal force; drags are unchanged
  Precision precision = Precision::fp64;
  double tolerance = 1e-7;  ///< GapSweepOptions::tolerance, fem::PatchOptions::tolerance
  double accept = 0;        ///< largest residual of a solved step; 0: fem::by_rule of patch and mesh
  fem::Element element = fem::Element::bbar;
  bool sides = true;   ///< of a patch: with the sensor's free sides
  bool exact = false;  ///< solved by the reference solver of the patch, fp64, without a device

  bool patch() const { return elements > 0; }
  /// A requested residual in place of the rung's tolerance.
  void accept_at_most(double residual) { tolerance = 0, accept = residual; }
};

/// Model of a contact on a pad: cells along a side, and the least number of increments to each pressing target.
struct PadRung {
  std::string name;
  int cells = 12;
  int increments = 4;
  bool exact = false;  ///< fem::PadReference, which states its own error
};

/// Returns all named rungs: of lines (Rung) patches, the paper's mesh, other meshes, the reference; of pads (PadRung)
/// the cheapest first, the reference last.
template <class AnyRung = Rung>
const std::vector<AnyRung>& all_rungs();
template <>
const std::vector<Rung>& all_rungs();
template <>
const std::vector<PadRung>& all_rungs();
/// Returns the rungs that the planner climbs, cheapest first. The last is the reference of the others.
const std::vector<Rung>& ladder();
/// Returns the rung of a name or of one of its other names. Throws ConfigError naming --rung.
template <class AnyRung = Rung>
const AnyRung& rung_named(const std::string& name);
/// Returns the names of all rungs and their other names.
template <class AnyRung = Rung>
std::vector<std::string> rung_names();
/// Returns the rung of contacts on patches, and of pads, where none is asked for.
inline const Rung& usual_patch() { return rung_named("patch-12"); }
inline const PadRung& usual_pad_rung() { return rung_named<PadRung>("pad-12"); }
/// Returns "12 elements, 4 increments, fp32 1e-03" or "41 x 11 bbar, 1 step, fp32 1e-04"; of a pad "12 x 12 cells, 4
/// increments".
std::string description(const Rung& rung);
std::string description(const PadRung& rung);
/// The same with the columns for this sensor.
std::string description(const Rung& rung, const fem::Sensor& sensor);

/// Returns true where the rung's mesh on this sensor stays within fem::most_columns. Longer sensors of equal
/// thickness have fewer meshes. Patches are carried by every sensor.
bool carries(const fem::Sensor& sensor, const Rung& rung);

/// Returns the scene as the rung's mesh models it: the mesh of its sensor, with fem::most_columns at most, and its
/// increments.
fem::Scene on_mesh(const fem::Scene& scene, const Rung& rung);
/// Returns the scene whose load steps an answer on this rung has: of a patch the scene itself, else on_mesh.
fem::Scene on_rung(const fem::Scene& scene, const Rung& rung);
/// Returns the indices of the requested increments in a solution, at which rungs are compared. Only existing
/// increments are returned (a path may end with sliding).
std::vector<std::size_t> asked_steps(const fem::Load& load, std::size_t steps_made);

}  // namespace tactel::host
