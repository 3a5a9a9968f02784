// SPDX-License-Identifier: Apache-2.0
#include "host/contact/patch_contact.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <tuple>

#include "fem/accuracy.h"
#include "fem/block.h"
#include "fem/contact_laws.h"
#include "fem/layer/patch_solver.h"
#include "fem/value_error.h"
#include "host/contact/patch_contact_tables.h"
#include "host/contact/strata.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

constexpr int friction_strata = 4;  ///< measured beside 2, 8 and 16

template <class Real>
Buffer<Real> table_on_device(const Device& device, const std::vector<double>& values) {
  std::vector<Real> rounded(values.begin(), values.end());
  if (rounded.empty()) rounded.resize(1);
  return Buffer<Real>(device, std::span<const Real>(rounded));
}

int rounded_up(int count) { return (count + PATCH_BLOCK - 1) / PATCH_BLOCK * PATCH_BLOCK; }

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
  State(Executor& executor, const PatchContactOptions& options)
      : executor(executor),
        options(options),
        lanes_of_group(executor.device().lanes(precision())),
        interleaved_lanes(executor.device().interleaved(precision())) {
    for (const int known : {8, 12, 16, 24})
      if (options.elements == known) elements = known;
    if (elements == 0) throw ValueError("elements", std::to_string(options.elements), "8, 12, 16 or 24");
    const auto [tolerance, accept] = fem::by_rule<Real>({options.tolerance, options.accept}, fem::slow_on_patch);
    this->options.tolerance = tolerance, this->options.accept = accept;
  }
  State(Executor& executor, const fem::LayerModel& layer, const PatchContactOptions& options)
      : State(executor, options) {
    model = std::make_shared<const fem::LayerModel>(layer);
    const PatchTables t = patch_tables(layer);
    tactels = layer.base.tactels();
    outputs = static_cast<std::size_t>(t.outputs);
    set_tables = [=, smooth = on_device(t.smooth), sides = on_device(t.sides), signs = on_device(t.signs),
                  base = on_device(t.base), cells = t.cells(), side_rows = t.side_rows(), base_rows = t.base_rows(),
                  per_mm = t.cells_per_mm, cy = t.cy, cx = t.cx, jump = t.jump, sides_per_mm = t.side_rows_per_mm,
                  sides_from = t.sides_from, base_per_mm = t.base_rows_per_mm, base_from = t.base_from,
                  thickness = layer.sensor.thickness, length = layer.sensor.length](KernelArguments& kernel) {
      kernel.set("smooth", smooth);
      kernel.set("cells", std::int32_t(cells));
      kernel.set("cells_per_mm", Real(per_mm));
      kernel.set("thickness", Real(thickness));
      kernel.set("length", Real(length));
      kernel.set("cy", Real(cy));
      kernel.set("cx", Real(cx));
      kernel.set("jump", Real(jump));
      kernel.set("sides", sides);
      kernel.set("side_rows", std::int32_t(side_rows));
      kernel.set("side_rows_per_mm", Real(sides_per_mm));
      kernel.set("sides_from", Real(sides_from));
      kernel.set("signs", signs);
      kernel.set("base", base);
      kernel.set("base_rows", std::int32_t(base_rows));
      kernel.set("base_rows_per_mm", Real(base_per_mm));
      kernel.set("base_from", Real(base_from));
    };
  }
  State(Executor& executor, const fem::SensorFamily& of, const PatchContactOptions& options)
      : State(executor, options) {
    family = of;
    const FamilyTables t = family_tables(of);
    tactels = of.range().tactels;
    outputs = static_cast<std::size_t>(rounded_up(tactels + rounded_up(tactels)));
    set_tables = [smooth = on_device(t.smooth), sides = on_device(t.sides), forces = on_device(t.side_forces),
                  stresses = on_device(t.side_stresses), cores = on_device(t.cores), layer = on_device(t.stresses),
                  poissons = t.poissons, cells = t.cells(), side_rows = t.side_rows(), stress_cells = t.stress_cells(),
                  tactels = tactels](KernelArguments& kernel) {
      kernel.set("smooth", smooth);
      kernel.set("cells", std::int32_t(cells));
      kernel.set("poissons", std::int32_t(poissons));
      kernel.set("cells_per_h", Real(fem::LayerTable::cells_a_thickness));
      kernel.set("sides", sides);
      kernel.set("side_forces", forces);
      kernel.set("side_stresses", stresses);
      kernel.set("side_rows", std::int32_t(side_rows));
      kernel.set("side_rows_per_h", Real(fem::EndModes::rows_a_thickness));
      kernel.set("cores", cores);
      kernel.set("layer_stresses", layer);
      kernel.set("stress_cells", std::int32_t(stress_cells));
      kernel.set("stress_cells_per_h", Real(fem::SensorFamily::stress_cells_a_thickness));
      kernel.set("tactels", std::int32_t(tactels));
    };
  }

  Buffer<Real> on_device(const std::vector<double>& values) const {
    return table_on_device<Real>(executor.device(), values);
  }

  static Precision precision() { return sizeof(Real) == 4 ? Precision::fp32 : Precision::fp64; }
  int lanes() const { return lanes_of_group; }
  int interleaved() const { return interleaved_lanes; }
  const char* kernel() const { return family ? "patch_contact_sensors" : "patch_contact"; }
  int pressing_increments() const {
    return fem::PatchOptions{.elements = options.elements, .pressing_increments = options.increments}.increments();
  }
  int force_rows() const { return rounded_up(2 * elements); }

  const Program& program(ContactKind kind) {
    const std::lock_guard lock(making);
    auto& program = programs[kind.force][kind.friction];
    if (!program) {
      const auto text = [](int value) { return std::to_string(value); };
      program = std::make_unique<Program>(executor.device(), "patch_contact.cl",
                                          Defines{{"REAL", real_type(precision())},
                                                  {"LANES", text(lanes())},
                                                  {"ELEMENTS", text(elements)},
                                                  {"FORCE_CONTROL", text(kind.force)},
                                                  {"FRICTION", text(kind.friction)},
                                                  {"SENSORS", text(family.has_value())}});
    }
    return *program;
  }

  Executor& executor;
  PatchContactOptions options;
  int lanes_of_group, interleaved_lanes;         ///< of the device
  std::shared_ptr<const fem::LayerModel> model;  ///< of the one sensor, or
  std::optional<fem::SensorFamily> family;       ///< of those of all scenes
  std::function<void(KernelArguments&)> set_tables;
  int elements = 0, tactels = 0;
  std::size_t outputs = 0;                  ///< numbers of a load step in the stresses
  std::unique_ptr<Program> programs[2][2];  ///< [force][friction]
  std::mutex making;                        ///< of what is made at first use
};

