// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "fem/numbers/value_error.h"
#include "fem/pad/pad_markers.h"
#include "host/contact/limits.h"
#include "host/contact/pads/pad_lanes.h"
#include "host/contact/pads/pad_search.h"
#include "host/contact/pads/pad_side_tables.h"
#include "host/contact/pads/pad_sums.h"
#include "host/support/side_by_side.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

constexpr int own_tables = 0;   ///< in place of a number of vectors: every lane has a table of its own
constexpr int free_sides = -1;  ///< the same: work-items are scenes whose sides are free
constexpr std::size_t bytes_of_wide_vector = 64;           ///< of AVX-512
constexpr std::size_t most_forces = std::size_t{1} << 24;  ///< of cells in a launch; twice as many on a GPU
constexpr int many_cells = 12;  ///< a side: the tractions of a wide vector of scenes are beyond the nearest cache

/// Whether the twin searches the contact: pad_search.cl knows flat skins of one layer, whose sides are held.
bool searched_by_twin(const fem::PadSensor& sensor) {
  return fem::has_free_sides(sensor) || sensor.curvature_radius || !sensor.layers.empty();
}

}  // namespace

template <class Real>
struct PadContact<Real>::State {
  State(Executor& executor, const fem::PadOptions& given)
      : executor(executor),
        options(given),
        search(executor, given.any_poisson),
        rubbers(given.cells, precision == Precision::fp64, given.any_poisson),
        side_tables(executor.device()) {
    constexpr std::array known{8, 12, 16, 24};
    if (std::ranges::find(known, given.cells) == known.end())
      throw ValueError("cells", std::to_string(given.cells), "8, 12, 16 or 24");
    const auto [tolerance, accept] = fem::by_rule<Real>({given.tolerance, given.accept}, fem::slow_on_patch);
    options.tolerance = tolerance, options.accept = accept;
  }

  static constexpr Precision precision = precision_of<Real>;
  const Device& device() const { return executor.device(); }
  /// Lanes. Half of them where a wide vector takes as long as its halves, and there are many cells.
  std::size_t width() const {
    const auto lanes = static_cast<std::size_t>(device().lanes(precision));
    const bool half =
        device().info().halves && lanes * sizeof(Real) == bytes_of_wide_vector && options.cells >= many_cells;
    return half ? lanes / 2 : lanes;
  }
  std::size_t count() const { return static_cast<std::size_t>(options.cells) * options.cells; }

  Program program(int vectors, const Laid& b) {
    return programs.get({vectors, b.mapped, b.creep_terms}, [&] {
      const bool free = vectors == free_sides;
      Defines defines{{"REAL", real_type(precision)},
                      {"LANES", std::to_string(free ? 1 : width())},
                      {"CELLS", std::to_string(options.cells)},
                      {"VECTORS", std::to_string(std::max(vectors, 1))},
                      {"OWN_TABLES", std::to_string(vectors == own_tables)}};
      if (b.mapped) defines.emplace_back("FRICTION_MAP", "1");
      if (b.creep_terms > 0) defines.emplace_back("CREEP_TERMS", std::to_string(b.creep_terms));
      if (free) defines.emplace_back("WIDE", std::to_string(device().lanes(precision)));
      return Program(device(), free ? "pad_free_contact.cl" : "pad_contact.cl", defines);
    });
  }

  /// Lays the cells of a scene, and takes what they need. `found`: by the kernel, where that searches.
  void lay(PadOnCells& on, std::optional<fem::PadCells> cells, const fem::PadSearch* found) {
    fem::PadScene& scene = on.scene;
    const double H = scene.sensor.thickness;
    const auto& at = scene.indenter.position;
    on.sides = fem::sides_at(scene.sensor, {at[0], at[1]}, fem::SideBricks::usual, StopScope::checker());
    const auto means = on.sides.free() ? rubbers.tables({scene.sensor.poisson}, true) : nullptr;
    double depth = 0;
    if (!cells) {
      const auto on_pad = [&](const fem::PadLayer& layer) {
        return fem::lay_cells(scene, layer, options.cells, options.ladder, on.sides);
      };
      fem::PadLayout laid = found                      ? fem::lay_cells(*found, scene, options.cells, options.ladder)
                            : !means                   ? on_pad(fem::pad_layer(scene))
                            : on.object().softness > 0 ? on_pad(means->layer()->beside(on.object()))
                                                       : on_pad(*means->layer());
      scene.indenter = std::move(laid.indenter), cells = laid.cells, depth = laid.depth;
    }
    on.solvable = fem::solvable(*cells, H, depth) && !reaches_beyond_block(scene, *cells);
    if (!on.solvable) cells->hx = cells->hy = H, cells->x_middle = cells->y_middle = 0;
    on.cells = *cells, on.size = cell_size(*cells, H), on.path = fem::pad_increments(scene, options, *cells);
    on.heights = (fem::heights_on_pad(on.cells, scene).transpose() / H).cwiseMin(double{PAD_OPEN}).reshaped();
    if (!means) return;
    on.softs = fem::shared_compliances(on.cells, scene) / H;
    on.influence = means->influence(on.size, on.object());
  }

