// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/contact_stream.h"

#include <map>
#include <mutex>

#include "fem/gap/load_stepping.h"
#include "fem/layer/layer_model.h"
#include "fem/layer/patch_reference.h"
#include "host/contact/lines/contact_fallback.h"
#include "host/support/side_by_side.h"

namespace tactel::host {
namespace {

using Launch = ContactLaunch<LineContacts>;
using Solver = SensorSolver<LineContacts>;
using Solutions = std::vector<fem::ContactSolution>;

template <class Real>
class OnPatches final : public Solver {
 public:
  explicit OnPatches(PatchContact<Real> contact) : contact_(std::move(contact)) {}
  std::unique_ptr<Launch> launch() const override {
    return std::make_unique<LaunchOf<LineContacts, PatchContact<Real>>>(contact_);
  }
  bool holds(const LaneAnswer& answer) const override { return certificate(answer).holds(); }
  Solutions solve(std::span<const fem::Scene> scenes, std::span<const LaneAnswer> known) const override {
    std::vector<PatchCertificate> said;
    for (const LaneAnswer& answer : known) said.push_back(certificate(answer));
    return solve_patch_contact(contact_, scenes, std::move(said));
  }

 private:
  PatchCertificate certificate(const LaneAnswer& answer) const {
    return patch_certificate(answer, contact_.options().elements);
  }
  PatchContact<Real> contact_;
};

/// Launches write stresses at the tactels and sums of base forces; solutions have all forces.
template <class Real>
class OnMesh final : public Solver {
 public:
  OnMesh(Executor& executor, const fem::Sensor& sensor, const GapSweepOptions& options)
      : executor_(executor), sensor_(sensor), options_(options) {}
  std::unique_ptr<Launch> launch() const override {
    GapSweepOptions options = options_;
    options.nodes = options.base_forces = false, options.base_sums = true;
    return std::make_unique<LaunchOf<LineContacts, GapSweep<Real>>>(sweep(lanes_, options));
  }
  bool holds(const LaneAnswer& answer) const override { return answer.solved(); }
  Solutions solve(std::span<const fem::Scene> scenes, std::span<const LaneAnswer>) const override {
    return solve_gap_sweep(sweep(forces_, options_), scenes);
  }

 private:
  const GapSweep<Real>& sweep(std::optional<GapSweep<Real>>& made, const GapSweepOptions& options) const {
    const std::lock_guard lock(making_);
    if (!made) made.emplace(executor_, sensor_, options);
    return *made;
  }
  Executor& executor_;
  fem::Sensor sensor_;
  GapSweepOptions options_;
  mutable std::mutex making_;  ///< of the next two
  mutable std::optional<GapSweep<Real>> lanes_, forces_;
};

/// The reference of patches, for scenes of any sensors.
class OnManyElements final : public Solver {
 public:
  OnManyElements(Executor& executor, const fem::PatchOptions& options) : executor_(executor), options_(options) {}
  std::unique_ptr<Launch> launch() const override { throw std::logic_error("the reference launches no kernel"); }
  bool holds(const LaneAnswer&) const override { return false; }
  Solutions solve(std::span<const fem::Scene> scenes, std::span<const LaneAnswer>) const override {
    std::map<LaunchKey, std::size_t> places;
    std::vector<std::size_t> sensor_of;  // [scenes]
    std::vector<const fem::Sensor*> sensors;
    for (const fem::Scene& scene : scenes) {
      const auto [place, is_new] = places.try_emplace(launch_key(scene.sensor, {}, false), sensors.size());
      if (is_new) sensors.push_back(&scene.sensor);
      sensor_of.push_back(place->second);
    }
    std::vector<std::optional<fem::LayerModel>> models(sensors.size());
    side_by_side(sensors.size(), executor_.threads(),
                 [&](std::size_t k) { models[k] = fem::layer_model(*sensors[k]); });
    Solutions solutions(scenes.size());
    side_by_side(scenes.size(), executor_.threads(),
                 [&](std::size_t i) { solutions[i] = solve_one(*models[sensor_of[i]], scenes[i]); });
    return solutions;
  }

 private:
  /// With much friction near nu = 1/2, many elements may have no solution that meets the tolerance where fewer have
  /// one.
  fem::ContactSolution solve_one(const fem::LayerModel& model, const fem::Scene& scene) const {
    fem::ContactSolution answer;
    for (const int share : {1, 2, 4}) {
      fem::PatchOptions reference = options_;
      reference.elements /= share;
      answer = fem::PatchReference(model, reference).solve(scene);
      if (every_step_converged(answer)) break;
    }
    return answer;
  }
  Executor& executor_;
  fem::PatchOptions options_;
};

template <class Real>
std::shared_ptr<const Solver> solver_on(Executor& executor, const fem::Sensor& sensor, const ContactModel& model) {
  if (const auto* mesh = std::get_if<MeshModel>(&model.surface))
    return std::make_shared<OnMesh<Real>>(executor, sensor, mesh->options);
  const PatchModel& patch = std::get<PatchModel>(model.surface);
  const fem::PatchOptions& options = patch.options;
  if (patch.family) return std::make_shared<OnPatches<Real>>(PatchContact<Real>(executor, *patch.family, options));
  return std::make_shared<OnPatches<Real>>(
      PatchContact<Real>(executor, patch.sides ? fem::layer_model(sensor) : fem::endless_layer(sensor), options));
}

}  // namespace

LineContacts::LineContacts(Executor& executor, ContactModel model) : executor_(executor), model_(std::move(model)) {
  if (patch() && patch()->behind && !patch()->family)
    behind_ = std::make_shared<ContactStream>(executor_, ContactModel{MeshModel{patch()->mesh}, model_.precision});
}

LaunchKey LineContacts::key(const fem::Sensor& sensor, ContactKind kind) const {
  if (patch() && patch()->exact) return {};
  if (patch() && patch()->family) return {{}, kind};
  return launch_key(sensor, kind, patch() == nullptr);
}

std::shared_ptr<const Solver> LineContacts::solver(const fem::Sensor& sensor) const {
  if (patch() && patch()->exact) return std::make_shared<OnManyElements>(executor_, patch()->options);
  return in_precision(model_.precision, [&]<class Real>() { return solver_on<Real>(executor_, sensor, model_); });
}

void LineContacts::finish(std::span<const fem::Scene> scenes, Solutions& solutions) const {
  if (!behind_) return;
  const Rung& rung = *patch()->behind;
  std::vector<fem::Scene> meshed;
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (every_step_converged(solutions[i]) || scenes[i].sensor.poisson == 0.5) continue;  // which no mesh takes
    others.push_back(i);
    meshed.push_back(on_mesh(scenes[i], rung));
    meshed.back().load.indentation_steps =
        scenes[i].load.indentation_steps * fem::pressing_parts(scenes[i].load, rung.steps);
  }
  Solutions found = behind_->solve(meshed);
  for (std::size_t k = 0; k < others.size(); ++k) {
    const fem::Load& load = scenes[others[k]].load;
    fem::keep_own_steps(found[k], load, fem::pressing_parts(load, rung.steps));
    if (every_step_converged(found[k])) solutions[others[k]] = std::move(found[k]);
  }
}

template class StreamOf<LineContacts>;

}  // namespace tactel::host
