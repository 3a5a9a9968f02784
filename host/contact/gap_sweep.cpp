// SPDX-License-Identifier: Apache-2.0
#include "host/contact/gap_sweep.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>
#include <stdexcept>

#include "fem/accuracy.h"
#include "fem/contact_laws.h"
#include "host/contact/gap_sweep_tables.h"
#include "host/contact/strata.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

constexpr double far_away = 2 * NO_GAP_ELEMENT;  ///< mm: no indenter here
constexpr int grip_strata = 8;                   ///< measured beside 16 and 32
constexpr double window_bins =
    16;  ///< in a factor e of nodes: windows of a group differ by 6 % or a node; measured beside 4, 8, none
constexpr int most_vectors = 3;  ///< of LANES scenes a work-item: each number of C that is loaded serves thrice

template <class Real>
Buffer<Real> on_device(const Device& device, const std::vector<Real>& values) {
  return Buffer<Real>(device, std::span<const Real>(values));
}

/// The deepest indentation of a path, mm, about: where it is driven by force, on a layer.
double expected_depth(const fem::Scene& scene, const fem::LoadPath& path) {
  double deepest = 0;
  for (const fem::LoadStep& step : path.steps) deepest = std::max(deepest, step.normal);
  return by_force(scene) ? 0.3 * deepest / scene.sensor.young : deepest;
}

/// When a contact begins to slide, about, which decides on its sweeps: friction times depth over the longest drag of an
/// increment, mm or a force as the depth.
double grip(const fem::Scene& scene, const fem::LoadPath& path, double depth) {
  double longest = 0, last = 0;
  for (const fem::LoadStep& step : path.steps) {
    longest = std::max(longest, std::abs(step.tangential - last));
    last = step.tangential;
  }
  if (by_force(scene) && scene.load.angle) longest *= 0.3 / scene.sensor.young;
  return longest > 0 ? scene.friction * depth / longest : scene.friction;
}

/// Nodes that the rigid profile reaches at the deepest indentation: what a lane costs, and how deep they are on the
/// whole, relative to that indentation. heights: [columns] mm, depth mm.
std::pair<int, double> expected_window(const Eigen::Ref<const Eigen::VectorXd>& heights, double depth) {
  const auto overlap = (1.25 * depth - heights.array()).max(0);
  const double relative = overlap.sum() / depth;
  return {static_cast<int>((overlap > 0).count()), std::isnan(relative) ? 0 : relative};
}

}  // namespace

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

ContactKind kind_of(const fem::Scene& scene) { return {.force = by_force(scene), .friction = scene.friction != 0}; }

template <class Real>
struct GapSweep<Real>::State {
  State(Executor& executor, const fem::Sensor& sensor, const GapSweepOptions& options,
        const std::filesystem::path& cache)
      : executor(executor), sensor(sensor), options(options), condensation(fem::condense_cached(sensor, cache)) {
    const bool own = options.tolerance == 0 && options.accept == 0;
    const double usual = sizeof(Real) == 4 ? 1e-5 : 1e-11;
    const auto [tolerance, accept] =
        fem::by_rule<Real>({own ? usual : options.tolerance, options.accept}, fem::slow_on_mesh);
    this->options.tolerance = tolerance;
    this->options.accept = options.accept > 0 ? accept : std::max(accept, 2 * fem::lost_force(condensation));
    const Device& device = executor.device();
    lanes_of_vector = device.lanes(precision());
    interleaved = device.interleaved(precision());
    node = on_device(device, node_table<Real>(condensation.compliance));
    const Eigen::MatrixXd base = base_outputs();
    base_rows = static_cast<int>(base.rows());
    rows = base_rows + (options.tactels ? static_cast<int>(condensation.tactel_stress.rows()) : 0);
    Eigen::MatrixXd outputs(rows, condensation.compliance.cols());
    outputs.topRows(base_rows) = base;
    if (options.tactels) outputs.bottomRows(rows - base_rows) = condensation.tactel_stress;
    map = on_device(device, output_table<Real>(outputs));
  }

  /// Base forces as options want them [rows, 2 columns]: x and y take turns.
  Eigen::MatrixXd base_outputs() const {
    const Eigen::MatrixXd& all = condensation.base_force;
    if (options.base_sums) {
      Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(2, all.cols());
      for (Eigen::Index row = 0; row < all.rows(); ++row) sums.row(row % 2) += all.row(row);
      return sums;
    }
    return options.base_forces ? all : Eigen::MatrixXd(0, all.cols());
  }

