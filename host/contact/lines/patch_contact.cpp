// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/patch_contact.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "fem/gap/accuracy.h"
#include "fem/gap/contact_laws.h"
#include "fem/layer/patch_solver.h"
#include "fem/mesh/block.h"
#include "fem/numbers/last_used.h"
#include "fem/numbers/value_error.h"
#include "host/contact/lines/patch_contact_tables.h"
#include "host/contact/strata.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

constexpr int friction_strata = 4;  ///< measured beside 2, 8 and 16
constexpr int usual_sweeps = 400;

/// Tables of a kernel on a device.
template <class Real>
class DeviceTables {
 public:
  DeviceTables(const Device& device, KernelTables&& from) : from_(std::move(from)) {
    for (auto& [name, values] : from_.tables) {
      tables_.emplace_back(name, buffer_of<Real>(device, values));
      values = {};
    }
  }
  void bind(KernelArguments& kernel) const {
    for (const auto& [name, table] : tables_) kernel.set(name, table);
    for (const auto& [name, count] : from_.counts) kernel.set(name, std::int32_t(count));
    for (const auto& [name, number] : from_.numbers) kernel.set(name, Real(number));
  }

 private:
  KernelTables from_;
  std::vector<std::pair<const char*, Buffer<Real>>> tables_;
};

/// Whether the indenter turns back on its way along x.
bool turns_back(const PatchPath& path) {
  double direction = 0;
  for (std::size_t k = 1; k < path.steps.size(); ++k) {
    const double way = path.steps[k].target.tangential - path.steps[k - 1].target.tangential;
    if (way * direction < 0) return true;
    if (way != 0) direction = way;
  }
  return false;
}

}  // namespace

template <class Real>
struct PatchContact<Real>::State {
  State(Executor& executor, const fem::PatchOptions& given, KernelTables&& numbers)
      : executor(executor),
        options(given),
        lanes_of_group(executor.device().lanes(precision)),
        interleaved_lanes(executor.device().interleaved(precision)),
        tactels(numbers.tactels),
        outputs(static_cast<std::size_t>(numbers.outputs)),
        tables(executor.device(), std::move(numbers)) {
    for (const int known : {8, 12, 16, 24})
      if (options.elements == known) elements = known;
    if (elements == 0) throw ValueError("elements", std::to_string(options.elements), "8, 12, 16 or 24");
    const auto [tolerance, accept] = fem::by_rule<Real>({options.tolerance, options.accept}, fem::slow_on_patch);
    options.tolerance = tolerance, options.accept = accept;
    if (options.most_sweeps == 0) options.most_sweeps = usual_sweeps;
  }

  static constexpr Precision precision = precision_of<Real>;
  const char* kernel() const { return family ? "patch_contact_sensors" : "patch_contact"; }
  int force_rows() const { return padded(2 * elements); }

  /// The sensors of lanes. Lanes without a scene have thickness 0, which is no sensor.
  LaneArray<Real> sensor_rows(const LaneState<Real>& b) const {
    return b.array(b.input.tile, 1, PATCH_SENSOR_ROWS, 0,
                   [&](std::size_t i) { return std::to_array(patch_sensor(*family, b.sensors[i]).rows); });
  }

  Program program(ContactKind kind) {
    return programs.get(kind, [&] {
      const auto text = [](int value) { return std::to_string(value); };
      return Program(executor.device(), "patch_contact.cl",
                     {{"REAL", real_type(precision)},
                      {"LANES", text(lanes_of_group)},
                      {"ELEMENTS", text(elements)},
                      {"FORCE_CONTROL", text(kind.force)},
                      {"FRICTION", text(kind.friction)},
                      {"SENSORS", text(family.has_value())}});
    });
  }

  fem::ContactSolution solution(const LaneView<Real>& view, std::size_t i) const;

  Executor& executor;
  fem::PatchOptions options;
  int lanes_of_group, interleaved_lanes;  ///< of the device
  int elements = 0, tactels;
  std::size_t outputs;  ///< numbers of a load step in the stresses
  DeviceTables<Real> tables;
  std::shared_ptr<const fem::LayerModel> model{};  ///< of the one sensor, or
  std::optional<fem::SensorFamily> family{};       ///< of those of all scenes
  fem::LastUsed<ContactKind, Program> programs{4};
};

