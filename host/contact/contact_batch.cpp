// SPDX-License-Identifier: Apache-2.0
#include "host/contact/contact_batch.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "fem/contact_laws.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/patch_layout.h"

namespace tactel::host {

ContactKind kind_of(const fem::Scene& scene) { return {.force = by_force(scene), .friction = scene.friction != 0}; }

std::optional<double> slip_index(double mu, double P, double kernel_index) {
  if (!fem::slip_index(mu, P, 0)) return std::nullopt;
  return mu < fem::largest_friction ? kernel_index : 0;
}

fem::ContactStep lane_step(const std::function<double(int)>& row, double mu) {
  const int status = static_cast<int>(row(LANE_STATUS));
  fem::ContactStep step;
  step.indentation = row(LANE_INDENTATION);
  step.tangential = row(LANE_TANGENTIAL);
  step.P = row(LANE_P);
  step.Q = row(LANE_Q);
  step.slip_index = slip_index(mu, step.P, row(LANE_SLIP_INDEX));
  step.slip_distance = row(LANE_SLIP_DISTANCE);
  step.converged = status == LANE_SOLVED || status == LANE_SLIDING;
  step.iterations = static_cast<int>(row(LANE_SWEEPS));
  step.residual = {row(LANE_PENETRATION), row(LANE_CONE), row(LANE_COMPLEMENTARITY), row(LANE_DRIFT),
                   row(LANE_BALANCE)};
  return step;
}

double LaneAnswer::element() const {
  return patch_.from ? patch(PATCH_ELEMENT) : sensor->length / (sensor->columns - 1);
}

bool LaneAnswer::solved() const {
  for (int k = 0; k < steps; ++k) {
    const int status = static_cast<int>(result(k, LANE_STATUS));
    if (status == LANE_UNSOLVED || status == LANE_INVALID) return false;
    if (status == LANE_NOT_RUN) break;
  }
  return true;
}

template <class Real>
void LaneScenes<Real>::begin(const fem::Scene& scene, const fem::LoadPath& path, std::size_t increments) {
  if (scenes.empty()) kind = kind_of(scene);
  if (kind_of(scene) != kind) throw std::invalid_argument("scenes of different kinds in one batch");
  const std::size_t at = scenes.empty() ? 0 : scenes.back().targets_at + scenes.back().increments;
  scenes.push_back({.steps = static_cast<int>(path.steps.size()),
                    .indentation_steps = path.indentation_steps,
                    .increments = static_cast<int>(increments),
                    .friction = scene.friction,
                    .young = scene.sensor.young,
                    .position = scene.indenter.position,
                    .targets_at = at});
}

template <class Real>
void ContactBatch<Real>::State::lay_out(Executor& on, LaneScenes<Real>&& from, std::vector<std::size_t> lane_order,
                                        std::size_t lanes_of_group, std::size_t interleaved, std::size_t input_rows,
                                        std::size_t rows_of_increment) {
  executor = &on;
  scenes = std::move(from.scenes), sensors = std::move(from.sensors);
  order = std::move(lane_order), path_rows = rows_of_increment;
  place.resize(order.size());
  for (std::size_t lane = 0; lane < order.size(); ++lane) place[order[lane]] = lane;
  for (const auto& scene : scenes) {
    steps = std::max(steps, scene.steps);
    increments = std::max(increments, scene.increments);
  }
  const std::size_t tile = lanes_of_group * interleaved;
  groups = (scenes.size() + lanes_of_group - 1) / lanes_of_group;
  lanes = (scenes.size() + tile - 1) / tile * tile;
  input = {device(), lanes, tile, input_rows};
  path = {device(), lanes, tile, static_cast<std::size_t>(increments) * path_rows};
  const auto in = input.numbers.map(MapFor::writing), targets = path.numbers.map(MapFor::writing);
  std::fill(in.view().begin(), in.view().end(), Real(0));  // lanes without a scene run no step
  std::fill(targets.view().begin(), targets.view().end(), Real(0));
  for (std::size_t lane = 0; lane < order.size(); ++lane) {  // in the order of lanes, for the memory's sake
    const auto& scene = scenes[order[lane]];
    input.put(in.view(), lane, std::span(from.inputs).subspan(order[lane] * input_rows, input_rows));
    path.put(targets.view(), lane,
             std::span(from.targets).subspan(scene.targets_at * path_rows, scene.increments * path_rows));
  }
}

template <class Real>
void ContactBatch<Real>::run(const RunOptions& options) {
  state_->seconds = state_->executor->run(state_->launch, state_->groups, options).seconds;
}

template <class Real>
std::size_t ContactBatch<Real>::size() const {
  return state_->scenes.size();
}

template <class Real>
int ContactBatch<Real>::steps() const {
  return state_->steps;
}

template <class Real>
std::size_t ContactBatch<Real>::steps_in_all() const {
  const auto& scenes = state_->scenes;
  return std::accumulate(scenes.begin(), scenes.end(), std::size_t{0}, [](std::size_t sum, const auto& scene) {
    return sum + static_cast<std::size_t>(scene.steps);
  });
}

template <class Real>
double ContactBatch<Real>::seconds() const {
  return state_->seconds;
}

template <class Real>
void ContactBatch<Real>::fill_outputs(Real value) {
  for (const auto* array : {&state_->results, &state_->outputs, &state_->forces, &state_->patches}) {
    const auto mapped = array->numbers.map(MapFor::writing);
    std::fill(mapped.view().begin(), mapped.view().end(), value);
  }
}

template <class Real>
void ContactBatch<Real>::fill_unused(Real value) {
  const State& b = *state_;
  const auto fill = [&](const LaneArray<Real>& array, const auto& used_rows) {
    const auto mapped = array.numbers.map(MapFor::both);
    for (std::size_t lane = 0; lane < b.lanes; ++lane)
      for (std::size_t row = used_rows(lane); row < array.rows; ++row) mapped[array.at(lane, row)] = value;
  };
  fill(b.path, [&](std::size_t lane) {
    return lane < b.order.size() ? static_cast<std::size_t>(b.scenes[b.order[lane]].increments) * b.path_rows : 0;
  });
  const auto all_or_none = [&](const LaneArray<Real>& array) {
    fill(array, [&](std::size_t lane) { return lane < b.order.size() ? array.rows : 0; });
  };
  all_or_none(b.input);
  for (const auto& array : b.more_inputs) all_or_none(array);
}

namespace {

template <class Real>
double one_number(const LaneArray<Real>& array, std::size_t lane, std::size_t row) {
  Real value;
  array.numbers.read(std::span(&value, 1), array.at(lane, row));
  return value;
}

/// Row of number `row` of a load step.
std::size_t row_of(int step, std::size_t rows, int row) {
  return static_cast<std::size_t>(step) * rows + static_cast<std::size_t>(row);
}

}  // namespace

template <class Real>
fem::ContactSolution ContactBatch<Real>::solution(std::size_t i) const {
  return View(*this).solution(i);
}

template <class Real>
double ContactBatch<Real>::result(std::size_t i, int step, int row) const {
  return one_number(state_->results, state_->place[i], row_of(step, state_->result_rows, row));
}

template <class Real>
double ContactBatch<Real>::output(std::size_t i, int step, int row) const {
  return one_number(state_->outputs, state_->place[i], row_of(step, state_->output_rows, row));
}

template <class Real>
double ContactBatch<Real>::patch(std::size_t i, int row) const {
  return one_number(state_->patches, state_->place[i], static_cast<std::size_t>(row));
}

template <class Real>
ContactBatch<Real>::View::View(const ContactBatch& batch)
    : state_(batch.state_),
      results_(state_->results.numbers.map(MapFor::reading)),
      outputs_(state_->outputs.numbers.map(MapFor::reading)),
      forces_(state_->forces.numbers.map(MapFor::reading)),
      patches_(state_->patches.numbers.map(MapFor::reading)) {}

template <class Real>
Real ContactBatch<Real>::View::result(std::size_t i, int step, int row) const {
  return results_[state_->results.at(state_->place[i], row_of(step, state_->result_rows, row))];
}

template <class Real>
Real ContactBatch<Real>::View::output(std::size_t i, int step, int row) const {
  return outputs_[state_->outputs.at(state_->place[i], row_of(step, state_->output_rows, row))];
}

template <class Real>
Real ContactBatch<Real>::View::force(std::size_t i, int step, int row) const {
  return forces_[state_->forces.at(state_->place[i], row_of(step, state_->force_rows, row))];
}

template <class Real>
Real ContactBatch<Real>::View::patch(std::size_t i, int row) const {
  return patches_[state_->patches.at(state_->place[i], static_cast<std::size_t>(row))];
}

template <class Real>
LaneAnswer ContactBatch<Real>::View::answer(std::size_t i) const {
  const State& b = *state_;
  const std::size_t lane = b.place[i];
  LaneAnswer answer;
  answer.steps = b.scenes[i].steps, answer.indentation_steps = b.scenes[i].indentation_steps;
  answer.sensor = &b.sensor(i);
  answer.stride = interleaved();
  answer.fp64_ = sizeof(Real) == sizeof(double);
  answer.results_ = {&results_[b.results.at(lane, 0)], b.result_rows};
  answer.stresses_ = {outputs_.view().data() + b.outputs.at(lane, b.stresses_from), b.output_rows};
  if (b.patches.rows > 0) answer.patch_ = {&patches_[b.patches.at(lane, 0)], b.patches.rows};
  return answer;
}

template <class Real>
std::size_t ContactBatch<Real>::View::interleaved() const {
  return state_->results.tile;
}

template <class Real>
int ContactBatch<Real>::View::path_steps(std::size_t i) const {
  return state_->scenes[i].steps;
}

template <class Real>
int ContactBatch<Real>::View::indentation_steps(std::size_t i) const {
  return state_->scenes[i].indentation_steps;
}

template <class Real>
std::span<const std::size_t> ContactBatch<Real>::View::by_lane() const {
  return state_->order;
}

template <class Real>
fem::ContactSolution ContactBatch<Real>::View::solution(std::size_t i) const {
  return state_->solution(*this, i);
}

template struct LaneScenes<float>;
template struct LaneScenes<double>;
template class ContactBatch<float>;
template class ContactBatch<double>;

}  // namespace tactel::host
