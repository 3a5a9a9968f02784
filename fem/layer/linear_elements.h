// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/layer/patch_reference.h"

namespace tactel::fem {

// Pressure that is constant on each element, with displacements at the middles, is too soft where the rubber is thin
// and hardly compressible. There u_y follows the curvature of the pressure over a thickness h (Reynolds' equation):
// constant pressures have none, and elements wider than h do not feel their neighbours. Forces are then up to 65 % too
// low. Linear elements have pressures that are linear between the middles, and the mean displacements weighted with
// these functions (Galerkin). With 12 of them P is off by 5 % and S by 0.007 at most for half-widths of 3 to 50 h and
// nu from 0.3 to 0.4999, where constant ones are off by 52 % and 0.015.

/// Poisson's ratio from which the width of an element matters, and the widest one with a constant pressure, over h.
inline constexpr double hardly_compressible = 0.49, widest_constant_element = 0.75;

/// Returns true where an element of this width, mm, needs a linear pressure.
bool needs_linear_pressure(const Sensor& sensor, double width);

/// As elements_condensation, with forces of linear elements: that of element k has its pressure linear between the
/// middles of its neighbours, and constant on the outer half of an outermost element.
Condensation linear_condensation(const LayerModel& model, const UnequalElements& elements);

}  // namespace tactel::fem
