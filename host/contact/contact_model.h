// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <compare>
#include <memory>
#include <optional>
#include <tuple>
#include <variant>

#include "fem/layer/sensor_family.h"
#include "fem/scenes/scene.h"
#include "host/contact/contact_batch.h"
#include "host/contact/lines/gap_sweep.h"
#include "host/contact/lines/patch_contact.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

/// Contacts on patches over what their indenters touch.
struct PatchModel {
  fem::PatchOptions options{};
  bool exact = false;                                    ///< by the reference of patches, fp64, without a device
  bool sides = true;                                     ///< with the sensor's free sides
  std::optional<Rung> behind{};                          ///< whose mesh solves what no patch solves; none: nothing does
  GapSweepOptions mesh{};                                ///< of that mesh
  std::shared_ptr<const fem::SensorFamily> family = {};  ///< where each contact has its own sensor, of this family
};

/// Contacts on the meshes of their sensors.
struct MeshModel {
  GapSweepOptions options{};
};

/// How contacts are solved.
struct ContactModel {
  std::variant<PatchModel, MeshModel> surface;
  Precision precision = Precision::fp32;
};
ContactModel model_of(const Rung& rung);

/// What scenes of one launch have in common: the sensor but for E, of patches also but for its mesh, and the kind.
struct LaunchKey {
  std::tuple<double, double, double, int, double, double, int, int, double, fem::Element, fem::StressRecovery,
             std::vector<RubberLayer>>
      sensor{};
  ContactKind kind{};
  auto operator<=>(const LaunchKey&) const = default;
};
LaunchKey launch_key(const fem::Sensor& sensor, ContactKind kind, bool on_mesh);

}  // namespace tactel::host
