// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <list>
#include <map>
#include <mutex>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "fem/numbers/angles.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "host/contact/limits.h"
#include "host/contact/pads/pad_contact_tables.h"
#include "host/contact/pads/pad_search.h"
#include "host/contact/pads/pad_side_tables.h"
#include "host/contact/strata.h"
#include "host/support/side_by_side.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

constexpr int pad_friction_strata = 4;
constexpr std::size_t most_poissons = 32;  ///< whose tables are kept
constexpr int own_tables = 0;              ///< in place of a number of vectors: every lane has a table of its own
constexpr int free_sides = -1;             ///< the same: work-items are scenes whose sides are free
constexpr double uniform_part = 0.4;       ///< H: of a cell under which two Gauss points give the base stress
constexpr std::size_t bytes_of_wide_vector = 64;  ///< of AVX-512
constexpr int many_cells = 12;  ///< a side: the tractions of a wide vector of scenes are beyond the nearest cache

/// A scene on its cells.
struct OnCells {
  fem::PadScene scene;
  fem::PadCells cells;
  PadCellSize size;
  bool solvable = true;  ///< else some cells stand for those that the scene would need
  // With free sides:
  fem::PadSides sides{};
  Eigen::MatrixXd heights{};                               ///< fem::heights_on_pad
  Eigen::VectorXd softs{};                                 ///< fem::shared_compliances
  std::shared_ptr<const std::vector<double>> influence{};  ///< of the layer: PadTables::influence
};

fem::SoftObject object_of(const fem::PadScene& scene) { return fem::soft_object(scene.sensor, scene.indenter); }

/// Depth of markers over H; 0: none.
double marker_depth(const fem::PadScene& scene) {
  return scene.markers ? scene.markers->depth / scene.sensor.thickness : 0;
}

/// Whether the twin searches the contact: pad_search.cl knows flat skins of one layer.
bool searched_by_twin(const fem::PadSensor& sensor) { return sensor.curvature_radius || !sensor.layers.empty(); }

/// What scenes share a table by.
using TableKey = std::tuple<fem::Rubber, PadCellSize, fem::SoftObject>;
TableKey table_key(const OnCells& on) { return {fem::rubber(on.scene.sensor), on.size, object_of(on.scene)}; }

/// Gauss's points of a side in so many equal parts.
std::vector<fem::PadLayer::Share> gauss_points(int parts) {
  std::vector<fem::PadLayer::Share> all;
  for (int k = 0; k < parts; ++k)
    for (const double at : {-0.5 / std::numbers::sqrt3, 0.5 / std::numbers::sqrt3})
      all.push_back({at / parts + (k - (parts - 1) / 2.0) / parts, 0.5 / parts});
  return all;
}

/// Frame of the cells on the pad.
double frame_of(const OnCells& of) { return fem::radians(of.cells.frame(of.scene.indenter)); }

/// Scenes in lanes. First groups of `vectors` vectors that share a table, then groups of a vector whose lanes have
/// their own.
struct PadLanes {
  std::vector<std::size_t> in_lane;
  std::vector<std::size_t> first_of_group;  ///< [groups that share a table] a scene that has it
  int vectors = 1;
  std::size_t groups = 0, own_groups = 0;
};

/// How straight the indenter's way is: chord over length, in tenths. Where it turns, guesses from the increment before
/// are worse and sweeps more.
int straightness(const fem::PadScene& scene, double lever) {
  Eigen::Vector3d at(0, 0, 0);
  double length = 0;
  for (const fem::PadTarget& target : fem::pad_targets(scene.load)) {
    const Eigen::Vector3d to(target.x, target.y, lever * target.twist);
    length += (to - at).norm();
    at = to;
  }
  return length > 0 ? static_cast<int>(9.999 * at.norm() / length) : 9;
}

/// Scenes of one table side by side, those of like cost together, so that the lanes of a group finish together. What
/// would not fill most of a group goes to groups where every lane has its own table; the bits are the same.
template <class Real>
PadLanes in_lanes(const std::vector<OnCells>& on_cells, const std::vector<typename LaneScenes<Real>::One>& scenes,
                  const fem::PadOptions& options, std::size_t width) {
  std::vector<double> friction;
  friction.reserve(on_cells.size());
  for (const OnCells& of : on_cells) friction.push_back(of.scene.friction);
  const std::vector<int> stratum = strata(friction, pad_friction_strata);
  using Cost = std::tuple<int, std::size_t, int, int, double, std::size_t>;
  std::map<TableKey, std::vector<Cost>> by_table;
  for (std::size_t i = 0; i < on_cells.size(); ++i) {
    const OnCells& of = on_cells[i];
    const auto& [scene, cells] = std::tie(of.scene, of.cells);
    const double half_size = cells.half_size();
    by_table[table_key(of)].emplace_back(scenes[i].increments, scene.indenter.shape.index(), stratum[i],
                                         straightness(scene, half_size), half_size, i);
  }
  PadLanes lanes;
  lanes.vectors = options.vectors;
  if (lanes.vectors == 0) {
    // Two vectors share each number of the table. That pays where they are full, and where their 18 sums fit into
    // registers: AVX-512 has 32, AVX 16.
    std::size_t full = 0;
    for (const auto& [table, members] : by_table) full += members.size() / (2 * width) * 2 * width;
    const bool fit = width * sizeof(Real) >= bytes_of_wide_vector;
    lanes.vectors = fit && options.cells <= 12 && 2 * full >= on_cells.size() ? 2 : 1;
  }
  const std::size_t size = static_cast<std::size_t>(lanes.vectors) * width;
  const auto place = [&](const Cost& member) { lanes.in_lane.push_back(std::get<5>(member)); };
  const auto fill_up = [&](std::size_t to) {
    lanes.in_lane.resize((lanes.in_lane.size() + to - 1) / to * to, no_scene);
    return lanes.in_lane.size();
  };
  std::vector<Cost> alone;
  for (auto& [table, members] : by_table) {
    std::ranges::sort(members);
    const std::size_t rest = members.size() % size, sharing = members.size() - (5 * rest < 3 * size ? rest : 0);
    for (std::size_t k = 0; k < sharing; ++k) {
      if (k % size == 0) lanes.first_of_group.push_back(std::get<5>(members[k]));
      place(members[k]);
    }
    fill_up(size);
    alone.insert(alone.end(), members.begin() + static_cast<std::ptrdiff_t>(sharing), members.end());
  }
  lanes.groups = lanes.first_of_group.size();
  std::ranges::sort(alone);
  for (const Cost& member : alone) place(member);
  lanes.own_groups = (fill_up(width) - lanes.groups * size) / width;
  return lanes;
}