template <class Real>
struct PatchContact<Real>::Batch::State {
  std::shared_ptr<PatchContact<Real>::State> contact;
  std::vector<std::size_t> place;            ///< [scenes] lane of scene i, counted over all groups
  std::vector<std::size_t> order;            ///< [scenes] scene in a lane: the inverse of place
  std::vector<typename Scenes::One> scenes;  ///< [scenes]
  int slots = 0, most_increments = 0;
  bool with_forces = true;
  std::size_t groups = 0, all_lanes = 0;  ///< groups that run; lanes of all arrays
  double seconds = 0;
  std::vector<fem::Sensor> sensors;  ///< [scenes] of a family
  Buffer<Real> shapes, lane_input, lane_sensor, path, result, forces, stress, patches;
  Launch launch;

  std::size_t outputs() const { return contact->outputs; }
  std::size_t lanes_of_tile() const { return static_cast<std::size_t>(contact->lanes()) * contact->interleaved(); }
  const fem::Sensor& sensor(std::size_t scene) const {
    return contact->family ? sensors[scene] : contact->model->sensor;
  }
  /// Index of [tile][.. `row` of `height` a lane ..][lane], for inputs; a tile is a group, or neighbouring groups of
  /// one lane.
  std::size_t at_lane(std::size_t lane, std::size_t height, std::size_t row) const {
    const std::size_t tile = lanes_of_tile();
    return ((lane / tile) * height + row) * tile + lane % tile;
  }
  /// Index of number `row` of `height` in an answer: [lane / interleaved][slots][height][lane % interleaved].
  std::size_t at_answer(std::size_t scene, int answers, int slot, std::size_t height, std::size_t row) const {
    const std::size_t lane = place[scene], tile = contact->interleaved();
    return ((lane / tile * answers + slot) * height + row) * tile + lane % tile;
  }

