// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

#include "fem/gap/contact_laws.h"
#include "fem/numbers/angles.h"
#include "fem/pad/pad_solver.h"
#include "host/answers/quantities.h"

// The quantities of the steps of fem: where these have other members than the public structs.

namespace tactel::fem {

/// An angle that is kept in radians.
struct Degrees {
  double radians = 0;
  operator double() const { return degrees(radians); }  // NOLINT: stands for its value
};

inline std::array<double, 2> tangential_of(const PadStep& step) { return {step.x, step.y}; }
inline Degrees twist_of(const PadStep& step) { return {step.twist}; }
inline auto sigma_z_of(const PadStep& step) { return step.stress.col(0); }
inline auto tau_x_of(const PadStep& step) { return step.stress.col(1); }
inline auto tau_y_of(const PadStep& step) { return step.stress.col(2); }

/// Returns the largest residual of a step.
inline double largest_residual(const ContactStep& step) { return largest(step.residual); }
inline double largest_residual(const PadStep& step) { return step.residual.largest(); }

}  // namespace tactel::fem