/// Scenes with free sides: each is a group.
PadLanes each_alone(std::size_t scenes) {
  PadLanes lanes;
  lanes.in_lane.resize(scenes);
  std::iota(lanes.in_lane.begin(), lanes.in_lane.end(), std::size_t{0});
  lanes.own_groups = scenes;
  return lanes;
}

template <class Real>
Buffer<Real> buffer_of(const Device& device, std::vector<Real> numbers) {
  if (numbers.empty()) numbers.resize(1);
  return Buffer<Real>(device, std::span<const Real>(numbers));
}

}  // namespace

template <class Real>
struct PadContact<Real>::State {
  State(Executor& executor, const fem::PadOptions& given)
      : executor(executor), options(given), search(executor, given.any_poisson), side_tables(executor.device()) {
    constexpr std::array known{8, 12, 16, 24};
    if (std::ranges::find(known, given.cells) == known.end())
      throw ValueError("cells", std::to_string(given.cells), "8, 12, 16 or 24");
    const auto [tolerance, accept] = fem::by_rule<Real>({given.tolerance, given.accept}, fem::slow_on_patch);
    options.tolerance = tolerance, options.accept = accept;
  }

  static Precision precision() { return sizeof(Real) == 4 ? Precision::fp32 : Precision::fp64; }
  const Device& device() const { return executor.device(); }
  /// Lanes. Half of them where a wide vector takes as long as its halves, and there are many cells.
  std::size_t width() const {
    const auto lanes = static_cast<std::size_t>(device().lanes(precision()));
    const bool half =
        device().info().halves && lanes * sizeof(Real) == bytes_of_wide_vector && options.cells >= many_cells;
    return half ? lanes / 2 : lanes;
  }
  std::size_t count() const { return static_cast<std::size_t>(options.cells) * options.cells; }

  const Program& program(int vectors, bool mapped) {
    const std::lock_guard lock(making);
    auto& program = programs[{vectors, mapped}];
    if (!program) {
      const bool free = vectors == free_sides;
      Defines defines{{"REAL", real_type(precision())},
                      {"LANES", std::to_string(free ? 1 : width())},
                      {"CELLS", std::to_string(options.cells)},
                      {"VECTORS", std::to_string(std::max(vectors, 1))},
                      {"OWN_TABLES", std::to_string(vectors == own_tables)}};
      if (mapped) defines.emplace_back("FRICTION_MAP", "1");
      if (free)
        for (const auto& define : Defines{{"FREE_SIDES", "1"}, {"WIDE", std::to_string(device().lanes(precision()))}})
          defines.push_back(define);
      program = std::make_unique<Program>(device(), "pad_contact.cl", defines);
    }
    return *program;
  }

  std::shared_ptr<const PadTables> tables(const fem::Rubber& rubber, bool means = false) {
    const std::lock_guard lock(making);
    const bool exact = precision() == Precision::fp64;
    auto& kept = means ? kept_means : kept_tables;
    if (options.any_poisson && !means && rubber.layers.empty()) {
      for (int k = static_cast<int>(points.size()); k < fem::poisson_points; ++k)
        points.push_back(std::make_shared<const PadTables>(fem::Rubber{fem::poisson_point(k)}, options.cells, exact));
      return std::make_shared<const PadTables>(rubber.poisson, points);
    }
    const auto found =
        std::ranges::find(kept, rubber, [](const auto& of) -> const fem::Rubber& { return of->rubber(); });
    if (found != kept.end()) {
      kept.splice(kept.begin(), kept, found);
    } else {
      kept.push_front(std::make_shared<const PadTables>(rubber, options.cells, exact, means));
      if (kept.size() > most_poissons) kept.pop_back();
    }
    return kept.front();
  }

  Buffer<Real> responses(const std::vector<OnCells>& on_cells, std::vector<std::int32_t>& response_of);
  void lay_on_pad(Scenes& scenes, std::vector<OnCells>& all);
  std::vector<OnCells> on_cells(Scenes& scenes);
  LaneScenes<Real> numbers(const std::vector<OnCells>& on_cells, const Scenes& scenes, bool mapped) const;
  Buffer<Real> shared_tables(const std::vector<OnCells>& on_cells, const PadLanes& lanes,
                             std::vector<std::int32_t>& table_of_group);
  Buffer<Real> tables_of_lanes(const std::vector<OnCells>& on_cells, const PadLanes& lanes, std::size_t width);
  LaneArray<Real> softs(const std::vector<OnCells>& on_cells, const LaneState<Real>& lanes) const;
  LaneArray<Real> heights(const std::vector<OnCells>& on_cells, const LaneState<Real>& lanes) const;
  void take_places(const Laid& b, Sums& sums);
  void take_points(const Laid& b, const Eigen::MatrixX2d& places, const std::vector<double>& weights, Sums& sums) const;
  int stress_rows(const std::vector<OnCells>& on_cells);
  void take_stress(Laid& b);
  void take_markers(Laid& b);
  std::vector<double> marker_table(double poisson, double depth);
  Launch contact_launch(const Laid& b, int vectors, std::size_t first);
  Launch sums_launch(const Laid& b, const Sums& sums, int vectors);
  void bind_sides(const Laid& b, KernelArguments& kernel) const;
  Launch side_stress_launch(const Laid& b);
  void put_free_jobs(Laid& b);
  void put_held_jobs(Laid& b, const PadLanes& lanes);
  std::size_t groups_at_once() const;