  void lay_out();
  void fill(const Scenes& from);
  void fill_sensors();
};

template <class Real>
void PatchContact<Real>::Scenes::push_back(const fem::Scene& scene, const fem::LoadPath& load, const Given& given) {
  if (scenes_.empty()) kind_ = kind_of(scene);
  if (kind_of(scene) != kind_)
    throw std::invalid_argument("PatchContact::Scenes::push_back: scenes of different kinds in one batch");
  if (contact_->family) {
    contact_->family->require(scene.sensor);
    sensors_.push_back(scene.sensor);
  }
  const PatchPath path = patch_path(load, scene.load, contact_->pressing_increments());
  const PatchLane lane = patch_lane(scene, path, given);
  const double width = lane.input[PATCH_TO] - lane.input[PATCH_FROM], young = scene.sensor.young;
  const auto increments = static_cast<int>(path.steps.size());
  scenes_.push_back({.slots = path.slots,
                     .indentation_slots = path.indentation_slots,
                     .increments = increments,
                     .friction = scene.friction,
                     .young = young,
                     .position = scene.indenter.position,
                     .kin = (-static_cast<std::int64_t>(std::variant_size_v<fem::Shape>) * increments +
                             static_cast<std::int64_t>(scene.indenter.shape.index())) *
                                2 +
                            turns_back(path),
                     .width = std::isnan(width) ? 0 : width,
                     .targets_at = targets_.size(),
                     .shape_at = shapes_.size(),
                     .shape_size = lane.shape.size()});
  const auto put = [](std::vector<Real>& to, double value) { to.push_back(static_cast<Real>(value)); };
  for (const double number : lane.input) put(inputs_, number);
  for (const double number : lane.shape) put(shapes_, number);
  int slot = 0;
  for (const auto& [step, asked] : path.steps) {
    put(targets_, step.normal_is_force ? step.normal / young : step.normal);
    put(targets_, step.tangential_is_force ? step.tangential / young : step.tangential);
    put(targets_, asked ? slot++ : -1);
  }
}

/// Scenes of like cost side by side, so that the lanes of a group finish together.
template <class Real>
void PatchContact<Real>::Batch::State::lay_out() {
  std::vector<double> friction;
  friction.reserve(scenes.size());
  for (const auto& scene : scenes) friction.push_back(scene.friction);
  const std::vector<int> stratum = strata(friction, friction_strata);
  std::vector<std::tuple<std::int64_t, double, std::size_t>> keys;
  keys.reserve(scenes.size());
  for (std::size_t i = 0; i < scenes.size(); ++i)
    keys.emplace_back(scenes[i].kin * friction_strata + stratum[i], scenes[i].width, i);
  std::sort(keys.begin(), keys.end());
  order.resize(scenes.size());
  place.resize(scenes.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    order[k] = std::get<2>(keys[k]);
    place[order[k]] = k;
  }
}

template <class Real>
void PatchContact<Real>::Batch::State::fill(const Scenes& from) {
  const auto input = lane_input.map(MapFor::writing), targets = path.map(MapFor::writing),
             numbers = shapes.map(MapFor::writing);
  std::fill(input.view().begin(), input.view().end(), Real(0));
  std::fill(targets.view().begin(), targets.view().end(), Real(0));
  const std::size_t height = static_cast<std::size_t>(most_increments) * PATCH_PATH_ROWS, tile = lanes_of_tile();
  const auto put = [&](std::span<const Real> rows, Real* to) {
    for (const Real number : rows) *to = number, to += tile;
  };
  std::size_t shapes_at = 0;
  for (std::size_t lane = 0; lane < order.size(); ++lane) {
    const std::size_t i = order[lane];
    const auto& scene = scenes[i];
    Real* const in = &input[at_lane(lane, PATCH_INPUT_ROWS, 0)];
    put(std::span(from.inputs_).subspan(i * PATCH_INPUT_ROWS, PATCH_INPUT_ROWS), in);
    put(std::span(from.targets_).subspan(scene.targets_at, scene.increments * std::size_t{PATCH_PATH_ROWS}),
        &targets[at_lane(lane, height, 0)]);
    if (scene.shape_size == 0) continue;
    in[tile * (in[tile * PATCH_POINTS] > 0 ? PATCH_POINTS_AT : PATCH_TERMS_AT)] = static_cast<Real>(shapes_at);
    std::copy_n(&from.shapes_[scene.shape_at], scene.shape_size, &numbers[shapes_at]);
    shapes_at += scene.shape_size;
  }
}

