// SPDX-License-Identifier: Apache-2.0
#include "host/contact/contact_model.h"

namespace tactel::host {

ContactModel model_of(const Rung& rung) {
  const GapSweepOptions mesh{.tolerance = rung.tolerance, .accept = rung.accept};
  if (!rung.patch()) return {MeshModel{mesh}, rung.precision};
  PatchModel patch{.exact = rung.exact, .sides = rung.sides, .behind = rung, .mesh = mesh};
  patch.options.elements = rung.elements, patch.options.pressing_increments = rung.steps;
  patch.options.tolerance = rung.tolerance, patch.options.accept = rung.accept;
  return {std::move(patch), rung.precision};
}

LaunchKey launch_key(const fem::Sensor& s, ContactKind kind, bool on_mesh) {
  const fem::Sensor mesh = on_mesh ? s : fem::Sensor{};
  return {{s.length, s.thickness, s.poisson, s.tactels, s.tactel_span.value_or(-1), s.tactel_width, mesh.columns,
           mesh.rows, mesh.grading, mesh.element, mesh.stress, s.layers},
          kind};
}

}  // namespace tactel::host