  Executor& executor;
  fem::PadOptions options;
  PadSearch<Real> search;
  std::mutex making;                                                    ///< of what is made at first use
  std::map<std::pair<int, bool>, std::unique_ptr<Program>> programs;    ///< by vectors, or own_tables; with a map
  std::list<std::shared_ptr<const PadTables>> kept_tables, kept_means;  ///< the last used first
  PadSideTables<Real> side_tables;
  std::map<std::pair<double, double>, std::vector<double>> marker_tables;  ///< by Poisson's ratio and depth over H
  std::vector<std::shared_ptr<const PadTables>> points;                    ///< of polynomials in Poisson's ratio
};

/// What a launch of pad_base_stress sums at places on the pad: the stress under tactels, or displacements of markers.
template <class Real>
struct PadContact<Real>::Sums {
  std::function<std::vector<double>(const fem::Rubber&)> table;
  std::function<std::vector<fem::PadLayer::Share>(double side, double soft_thickness)> points_of;  ///< of a cell
  std::function<double(const fem::PadSensor&)> unit;
  int rows = 0, rows_a_thickness = 0;  ///< of a table
  int count = 0, parts = 0, from = 0;  ///< places; points of each; their first number in the outputs
  std::size_t groups = 0;
  Buffer<Real> tables, shares, points, weights;
  LaneArray<Real> places;
};

/// What a batch has besides the lanes' arrays.
template <class Real>
struct PadContact<Real>::Laid : LaneState<Real> {
  std::shared_ptr<State> contact;
  std::vector<OnCells> on_cells;  ///< [scenes]
  bool mapped = false;            ///< some scene has a map of friction
  Sums stress, markers;
  Buffer<Real> tables, own_tables;
  Buffer<std::int32_t> table_of_group;
  LaneArray<Real> heights, cell_forces;
  // With free sides:
  bool free = false;
  Buffer<Real> between, responses;
  Buffer<std::int32_t> response_of;
  LaneArray<Real> softs;
  std::array<int, 2> nodes{};
  std::array<double, 2> sides{};  ///< of the block over H
};

template <class Real>
void PadContact<Real>::Scenes::push_back(const fem::PadScene& scene, PadPath path,
                                         const std::optional<fem::PadCells>& cells) {
  const fem::PadSensor &sensor = scene.sensor, &first = all_.empty() ? sensor : all_.front().scene.sensor;
  if (sensor.tactels != first.tactels || sensor.pitch != first.pitch || sensor.tactel_size != first.tactel_size ||
      TactelPoints::along(sensor) != TactelPoints::along(first))
    throw std::invalid_argument("PadContact: scenes with different tactels in one batch");
  if (free_block(sensor) != free_block(first))
    throw std::invalid_argument("PadContact: scenes with different free sides in one batch");
  if (!all_.empty() &&
      (scene.markers != all_.front().scene.markers || marker_depth(scene) != marker_depth(all_.front().scene)))
    throw std::invalid_argument("PadContact: scenes with different markers in one batch");
  all_.push_back({scene, std::move(path), cells});
}

/// The cells of scenes with free sides, by the twin's search.
template <class Real>
void PadContact<Real>::State::lay_on_pad(Scenes& scenes, std::vector<OnCells>& all) {
  const double poisson = scenes.all_.front().scene.sensor.poisson;
  const fem::PadLayer layer = fem::pad_layer(poisson);
  const std::shared_ptr<const PadTables> means = tables({poisson}, true);
  all.resize(scenes.all_.size());
  side_by_side(all.size(), executor.threads(), [&](std::size_t i) {
    auto& [scene, path, cells] = scenes.all_[i];
    OnCells& to = all[i];
    const fem::SoftObject object = object_of(scene);
    const auto& at = scene.indenter.position;
    to.sides = fem::sides_at(scene.sensor, {at[0], at[1]}, fem::SideBricks::usual, StopScope::checker());
    double depth = 0;
    if (!cells) {
      fem::PadLayout laid = object.softness > 0
                                ? fem::lay_cells_on_pad(scene, layer.beside(object), options.cells, to.sides)
                                : fem::lay_cells_on_pad(scene, layer, options.cells, to.sides);
      scene.indenter = std::move(laid.indenter), cells = laid.cells, depth = laid.depth;
    }
    const double H = scene.sensor.thickness;
    to.solvable = fem::solvable(*cells, H, depth) && !reaches_beyond_block(scene, *cells);
    if (!to.solvable) cells->hx = cells->hy = H, cells->x_middle = cells->y_middle = 0;
    to.scene = std::move(scene), to.cells = *cells, to.size = cell_size(*cells, H);
    to.heights = fem::heights_on_pad(to.cells, to.scene), to.softs = fem::shared_compliances(to.cells, to.scene);
    to.influence = means->influence(to.size, object);
  });
}

