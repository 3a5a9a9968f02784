#include "host/paper_sets.h"

#include <fmt/format.h>

#include "host/gap_sweep.h"
#include "host/scene_file.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

void add(SceneFamily& family, const fem::Scene& base, const fem::Shape& shape, std::uint16_t kind) {
  fem::Scene scene = base;
  scene.indenter.shape = shape;
  scene.validate();
  family.scenes.push_back(std::move(scene));
  family.kind.push_back(kind);
}

std::string sum_of_powers(const std::vector<int>& powers) {
  if (powers.empty()) return "0";
  std::string text;
  for (int k : powers) text += fmt::format("{}x{}", text.empty() ? "" : " + ", k == 1 ? "" : fmt::format("^{}", k));
  return text;
}

void add_row(ContactSet& set, const fem::ContactStep& step, const fem::Scene& scene, std::size_t contact,
             std::size_t index, std::uint16_t kind) {
  for (double value : step.sigma_y) set.frames.push_back(static_cast<float>(value));
  for (double value : step.tau_xy) set.frames.push_back(static_cast<float>(value));
  const auto sticking = std::count(step.status.begin(), step.status.end(), fem::GapStatus::stick);
  const auto slipping = std::count(step.status.begin(), step.status.end(), fem::GapStatus::slip);
  const fem::Residual& r = step.residual;
  set.slip_index.push_back(static_cast<float>(*step.slip_index));
  set.normal_force.push_back(static_cast<float>(step.P));
  set.tangential_force.push_back(static_cast<float>(step.Q));
  set.friction.push_back(static_cast<float>(scene.friction));
  set.stick_fraction.push_back(static_cast<float>(sticking) / static_cast<float>(sticking + slipping));
  set.contact_nodes.push_back(static_cast<std::uint16_t>(sticking + slipping));
  set.contact.push_back(contact);
  set.step.push_back(static_cast<std::uint32_t>(index));
  set.indenter.push_back(kind);
  set.status.push_back(!step.converged ? LANE_UNSOLVED : sticking ? LANE_SOLVED : LANE_SLIDING);
  set.residual.push_back(static_cast<float>(std::max({r.penetration, r.cone, r.complementarity, r.drift, r.balance})));
}

}  // namespace

SceneFamily paper_learning_family(const fem::Scene& base, double scale, double height) {
  SceneFamily family;
  for (unsigned subset = 0; subset < 32; ++subset) {
    std::vector<int> powers;
    for (int k = 1; k <= 5; ++k)
      if (subset >> (k - 1) & 1u) powers.push_back(k);
    family.kind_names.push_back(sum_of_powers(powers));
    add(family, base, fem::Taylor{powers, scale, height}, static_cast<std::uint16_t>(subset));
  }
  return family;
}

SceneFamily paper_recall_family(const fem::Scene& base) {
  SceneFamily family;
  family.kind_names = {"flat",        "triangular",           "parabolic", "spherical", "exponential",
                       "trapezoidal", "flat, parabolic edges"};
  for (double half_width : {2.0, 3.0, 4.0, 5.0}) add(family, base, fem::Flat{half_width}, 0);
  for (double edge_angle : {120.0, 140.0, 160.0, 170.0}) add(family, base, fem::Wedge{edge_angle}, 1);
  for (double radius : {5.0, 10.0, 20.0, 40.0}) add(family, base, fem::Parabola{radius}, 2);
  for (double radius : {7.0, 15.0, 30.0, 60.0}) add(family, base, fem::Cylinder{radius}, 3);
  for (double rate : {0.25, 0.5, 1.0, 2.0}) add(family, base, fem::Exponential{0.1, rate}, 4);
  for (double half_width : {1.0, 2.0, 3.0, 4.0}) add(family, base, fem::Trapezoid{half_width, 0.5}, 5);
  for (double half_width : {1.0, 2.0, 3.0, 4.0}) add(family, base, fem::RoundedFlat{half_width, 10.0}, 6);
  return family;
}

fem::Scene paper_set_scene() {
  fem::Scene scene = paper_preset();
  scene.load.tangential_step = 0.05;
  scene.load.tangential_steps.reset();
  return scene;
}

ContactSet simulate_family(Executor& executor, const SceneFamily& family, Precision precision, double tolerance) {
  GapSweepOptions options;
  options.tolerance = tolerance;
  const auto solutions = solve_gap_sweep(executor, family.scenes, precision, options);
  ContactSet set;
  set.inputs = 2 * family.scenes.front().sensor.tactels;
  set.indenter_names = family.kind_names;
  set.device = executor.device().info().name;
  for (std::size_t i = 0; i < solutions.size(); ++i) {
    const fem::Scene& scene = family.scenes[i];
    const auto& steps = solutions[i].steps;
    set.fell_back += solutions[i].fell_back;
    set.unsolved += !steps.back().converged;
    for (std::size_t k = fem::load_path(scene.load).indentation_steps - 1; k < steps.size(); ++k)
      if (steps[k].slip_index) add_row(set, steps[k], scene, i, k, family.kind[i]);
  }
  return set;
}

}  // namespace tactel::host
