// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/gap_sweep.h"

#include <algorithm>
#include <cmath>

#include "fem/gap/accuracy.h"
#include "fem/gap/contact_laws.h"
#include "fem/numbers/last_used.h"
#include "host/contact/lines/gap_sweep_tables.h"
#include "host/contact/strata.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

constexpr double far_away = 2 * NO_GAP_ELEMENT;  ///< mm: no indenter here
constexpr int grip_strata = 8;                   ///< measured beside 16 and 32
constexpr double window_bins =
    16;  ///< in a factor e of nodes: windows of a group differ by 6 % or a node; measured beside 4, 8, none
/// Returns the vectors of LANES scenes of a work-item that has many scenes. Each number of C that is loaded then serves
/// thrice. Where a vector takes two cycles loads keep up with one vector: then fewer scenes wait for each other, and
/// their forces stay near.
int most_vectors(const Device& device) { return device.info().halves ? 1 : 3; }

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
std::pair<int, double> expected_window(const Eigen::VectorXd& heights, double depth) {
  const auto overlap = (1.25 * depth - heights.array()).max(0);
  const double relative = overlap.sum() / depth;
  return {static_cast<int>((overlap > 0).count()), std::isnan(relative) ? 0 : relative};
}

}  // namespace

template <class Real>
struct GapSweep<Real>::State {
  State(Executor& executor, const fem::Sensor& sensor, const GapSweepOptions& options,
        const std::filesystem::path& cache)
      : executor(executor), sensor(sensor), options(options), condensation(fem::condense_cached(sensor, cache)) {
    const bool by_default = options.tolerance == 0 && options.accept == 0;
    const double usual = sizeof(Real) == 4 ? 1e-5 : 1e-11;
    const auto [tolerance, accept] =
        fem::by_rule<Real>({by_default ? usual : options.tolerance, options.accept}, fem::slow_on_mesh);
    this->options.tolerance = tolerance;
    this->options.accept = options.accept > 0 ? accept : std::max(accept, 2 * fem::lost_force(condensation));
    const Device& device = executor.device();
    lanes_of_vector = device.lanes(precision);
    interleaved = device.interleaved(precision);
    node = buffer_of<Real>(device, node_table<Real>(condensation.compliance));
    const Eigen::MatrixXd base = base_outputs();
    base_rows = static_cast<int>(base.rows());
    rows = base_rows + (options.tactels ? static_cast<int>(condensation.tactel_stress.rows()) : 0);
    Eigen::MatrixXd outputs(rows, condensation.compliance.cols());
    outputs.topRows(base_rows) = base;
    if (options.tactels) outputs.bottomRows(rows - base_rows) = condensation.tactel_stress;
    map = buffer_of<Real>(device, output_table<Real>(outputs));
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
  static constexpr Precision precision = precision_of<Real>;
  /// Returns the vectors of a work-item: one where it holds all scenes, which then do not pay for empty ones.
  int vectors(std::size_t scenes) const {
    return lanes_of_vector == 1 || scenes <= static_cast<std::size_t>(lanes_of_vector)
               ? 1
               : most_vectors(executor.device());
  }

  Buffer<Real> compliance(bool friction) {
    return compliances.get(friction, [&] {
      return buffer_of<Real>(executor.device(), compliance_table<Real>(condensation.compliance, friction));
    });
  }

  Program program(ContactKind kind, int vectors) {
    return programs.get({kind, vectors}, [&] {
      const auto text = [](int value) { return std::to_string(value); };
      return Program(executor.device(), "gap_sweep.cl",
                     {{"REAL", real_type(precision)},
                      {"LANES", text(lanes_of_vector)},
                      {"VECTORS", text(vectors)},
                      {"NODES", text(columns())},
                      {"FORCE_CONTROL", text(kind.force)},
                      {"FRICTION", text(kind.friction)}});
    });
  }

  fem::ContactSolution solution(const LaneView<Real>& view, std::size_t i) const;

  Executor& executor;
  fem::Sensor sensor;
  GapSweepOptions options;
  fem::Condensation condensation;
  Buffer<Real> node, map;
  fem::LastUsed<bool, Buffer<Real>> compliances{2};  ///< by friction
  int rows = 0, base_rows = 0;
  int lanes_of_vector = 1;
  int interleaved = 1;                                              ///< work-items with their numbers side by side
  fem::LastUsed<std::pair<ContactKind, int>, Program> programs{8};  ///< by vectors, too
};

template <class Real>
fem::ContactSolution GapSweep<Real>::State::solution(const LaneView<Real>& view, std::size_t i) const {
  const fem::Condensation& c = condensation;
  const auto& scene = view.scene(i);
  const int nodes = columns(), base_nodes = base_rows / 2, tactels = (rows - base_rows) / 2;
  fem::ContactSolution solution{c.surface_x, c.base_x, c.tactel_x, {}, false};
  for (int k = 0; k < scene.steps; ++k) {
    const auto result = [&](int row) { return static_cast<double>(view.result(i, k, row)); };
    const auto output = [&](auto row) { return static_cast<double>(view.output(i, k, static_cast<int>(row))); };
    const auto node = [&](auto row) { return static_cast<double>(view.force(i, k, static_cast<int>(row))); };
    const int status = static_cast<int>(result(RESULT_STATUS));
    if (status == LANE_NOT_RUN) break;
    fem::ContactStep step = lane_step(result, scene.friction);
    if (options.nodes) {
      step.normal_force = Eigen::VectorXd::NullaryExpr(nodes, [&](auto n) { return node(n); });
      step.tangential_force = Eigen::VectorXd::NullaryExpr(nodes, [&](auto n) { return node(nodes + n); });
      for (int n = 0; n < nodes; ++n)  // a force that E scales down to 0 is none
        step.status.push_back(node(n) > 0 ? static_cast<fem::GapStatus>(node(2 * nodes + n)) : fem::GapStatus::open);
    }
    step.base_force_x = Eigen::VectorXd::NullaryExpr(base_nodes, [&](auto n) { return output(2 * n); });
    step.base_force_y = Eigen::VectorXd::NullaryExpr(base_nodes, [&](auto n) { return output(2 * n + 1); });
    step.sigma_y = Eigen::VectorXd::NullaryExpr(tactels, [&](auto n) { return output(base_rows + n); });
    step.tau_xy = Eigen::VectorXd::NullaryExpr(tactels, [&](auto n) { return output(base_rows + tactels + n); });
    solution.sliding = status == LANE_SLIDING && k >= scene.indentation_steps;
    solution.steps.push_back(std::move(step));
  }
  return solution;
}

template <class Real>
void GapSweep<Real>::Scenes::push_back(const fem::Scene& scene, const fem::LoadPath& path) {
  const auto steps = static_cast<int>(path.steps.size());
  this->add(
      kind_of(scene),
      {.steps = steps, .indentation_steps = path.indentation_steps, .increments = steps, .friction = scene.friction});
  const Eigen::VectorXd heights = fem::profile_heights(scene.indenter, sweep_->condensation.surface_x);  // mm
  const double young = scene.sensor.young, depth = expected_depth(scene, path);
  const auto [nodes, overlap] = expected_window(heights, depth);
  costs_.push_back({nodes, overlap, grip(scene, path, depth)});
  for (const double height : heights) heights_.push_back(static_cast<Real>(std::isinf(height) ? far_away : height));
  const bool force = by_force(scene), both = force && scene.load.angle.has_value();
  double input[LANE_INPUT_ROWS];
  input[LANE_MU] = std::min(scene.friction, fem::largest_friction);
  input[LANE_YOUNG] = young;
  input[LANE_STEPS] = static_cast<double>(path.steps.size());
  input[LANE_MAY_STOP] = path.until_sliding ? path.indentation_steps : 1e6;
  input[LANE_FORCE] = force ? (both ? FORCE_BOTH : FORCE_NORMAL) : FORCE_NONE;
  for (const double number : input) this->inputs.push_back(static_cast<Real>(number));
  static_assert(PATH_NORMAL == 0 && PATH_TANGENTIAL == 1 && PATH_ROWS == 2);
  for (const fem::LoadStep& step : path.steps) {
    this->targets.push_back(static_cast<Real>(force ? step.normal / young : step.normal));
    this->targets.push_back(static_cast<Real>(both ? step.tangential / young : step.tangential));
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
ContactBatch<Real> GapSweep<Real>::prepare(std::span<const fem::Scene> scenes) const {
  Scenes all(*this);
  for (const fem::Scene& scene : scenes) all.push_back(scene, fem::load_path(scene.load));
  return prepare(std::move(all));
}

/// Scenes of like cost side by side, so that the lanes of a group finish together.
template <class Real>
std::vector<std::size_t> GapSweep<Real>::Scenes::by_cost() const {
  std::vector<double> grips;
  grips.reserve(costs_.size());
  for (const Cost& cost : costs_) grips.push_back(cost.grip);
  const std::vector<int> stratum = strata(grips, grip_strata);
  std::vector<std::tuple<int, int, int, double, std::size_t>> keys;
  keys.reserve(costs_.size());
  for (std::size_t i = 0; i < costs_.size(); ++i)
    keys.emplace_back(static_cast<int>(window_bins * std::log(std::max(costs_[i].nodes, 1))), this->scenes[i].steps,
                      stratum[i], costs_[i].overlap, i);
  std::ranges::sort(keys, std::greater<>());
  std::vector<std::size_t> order;
  order.reserve(keys.size());
  for (const auto& key : keys) order.push_back(std::get<4>(key));
  return order;
}

template <class Real>
ContactBatch<Real> GapSweep<Real>::prepare(Scenes scenes) const {
  auto batch = std::make_shared<LaneState<Real>>();
  auto& b = *batch;
  const GapSweepOptions& o = state_->options;
  const ContactKind kind = scenes.kind;
  const int vectors = state_->vectors(scenes.size());
  const std::size_t columns = state_->columns();
  const std::vector<Real> heights = std::move(scenes.heights_);
  const std::vector<std::size_t> order = scenes.by_cost();
  scenes.sensors = {state_->sensor};
  b.lay_out(state_->executor, std::move(scenes), order, static_cast<std::size_t>(state_->lanes_of_vector) * vectors,
            state_->interleaved, LANE_INPUT_ROWS, PATH_ROWS);
  const LaneArray<Real> profile = b.array(b.input.tile, 1, columns, Real(far_away), [&](std::size_t i) {
    return std::span(heights).subspan(i * columns, columns);
  });
  b.more_inputs = {profile};
  b.stresses_from = state_->base_rows;
  const auto outputs = [&](std::size_t rows, bool written = true) {
    return LaneArray<Real>(b.device(), written ? b.lanes : 0, b.input.tile, b.steps, rows);
  };
  b.results = outputs(LANE_RESULT_ROWS), b.outputs = outputs(state_->rows);
  b.forces = outputs(3 * columns, o.nodes), b.patches = outputs(0);
  auto launch = state_->executor.prepare(state_->program(kind, vectors), "gap_sweep", [&](KernelArguments& kernel) {
    kernel.set("compliance", state_->compliance(kind.friction));
    kernel.set("node", state_->node);
    kernel.set("map", state_->map);
    kernel.set("rows", std::int32_t(state_->rows));
    kernel.set("base_rows", std::int32_t(state_->base_rows));
    kernel.set("lane_input", b.input.numbers);
    kernel.set("profile", profile.numbers);
    kernel.set("path", b.path.numbers);
    kernel.set("steps", std::int32_t(b.steps));
    kernel.set("tolerance", Real(o.tolerance));
    kernel.set("accept", Real(o.accept));
    kernel.set("most_sweeps", std::int32_t(o.most_sweeps));
    kernel.set("reach", Real(o.reach));
    kernel.set("result", b.results.numbers);
    kernel.set("rows_out", b.outputs.numbers);
    kernel.set("nodes_out", b.forces.numbers);
    kernel.set("write_node_rows", std::int32_t(o.nodes));
  });
  b.rounds = {{{std::move(launch), b.groups}}};
  b.solution = [sweep = state_](const LaneView<Real>& view, std::size_t i) { return sweep->solution(view, i); };
  return Batch(std::move(batch));
}

template class GapSweep<float>;
template class GapSweep<double>;

}  // namespace tactel::host