/// The cells of each scene, and the tables that they need.
template <class Real>
std::vector<OnCells> PadContact<Real>::State::on_cells(Scenes& scenes) {
  if (!scenes.all_.empty() && fem::has_free_sides(scenes.all_.front().scene.sensor)) {
    std::vector<OnCells> all;
    lay_on_pad(scenes, all);
    return all;
  }
  std::vector<const fem::PadScene*> searched;
  std::vector<fem::PadScene*> curved;  // skins, and layers upon layers, by the twin
  for (auto& [scene, path, cells] : scenes.all_) {
    if (cells) continue;
    if (searched_by_twin(scene.sensor))
      curved.push_back(&scene);
    else
      scene.indenter = fem::aligned(std::move(scene.indenter), scene.sensor), searched.push_back(&scene);
  }
  const std::vector<fem::PadSearch> found = search.find(searched);
  std::vector<fem::PadSearch> found_by_twin(curved.size());
  side_by_side(curved.size(), executor.threads(), [&](std::size_t i) {
    fem::PadScene& scene = *curved[i];
    scene.indenter = fem::aligned(std::move(scene.indenter), scene.sensor);
    found_by_twin[i] = fem::find_pad_contact(scene, fem::pad_layer(scene));
  });
  auto next = found.begin(), next_curved = std::as_const(found_by_twin).begin();
  std::vector<OnCells> all;
  all.reserve(scenes.all_.size());
  for (auto& [scene, path, cells] : scenes.all_) {
    double depth = 0;
    if (!cells) {
      const fem::PadSearch& search_found = searched_by_twin(scene.sensor) ? *next_curved++ : *next++;
      depth = search_found.depth;
      fem::PadLayout laid = fem::lay_cells(search_found, scene, options.cells, options.ladder);
      scene.indenter = std::move(laid.indenter), cells = laid.cells;
    }
    const double H = scene.sensor.thickness;
    const bool solvable = fem::solvable(*cells, H, depth);
    if (!solvable) cells->hx = cells->hy = H, cells->x_middle = cells->y_middle = 0;
    const PadCellSize size = cell_size(*cells, H);
    all.push_back({.scene = std::move(scene), .cells = *cells, .size = size, .solvable = solvable});
  }
  return all;
}

template <class Real>
LaneScenes<Real> PadContact<Real>::State::numbers(const std::vector<OnCells>& on_cells, const Scenes& scenes,
                                                  bool mapped) const {
  LaneScenes<Real> all;
  const auto put = [](std::vector<Real>& to, double number) { to.push_back(static_cast<Real>(number)); };
  for (std::size_t i = 0; i < on_cells.size(); ++i) {
    const OnCells& of = on_cells[i];
    const auto& [scene, cells, solvable, sides] = std::tie(of.scene, of.cells, of.solvable, of.sides);
    const std::vector<fem::PadIncrement> path = fem::pad_increments(scene, options, cells);
    const int steps = static_cast<int>(scenes.all_[i].path.steps.size());
    all.add({}, {.steps = steps,
                 .indentation_steps = static_cast<int>(fem::pressing_targets(scene.load)),
                 .increments = static_cast<int>(path.size()),
                 .friction = scene.friction,
                 .young = scene.sensor.young});
    const double H = scene.sensor.thickness, force = scene.sensor.young * H * H, yaw = frame_of(on_cells[i]),
                 cosine = std::cos(yaw), sine = std::sin(yaw);
    double input[PAD_INPUT_ROWS] = {};
    input[PAD_MU] = solvable ? scene.friction : std::numeric_limits<double>::quiet_NaN();  // which is no scene
    input[PAD_STEPS] = static_cast<double>(path.size());
    input[PAD_X_MIDDLE] = cells.x_middle / H, input[PAD_Y_MIDDLE] = cells.y_middle / H;
    input[PAD_FORCE] = force, input[PAD_THICKNESS] = H;
    input[PAD_COSINE] = cosine, input[PAD_SINE] = sine, input[PAD_BY_FORCE] = by_force(scene);
    if (sides.kernel) {
      const Eigen::Vector2d at = sides.in_block({scene.indenter.position[0], scene.indenter.position[1]});
      input[PAD_BLOCK_X] = at[0], input[PAD_BLOCK_Y] = at[1];
    }
    for (const double number : input) put(all.inputs, number);
    if (mapped)
      for (const double mu : fem::friction_on_cells(cells, scene)) put(all.inputs, mu);
    int slot = 0;
    for (const auto& [to, asked, dt] : path) {
      double target[PAD_PATH_ROWS] = {};
      target[PAD_NORMAL] = to.normal / (by_force(scene) ? force : H);
      target[PAD_X] = (cosine * to.x + sine * to.y) / H, target[PAD_Y] = (cosine * to.y - sine * to.x) / H;
      target[PAD_TWIST] = to.twist, target[PAD_SLOT] = asked ? slot++ : -1;
      for (const double number : target) put(all.targets, number);
    }
  }
  return all;
}

template <class Real>
Buffer<Real> PadContact<Real>::State::shared_tables(const std::vector<OnCells>& on_cells, const PadLanes& lanes,
                                                    std::vector<std::int32_t>& table_of_group) {
  std::map<TableKey, std::int32_t> index;
  std::vector<Real> numbers;
  for (const std::size_t i : lanes.first_of_group) {
    const OnCells& of = on_cells[i];
    const auto [entry, is_new] = index.try_emplace(table_key(of), static_cast<std::int32_t>(index.size()));
    table_of_group.push_back(entry->second);
    if (!is_new) continue;
    const std::vector<double> table =
        tables(fem::rubber(of.scene.sensor))->shared_influence(of.size, object_of(of.scene));
    for (const double number : table) numbers.push_back(static_cast<Real>(number));
  }
  return buffer_of(device(), std::move(numbers));
}

