// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "fem/gap/stress_field.h"
#include "fem/pad/pad_field.h"
#include "fem/pad/pad_solver.h"

namespace tactel::host {

/// Returns the field as a VTK XML UnstructuredGrid (.vtu), for ParaView. `beyond_linear` is 1 where the strain
/// exceeds linear_strain_limit.
std::string to_vtu(const fem::StressField& field);

/// Returns the cells of a contact on a pad at one of its steps as quads on the surface, z = thickness, with the
/// indenter's tractions on the rubber, MPa, and the status, 0 open, 1 stick, 2 slip.
std::string to_vtu(const fem::PadScene& scene, const fem::PadSolution& solution, std::size_t step);

/// Returns the rubber of a pad as a VTK XML StructuredGrid (.vts), for ParaView: displacement, and stress as six
/// numbers, tension > 0.
std::string to_vts(const fem::PadField& field);

/// What a file of a contact on a pad holds: its rubber where the name ends in .vts, else its cells.
std::string field_of(const std::string& file, const fem::PadScene& scene, const fem::PadSolution& solution,
                     std::size_t step);

}  // namespace tactel::host