template <class Real>
fem::ContactSolution PatchContact<Real>::State::solution(const LaneView<Real>& view, std::size_t i) const {
  const auto& scene = view.scene(i);
  const double origin = view.patch(i, PATCH_ORIGIN), width = view.patch(i, PATCH_ELEMENT);
  const Real mu = static_cast<Real>(std::min(scene.friction, fem::largest_friction));
  fem::ContactSolution solution;
  solution.surface_x = Eigen::VectorXd::NullaryExpr(
      elements, [&](auto n) { return scene.position + origin + width * (static_cast<double>(n) + 0.5); });
  solution.surface_width = Eigen::VectorXd::Constant(elements, width);
  solution.tactel_x = fem::tactel_positions(view.sensor(i));
  for (int k = 0; k < scene.steps; ++k) {
    const auto result = [&](int row) { return static_cast<double>(view.result(i, k, row)); };
    const int status = static_cast<int>(result(RESULT_STATUS));
    if (status == LANE_NOT_RUN) break;
    fem::ContactStep step = lane_step(result, scene.friction);
    if (status != LANE_INVALID) {
      const auto force = [&](auto row) { return view.force(i, k, static_cast<int>(row)); };
      step.normal_force =
          Eigen::VectorXd::NullaryExpr(elements, [&](auto n) { return static_cast<double>(force(n)) * scene.young; });
      step.tangential_force = Eigen::VectorXd::NullaryExpr(
          elements, [&](auto n) { return static_cast<double>(force(elements + n)) * scene.young; });
      for (int n = 0; n < elements; ++n) {
        const bool sticks = std::abs(force(elements + n)) < mu * force(n);
        step.status.push_back(!(force(n) > 0) ? fem::GapStatus::open
                              : sticks        ? fem::GapStatus::stick
                                              : fem::GapStatus::slip);
      }
      std::vector<double> stress(2 * static_cast<std::size_t>(tactels));
      view.answer(i).tactels(k, std::span(stress));
      step.sigma_y = Eigen::Map<const Eigen::VectorXd>(stress.data(), tactels);
      step.tau_xy = Eigen::Map<const Eigen::VectorXd>(stress.data() + tactels, tactels);
    } else {
      step.normal_force = step.tangential_force = Eigen::VectorXd::Zero(elements);
      step.sigma_y = step.tau_xy = Eigen::VectorXd::Zero(tactels);
      step.status.assign(elements, fem::GapStatus::open);
    }
    solution.sliding = status == LANE_SLIDING && k >= scene.indentation_steps;
    solution.steps.push_back(std::move(step));
  }
  return solution;
}

template <class Real>
void PatchContact<Real>::Scenes::push_back(const fem::Scene& scene, const fem::LoadPath& load, const Given& given) {
  const PatchPath path = patch_path(load, scene.load, contact_->options.increments());
  this->add(kind_of(scene), {.steps = path.slots,
                             .indentation_steps = path.indentation_slots,
                             .increments = static_cast<int>(path.steps.size()),
                             .friction = scene.friction,
                             .young = scene.sensor.young,
                             .position = scene.indenter.position});
  if (contact_->family) {
    contact_->family->require(scene.sensor);
    this->sensors.push_back(scene.sensor);
  }
  PatchLane lane = patch_lane(scene, path, given);
  if (!lane.shape.empty())
    lane.input[lane.input[PATCH_POINTS] > 0 ? PATCH_POINTS_AT : PATCH_TERMS_AT] = static_cast<double>(shapes_.size());
  const double width = lane.input[PATCH_TO] - lane.input[PATCH_FROM], young = scene.sensor.young;
  costs_.push_back({.kin = (-static_cast<std::int64_t>(std::variant_size_v<fem::Shape> * path.steps.size()) +
                            static_cast<std::int64_t>(scene.indenter.shape.index())) *
                               2 +
                           turns_back(path),
                    .width = std::isnan(width) ? 0 : width});
  const auto put = [](std::vector<Real>& to, double value) { to.push_back(static_cast<Real>(value)); };
  for (const double number : lane.input) put(this->inputs, number);
  for (const double number : lane.shape) put(shapes_, number);
  int slot = 0;
  for (const auto& [step, asked] : path.steps) {
    put(this->targets, step.normal_is_force ? step.normal / young : step.normal);
    put(this->targets, step.tangential_is_force ? step.tangential / young : step.tangential);
    put(this->targets, asked ? slot++ : -1);
  }
}

/// Scenes of like cost side by side, so that the lanes of a group finish together.
template <class Real>
std::vector<std::size_t> PatchContact<Real>::Scenes::by_cost() const {
  std::vector<double> friction;
  friction.reserve(costs_.size());
  for (const auto& scene : this->scenes) friction.push_back(scene.friction);
  const std::vector<int> stratum = strata(friction, friction_strata);
  std::vector<std::tuple<std::int64_t, double, std::size_t>> keys;
  keys.reserve(costs_.size());
  for (std::size_t i = 0; i < costs_.size(); ++i)
    keys.emplace_back(costs_[i].kin * friction_strata + stratum[i], costs_[i].width, i);
  std::sort(keys.begin(), keys.end());
  std::vector<std::size_t> order;
  order.reserve(costs_.size());
  for (const auto& key : keys) order.push_back(std::get<2>(key));
  return order;
}