  /// The scenes on their cells.
  std::vector<PadOnCells> on_cells(Scenes& scenes) {
    std::vector<PadOnCells> all(scenes.all_.size());
    std::vector<std::size_t> by_twin, by_kernel;
    std::vector<const fem::PadScene*> searched;
    for (std::size_t i = 0; i < all.size(); ++i) {
      fem::PadScene& scene = all[i].scene = std::move(scenes.all_[i].scene);
      const bool twin = searched_by_twin(scene.sensor);
      (twin ? by_twin : by_kernel).push_back(i);
      if (twin || scenes.all_[i].cells) continue;
      scene.indenter = fem::aligned(std::move(scene.indenter), scene.sensor);
      searched.push_back(&scene);
    }
    const std::vector<fem::PadSearch> found = search.find(searched);
    side_by_side(by_twin.size(), executor.threads(),
                 [&](std::size_t k) { lay(all[by_twin[k]], scenes.all_[by_twin[k]].cells, nullptr); });
    auto next = found.begin();
    for (const std::size_t i : by_kernel) lay(all[i], scenes.all_[i].cells, scenes.all_[i].cells ? nullptr : &*next++);
    return all;
  }

  LaneScenes<Real> numbers(const Laid& b, const Scenes& scenes) const {
    const std::vector<PadOnCells>& on_cells = b.on_cells;
    LaneScenes<Real> all;
    const auto put = [](std::vector<Real>& to, const auto& numbers) {
      for (const double number : numbers) to.push_back(static_cast<Real>(number));
    };
    for (std::size_t i = 0; i < on_cells.size(); ++i) {
      const PadOnCells& of = on_cells[i];
      const fem::PadScene& scene = of.scene;
      all.add({}, {.steps = static_cast<int>(scenes.all_[i].path.steps.size()),
                   .indentation_steps = static_cast<int>(fem::pressing_targets(scene.load)),
                   .increments = static_cast<int>(of.path.size()),
                   .friction = scene.friction,
                   .young = scene.sensor.young});
      const double H = scene.sensor.thickness, force = scene.sensor.young * H * H, yaw = of.frame(),
                   cosine = std::cos(yaw), sine = std::sin(yaw);
      double input[PAD_INPUT_ROWS] = {};
      input[PAD_MU] = of.solvable ? scene.friction : std::numeric_limits<double>::quiet_NaN();  // which is no scene
      input[PAD_STEPS] = static_cast<double>(of.path.size());
      input[PAD_X_MIDDLE] = of.cells.x_middle / H, input[PAD_Y_MIDDLE] = of.cells.y_middle / H;
      input[PAD_FORCE] = force, input[PAD_THICKNESS] = H;
      input[PAD_COSINE] = cosine, input[PAD_SINE] = sine, input[PAD_BY_FORCE] = by_force(scene);
      if (of.sides.kernel) {
        const Eigen::Vector2d at = of.sides.in_block({scene.indenter.position[0], scene.indenter.position[1]});
        input[PAD_BLOCK_X] = at[0], input[PAD_BLOCK_Y] = at[1];
      }
      put(all.inputs, input);
      if (b.mapped) put(all.inputs, fem::friction_on_cells(of.cells, scene));
      const fem::Creep creep(scene.sensor.relaxation);
      int slot = 0;
      for (const auto& [to, asked, dt] : of.path) {
        double target[PAD_PATH_ROWS] = {};
        target[PAD_NORMAL] = to.normal / (by_force(scene) ? force : H);
        target[PAD_X] = (cosine * to.x + sine * to.y) / H, target[PAD_Y] = (cosine * to.y - sine * to.x) / H;
        target[PAD_TWIST] = to.twist, target[PAD_SLOT] = asked ? slot++ : -1;
        put(all.targets, target);
        if (b.creep_terms == 0) continue;
        const fem::CreepStep step = creep.step(dt);
        std::vector<double> rows{step.softer};
        for (const auto& term : step.terms) std::ranges::copy(creep_numbers(term), std::back_inserter(rows));
        rows.resize(static_cast<std::size_t>(b.path_rows()) - PAD_PATH_ROWS);
        put(all.targets, rows);
      }
    }
    return all;
  }