/// Lanes without a scene have thickness 0, which is no sensor.
template <class Real>
void PatchContact<Real>::Batch::State::fill_sensors() {
  const auto rows = lane_sensor.map(MapFor::writing);
  std::fill(rows.view().begin(), rows.view().end(), Real(0));
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const PatchSensor sensor = patch_sensor(*contact->family, sensors[i]);
    for (int row = 0; row < PATCH_SENSOR_ROWS; ++row)
      rows[at_lane(place[i], PATCH_SENSOR_ROWS, row)] = static_cast<Real>(sensor.rows[row]);
  }
}

template <class Real>
PatchContact<Real>::PatchContact(Executor& executor, const fem::SensorFamily& family,
                                 const PatchContactOptions& options)
    : state_(std::make_shared<State>(executor, family, options)) {}

template <class Real>
PatchContact<Real>::PatchContact(Executor& executor, const fem::LayerModel& model, const PatchContactOptions& options)
    : state_(std::make_shared<State>(executor, model, options)) {}

template <class Real>
std::shared_ptr<const fem::LayerModel> PatchContact<Real>::model_of(const fem::Sensor& sensor) const {
  return state_->family ? std::make_shared<const fem::LayerModel>(state_->family->model(sensor)) : state_->model;
}

template <class Real>
const PatchContactOptions& PatchContact<Real>::options() const {
  return state_->options;
}

template <class Real>
typename PatchContact<Real>::Batch PatchContact<Real>::prepare(std::span<const fem::Scene> scenes,
                                                               std::span<const Given> given) const {
  Scenes all(*this);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    all.push_back(scenes[i], fem::load_path(scenes[i].load), given.empty() ? std::nullopt : given[i]);
  return prepare(std::move(all));
}

template <class Real>
typename PatchContact<Real>::Batch PatchContact<Real>::prepare(Scenes scenes, bool forces) const {
  Batch batch;
  batch.state_ = std::make_shared<typename Batch::State>();
  auto& b = *batch.state_;
  b.contact = state_;
  b.with_forces = forces;
  b.scenes = std::move(scenes.scenes_);
  b.sensors = std::move(scenes.sensors_);
  for (const auto& scene : b.scenes) {
    b.slots = std::max(b.slots, scene.slots);
    b.most_increments = std::max(b.most_increments, scene.increments);
  }
  b.lay_out();

  const std::size_t lanes = state_->lanes(), tile = lanes * state_->interleaved();
  b.groups = (b.scenes.size() + lanes - 1) / lanes;
  b.all_lanes = (b.scenes.size() + tile - 1) / tile * tile;
  const std::size_t all = b.all_lanes, steps = all * b.slots;
  const Device& device = state_->executor.device();
  const auto buffer = [&](std::size_t size) { return Buffer<Real>(device, std::max<std::size_t>(size, 1)); };
  b.shapes = buffer(scenes.shapes_.size());
  b.lane_input = buffer(all * PATCH_INPUT_ROWS);
  b.path = buffer(all * b.most_increments * PATCH_PATH_ROWS);
  b.result = buffer(steps * PATCH_BLOCK);
  b.forces = buffer(forces ? steps * state_->force_rows() : 0);
  b.stress = buffer(steps * b.outputs());
  b.patches = buffer(all * PATCH_BLOCK);
  b.fill(scenes);
  if (state_->family) {
    b.lane_sensor = buffer(all * PATCH_SENSOR_ROWS);
    b.fill_sensors();
  }

  const PatchContactOptions& o = state_->options;
  b.launch = state_->executor.prepare(state_->program(scenes.kind_), state_->kernel(), [&](KernelArguments& kernel) {
    state_->set_tables(kernel);
    if (state_->family) kernel.set("sensors", b.lane_sensor);
    kernel.set("outputs", std::int32_t(b.outputs()));
    kernel.set("shapes", b.shapes);
    kernel.set("lane_input", b.lane_input);
    kernel.set("path", b.path);
    kernel.set("increments", std::int32_t(b.most_increments));
    kernel.set("slots", std::int32_t(b.slots));
    kernel.set("write_forces", std::int32_t(forces));
    kernel.set("tolerance", Real(o.tolerance));
    kernel.set("accept", Real(o.accept));
    kernel.set("most_sweeps", std::int32_t(o.most_sweeps));
    kernel.set("result", b.result);
    kernel.set("forces", b.forces);
    kernel.set("stress", b.stress);
    kernel.set("patches", b.patches);
  });
  return batch;
}