template <class Real>
PatchContact<Real>::PatchContact(Executor& executor, const fem::SensorFamily& family, const fem::PatchOptions& options)
    : state_(std::make_shared<State>(executor, options, family_tables(family))) {
  state_->family = family;
}

template <class Real>
PatchContact<Real>::PatchContact(Executor& executor, const fem::LayerModel& model, const fem::PatchOptions& options)
    : state_(std::make_shared<State>(executor, options, patch_tables(model))) {
  state_->model = std::make_shared<const fem::LayerModel>(model);
}

template <class Real>
std::shared_ptr<const fem::LayerModel> PatchContact<Real>::model_of(const fem::Sensor& sensor) const {
  return state_->family ? std::make_shared<const fem::LayerModel>(state_->family->model(sensor)) : state_->model;
}

template <class Real>
const fem::PatchOptions& PatchContact<Real>::options() const {
  return state_->options;
}

template <class Real>
ContactBatch<Real> PatchContact<Real>::prepare(std::span<const fem::Scene> scenes, std::span<const Given> given) const {
  Scenes all(*this);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    all.push_back(scenes[i], fem::load_path(scenes[i].load), given.empty() ? std::nullopt : given[i]);
  return prepare(std::move(all));
}

template <class Real>
ContactBatch<Real> PatchContact<Real>::prepare(Scenes scenes, bool forces) const {
  auto batch = std::make_shared<LaneState<Real>>();
  auto& b = *batch;
  const ContactKind kind = scenes.kind;
  const std::vector<Real> shape_numbers = std::move(scenes.shapes_);
  const std::vector<std::size_t> order = scenes.by_cost();
  if (state_->model) scenes.sensors = {state_->model->sensor};
  b.lay_out(state_->executor, std::move(scenes), order, state_->lanes_of_group, state_->interleaved_lanes,
            PATCH_INPUT_ROWS, PATCH_PATH_ROWS);
  b.shapes = buffer_of<Real>(b.device(), shape_numbers);
  if (state_->family) b.more_inputs = {state_->sensor_rows(b)};
  const auto outputs = [&](std::size_t steps, std::size_t rows, bool written = true) {
    return LaneArray<Real>(b.device(), written ? b.lanes : 0, state_->interleaved_lanes, steps, rows);
  };
  b.results = outputs(b.steps, PATCH_BLOCK), b.outputs = outputs(b.steps, state_->outputs);
  b.forces = outputs(b.steps, state_->force_rows(), forces), b.patches = outputs(1, PATCH_BLOCK);
  const fem::PatchOptions& o = state_->options;
  auto launch = state_->executor.prepare(state_->program(kind), state_->kernel(), [&](KernelArguments& kernel) {
    state_->tables.bind(kernel);
    if (state_->family) kernel.set("sensors", b.more_inputs.front().numbers);
    kernel.set("outputs", std::int32_t(b.outputs.rows));
    kernel.set("shapes", b.shapes);
    kernel.set("lane_input", b.input.numbers);
    kernel.set("path", b.path.numbers);
    kernel.set("increments", std::int32_t(b.increments));
    kernel.set("slots", std::int32_t(b.steps));
    kernel.set("write_forces", std::int32_t(forces));
    kernel.set("tolerance", Real(o.tolerance));
    kernel.set("accept", Real(o.accept));
    kernel.set("most_sweeps", std::int32_t(o.most_sweeps));
    kernel.set("result", b.results.numbers);
    kernel.set("forces", b.forces.numbers);
    kernel.set("stress", b.outputs.numbers);
    kernel.set("patches", b.patches.numbers);
  });
  b.rounds = {{{std::move(launch), b.groups}}};
  b.solution = [contact = state_, forces](const LaneView<Real>& view, std::size_t i) {
    if (!forces) throw std::logic_error("PatchContact: a solution of a batch without forces");
    return contact->solution(view, i);
  };
  return Batch(std::move(batch));
}

template <class Real>
void PatchContact<Real>::set_parts(Batch& batch, bool path, bool base_stress) {
  LaneState<Real>& b = *batch.state();
  Launch& launch = b.rounds.front().front().launch;
  launch.set("increments", std::int32_t(path ? b.increments : 0));
  launch.set("outputs", std::int32_t(path && base_stress ? b.outputs.rows : 0));
}

template class PatchContact<float>;
template class PatchContact<double>;

}  // namespace tactel::host