  /// Tables of groups that share one, and of lanes that have their own: these lie behind the others.
  void take_tables(Laid& b, const PadLanes& lanes) {
    Distinct<Real, PadOnCells::Table> shared;
    std::vector<std::int32_t> table_of_group;
    for (const std::size_t i : lanes.first_of_group) {
      const PadOnCells& of = b.on_cells[i];
      const auto table = shared.take(of.table(), [&] {
        return rubbers.tables(fem::rubber(of.scene.sensor))
            ->shared_influence(of.size, of.object(), options.cells, options.cells);
      });
      table_of_group.push_back(static_cast<std::int32_t>(table.first / table.count));
    }
    b.tables = buffer_of<Real>(device(), shared.numbers);
    b.table_of_group = buffer_of<std::int32_t>(device(), table_of_group);
    const std::size_t side = static_cast<std::size_t>(options.cells) + 1, own_lanes = lanes.own_groups * lanes.width;
    const auto own = std::span(lanes.in_lane).last(own_lanes);
    LaneArray<Real> array(device(), own_lanes, lanes.width, 1, PAD_TABLE_HEAD + side * side * PAD_OWN_INFLUENCE);
    const auto all = array.numbers.map(MapFor::writing);
    std::ranges::fill(all.view(), Real(1));  // lanes without a scene: no zeros to divide by
    for (std::size_t lane = 0; lane < own_lanes; ++lane) {
      if (own[lane] == no_scene) continue;
      const PadOnCells& of = b.on_cells[own[lane]];
      array.put(all.view(), lane,
                of.influence ? *of.influence
                             : *rubbers.tables(fem::rubber(of.scene.sensor))->influence(of.size, of.object()));
    }
    b.own_tables = array.numbers;
  }

  /// What scenes with free sides have besides.
  void take_sides(Laid& b) {
    const fem::PadSides& sides = b.on_cells.front().sides;
    b.nodes = sides.kernel->mesh().cells, b.sides = sides.kernel->sides();
    b.between = side_tables.between(sides);
    Distinct<Real, std::pair<double, double>> places;
    std::vector<std::int32_t> response_of;
    for (const PadOnCells& of : b.on_cells) {
      const auto place = places.take({of.sides.middle[0], of.sides.middle[1]},
                                     [&] { return *side_tables.response(of.scene.sensor, of.sides); });
      response_of.push_back(static_cast<std::int32_t>(place.first / place.count));
    }
    b.responses = buffer_of<Real>(device(), places.numbers);
    b.response_of = buffer_of<std::int32_t>(device(), response_of);
    b.softs = b.array(
        1, 1, count(), 0, [&](std::size_t i) -> const auto& { return b.on_cells[i].softs; });
  }

  Launch contact_launch(const Laid& b, int vectors, std::size_t first) {
    const bool free = vectors == free_sides;
    const char* const kernel_name = free ? "pad_free_contact" : "pad_contact";
    return executor.prepare(program(vectors, b), kernel_name, [&](KernelArguments& kernel) {
      if (free) {
        kernel.set("pairs", b.between);  // until it is run
        kernel.set("layers", b.own_tables);
        kernel.set("softs", b.softs.numbers);
        kernel.set("between", b.between);
        bind_sides(b, kernel);
        kernel.set("first_scene", std::int32_t(first));
      } else {
        kernel.set("tables", vectors == own_tables ? b.own_tables : b.tables);
        kernel.set("table_of", b.table_of_group);
        kernel.set("first_vector", std::int32_t(first));
      }
      kernel.set("lane_input", b.input.numbers);
      kernel.set("path", b.path.numbers);
      kernel.set("heights", b.more_inputs.front().numbers);
      kernel.set("increments", std::int32_t(b.increments));
      kernel.set("slots", std::int32_t(b.steps));
      kernel.set("write_forces", std::int32_t(1));
      kernel.set("tolerance", Real(options.tolerance));
      kernel.set("accept", Real(options.accept));
      kernel.set("most_sweeps", std::int32_t(options.most_sweeps));
      kernel.set("result", b.results.numbers);
      kernel.set("forces", b.cell_forces.numbers);
      kernel.set("memory", b.cell_forces.numbers);  // until it is run; read where LANES is 1 and rubber creeps
    });
  }