template <class Real>
Buffer<Real> PadContact<Real>::State::tables_of_lanes(const std::vector<OnCells>& on_cells, const PadLanes& lanes,
                                                      std::size_t width) {
  const std::size_t side = static_cast<std::size_t>(options.cells) + 1,
                    rows = PAD_TABLE_HEAD + side * side * PAD_OWN_INFLUENCE;
  const std::size_t first = lanes.in_lane.size() - lanes.own_groups * width;
  LaneArray<Real> array(device(), lanes.own_groups * width, width, 1, rows);
  const auto all = array.numbers.map(MapFor::writing);
  std::ranges::fill(all.view(), Real(1));  // lanes without a scene: no zeros to divide by
  for (std::size_t lane = first; lane < lanes.in_lane.size(); ++lane) {
    if (lanes.in_lane[lane] == no_scene) continue;
    const OnCells& of = on_cells[lanes.in_lane[lane]];
    const auto table =
        of.influence ? of.influence : tables(fem::rubber(of.scene.sensor))->influence(of.size, object_of(of.scene));
    const std::vector<Real> numbers(table->begin(), table->end());
    array.put(all.view(), lane - first, std::span(numbers));
  }
  return array.numbers;
}

template <class Real>
LaneArray<Real> PadContact<Real>::State::heights(const std::vector<OnCells>& on_cells,
                                                 const LaneState<Real>& lanes) const {
  const int ring = options.cells + 2;
  LaneArray<Real> array(device(), lanes.lanes, lanes.input.tile, 1, static_cast<std::size_t>(ring) * ring);
  const auto all = array.numbers.map(MapFor::writing);
  std::ranges::fill(all.view(), Real(0));
  std::vector<Real> numbers;
  for (const std::size_t i : lanes.order) {
    const OnCells& of = on_cells[i];
    const Eigen::MatrixXd h = of.sides.kernel ? of.heights : fem::cell_heights(of.cells, of.scene.indenter);
    numbers.clear();
    for (int k = 0; k < ring * ring; ++k)
      numbers.push_back(static_cast<Real>(
          std::min(h(k / ring, k % ring) / of.scene.sensor.thickness, static_cast<double>(PAD_OPEN))));
    array.put(all.view(), lanes.place[i], std::span(numbers));
  }
  return array;
}

/// Compliances that cells have of their own, over H.
template <class Real>
LaneArray<Real> PadContact<Real>::State::softs(const std::vector<OnCells>& on_cells,
                                               const LaneState<Real>& lanes) const {
  LaneArray<Real> array(device(), lanes.lanes, 1, 1, count());
  const auto all = array.numbers.map(MapFor::writing);
  for (const std::size_t i : lanes.order) {
    const OnCells& of = on_cells[i];
    const Eigen::VectorXd own = of.softs / of.scene.sensor.thickness;
    const std::vector<Real> numbers(own.begin(), own.end());
    array.put(all.view(), lanes.place[i], std::span(numbers));
  }
  return array;
}

template <class Real>
Buffer<Real> PadContact<Real>::State::responses(const std::vector<OnCells>& on_cells,
                                                std::vector<std::int32_t>& response_of) {
  std::map<std::pair<double, double>, std::int32_t> places;
  std::vector<Real> all;
  for (const OnCells& of : on_cells) {
    const Eigen::Vector2d& middle = of.sides.middle;
    const auto [place, is_new] = places.try_emplace({middle[0], middle[1]}, static_cast<std::int32_t>(places.size()));
    response_of.push_back(place->second);
    if (!is_new) continue;
    const auto numbers = side_tables.response(of.scene.sensor, of.sides);
    all.insert(all.end(), numbers->begin(), numbers->end());
  }
  return buffer_of(device(), std::move(all));
}

/// Rows of the base stress that serve all rubbers of a batch.
template <class Real>
int PadContact<Real>::State::stress_rows(const std::vector<OnCells>& on_cells) {
  int rows = PadTables::stress_rows;
  for (const OnCells& on : on_cells)
    if (const fem::Rubber rubber = fem::rubber(on.scene.sensor); !rubber.layers.empty())
      rows = std::max(rows, PadTables::stress_rows_of(*tables(rubber)->layer()));
  return rows;
}

