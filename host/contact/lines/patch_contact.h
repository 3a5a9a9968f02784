// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/layer/layer_model.h"
#include "fem/layer/patch_contact.h"
#include "fem/layer/sensor_family.h"
#include "fem/scenes/scene.h"
#include "host/contact/contact_batch.h"
#include "host/contact/lines/patch_contact_lanes.h"
#include "host/device/executor.h"

namespace tactel::host {

/// Contact of scenes that share a sensor, or whose sensors are of one family, each on its own patch of equal elements
/// over what its indenter touches (kernels/patch_contact.cl). Tables and programs for one precision. Cheap to copy.
template <class Real>
class PatchContact {
  struct State;

 public:
  using Batch = ContactBatch<Real>;
  /// Throws ValueError for a number of elements that has no program.
  PatchContact(Executor& executor, const fem::LayerModel& model, const fem::PatchOptions& options = {});
  /// The same for scenes each with its own sensor of this family.
  PatchContact(Executor& executor, const fem::SensorFamily& family, const fem::PatchOptions& options = {});

  /// The contact that the patch of a scene must cover; none: the kernel searches it.
  using Given = std::optional<PatchContactExtent>;

  /// Scenes of this sensor (E may differ), or of sensors of the family, on their way into a batch.
  class Scenes : public LaneScenes<Real> {
   public:
    explicit Scenes(const PatchContact& contact) : contact_(contact.state_) {}
    /// `path`: load_path(scene.load). Throws std::invalid_argument where the ContactKind is not that of the first,
    /// ValueError for a sensor outside the family.
    void push_back(const fem::Scene& scene, const fem::LoadPath& path, const Given& given = {});

   private:
    friend class PatchContact;
    struct Cost {
      std::int64_t kin = 0;  ///< scenes with the same number cost alike
      double width = 0;      ///< mm, of the rigid profile at the largest depth
    };
    std::vector<std::size_t> by_cost() const;  ///< scene in a lane
    std::shared_ptr<State> contact_;
    std::vector<Cost> costs_;  ///< [scenes]
    std::vector<Real> shapes_;
  };

  /// `given`: [scenes], or empty for none. Throws std::invalid_argument where scenes differ in kind, ValueError for a
  /// sensor outside the family.
  Batch prepare(std::span<const fem::Scene> scenes, std::span<const Given> given = {}) const;
  /// Without `forces` the kernel writes no forces of elements, and the batch has no solution(). Node forces of a
  /// solution are those of the elements of its patch, surface_x their middles; base forces are not known.
  Batch prepare(Scenes scenes, bool forces = true) const;
  /// What runs of a batch compute from now on: with `path` the load path, with `base_stress` also the stresses at the
  /// tactels. The patch and its compliance are always computed. Benchmarks time the parts with it.
  static void set_parts(Batch& batch, bool path, bool base_stress);
  /// Returns the tables of this sensor: those of all scenes, or made from the family's.
  std::shared_ptr<const fem::LayerModel> model_of(const fem::Sensor& sensor) const;
  const fem::PatchOptions& options() const;

 private:
  std::shared_ptr<State> state_;
};

extern template class PatchContact<float>;
extern template class PatchContact<double>;

}  // namespace tactel::host