  Launch sums_launch(const Laid& b, const PadSums<Real>& sums, int vectors) {
    return executor.prepare(program(vectors, b), "pad_base_stress", [&](KernelArguments& kernel) {
      kernel.set("layer", sums.tables);
      kernel.set("layer_rows", std::int32_t(sums.rows));
      kernel.set("rows_a_thickness", Real(sums.rows_a_thickness));
      kernel.set("places", sums.cells.numbers);
      kernel.set("shares", sums.shares);
      kernel.set("points", sums.points);
      kernel.set("weights", sums.weights);
      kernel.set("parts", std::int32_t(sums.parts));
      kernel.set("tactels", std::int32_t(sums.count));
      kernel.set("slots", std::int32_t(b.steps));
      kernel.set("numbers", std::int32_t(b.outputs.rows));
      kernel.set("from", std::int32_t(&sums == &b.stress ? 0 : 3 * b.stress.count));
      kernel.set("first_part", std::int32_t(&sums == &b.stress ? 0 : b.force_parts() - 3));
      kernel.set("forces", b.cell_forces.numbers);
      kernel.set("stress", b.outputs.numbers);
    });
  }

  static void bind_sides(const Laid& b, KernelArguments& kernel) {
    kernel.set("nodes_x", std::int32_t(b.nodes[0]));
    kernel.set("nodes_y", std::int32_t(b.nodes[1]));
    kernel.set("side_x", Real(b.sides[0]));
    kernel.set("side_y", Real(b.sides[1]));
  }

  Launch side_stress_launch(const Laid& b) {
    return executor.prepare(program(free_sides, b), "pad_side_stress", [&](KernelArguments& kernel) {
      kernel.set("responses", b.responses);
      kernel.set("response_of", b.response_of);
      bind_sides(b, kernel);
      kernel.set("lane_input", b.input.numbers);
      kernel.set("places", b.stress.cells.numbers);
      kernel.set("tactels", std::int32_t(b.stress.count));
      kernel.set("slots", std::int32_t(b.steps));
      kernel.set("forces", b.cell_forces.numbers);
      kernel.set("stress", b.outputs.numbers);
    });
  }

  /// Scenes with free sides whose tables are in memory: some 128 MB on a processor, which has few at work, and what a
  /// GPU can spare.
  std::size_t groups_at_once() const {
    const std::size_t on_host = std::size_t{1} << 27;
    const std::size_t bytes = device().info().type == DeviceType::gpu ? memory_of(device().info()) / 4 : on_host;
    return std::max<std::size_t>(8, bytes / (sizeof(Real) * PAIRS_NUMBERS(static_cast<std::size_t>(options.cells))));
  }

  /// Lends a run the memory of an argument that nobody reads after it, of this kernel or all: launches one after
  /// another touch the same pages.
  void lend(Laid& b, std::string_view kernel, std::string_view argument, std::size_t size) {
    b.borrow = [&b, this, kernel, argument, size, others = std::move(b.borrow)]() -> std::shared_ptr<const void> {
      const auto other = others ? others() : std::shared_ptr<const void>();
      auto lent = side_tables.borrow(size);
      for (auto& jobs : b.rounds)
        for (Job& job : jobs)
          if (kernel.empty() || job.launch.kernel() == kernel) job.launch.set(argument, *lent);
      return std::make_shared<const std::pair<decltype(lent), decltype(other)>>(lent, other);
    };
  }

