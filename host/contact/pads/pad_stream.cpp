// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_stream.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "host/contact/limits.h"
#include "host/contact/pads/pad_contact_tables.h"
#include "host/support/side_by_side.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

constexpr double exact_tolerance = 1e-6;
constexpr int finest_cells = 24;

bool any(const std::array<bool, 4>& sides) { return std::ranges::find(sides, true) != sides.end(); }

template <class Real>
class OnPads final : public SensorSolver<PadContacts> {
 public:
  explicit OnPads(const PadContact<Real>& contact) : contact_(contact) {}
  std::unique_ptr<ContactLaunch<PadContacts>> launch() const override {
    return std::make_unique<LaunchOf<PadContacts, PadContact<Real>>>(contact_);
  }
  bool holds(const LaneAnswer& answer) const override { return answer.solved() && !any(penetrated_sides(answer)); }
  std::vector<fem::PadSolution> solve(std::span<const fem::PadScene> scenes,
                                      std::span<const LaneAnswer>) const override {
    return solve_pad_contact(contact_, scenes);
  }

 private:
  PadContact<Real> contact_;
};

/// Solves by the twin what the kernel did not.
template <class Real>
fem::PadSolution by_twin(const PadContact<Real>& contact, const fem::PadScene& scene) {
  const bool own_layer = free_block(scene.sensor)[0] > 0 || scene.indenter.young;
  const auto layer = own_layer ? std::make_shared<const fem::PadLayer>(fem::pad_layer(scene))
                               : contact.layer(fem::rubber(scene.sensor));
  fem::PadOptions exact = contact.options();
  exact.tolerance = std::min(exact_tolerance, exact.tolerance);
  exact.most_sweeps = fem::PadOptions{}.most_sweeps, exact.most_growths = fem::PadOptions{}.most_growths;
  exact.between_sweeps = StopScope::checker();
  fem::PadSolution solution = fem::PadSolver(*layer, exact).solve(scene);
  if (!every_step_converged(solution) && exact.cells < finest_cells) {
    exact.cells = finest_cells, exact.whole_path = false;
    fem::PadSolution finer = fem::PadSolver(*layer, exact).solve(scene);
    if (every_step_converged(finer)) solution = std::move(finer);
  }
  fem::see_markers(scene, solution, StopScope::checker());
  solution.fell_back = true;
  return solution;
}

/// Solves coarse steps of the pressing alone.
template <class Real>
void solve_presses_alone(const PadContact<Real>& contact, std::span<const fem::PadScene> scenes,
                         std::vector<fem::PadSolution>& solutions) {
  std::vector<fem::PadScene> alone;
  std::vector<std::pair<std::size_t, std::size_t>> steps;  // scene, step
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (const std::size_t k : fem::coarse_presses(scenes[i], solutions[i])) {
      alone.push_back(fem::pressed_alone(scenes[i], k));
      steps.emplace_back(i, k);
    }
  if (alone.empty()) return;
  const std::vector<fem::PadSolution> found = solve_pad_contact(contact, std::span<const fem::PadScene>(alone));
  for (std::size_t a = 0; a < alone.size(); ++a) {
    const auto [i, k] = steps[a];
    fem::take_alone(solutions[i], k, found[a]);
    solutions[i].fell_back |= found[a].fell_back;
  }
}

}  // namespace

PadModel model_of(const PadRung& rung) {
  return {.options = {.cells = rung.cells, .pressing_increments = rung.increments}};
}

PadContacts::PadContacts(Executor& executor, const PadModel& model)
    : contact_(model.precision == Precision::fp32 ? decltype(contact_)(PadContact<float>(executor, model.options))
                                                  : decltype(contact_)(PadContact<double>(executor, model.options))) {}

PadKey PadContacts::key(const fem::PadSensor& sensor, ContactKind) {
  return {{tactels_of(sensor), free_block(sensor)}};
}