template <class Real>
void PatchContact<Real>::Batch::run(const RunOptions& options) {
  state_->seconds = state_->contact->executor.run(state_->launch, state_->groups, options).seconds;
}

template <class Real>
void PatchContact<Real>::Batch::set_parts(bool path, bool base_stress) {
  state_->launch.set("increments", std::int32_t(path ? state_->most_increments : 0));
  state_->launch.set("outputs", std::int32_t(path && base_stress ? state_->outputs() : 0));
}

template <class Real>
std::size_t PatchContact<Real>::Batch::size() const {
  return state_->place.size();
}

template <class Real>
int PatchContact<Real>::Batch::steps() const {
  return state_->slots;
}

template <class Real>
std::size_t PatchContact<Real>::Batch::steps_in_all() const {
  std::size_t all = 0;
  for (const auto& scene : state_->scenes) all += static_cast<std::size_t>(scene.slots);
  return all;
}

template <class Real>
double PatchContact<Real>::Batch::seconds() const {
  return state_->seconds;
}

template <class Real>
void PatchContact<Real>::Batch::fill_outputs(Real value) {
  for (const auto* buffer : {&state_->result, &state_->forces, &state_->stress, &state_->patches}) {
    const auto mapped = buffer->map(MapFor::writing);
    std::fill(mapped.view().begin(), mapped.view().end(), value);
  }
}

template <class Real>
void PatchContact<Real>::Batch::fill_unused(Real value) {
  const auto& b = *state_;
  const auto input = b.lane_input.map(MapFor::both), targets = b.path.map(MapFor::both);
  const auto fill = [&](std::span<Real> buffer, std::size_t lane, std::size_t height, std::size_t from) {
    for (std::size_t row = from; row < height; ++row) buffer[b.at_lane(lane, height, row)] = value;
  };
  for (std::size_t lane = 0; lane < b.all_lanes; ++lane) {
    const bool used = lane < b.order.size();
    const std::size_t own = used ? b.scenes[b.order[lane]].increments : 0;
    fill(targets.view(), lane, static_cast<std::size_t>(b.most_increments) * PATCH_PATH_ROWS, own * PATCH_PATH_ROWS);
    if (!used) fill(input.view(), lane, PATCH_INPUT_ROWS, 0);
  }
  if (!b.contact->family) return;
  const auto sensors = b.lane_sensor.map(MapFor::both);
  for (std::size_t lane = b.order.size(); lane < b.all_lanes; ++lane) fill(sensors.view(), lane, PATCH_SENSOR_ROWS, 0);
}

template <class Real>
double PatchContact<Real>::Batch::result(std::size_t i, int step, int row) const {
  Real value;
  state_->result.read(std::span(&value, 1), state_->at_answer(i, state_->slots, step, PATCH_BLOCK, row));
  return value;
}

template <class Real>
double PatchContact<Real>::Batch::patch(std::size_t i, int row) const {
  Real value;
  state_->patches.read(std::span(&value, 1), state_->at_answer(i, 1, 0, PATCH_BLOCK, row));
  return value;
}