  void put_free_jobs(Laid& b) {
    const std::size_t at_once = std::min(groups_at_once(), b.lanes);
    lend(b, "pad_free_contact", "pairs", at_once * PAIRS_NUMBERS(static_cast<std::size_t>(options.cells)));
    if (b.creep_terms > 0) lend(b, "pad_free_contact", "memory", at_once * b.memory_rows() * count());
    for (std::size_t first = 0; first < b.lanes; first += at_once)
      b.rounds.push_back({{contact_launch(b, free_sides, first), std::min(at_once, b.lanes - first)}});
    b.rounds.push_back({{sums_launch(b, b.stress, own_tables), b.stress.groups}});
    b.rounds.push_back({{side_stress_launch(b), b.lanes}});
  }

  void put_held_jobs(Laid& b, const PadLanes& lanes) {
    auto& jobs = b.rounds.emplace_back();
    if (b.creep_terms > 0 && width() == 1) lend(b, "pad_contact", "memory", b.lanes * b.memory_rows() * count());
    if (lanes.own_groups > 0)  // first, for they take longer
      jobs.push_back({contact_launch(b, own_tables, lanes.groups * lanes.vectors), lanes.own_groups});
    if (lanes.groups > 0) jobs.push_back({contact_launch(b, lanes.vectors, 0), lanes.groups});
    const int vectors = lanes.own_groups > 0 ? own_tables : lanes.vectors;
    b.rounds.push_back({{sums_launch(b, b.stress, vectors), b.stress.groups}});
    if (b.markers.count > 0) b.rounds.back().push_back({sums_launch(b, b.markers, vectors), b.markers.groups});
  }

  Executor& executor;
  fem::PadOptions options;
  PadSearch<Real> search;
  PadRubbers rubbers;
  PadSideTables<Real> side_tables;
  fem::LastUsed<std::tuple<int, bool, std::size_t>, Program> programs{16};  ///< by vectors, or own_tables; with a map;
                                                                            ///< terms of creep
};

template <class Real>
void PadContact<Real>::Scenes::push_back(const fem::PadScene& scene, PadPath path,
                                         const std::optional<fem::PadCells>& cells) {
  const fem::PadScene& first = all_.empty() ? scene : all_.front().scene;
  const auto check = [](bool alike, const char* what) {
    if (!alike) throw std::invalid_argument(std::string("PadContact: scenes with different ") + what + " in one batch");
  };
  check(tactels_of(scene.sensor) == tactels_of(first.sensor), "tactels");
  check(free_block(scene.sensor) == free_block(first.sensor), "free sides");
  check(scene.markers == first.markers && marker_depth(scene) == marker_depth(first), "markers");
  all_.push_back({scene, std::move(path), cells});
}

template <class Real>
PadContact<Real>::PadContact(Executor& executor, const fem::PadOptions& options)
    : state_(std::make_shared<State>(executor, options)) {}

template <class Real>
const fem::PadOptions& PadContact<Real>::options() const {
  return state_->options;
}

template <class Real>
Executor& PadContact<Real>::executor() const {
  return state_->executor;
}

template <class Real>
std::shared_ptr<const fem::PadLayer> PadContact<Real>::layer(const fem::Rubber& rubber) const {
  if (state_->options.any_poisson) return std::make_shared<const fem::PadLayer>(fem::pad_layer(rubber));
  return state_->rubbers.tables(rubber)->layer();
}

template <class Real>
std::size_t PadContact<Real>::most_lane_steps(const Scenes& scenes) const {
  constexpr std::size_t most_with_responses = 4096;
  const std::size_t markers = scenes.all_.empty() ? 0 : fem::marker_count(scenes.all_.front().scene.markers);
  const bool gpu = state_->device().info().type == DeviceType::gpu;
  const bool creeps =
      std::ranges::any_of(scenes.all_, [](const auto& one) { return !one.scene.sensor.relaxation.empty(); });
  const std::size_t most = (gpu ? 2 : 1) * most_forces / (3 * std::max((creeps ? 2 : 1) * state_->count(), markers));
  return long_pads_ ? std::min(most, most_with_responses) : most;
}

template <class Real>
PadContact<Real> PadContact<Real>::for_long_pads() const {
  PadContact other = *this;
  other.long_pads_ = true;
  return other;
}

template <class Real>
typename PadContact<Real>::Batch PadContact<Real>::prepare(std::span<const fem::PadScene> scenes,
                                                           std::span<const fem::PadCells> cells) const {
  Scenes all(*this);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    all.push_back(scenes[i], {fem::pad_targets(scenes[i].load)},
                  cells.empty() ? std::nullopt : std::optional(cells[i]));
  return prepare(std::move(all));
}

