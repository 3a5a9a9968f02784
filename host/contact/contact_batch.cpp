// SPDX-License-Identifier: Apache-2.0
#include "host/contact/contact_batch.h"

#include <algorithm>
#include <stdexcept>

#include "host/device/unwritten.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/patch_layout.h"

namespace tactel::host {

ContactKind kind_of(const fem::Scene& scene) { return {.force = by_force(scene), .friction = scene.friction != 0}; }

fem::ContactStep lane_step(const std::function<double(int)>& row, double mu) {
  auto step = step_of<fem::ContactStep>(row, mu);
  if (step.slip_index) step.slip_index = std::clamp(*step.slip_index, -1.0, 1.0);  // fp32 rounds beyond them
  step.tangential = row(LANE_TANGENTIAL), step.Q = row(LANE_Q), step.residual.balance = row(LANE_BALANCE);
  return step;
}

double LaneAnswer::element() const {
  return patch_.from ? patch(PATCH_ELEMENT) : sensor->length / (sensor->columns - 1);
}

bool LaneAnswer::solved() const {
  for (int k = 0; k < steps; ++k) {
    const int status = static_cast<int>(result(k, RESULT_STATUS));
    if (status == LANE_UNSOLVED || status == LANE_INVALID) return false;
    if (status == LANE_NOT_RUN) break;
  }
  return true;
}

template <class Real>
void LaneScenes<Real>::add(ContactKind scene_kind, One scene) {
  if (scenes.empty()) kind = scene_kind;
  if (scene_kind != kind) throw std::invalid_argument("scenes of different kinds in one batch");
  scene.targets_at = scenes.empty() ? 0 : scenes.back().targets_at + scenes.back().increments;
  scenes.push_back(scene);
}

template <class Real>
void LaneState<Real>::lay_out(Executor& on, LaneScenes<Real>&& from, std::span<const std::size_t> in_lane,
                              std::size_t lanes_of_group, std::size_t interleaved, std::size_t input_rows,
                              std::size_t path_rows) {
  executor = &on;
  scenes = std::move(from.scenes), sensors = std::move(from.sensors);
  order.reserve(scenes.size());
  place.resize(scenes.size());
  for (std::size_t lane = 0; lane < in_lane.size(); ++lane) {
    if (in_lane[lane] == no_scene) continue;
    order.push_back(in_lane[lane]);
    place[in_lane[lane]] = lane;
  }
  for (const auto& scene : scenes) {
    steps = std::max(steps, scene.steps);
    increments = std::max(increments, scene.increments);
  }
  const std::size_t tile = lanes_of_group * interleaved;
  groups = (in_lane.size() + lanes_of_group - 1) / lanes_of_group;
  lanes = (in_lane.size() + tile - 1) / tile * tile;
  input = array(tile, 1, input_rows, 0, [&](std::size_t i) {  // lanes without a scene run no step
    return std::span(from.inputs).subspan(i * input_rows, input_rows);
  });
  path = array(tile, static_cast<std::size_t>(increments), path_rows, 0, [&](std::size_t i) {
    return std::span(from.targets).subspan(scenes[i].targets_at * path_rows, scenes[i].increments * path_rows);
  });
}

namespace {

/// Stands in place of a status until the kernel has written it.
constexpr int unwritten = -1;

/// Calls of(status) for each step of each scene, until it returns false for one of a scene.
template <class Real, class Of>
void each_status(const LaneState<Real>& b, MapFor use, const Of& takes) {
  const auto mapped = b.results.numbers.map(use);
  for (const std::size_t i : b.order)
    for (int k = 0; k < b.scenes[i].steps; ++k)
      if (!takes(mapped[b.results.at(b.place[i], static_cast<std::size_t>(k), RESULT_STATUS)])) break;
}

}  // namespace

template <class Real>
void ContactBatch<Real>::run(const RunOptions& options) {
  LaneState<Real>& b = *state_;
  b.seconds = 0;
  each_status(b, MapFor::writing, [](Real& status) { return status = unwritten, true; });
  const std::shared_ptr<const void> borrowed = b.borrow ? b.borrow() : nullptr;
  for (const std::vector<Job>& jobs : b.rounds) {
    if (std::ranges::all_of(jobs, [](const Job& job) { return job.groups == 0; })) continue;
    const RunReport report = b.executor->run(jobs, options);
    b.seconds += report.seconds;
    if (report.cancelled) return;
  }
  each_status(b, MapFor::reading, [&b](Real status) {
    if (!(status > unwritten)) refuse_unwritten(b.device());
    return static_cast<int>(status) != LANE_NOT_RUN;
  });
}

template <class Real>
std::size_t ContactBatch<Real>::steps_in_all() const {
  std::size_t all = 0;
  for (const auto& scene : state_->scenes) all += static_cast<std::size_t>(scene.steps);
  return all;
}

template <class Real>
void ContactBatch<Real>::fill_outputs(Real value) {
  for (const auto* array : {&state_->results, &state_->outputs, &state_->forces, &state_->patches}) array->fill(value);
}

template <class Real>
void ContactBatch<Real>::fill_unused(Real value) {
  const LaneState<Real>& b = *state_;
  const auto fill = [&](const LaneArray<Real>& array, const auto& used_steps) {
    std::vector<std::size_t> used(b.lanes, 0);
    for (const std::size_t i : b.order) used[b.place[i]] = used_steps(i);
    const auto mapped = array.numbers.map(MapFor::both);
    for (std::size_t lane = 0; lane < b.lanes; ++lane)
      for (std::size_t step = used[lane]; step < array.steps; ++step)
        for (std::size_t row = 0; row < array.rows; ++row) mapped[array.at(lane, step, row)] = value;
  };
  fill(b.path, [&](std::size_t i) { return static_cast<std::size_t>(b.scenes[i].increments); });
  fill(b.input, [](std::size_t) { return 1; });
  for (const auto& array : b.more_inputs) fill(array, [](std::size_t) { return 1; });
}

template <class Real>
LaneAnswer LaneView<Real>::answer(std::size_t i) const {
  const LaneState<Real>& b = *state_;
  const std::size_t lane = b.place[i];
  LaneAnswer answer;
  answer.steps = b.scenes[i].steps, answer.indentation_steps = b.scenes[i].indentation_steps;
  answer.sensor = b.sensors.empty() ? nullptr : &sensor(i);
  answer.stride = interleaved();
  constexpr bool fp64 = sizeof(Real) == sizeof(double);
  answer.results_ = {results_.view().data() + b.results.at(lane, 0, 0), b.results.rows, fp64};
  answer.stresses_ = {outputs_.view().data() + b.outputs.at(lane, 0, b.stresses_from), b.outputs.rows, fp64};
  if (b.patches.rows > 0) answer.patch_ = {patches_.view().data() + b.patches.at(lane, 0, 0), b.patches.rows, fp64};
  return answer;
}

template struct LaneScenes<float>;
template struct LaneScenes<double>;
template struct LaneState<float>;
template struct LaneState<double>;
template class ContactBatch<float>;
template class ContactBatch<double>;
template class LaneView<float>;
template class LaneView<double>;

}  // namespace tactel::host