template <class Real>
PatchContact<Real>::Batch::View::View(const Batch& batch)
    : state_(batch.state_),
      results_(state_->result.map(MapFor::reading)),
      forces_(state_->forces.map(MapFor::reading)),
      stresses_(state_->stress.map(MapFor::reading)),
      patches_(state_->patches.map(MapFor::reading)) {}

template <class Real>
int PatchContact<Real>::Batch::View::path_steps(std::size_t i) const {
  return state_->scenes[i].slots;
}

template <class Real>
int PatchContact<Real>::Batch::View::indentation_steps(std::size_t i) const {
  return state_->scenes[i].indentation_slots;
}

template <class Real>
std::span<const std::size_t> PatchContact<Real>::Batch::View::by_lane() const {
  return state_->order;
}

template <class Real>
Real PatchContact<Real>::Batch::View::result(std::size_t i, int step, int row) const {
  return results_[state_->at_answer(i, state_->slots, step, PATCH_BLOCK, row)];
}

template <class Real>
LaneAnswer<Real> PatchContact<Real>::Batch::View::answer(std::size_t i) const {
  const auto& b = *state_;
  return {.steps = b.scenes[i].slots,
          .results = results_.view().data() + b.at_answer(i, b.slots, 0, PATCH_BLOCK, 0),
          .result_rows = PATCH_BLOCK,
          .stresses = stresses_.view().data() + b.at_answer(i, b.slots, 0, b.outputs(), 0),
          .stress_rows = b.outputs(),
          .stride = interleaved()};
}

template <class Real>
std::size_t PatchContact<Real>::Batch::View::interleaved() const {
  return static_cast<std::size_t>(state_->contact->interleaved());
}

template <class Real>
Real PatchContact<Real>::Batch::View::patch(std::size_t i, int row) const {
  return patches_[state_->at_answer(i, 1, 0, PATCH_BLOCK, row)];
}

template <class Real>
fem::ContactSolution PatchContact<Real>::Batch::solution(std::size_t i) const {
  return View(*this).solution(i);
}

template <class Real>
fem::ContactSolution PatchContact<Real>::Batch::View::solution(std::size_t i) const {
  const auto& b = *state_;
  if (!b.with_forces) throw std::logic_error("PatchContact: a solution of a batch without forces");
  const auto& scene = b.scenes[i];
  const int elements = b.contact->elements, tactels = b.contact->tactels;
  const double origin = patch(i, PATCH_ORIGIN), width = patch(i, PATCH_ELEMENT);
  const Real mu = static_cast<Real>(std::min(scene.friction, fem::largest_friction));
  fem::ContactSolution solution;
  solution.surface_x = Eigen::VectorXd::NullaryExpr(
      elements, [&](auto n) { return scene.position + origin + width * (static_cast<double>(n) + 0.5); });
  solution.surface_width = Eigen::VectorXd::Constant(elements, width);
  solution.tactel_x = fem::tactel_positions(b.sensor(i));
  for (int k = 0; k < scene.slots; ++k) {
    const auto said = [&](int row) { return static_cast<double>(result(i, k, row)); };
    const int status = static_cast<int>(said(LANE_STATUS));
    if (status == LANE_NOT_RUN) break;
    fem::ContactStep step = lane_step(said, scene.friction);
    if (status != LANE_INVALID) {
      const auto force = [&](auto row) {
        return forces_[b.at_answer(i, b.slots, k, b.contact->force_rows(), static_cast<std::size_t>(row))];
      };
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
      answer(i).tactels(k, std::span(stress));
      step.sigma_y = Eigen::Map<const Eigen::VectorXd>(stress.data(), tactels);
      step.tau_xy = Eigen::Map<const Eigen::VectorXd>(stress.data() + tactels, tactels);
    } else {
      step.normal_force = step.tangential_force = Eigen::VectorXd::Zero(elements);
      step.sigma_y = step.tau_xy = Eigen::VectorXd::Zero(tactels);
      step.status.assign(elements, fem::GapStatus::open);
    }
    solution.sliding = status == LANE_SLIDING && k >= scene.indentation_slots;
    solution.steps.push_back(std::move(step));
  }
  return solution;
}

template class PatchContact<float>;
template class PatchContact<double>;

}  // namespace tactel::host