/// Where the cells of each lane lie, for sums; with them the tables of the rubbers, and the points of the cells.
template <class Real>
void PadContact<Real>::State::take_places(const Laid& b, Sums& sums) {
  LaneArray<Real> array(device(), b.lanes, 1, 1, PAD_PLACE_ROWS);
  const auto all = array.numbers.map(MapFor::writing);
  std::ranges::fill(all.view(), Real(0));  // no steps
  std::vector<Real> numbers_of_tables, shares;
  std::map<fem::Rubber, std::size_t> rows;
  using Side = std::pair<double, double>;                      // of a cell, and PadLayer::soft_thickness, over H
  std::map<Side, std::pair<std::size_t, std::size_t>> points;  // first, number
  const auto points_of = [&](double side, double soft_thickness) {
    const auto [at, is_new] = points.try_emplace({side, soft_thickness});
    if (!is_new) return at->second;
    const std::vector<fem::PadLayer::Share> all = sums.points_of(side, soft_thickness);
    at->second = {shares.size() / 2, all.size()};
    for (const auto& [place, share] : all)
      shares.insert(shares.end(), {static_cast<Real>(place), static_cast<Real>(share)});
    return at->second;
  };
  for (const std::size_t i : b.order) {
    const auto& [scene, cells, size] = std::tie(b.on_cells[i].scene, b.on_cells[i].cells, b.on_cells[i].size);
    const fem::Rubber rubber = fem::rubber(scene.sensor);
    const auto [row, is_new] = rows.try_emplace(rubber, rows.size() * static_cast<std::size_t>(sums.rows));
    if (is_new) {
      for (const double number : sums.table(rubber)) numbers_of_tables.push_back(static_cast<Real>(number));
      numbers_of_tables.resize(rows.size() * static_cast<std::size_t>(sums.rows) * PAD_BLOCK);
    }
    const double soft_thickness = rubber.layers.empty() ? 1 : tables(rubber)->layer()->soft_thickness();
    const double H = scene.sensor.thickness, yaw = frame_of(b.on_cells[i]);
    double place[PAD_PLACE_ROWS] = {};
    place[PAD_PLACE_X] = scene.indenter.position[0] / H, place[PAD_PLACE_Y] = scene.indenter.position[1] / H;
    place[PAD_PLACE_COSINE] = std::cos(yaw), place[PAD_PLACE_SINE] = std::sin(yaw);
    place[PAD_PLACE_X_MIDDLE] = cells.x_middle / H, place[PAD_PLACE_Y_MIDDLE] = cells.y_middle / H;
    place[PAD_PLACE_HX] = cells.hx / H, place[PAD_PLACE_HY] = cells.hy / H;
    place[PAD_PLACE_THICKNESS] = 1 / H, place[PAD_PLACE_STRESS] = sums.unit(scene.sensor);
    const auto [first_x, count_x] = points_of(size.hx, soft_thickness);
    const auto [first_y, count_y] = points_of(size.hy, soft_thickness);
    place[PAD_PLACE_SHARES_X] = static_cast<double>(first_x), place[PAD_PLACE_COUNT_X] = static_cast<double>(count_x);
    place[PAD_PLACE_SHARES_Y] = static_cast<double>(first_y), place[PAD_PLACE_COUNT_Y] = static_cast<double>(count_y);
    place[PAD_PLACE_STEPS] = b.scenes[i].steps, place[PAD_PLACE_LAYER] = static_cast<double>(row->second);
    const std::vector<Real> numbers(std::begin(place), std::end(place));
    array.put(all.view(), b.place[i], std::span(numbers));
  }
  sums.places = array;
  sums.tables = buffer_of(device(), std::move(numbers_of_tables)), sums.shares = buffer_of(device(), std::move(shares));
}

/// The points of places, [blocks of lanes][points of a place][x, y][lane].
template <class Real>
void PadContact<Real>::State::take_points(const Laid& b, const Eigen::MatrixX2d& places,
                                          const std::vector<double>& weights, Sums& sums) const {
  sums.parts = static_cast<int>(weights.size());
  sums.count = static_cast<int>(places.rows()) / sums.parts;
  const std::size_t blocks = (static_cast<std::size_t>(sums.count) + width() - 1) / width();
  LaneArray<Real> array(device(), blocks * width(), width(), sums.parts, 2);
  const auto all = array.numbers.map(MapFor::writing);
  std::ranges::fill(all.view(), Real(0));
  for (Eigen::Index k = 0; k < places.rows(); ++k)
    for (std::size_t axis = 0; axis < 2; ++axis)
      all[array.at(k / sums.parts, k % sums.parts, axis)] = static_cast<Real>(places(k, axis));
  sums.points = array.numbers;
  sums.weights = buffer_of(device(), std::vector<Real>(weights.begin(), weights.end()));
  sums.groups = b.lanes * blocks;
}

template <class Real>
void PadContact<Real>::State::take_stress(Laid& b) {
  b.stress.rows = stress_rows(b.on_cells), b.stress.rows_a_thickness = PadTables::stress_rows_a_thickness;
  b.stress.table = [this](const fem::Rubber& rubber) { return tables(rubber)->stress(); };
  b.stress.points_of = [free = b.free](double side, double soft_thickness) {
    if (free) return gauss_points(static_cast<int>(std::ceil(side / uniform_part)));
    std::vector<fem::PadLayer::Share> all = fem::PadLayer::shares(side / soft_thickness);
    return all.size() == 1 ? gauss_points(1) : all;
  };
  b.stress.unit = [](const fem::PadSensor& pad) { return 1 / (2 * std::numbers::pi * pad.thickness * pad.thickness); };
  take_places(b, b.stress);
  const TactelPoints points(b.on_cells.front().scene.sensor);
  take_points(b, points.places, points.weights, b.stress);
}

/// Displacements of the scenes' markers, behind the stresses of the tactels. Points lie evenly over a cell, as near
/// to each other as the markers to the surface: a lone cell's miss 3 % of its own there. Shallower markers have none.
template <class Real>
void PadContact<Real>::State::take_markers(Laid& b) {
  constexpr double least_depth = 0.02;
  const fem::PadScene& scene = b.on_cells.front().scene;
  const double depth = marker_depth(scene);
  if (depth < least_depth) return;
  b.markers.from = 3 * b.stress.count;
  b.markers.rows_a_thickness = marker_rows_a_thickness(depth), b.markers.rows = marker_rows(depth);
  b.markers.table = [this, depth](const fem::Rubber& rubber) { return marker_table(rubber.poisson, depth); };
  b.markers.points_of = [depth](double side, double) {
    std::vector<fem::PadLayer::Share> all;
    const double width = 1.0 / fem::PadLayer::parts(side);  // of a part
    const int along = std::clamp(static_cast<int>(std::ceil(width * side / depth)), 3, 12);
    for (const auto& [place, share] : fem::PadLayer::shares(side))
      for (int k = 0; k < along; ++k) all.push_back({place + width * ((k + 0.5) / along - 0.5), share / along});
    return all;
  };
  b.markers.unit = [](const fem::PadSensor& pad) { return 1 / (pad.young * pad.thickness); };
  take_places(b, b.markers);
  const auto places = fem::marker_places(*scene.markers);
  take_points(b, Eigen::Map<const Eigen::Matrix2Xd>(places.front().data(), 2, std::ssize(places)).transpose(), {1},
              b.markers);
}