  int columns() const { return static_cast<int>(condensation.surface_x.size()); }
  static Precision precision() { return sizeof(Real) == 4 ? Precision::fp32 : Precision::fp64; }
  /// Returns the vectors of a work-item: one where it holds all scenes, which then do not pay for empty ones.
  int vectors(std::size_t scenes) const {
    return lanes_of_vector == 1 || scenes <= static_cast<std::size_t>(lanes_of_vector) ? 1 : most_vectors;
  }

  const Buffer<Real>& compliance(bool friction) {
    const std::lock_guard lock(making);
    auto& table = compliances[friction];
    if (table.size() == 0)
      table = on_device(executor.device(), compliance_table<Real>(condensation.compliance, friction));
    return table;
  }

  const Program& program(ContactKind kind, int vectors) {
    const std::lock_guard lock(making);
    auto& program = programs[kind.force][kind.friction][vectors > 1];
    if (!program) {
      const auto text = [](int value) { return std::to_string(value); };
      program = std::make_unique<Program>(executor.device(), "gap_sweep.cl",
                                          Defines{{"REAL", real_type(precision())},
                                                  {"LANES", text(lanes_of_vector)},
                                                  {"VECTORS", text(vectors)},
                                                  {"NODES", text(columns())},
                                                  {"FORCE_CONTROL", text(kind.force)},
                                                  {"FRICTION", text(kind.friction)}});
    }
    return *program;
  }

  Executor& executor;
  fem::Sensor sensor;
  GapSweepOptions options;
  fem::Condensation condensation;
  Buffer<Real> node, map;
  Buffer<Real> compliances[2];  ///< [friction], made at first use
  int rows = 0, base_rows = 0;
  int lanes_of_vector = 1;
  int interleaved = 1;                         ///< work-items with their numbers side by side
  std::unique_ptr<Program> programs[2][2][2];  ///< [force][friction][several vectors]
  std::mutex making;                           ///< of what is made at first use
};

template <class Real>
struct GapSweep<Real>::Batch::State {
  std::shared_ptr<GapSweep<Real>::State> sweep;
  std::vector<std::size_t> place;      ///< [scenes] lane of scene i, counted over all groups
  std::vector<std::size_t> order;      ///< [scenes] scene in a lane: the inverse of place
  std::vector<int> path_steps;         ///< [scenes]
  std::vector<int> indentation_steps;  ///< [scenes]
  std::vector<double> friction;        ///< [scenes]
  int steps = 0;
  std::size_t groups = 0, lanes = 0;  ///< groups that run; lanes of all arrays
  std::size_t tile = 1;  ///< lanes whose numbers lie side by side: of a group, or of neighbouring groups of one lane
  double seconds = 0;
  Buffer<Real> lane_input, profile, path, result, rows, nodes;
  Launch launch;

  /// Index of [tile][.. `row` of `height` a lane ..][lane].
  std::size_t at(std::size_t scene, std::size_t height, std::size_t row) const {
    return at_lane(place[scene], height, row);
  }
  std::size_t at_lane(std::size_t lane, std::size_t height, std::size_t row) const {
    return ((lane / tile) * height + row) * tile + lane % tile;
  }

  void lay_out(std::span<const fem::Scene> scenes, std::span<const fem::LoadPath> paths,
               const Eigen::MatrixXd& profiles);
  void fill_scene(std::size_t i, const fem::Scene& scene, const fem::LoadPath& path, std::span<Real> input,
                  std::span<Real> targets) const;
  void fill(std::span<const fem::Scene> scenes, std::span<const fem::LoadPath> paths, const Eigen::MatrixXd& profiles);
};