template <class Real>
typename PadContact<Real>::Batch PadContact<Real>::prepare(Scenes scenes, bool forces) const {
  State& s = *state_;
  auto laid = std::make_shared<Laid>();
  Laid& b = *laid;
  b.contact = state_;
  b.on_cells = s.on_cells(scenes);
  for (const PadOnCells& of : b.on_cells) {
    b.mapped |= of.scene.friction_map.has_value();
    b.creep_terms = std::max(b.creep_terms, of.scene.sensor.relaxation.size());
  }
  const bool free = b.on_cells.front().sides.kernel != nullptr;
  const std::size_t width = s.width();
  // Two vectors have 18 sums: AVX-512 has 32 registers, AVX 16.
  const bool two_fit = width * sizeof(Real) >= bytes_of_wide_vector && s.options.cells <= 12;
  const PadLanes lanes(b.on_cells, s.options.vectors, width, two_fit);
  b.lay_out(s.executor, s.numbers(b, scenes), lanes.in_lane, lanes.width, 1, PAD_INPUT_ROWS + b.mapped * s.count(),
            b.path_rows());
  s.take_tables(b, lanes);
  if (free) s.take_sides(b);
  const std::size_t ring = static_cast<std::size_t>(s.options.cells) + 2;
  b.more_inputs = {b.array(
      b.input.tile, 1, ring * ring, 0, [&](std::size_t i) -> const auto& { return b.on_cells[i].heights; })};
  b.stress = PadSums<Real>::stress(b, b.on_cells, s.rubbers, width);
  b.markers = PadSums<Real>::markers(b, b.on_cells, s.rubbers, width);

  const auto outputs = [&](std::size_t rows, bool written = true) {
    return LaneArray<Real>(s.device(), written ? b.lanes : 0, 1, b.steps, rows);
  };
  const std::size_t numbers = static_cast<std::size_t>(b.force_parts()) * s.count();
  b.cell_forces = outputs(numbers, forces);
  b.results = outputs(PAD_RESULT_ROWS);
  b.outputs = outputs(3 * static_cast<std::size_t>(b.stress.count + b.markers.count));
  b.forces = forces ? b.cell_forces : outputs(0, false), b.patches = outputs(0, false);
  if (free)
    s.put_free_jobs(b);
  else
    s.put_held_jobs(b, lanes);
  if (!forces) b.on_cells.clear(), s.lend(b, "", "forces", std::max(most_forces, b.lanes * b.steps * numbers));
  return Batch(std::move(laid));
}

template <class Real>
void PadContact<Real>::Batch::set_parts(bool base_stress) {
  for (std::vector<Job>& jobs : laid_->rounds)
    for (Job& job : jobs) {
      const std::string& kernel = job.launch.kernel();
      if (kernel == "pad_contact" || kernel == "pad_free_contact")
        job.launch.set("write_forces", std::int32_t(base_stress));
      if (kernel == "pad_base_stress") job.groups = base_stress ? laid_->stress.groups : 0;
      if (kernel == "pad_side_stress") job.groups = base_stress ? laid_->lanes : 0;
    }
}