template <class Real>
std::vector<double> PadContact<Real>::State::marker_table(double poisson, double depth) {
  constexpr std::size_t most = 64;
  const std::lock_guard lock(making);
  if (marker_tables.size() >= most) marker_tables.clear();
  auto& table = marker_tables[{poisson, depth}];
  if (table.empty()) table = displacement_table(poisson, depth);
  return table;
}

template <class Real>
Launch PadContact<Real>::State::contact_launch(const Laid& b, int vectors, std::size_t first) {
  const char* const kernel_name = b.free ? "pad_free_contact" : "pad_contact";
  return executor.prepare(program(vectors, b.mapped), kernel_name, [&](KernelArguments& kernel) {
    if (b.free) {
      kernel.set("pairs", b.between);  // until it is run
      kernel.set("layers", b.own_tables);
      kernel.set("softs", b.softs.numbers);
      kernel.set("between", b.between);
      bind_sides(b, kernel);
      kernel.set("first_scene", std::int32_t(first));
    } else {
      kernel.set("tables", vectors == host::own_tables ? b.own_tables : b.tables);
      kernel.set("table_of", b.table_of_group);
      kernel.set("first_vector", std::int32_t(first));
    }
    kernel.set("lane_input", b.input.numbers);
    kernel.set("path", b.path.numbers);
    kernel.set("heights", b.heights.numbers);
    kernel.set("increments", std::int32_t(b.increments));
    kernel.set("slots", std::int32_t(b.steps));
    kernel.set("write_forces", std::int32_t(1));
    kernel.set("tolerance", Real(options.tolerance));
    kernel.set("accept", Real(options.accept));
    kernel.set("most_sweeps", std::int32_t(options.most_sweeps));
    kernel.set("result", b.results.numbers);
    kernel.set("forces", b.cell_forces.numbers);
  });
}

template <class Real>
Launch PadContact<Real>::State::sums_launch(const Laid& b, const Sums& sums, int vectors) {
  return executor.prepare(program(vectors, b.mapped), "pad_base_stress", [&](KernelArguments& kernel) {
    kernel.set("layer", sums.tables);
    kernel.set("layer_rows", std::int32_t(sums.rows));
    kernel.set("rows_a_thickness", Real(sums.rows_a_thickness));
    kernel.set("places", sums.places.numbers);
    kernel.set("shares", sums.shares);
    kernel.set("points", sums.points);
    kernel.set("weights", sums.weights);
    kernel.set("parts", std::int32_t(sums.parts));
    kernel.set("tactels", std::int32_t(sums.count));
    kernel.set("slots", std::int32_t(b.steps));
    kernel.set("numbers", std::int32_t(b.outputs.rows));
    kernel.set("from", std::int32_t(sums.from));
    kernel.set("forces", b.cell_forces.numbers);
    kernel.set("stress", b.outputs.numbers);
  });
}

template <class Real>
void PadContact<Real>::State::bind_sides(const Laid& b, KernelArguments& kernel) const {
  kernel.set("nodes_x", std::int32_t(b.nodes[0]));
  kernel.set("nodes_y", std::int32_t(b.nodes[1]));
  kernel.set("side_x", Real(b.sides[0]));
  kernel.set("side_y", Real(b.sides[1]));
}

template <class Real>
Launch PadContact<Real>::State::side_stress_launch(const Laid& b) {
  return executor.prepare(program(free_sides, b.mapped), "pad_side_stress", [&](KernelArguments& kernel) {
    kernel.set("responses", b.responses);
    kernel.set("response_of", b.response_of);
    bind_sides(b, kernel);
    kernel.set("lane_input", b.input.numbers);
    kernel.set("places", b.stress.places.numbers);
    kernel.set("tactels", std::int32_t(b.stress.count));
    kernel.set("slots", std::int32_t(b.steps));
    kernel.set("forces", b.cell_forces.numbers);
    kernel.set("stress", b.outputs.numbers);
  });
}

/// Scenes with free sides whose tables are in memory: some 128 MB on a processor, which has few at work, and what a
/// GPU can spare.
template <class Real>
std::size_t PadContact<Real>::State::groups_at_once() const {
  const std::size_t on_host = std::size_t{1} << 27;
  const std::size_t bytes = device().info().type == DeviceType::gpu ? memory_of(device().info()) / 4 : on_host;
  return std::max<std::size_t>(8, bytes / (sizeof(Real) * PAIRS_NUMBERS(static_cast<std::size_t>(options.cells))));
}