/// Scenes of like cost side by side, so that the lanes of a group finish together.
template <class Real>
void GapSweep<Real>::Batch::State::lay_out(std::span<const fem::Scene> scenes, std::span<const fem::LoadPath> paths,
                                           const Eigen::MatrixXd& profiles) {
  order.resize(scenes.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::pair<int, double>> window(scenes.size());
  std::vector<double> grips(scenes.size());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const double depth = expected_depth(scenes[i], paths[i]);
    window[i] = expected_window(profiles.col(static_cast<Eigen::Index>(i)), depth);
    grips[i] = grip(scenes[i], paths[i], depth);
  }
  const std::vector<int> stratum = strata(grips, grip_strata);
  const auto key = [&](std::size_t i) {
    const auto& [nodes, overlap] = window[i];
    const int bin = static_cast<int>(window_bins * std::log(std::max(nodes, 1)));
    return std::tuple(bin, path_steps[i], stratum[i], overlap, i);
  };
  std::ranges::sort(order, std::greater<>(), key);
  place.resize(scenes.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = k;
}

template <class Real>
void GapSweep<Real>::Batch::State::fill_scene(std::size_t i, const fem::Scene& scene, const fem::LoadPath& load,
                                              std::span<Real> input, std::span<Real> targets) const {
  const double young = scene.sensor.young;
  const bool both = by_force(scene) && scene.load.angle.has_value();
  const auto put = [&](LaneInputRow row, double value) {
    input[at(i, LANE_INPUT_ROWS, row)] = static_cast<Real>(value);
  };
  put(LANE_MU, std::min(scene.friction, fem::largest_friction));
  put(LANE_YOUNG, young);
  put(LANE_STEPS, static_cast<double>(load.steps.size()));
  put(LANE_MAY_STOP, load.until_sliding ? load.indentation_steps : 1e6);
  put(LANE_FORCE, by_force(scene) ? (both ? FORCE_BOTH : FORCE_NORMAL) : FORCE_NONE);
  for (std::size_t k = 0; k < load.steps.size(); ++k) {
    const fem::LoadStep& step = load.steps[k];
    targets[at(i, steps * PATH_ROWS, k * PATH_ROWS + PATH_NORMAL)] =
        static_cast<Real>(by_force(scene) ? step.normal / young : step.normal);
    targets[at(i, steps * PATH_ROWS, k * PATH_ROWS + PATH_TANGENTIAL)] =
        static_cast<Real>(both ? step.tangential / young : step.tangential);
  }
}

template <class Real>
void GapSweep<Real>::Batch::State::fill(std::span<const fem::Scene> scenes, std::span<const fem::LoadPath> paths,
                                        const Eigen::MatrixXd& profiles) {
  const auto input = lane_input.map(MapFor::writing), heights = profile.map(MapFor::writing),
             targets = path.map(MapFor::writing);
  // Lanes beyond the last scene run no step; young = 1 makes their input valid.
  std::fill(input.view().begin(), input.view().end(), Real(0));
  std::fill(heights.view().begin(), heights.view().end(), Real(far_away));
  std::fill(targets.view().begin(), targets.view().end(), Real(0));
  for (const std::size_t i : order) {  // in the order of lanes, for the memory's sake
    fill_scene(i, scenes[i], paths[i], input.view(), targets.view());
    const std::size_t first = at(i, sweep->columns(), 0);
    for (int node = 0; node < sweep->columns(); ++node) {
      const double height = profiles(node, static_cast<Eigen::Index>(i));
      heights[first + node * tile] = static_cast<Real>(std::isinf(height) ? far_away : height);
    }
  }
}

template <class Real>
GapSweep<Real>::GapSweep(Executor& executor, const fem::Sensor& sensor, const GapSweepOptions& options,
                         const std::filesystem::path& cache)
    : state_(std::make_shared<State>(executor, sensor, options, cache)) {}

template <class Real>
const fem::Condensation& GapSweep<Real>::condensation() const {
  return state_->condensation;
}

template <class Real>
const GapSweepOptions& GapSweep<Real>::options() const {
  return state_->options;
}

template <class Real>
typename GapSweep<Real>::Batch GapSweep<Real>::prepare(std::span<const fem::Scene> scenes) const {
  const ContactKind kind = scenes.empty() ? ContactKind{} : kind_of(scenes.front());
  if (!std::ranges::all_of(scenes, [&](const fem::Scene& scene) { return kind_of(scene) == kind; }))
    throw std::invalid_argument("GapSweep::prepare: scenes of different kinds in one batch");
  Batch batch;
  batch.state_ = std::make_shared<typename Batch::State>();
  auto& b = *batch.state_;
  b.sweep = state_;
  std::vector<fem::LoadPath> paths;
  for (const fem::Scene& scene : scenes) {
    paths.push_back(fem::load_path(scene.load));
    b.path_steps.push_back(static_cast<int>(paths.back().steps.size()));
    b.indentation_steps.push_back(paths.back().indentation_steps);
    b.friction.push_back(scene.friction);
  }
  b.steps = scenes.empty() ? 0 : *std::max_element(b.path_steps.begin(), b.path_steps.end());
  Eigen::MatrixXd profiles(state_->columns(), static_cast<Eigen::Index>(scenes.size()));  // mm
  for (std::size_t i = 0; i < scenes.size(); ++i)
    profiles.col(static_cast<Eigen::Index>(i)) =
        fem::profile_heights(scenes[i].indenter, state_->condensation.surface_x);
  b.lay_out(scenes, paths, profiles);

  const int vectors = state_->vectors(scenes.size());
  const std::size_t group = state_->lanes_of_vector * vectors, columns = state_->columns();
  b.tile = group * state_->interleaved;
  b.groups = (scenes.size() + group - 1) / group;
  b.lanes = (scenes.size() + b.tile - 1) / b.tile * b.tile;
  const std::size_t lanes = b.lanes, lane_steps = lanes * b.steps;
  const Device& device = state_->executor.device();
  b.lane_input = Buffer<Real>(device, lanes * LANE_INPUT_ROWS);
  b.profile = Buffer<Real>(device, lanes * columns);
  b.path = Buffer<Real>(device, lane_steps * PATH_ROWS);
  b.result = Buffer<Real>(device, lane_steps * LANE_RESULT_ROWS);
  b.rows = Buffer<Real>(device, std::max<std::size_t>(lane_steps * state_->rows, 1));
  b.nodes = Buffer<Real>(device, state_->options.nodes ? lane_steps * 3 * columns : 1);
  b.fill(scenes, paths, profiles);

  const GapSweepOptions& o = state_->options;
  b.launch = state_->executor.prepare(state_->program(kind, vectors), "gap_sweep", [&](KernelArguments& kernel) {
    kernel.set("compliance", state_->compliance(kind.friction));
    kernel.set("node", state_->node);
    kernel.set("map", state_->map);
    kernel.set("rows", std::int32_t(state_->rows));
    kernel.set("base_rows", std::int32_t(state_->base_rows));
    kernel.set("lane_input", b.lane_input);
    kernel.set("profile", b.profile);
    kernel.set("path", b.path);
    kernel.set("steps", std::int32_t(b.steps));
    kernel.set("tolerance", Real(o.tolerance));
    kernel.set("accept", Real(o.accept));
    kernel.set("most_sweeps", std::int32_t(o.most_sweeps));
    kernel.set("reach", Real(o.reach));
    kernel.set("result", b.result);
    kernel.set("rows_out", b.rows);
    kernel.set("nodes_out", b.nodes);
    kernel.set("write_node_rows", std::int32_t(o.nodes));
  });
  return batch;
}

template <class Real>
void GapSweep<Real>::Batch::run(const RunOptions& options) {
  state_->seconds = state_->sweep->executor.run(state_->launch, state_->groups, options).seconds;
}

template <class Real>
std::size_t GapSweep<Real>::Batch::size() const {
  return state_->place.size();
}

template <class Real>
int GapSweep<Real>::Batch::steps() const {
  return state_->steps;
}

template <class Real>
std::size_t GapSweep<Real>::Batch::steps_in_all() const {
  return std::accumulate(state_->path_steps.begin(), state_->path_steps.end(), std::size_t(0));
}

template <class Real>
double GapSweep<Real>::Batch::seconds() const {
  return state_->seconds;
}

template <class Real>
void GapSweep<Real>::Batch::fill_outputs(Real value) {
  for (const auto* buffer : {&state_->result, &state_->rows, &state_->nodes}) {
    const auto mapped = buffer->map(MapFor::writing);
    std::fill(mapped.view().begin(), mapped.view().end(), value);
  }
}

template <class Real>
void GapSweep<Real>::Batch::fill_unused(Real value) {
  const auto& b = *state_;
  const std::size_t scenes = b.place.size();
  const auto input = b.lane_input.map(MapFor::both), heights = b.profile.map(MapFor::both),
             targets = b.path.map(MapFor::both);
  const auto fill = [&](std::span<Real> buffer, std::size_t lane, std::size_t height, std::size_t from) {
    for (std::size_t row = from; row < height; ++row) buffer[b.at_lane(lane, height, row)] = value;
  };
  for (std::size_t lane = 0; lane < b.lanes; ++lane) {
    const std::size_t scene = std::find(b.place.begin(), b.place.end(), lane) - b.place.begin();
    const std::size_t own_steps = scene < scenes ? b.path_steps[scene] : 0;
    fill(targets.view(), lane, b.steps * PATH_ROWS, own_steps * PATH_ROWS);
    if (scene < scenes) continue;
    fill(input.view(), lane, LANE_INPUT_ROWS, 0);
    fill(heights.view(), lane, b.sweep->columns(), 0);
  }
}

template <class Real>
double GapSweep<Real>::Batch::result(std::size_t i, int step, int row) const {
  const auto& b = *state_;
  Real value;
  b.result.read(std::span(&value, 1), b.at(i, b.steps * LANE_RESULT_ROWS, step * LANE_RESULT_ROWS + row));
  return value;
}

template <class Real>
double GapSweep<Real>::Batch::output(std::size_t i, int step, int row) const {
  const auto& b = *state_;
  Real value;
  b.rows.read(std::span(&value, 1),
              b.at(i, static_cast<std::size_t>(b.steps) * b.sweep->rows, step * b.sweep->rows + row));
  return value;
}

template <class Real>
GapSweep<Real>::Batch::View::View(const Batch& batch)
    : state_(batch.state_),
      results_(state_->result.map(MapFor::reading)),
      rows_(state_->rows.map(MapFor::reading)),
      nodes_(state_->nodes.map(MapFor::reading)) {}

template <class Real>
int GapSweep<Real>::Batch::View::path_steps(std::size_t i) const {
  return state_->path_steps[i];
}

template <class Real>
std::span<const std::size_t> GapSweep<Real>::Batch::View::by_lane() const {
  return state_->order;
}

template <class Real>
Real GapSweep<Real>::Batch::View::result(std::size_t i, int step, int row) const {
  return results_[state_->at(i, state_->steps * LANE_RESULT_ROWS, step * LANE_RESULT_ROWS + row)];
}

template <class Real>
LaneAnswer<Real> GapSweep<Real>::Batch::View::answer(std::size_t i) const {
  const auto& b = *state_;
  const std::size_t rows = b.sweep->rows, steps = b.steps;
  return {.steps = b.path_steps[i],
          .results = results_.view().data() + b.at(i, steps * LANE_RESULT_ROWS, 0),
          .result_rows = LANE_RESULT_ROWS,
          .stresses = rows_.view().data() + b.at(i, steps * rows, b.sweep->base_rows),
          .stress_rows = rows,
          .stride = interleaved()};
}

template <class Real>
std::size_t GapSweep<Real>::Batch::View::interleaved() const {
  return state_->tile;
}

template <class Real>
int GapSweep<Real>::Batch::View::indentation_steps(std::size_t i) const {
  return state_->indentation_steps[i];
}

template <class Real>
fem::ContactSolution GapSweep<Real>::Batch::solution(std::size_t i) const {
  return View(*this).solution(i);
}

template <class Real>
fem::ContactSolution GapSweep<Real>::Batch::View::solution(std::size_t i) const {
  const auto& b = *state_;
  const auto& sweep = *b.sweep;
  const fem::Condensation& c = sweep.condensation;
  const int columns = sweep.columns(), base_nodes = sweep.base_rows / 2, tactels = (sweep.rows - sweep.base_rows) / 2;
  fem::ContactSolution solution{c.surface_x, c.base_x, c.tactel_x, {}, false};
  for (int k = 0; k < b.path_steps[i]; ++k) {
    const auto said = [&](int row) {
      return static_cast<double>(results_[b.at(i, b.steps * LANE_RESULT_ROWS, k * LANE_RESULT_ROWS + row)]);
    };
    const auto output = [&](int row) {
      return static_cast<double>(rows_[b.at(i, static_cast<std::size_t>(b.steps) * sweep.rows, k * sweep.rows + row)]);
    };
    const auto node = [&](int row) {
      return static_cast<double>(
          nodes_[b.at(i, static_cast<std::size_t>(b.steps) * 3 * columns, 3 * k * columns + row)]);
    };
    const int status = static_cast<int>(said(LANE_STATUS));
    if (status == LANE_NOT_RUN) break;
    fem::ContactStep step = lane_step(said, b.friction[i]);
    if (sweep.options.nodes) {
      step.normal_force = Eigen::VectorXd::NullaryExpr(columns, [&](auto n) { return node(n); });
      step.tangential_force = Eigen::VectorXd::NullaryExpr(columns, [&](auto n) { return node(columns + n); });
      for (int n = 0; n < columns; ++n)  // a force that E scales down to 0 is none
        step.status.push_back(node(n) > 0 ? static_cast<fem::GapStatus>(node(2 * columns + n)) : fem::GapStatus::open);
    }
    step.base_force_x = Eigen::VectorXd::NullaryExpr(base_nodes, [&](auto n) { return output(2 * n); });
    step.base_force_y = Eigen::VectorXd::NullaryExpr(base_nodes, [&](auto n) { return output(2 * n + 1); });
    step.sigma_y = Eigen::VectorXd::NullaryExpr(tactels, [&](auto n) { return output(sweep.base_rows + n); });
    step.tau_xy = Eigen::VectorXd::NullaryExpr(tactels, [&](auto n) { return output(sweep.base_rows + tactels + n); });
    solution.sliding = status == LANE_SLIDING && k >= b.indentation_steps[i];
    solution.steps.push_back(std::move(step));
  }
  return solution;
}

template class GapSweep<float>;
template class GapSweep<double>;

}  // namespace tactel::host
