// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "fem/stress_field.h"

namespace tactel::host {

/// Returns the field as a VTK XML UnstructuredGrid (.vtu), for ParaView. `beyond_linear` is 1 where the strain
/// exceeds linear_strain_limit.
std::string to_vtu(const fem::StressField& field);

}  // namespace tactel::host
