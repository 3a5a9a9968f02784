// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tuple>

#include "host/support/tables.h"

// Every number of a load step of an answer, once. `steps` of the JSON, steps and arrays of the C++ API and attributes
// of the Python API are made from these tables. A table serves all structs with its members: of a line
// fem::ContactStep, tactel::Step and tactel::Paths, of a pad fem::PadStep, tactel::PadStep and tactel::PadPaths. To add
// a quantity, add a line here and a member of that name to these structs.

namespace tactel::host {

template <class Value>
struct Quantity {
  const char* key;      ///< name of the member, key of the JSON, attribute in Python
  const char* extent;   ///< axes in a step: "", "2", "cells, 2"
  const char* unit;     ///< "": none
  const char* meaning;  ///< follows the unit in a sentence
  Value value;          ///< reference to the member, or what is made of members
};
template <class Value>
Quantity(const char*, const char*, const char*, const char*, Value&&) -> Quantity<Value>;

// Members that a step of fem::PadStep has by other names (step_quantities.h).
auto& tangential_of(auto& step) { return step.tangential; }
auto& twist_of(auto& step) { return step.twist; }
auto& sigma_z_of(auto& step) { return step.sigma_z; }
auto& tau_x_of(auto& step) { return step.tau_x; }
auto& tau_y_of(auto& step) { return step.tau_y; }

template <class Step>
concept OfPad = requires(const Step& step) {
  step.twist;
};

/// Returns the last quantities of a step of either kind: what the solver says of itself.
template <class Step>
auto solver_quantities(Step& s) {
  return std::tuple{Quantity{"iterations", "", "", "sweeps", s.iterations},
                    Quantity{"residual", "", "", "largest relative residual of the contact laws", s.residual}};
}

/// Returns the quantities of a step of a line. `many`: without those of elements and of the solver, as many answers
/// keep them.
template <bool many, class Step>
requires(!OfPad<Step>) auto quantities(Step& s) {
  const auto path = std::tuple{Quantity{"indentation", "", "mm", "", s.indentation},
                               Quantity{"tangential", "", "mm", "", s.tangential},
                               Quantity{"P", "", "N/mm", ", of the indenter on the rubber", s.P},
                               Quantity{"Q", "", "N/mm", "; > 0 drags the rubber toward +x", s.Q},
                               Quantity{"slip_index", "", "", "S = Q / (mu P); NaN where mu P = 0", s.slip_index},
                               Quantity{"slip_distance", "", "mm", "", s.slip_distance}};
  const auto tactels = std::tuple{Quantity{"sigma_y", "tactels", "MPa", "; < 0 is compression", s.sigma_y},
                                  Quantity{"tau_xy", "tactels", "MPa", "; > 0 drags toward +x", s.tau_xy},
                                  Quantity{"converged", "", "", "1: within its tolerance", s.converged}};
  if constexpr (many) {
    return std::tuple_cat(path, tactels);
  } else {
    const auto surface =
        std::tuple{Quantity{"status", "surface", "", "0 open, 1 stick, 2 slip", s.status},
                   Quantity{"normal_force", "surface", "N/mm", "; >= 0 presses", s.normal_force},
                   Quantity{"tangential_force", "surface", "N/mm", "", s.tangential_force},
                   Quantity{"base_force_x", "base", "N/mm", ", of the rubber on the base", s.base_force_x},
                   Quantity{"base_force_y", "base", "N/mm", ", of the rubber on the base", s.base_force_y}};
    return std::tuple_cat(path, surface, tactels, solver_quantities(s));
  }
}

/// The same of a step of a pad.
template <bool many, class Step>
requires OfPad<Step>
auto quantities(Step& s) {
  const auto path = std::tuple{
      Quantity{"indentation", "", "mm", "", s.indentation},
      Quantity{"tangential", "2", "mm", " along x, y", tangential_of(s)},
      Quantity{"twist", "", "degrees", "", twist_of(s)},
      Quantity{"P", "", "N", ", of the indenter on the rubber", s.P},
      Quantity{"Q", "2", "N", " along x, y; > 0 drags the rubber toward +x, +y", s.Q},
      Quantity{"M", "", "N mm", " about the indenter's axis", s.M},
      Quantity{"slip_index", "", "", "S, 1 where the forces Q and the torque M can grow no more; NaN where mu P = 0",
               s.slip_index},
      Quantity{"force_ratio", "", "", "|Q| / (mu P); NaN where mu P = 0", s.force_ratio},
      Quantity{"stick_fraction", "", "", "cells that stick over those that touch", s.stick_fraction},
      Quantity{"slip_distance", "", "mm", "", s.slip_distance},
      Quantity{"sigma_z", "tactels", "MPa", "; < 0 is compression", sigma_z_of(s)},
      Quantity{"tau_x", "tactels", "MPa", "; > 0 drags toward +x", tau_x_of(s)},
      Quantity{"tau_y", "tactels", "MPa", "; > 0 drags toward +y", tau_y_of(s)}};
  const auto converged = std::tuple{Quantity{"converged", "", "", "1: within its tolerance", s.converged}};
  if constexpr (many) {
    return std::tuple_cat(path, converged);
  } else {
    const auto cells = std::tuple{Quantity{"status", "cells", "", "0 open, 1 stick, 2 slip", s.status},
                                  Quantity{"normal_force", "cells", "N", "; >= 0 presses", s.normal_force},
                                  Quantity{"tangential_force", "cells, 2", "N", " along x, y", s.tangential_force}};
    const auto markers = std::tuple{
        Quantity{"markers", "markers, 3", "mm", " along x, y, z: displacements of the scene's markers", s.markers},
        Quantity{"pixels", "markers, 2", "pixels", "; where the scene's camera sees them", s.pixels}};
    return std::tuple_cat(path, cells, markers, converged, solver_quantities(s));
  }
}

/// Returns the residuals of the contact laws of a line, in the order of their keys in answers.
template <class Residual>
requires requires(const Residual& r) { r.balance; }
auto residuals(Residual& r) {
  return std::tuple{Quantity{"penetration", "", "", "", r.penetration}, Quantity{"cone", "", "", "", r.cone},
                    Quantity{"complementarity", "", "", "", r.complementarity}, Quantity{"drift", "", "", "", r.drift},
                    Quantity{"balance", "", "", "", r.balance}};
}
/// The same of a pad.
template <class Residual>
requires requires(const Residual& r) { r.angle; }
auto residuals(Residual& r) {
  return std::tuple{Quantity{"penetration", "", "", "", r.penetration},
                    Quantity{"complementarity", "", "", "", r.complementarity}, Quantity{"cone", "", "", "", r.cone},
                    Quantity{"drift", "", "", "", r.drift}, Quantity{"angle", "", "", "", r.angle}};
}

}  // namespace tactel::host
