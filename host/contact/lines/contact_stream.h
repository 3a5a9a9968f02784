// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "host/contact/contact_model.h"
#include "host/contact/stream_of.h"

namespace tactel::host {

/// Contacts of the line, on patches or meshes, for a stream. A contact that no patch solves is solved on the mesh of
/// its rung, with its own load steps; such answers have no surface_width.
class LineContacts {
 public:
  using Scene = fem::Scene;
  using Sensor = fem::Sensor;
  using Path = fem::LoadPath;
  using Solution = fem::ContactSolution;
  using Model = ContactModel;
  using Key = LaunchKey;

  LineContacts(Executor& executor, ContactModel model);
  Key key(const Sensor& sensor, ContactKind kind) const;
  Key key(const Scene& scene) const { return key(scene.sensor, kind_of(scene)); }
  static Path path(const Scene& scene) { return fem::load_path(scene.load); }
  std::shared_ptr<const SensorSolver<LineContacts>> solver(const Sensor& sensor) const;
  /// Solves what the solvers of sensors left unsolved.
  void finish(std::span<const Scene> scenes, std::vector<Solution>& solutions) const;
  static std::vector<std::size_t> coarse(const Scene&, const LaneAnswer&) { return {}; }
  static Scene alone(const Scene& scene, std::size_t) { return scene; }

 private:
  const PatchModel* patch() const { return std::get_if<PatchModel>(&model_.surface); }
  Executor& executor_;
  ContactModel model_;
  std::shared_ptr<const StreamOf<LineContacts>> behind_;
};

static_assert(Contacts<LineContacts>);

/// The stream of contacts of the line.
using ContactStream = StreamOf<LineContacts>;
extern template class StreamOf<LineContacts>;

}  // namespace tactel::host
