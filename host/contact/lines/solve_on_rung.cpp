// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/solve_on_rung.h"

#include "host/contact/lines/contact_stream.h"

namespace tactel::host {

std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, std::span<const fem::Scene> scenes,
                                                const Rung& rung, bool nodes,
                                                std::shared_ptr<const fem::SensorFamily> family) {
  ContactModel model = model_of(rung);
  if (rung.patch()) {
    if (!rung.exact) std::get<PatchModel>(model.surface).family = std::move(family);
    return ContactStream(executor, std::move(model)).solve(scenes);
  }
  std::get<MeshModel>(model.surface).options.nodes = nodes;
  std::vector<fem::Scene> meshed;
  for (const fem::Scene& scene : scenes) meshed.push_back(on_mesh(scene, rung));
  return ContactStream(executor, std::move(model)).solve(meshed);
}

std::vector<fem::ContactSolution> solve_on_meshes(Executor& executor, std::span<const fem::Scene> scenes,
                                                  Precision precision, const GapSweepOptions& options) {
  return ContactStream(executor, {MeshModel{options}, precision}).solve(scenes);
}

}  // namespace tactel::host