template <class Real>
void PadContact<Real>::State::put_free_jobs(Laid& b) {
  const fem::PadSides& sides = b.on_cells.front().sides;
  b.nodes = sides.kernel->mesh().cells, b.sides = sides.kernel->sides();
  b.between = side_tables.between(sides);
  std::vector<std::int32_t> response_of;
  b.responses = responses(b.on_cells, response_of);
  b.response_of = Buffer<std::int32_t>(device(), std::span<const std::int32_t>(response_of));
  b.softs = softs(b.on_cells, b);
  const std::size_t at_once = std::min(groups_at_once(), b.lanes);
  b.borrow = [&b, this, size = at_once * PAIRS_NUMBERS(static_cast<std::size_t>(options.cells))] {
    auto lent = side_tables.borrow(size);
    for (auto& jobs : b.rounds)
      if (Launch& launch = jobs.front().launch; launch.kernel() == "pad_free_contact") launch.set("pairs", *lent);
    return lent;
  };
  for (std::size_t first = 0; first < b.lanes; first += at_once)
    b.rounds.push_back({{contact_launch(b, free_sides, first), std::min(at_once, b.lanes - first)}});
  b.rounds.push_back({{sums_launch(b, b.stress, own_tables), b.stress.groups}});
  b.rounds.push_back({{side_stress_launch(b), b.lanes}});
}

template <class Real>
void PadContact<Real>::State::put_held_jobs(Laid& b, const PadLanes& lanes) {
  auto& jobs = b.rounds.emplace_back();
  if (lanes.own_groups > 0)  // first, for they take longer
    jobs.push_back({contact_launch(b, own_tables, lanes.groups * lanes.vectors), lanes.own_groups});
  if (lanes.groups > 0) jobs.push_back({contact_launch(b, lanes.vectors, 0), lanes.groups});
  const int vectors = lanes.own_groups > 0 ? own_tables : lanes.vectors;
  b.rounds.push_back({{sums_launch(b, b.stress, vectors), b.stress.groups}});
  if (b.markers.count > 0) b.rounds.back().push_back({sums_launch(b, b.markers, vectors), b.markers.groups});
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
  return state_->tables(rubber)->layer();
}

template <class Real>
std::size_t PadContact<Real>::most_lane_steps(const Scenes& scenes) const {
  constexpr std::size_t most_numbers = std::size_t{1} << 25, most_with_responses = 4096;
  const std::size_t markers = scenes.all_.empty() ? 0 : fem::marker_count(scenes.all_.front().scene.markers);
  const std::size_t most = most_numbers / (3 * std::max(state_->count(), markers));
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
  b.mapped = std::ranges::any_of(b.on_cells, [](const OnCells& of) { return of.scene.friction_map.has_value(); });
  LaneScenes<Real> numbers = s.numbers(b.on_cells, scenes, b.mapped);
  b.free = !b.on_cells.empty() && b.on_cells.front().sides.kernel;
  const std::size_t width = b.free ? 1 : s.width();
  const PadLanes lanes =
      b.free ? each_alone(b.on_cells.size()) : in_lanes<Real>(b.on_cells, numbers.scenes, s.options, width);
  b.lay_out(s.executor, std::move(numbers), lanes.in_lane, width, 1, PAD_INPUT_ROWS + b.mapped * s.count(),
            PAD_PATH_ROWS);

  std::vector<std::int32_t> table_of_group;
  b.tables = s.shared_tables(b.on_cells, lanes, table_of_group);
  b.table_of_group = buffer_of(s.device(), std::move(table_of_group));
  b.own_tables = s.tables_of_lanes(b.on_cells, lanes, width);
  b.heights = s.heights(b.on_cells, b);
  b.more_inputs = {b.heights};
  s.take_stress(b);
  s.take_markers(b);

  const auto outputs = [&](std::size_t rows, bool written = true) {
    return LaneArray<Real>(s.device(), written ? b.lanes : 0, 1, b.steps, rows);
  };
  b.cell_forces = outputs(3 * s.count());
  b.results = outputs(PAD_RESULT_ROWS),
  b.outputs = outputs(3 * static_cast<std::size_t>(b.stress.count + b.markers.count));
  b.forces = forces ? b.cell_forces : outputs(0, false), b.patches = outputs(0, false);
  b.free ? s.put_free_jobs(b) : s.put_held_jobs(b, lanes);
  if (!forces) b.on_cells.clear();
  return Batch(std::move(laid));
}

template <class Real>
PadContact<Real>::Batch::Batch(std::shared_ptr<Laid> laid) : ContactBatch<Real>(laid), laid_(std::move(laid)) {}

template <class Real>
double PadContact<Real>::Batch::filled() const {
  return static_cast<double>(this->size()) / static_cast<double>(laid_->lanes);
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
const fem::PadScene& PadContact<Real>::Batch::scene(std::size_t i) const {
  return laid_->on_cells.at(i).scene;
}

template <class Real>
const fem::PadCells& PadContact<Real>::Batch::cells(std::size_t i) const {
  return laid_->on_cells.at(i).cells;
}

template <class Real>
fem::PadSolution PadContact<Real>::Batch::solution(const LaneView<Real>& view, std::size_t i) const {
  if (laid_->forces.rows == 0) throw std::logic_error("PadContact: a solution of a batch without forces");
  const fem::PadScene& scene = this->scene(i);
  const fem::PadCells& cells = this->cells(i);
  const Eigen::Index count = cells.count();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(frame_of(laid_->on_cells[i])).toRotationMatrix();
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
    if (solvable) answer.tactels(k, std::span(numbers));
    step.stress = Eigen::Map<const Eigen::MatrixX3d>(numbers.data(), laid_->stress.count, 3);
    if (laid_->markers.count > 0) {
      const double* const z = numbers.data() + laid_->markers.from;  // then x, then y
      const Eigen::Map<const Eigen::MatrixX3d> zxy(z, laid_->markers.count, 3);
      step.markers.resize(zxy.rows(), 3), step.markers << zxy.rightCols<2>(), zxy.col(0);
    }
    step.converged = step.converged && step.stress.allFinite();
    solution.steps.push_back(std::move(step));
  }
  return solution;
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