template <class Real>
fem::PadSolution PadContact<Real>::Batch::solution(const LaneView<Real>& view, std::size_t i) const {
  if (laid_->forces.rows == 0) throw std::logic_error("PadContact: a solution of a batch without forces");
  const fem::PadScene& scene = this->scene(i);
  const fem::PadCells& cells = this->cells(i);
  const Eigen::Index count = cells.count();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(laid_->on_cells[i].frame()).toRotationMatrix();
  const std::vector<fem::PadTarget> targets = fem::pad_targets(scene.load);
  const LaneAnswer answer = view.answer(i);
  const bool solvable = laid_->on_cells[i].solvable;  // else nothing was written but the results
  fem::PadSolution solution;
  solution.cells = cells;
  solution.outside = penetrated_sides(answer);
  solution.places.resize(count, 2);
  for (int k = 0; k < count; ++k)
    solution.places.row(k) = (turn * Eigen::Vector2d(cells.x(k / cells.n), cells.y(k % cells.n))).transpose() +
                             Eigen::RowVector2d(scene.indenter.position[0], scene.indenter.position[1]);
  const Eigen::VectorXd mu = fem::friction_on_cells(cells, scene);
  std::vector<double> numbers(laid_->outputs.rows);
  for (int k = 0; k < answer.steps; ++k) {
    const auto result = [&](int row) { return answer.result(k, row); };
    const auto forces = [&](Eigen::Index part) {
      return Eigen::VectorXd::NullaryExpr(count, [&, part](Eigen::Index cell) {
        return solvable ? static_cast<double>(view.force(i, k, static_cast<int>(part * count + cell))) : 0;
      });
    };
    const Eigen::VectorXd pressing = forces(0);
    fem::PadStep step = pad_step(result, targets[static_cast<std::size_t>(k)], fem::mean_friction(scene, mu, pressing));
    step.normal_force = pressing;
    Eigen::MatrixX2d own(count, 2);
    own << forces(1), forces(2);
    const double inside = std::is_same_v<Real, float> ? 1 - 1e-6 : 1 - 1e-12;
    for (Eigen::Index c = 0; c < count; ++c) {
      const double n = step.normal_force[c];
      step.status.push_back(!(n > 0)                                 ? fem::GapStatus::open
                            : own.row(c).norm() < inside * mu[c] * n ? fem::GapStatus::stick
                                                                     : fem::GapStatus::slip);
    }
    step.tangential_force = own * turn.transpose();
    if (!scene.sensor.relaxation.empty()) {
      own << forces(4), forces(5);
      step.straining.resize(count, 3), step.straining << forces(3), own * turn.transpose();
    }
    if (solvable) answer.tactels(k, std::span(numbers));
    step.stress = Eigen::Map<const Eigen::MatrixX3d>(numbers.data(), laid_->stress.count, 3);
    if (laid_->markers.count > 0) {
      const double* const z = numbers.data() + step.stress.size();  // then x, then y
      const Eigen::Map<const Eigen::MatrixX3d> zxy(z, laid_->markers.count, 3);
      step.markers.resize(zxy.rows(), 3), step.markers << zxy.rightCols<2>(), zxy.col(0);
    }
    step.converged = step.converged && step.stress.allFinite();
    solution.steps.push_back(std::move(step));
  }
  return solution;
}

PadTactels tactels_of(const fem::PadSensor& s) {
  return {s.tactels, s.pitch, s.tactel_size, fem::TactelPoints::along(s), s.depth / s.thickness};
}

std::array<double, 4> free_block(const fem::PadSensor& sensor) {
  if (!fem::has_free_sides(sensor)) return {};
  return {*sensor.length, *sensor.width, sensor.thickness, sensor.poisson};
}

fem::PadStep pad_step(const std::function<double(int row)>& row, const fem::PadTarget& target, double mu) {
  auto step = step_of<fem::PadStep>(row, mu);
  step.x = target.x, step.y = target.y, step.twist = target.twist, step.mu = mu;
  step.Q = {row(PAD_RESULT_QX), row(PAD_RESULT_QY)}, step.M = row(PAD_RESULT_M);
  if (step.slip_index) {
    step.slip_index = std::min(1.0, *step.slip_index);  // fp32 rounds beyond it
    step.force_ratio = step.Q.norm() / (mu * step.P);
  }
  const double stick = row(RESULT_STICKING), touch = stick + row(RESULT_SLIPPING);
  step.stick_fraction = touch > 0 ? stick / touch : 0;
  step.area = row(PAD_RESULT_AREA), step.across = static_cast<int>(row(PAD_RESULT_ACROSS));
  step.reach = {{row(PAD_RESULT_LEFT), row(PAD_RESULT_RIGHT)}, {row(PAD_RESULT_BELOW), row(PAD_RESULT_ABOVE)}};
  step.residual.angle = row(PAD_RESULT_ANGLE), step.slid = row(PAD_RESULT_SLID),
  step.slip_path = row(PAD_RESULT_SLIP_PATH);
  return step;
}

std::array<bool, 4> penetrated_sides(const LaneAnswer& answer) {
  std::array<bool, 4> sides{};
  for (int k = 0; k < answer.steps; ++k)
    for (int side = 0; side < 4; ++side)
      sides[side] |= (static_cast<int>(answer.result(k, PAD_RESULT_OUTSIDE)) >> side & 1) != 0;
  return sides;
}

template class PadContact<float>;
template class PadContact<double>;

}  // namespace tactel::host