PadKey PadContacts::key(const fem::PadScene& scene) {
  PadKey key = PadContacts::key(scene.sensor, {});
  if (scene.markers) key.markers = {marker_depth(scene), fem::marker_places(*scene.markers)};
  key.mapped = scene.friction_map.has_value(), key.creep_terms = scene.sensor.relaxation.size();
  return key;
}

std::shared_ptr<const SensorSolver<PadContacts>> PadContacts::solver(const fem::PadSensor& sensor) const {
  return std::visit(
      [&]<class Real>(const PadContact<Real>& contact) -> std::shared_ptr<const SensorSolver<PadContacts>> {
        if (!fem::sides_at(sensor, {0, 0}, fem::SideBricks::usual, StopScope::checker()).free())
          contact.layer(fem::rubber(sensor));
        const std::array block = free_block(sensor);
        const bool is_long = std::max(block[0], block[1]) > fem::longest_block * sensor.thickness;
        return std::make_shared<OnPads<Real>>(is_long ? contact.for_long_pads() : contact);
      },
      contact_);
}

std::vector<std::size_t> PadContacts::coarse(const fem::PadScene& scene, const LaneAnswer& answer) const {
  const int cells = std::visit([](const auto& contact) { return contact.options().cells; }, contact_);
  return fem::coarse_presses(scene.load, cells, [&](std::size_t k) {
    return static_cast<int>(answer.result(static_cast<int>(k), PAD_RESULT_ACROSS));
  });
}

bool every_step_converged(const fem::PadSolution& solution) {
  return std::ranges::all_of(solution.steps, &fem::PadStep::converged);
}

template <class Real>
std::vector<fem::PadSolution> solve_pad_contact(const PadContact<Real>& contact, std::span<const fem::PadScene> scenes,
                                                std::span<const fem::PadCells> cells) {
  const fem::PadOptions& options = contact.options();
  std::vector<fem::PadSolution> solutions(scenes.size());
  std::span<const fem::PadScene> now = scenes;
  std::vector<fem::PadScene> again;
  std::vector<fem::PadCells> laid(cells.begin(), cells.end());
  std::vector<std::size_t> which(scenes.size());
  std::iota(which.begin(), which.end(), 0);
  std::vector<char> solvable(scenes.size(), 1);
  for (int growths = 0; !now.empty(); ++growths) {
    auto batch = contact.prepare(now, laid);
    batch.run();
    const LaneView<Real> view(batch);
    again.clear(), laid.clear();
    std::vector<std::size_t> others;
    for (std::size_t k = 0; k < which.size(); ++k) {
      fem::PadSolution& solution = solutions[which[k]] = batch.solution(view, k);
      solvable[which[k]] = static_cast<int>(view.answer(k).result(0, RESULT_STATUS)) != LANE_INVALID;
      if (!any(solution.outside) || growths == options.most_growths) continue;
      others.push_back(which[k]);
      again.push_back(batch.scene(k));
      laid.push_back(fem::grown(batch.cells(k), solution.outside, batch.scene(k), options.ladder));
    }
    which = std::move(others), now = again;
  }
  std::vector<std::size_t> unsolved;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    if (solvable[i] && !every_step_converged(solutions[i])) unsolved.push_back(i);
  side_by_side(unsolved.size(), contact.executor().threads(),
               [&](std::size_t k) { solutions[unsolved[k]] = by_twin(contact, scenes[unsolved[k]]); });
  if (cells.empty()) solve_presses_alone(contact, scenes, solutions);
  return solutions;
}

template class StreamOf<PadContacts>;
template std::vector<fem::PadSolution> solve_pad_contact(const PadContact<float>&, std::span<const fem::PadScene>,
                                                         std::span<const fem::PadCells>);
template std::vector<fem::PadSolution> solve_pad_contact(const PadContact<double>&, std::span<const fem::PadScene>,
                                                         std::span<const fem::PadCells>);

}  // namespace tactel::host
