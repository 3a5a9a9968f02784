// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pad_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <tuple>

#include "fem/layer/legendre_points.h"
#include "fem/pad/pad_search.h"
#include "fem/value_error.h"
#include "host/contact/strata.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

constexpr int pad_friction_strata = 4;
// The base stress by quadratics in rho; beyond 12 H it is below 2e-4 of a unit stress.
constexpr int stress_rows_a_thickness = 32, pad_stress_rows = 12 * stress_rows_a_thickness + 1;

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// What scenes of one group share: Poisson's ratio, and the sides of a cell over H in units of 1e-12.
using TableKey = std::tuple<double, long long, long long>;
constexpr double side_unit = 1e-12;
TableKey table_key(const fem::PadScene& scene, const fem::PadCells& cells) {
  const double unit = side_unit * scene.sensor.thickness;
  return {scene.sensor.poisson, std::llround(cells.hx / unit), std::llround(cells.hy / unit)};
}

constexpr int own_tables = 0;  ///< in place of a number of vectors: every lane has a table of its own

/// The numbers of a table for cells hx x hy over H; both kinds of tables have the same.
class InfluenceTable {
 public:
  InfluenceTable(const fem::PadLayer& layer, double hx, double hy) : layer_(layer), hx_(hx), hy_(hy) {
    const fem::CellInfluence own = layer.influence(1, hx, hy, 0, 0);
    zz_ = std::sqrt(own.zz), tt_ = std::sqrt(std::max(own.xx, own.yy));
  }
  std::array<double, PAD_TABLE_HEAD> head() const {
    std::array<double, PAD_TABLE_HEAD> head{};
    head[PAD_ROOT_ZZ] = zz_, head[PAD_ROOT_TT] = tt_, head[PAD_HX] = hx_, head[PAD_HY] = hy_;
    return head;
  }
  /// Of a place i, j >= 0 cells from the source.
  std::array<double, PAD_OWN_INFLUENCE> entry(int i, int j) const {
    const fem::CellInfluence c = layer_.influence(1, hx_, hy_, i * hx_, j * hy_);
    std::array<double, PAD_OWN_INFLUENCE> row{};
    row[PAD_ZZ] = c.zz / (zz_ * zz_);
    row[PAD_XX] = c.xx / (tt_ * tt_), row[PAD_YY] = c.yy / (tt_ * tt_), row[PAD_XY] = c.xy / (tt_ * tt_);
    row[PAD_XZ] = c.xz / (zz_ * tt_), row[PAD_YZ] = c.yz / (zz_ * tt_);
    return row;
  }
  /// As a group shares it.
  std::vector<double> shared(int n) const {
    const int span = 2 * n + 1;
    std::vector<double> table(PAD_TABLE_HEAD + std::size_t{PAD_INFLUENCE} * span * span);
    std::ranges::copy(head(), table.begin());
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        const auto c = entry(i, j);
        for (const int sx : {-1, 1})
          for (const int sy : {-1, 1}) {  // the place lies at +(sx i, sy j) from the source
            double* row = &table[PAD_TABLE_HEAD + std::size_t{PAD_INFLUENCE} * ((n - sx * i) * span + n - sy * j)];
            std::ranges::copy(c, row);
            row[PAD_XY] *= sx * sy, row[PAD_XZ] *= sx, row[PAD_YZ] *= sy;
          }
      }
    return table;
  }

 private:
  const fem::PadLayer& layer_;
  double hx_, hy_, zz_, tt_;
};

/// Rows of the base stress's table for one Poisson's ratio, [pad_stress_rows][PAD_BLOCK].
std::vector<double> stress_table(const fem::PadLayer& layer) {
  std::vector<double> table(pad_stress_rows * std::size_t{PAD_BLOCK});
  const double step = 1.0 / stress_rows_a_thickness;
  for (int row = 0; row + 1 < pad_stress_rows; ++row) {  // the last row is 0: beyond
    const Eigen::Array<double, 5, 1> left = layer.stresses(row * step), middle = layer.stresses((row + 0.5) * step),
                                     right = layer.stresses((row + 1) * step);
    for (int f = 0; f < 5; ++f) {
      double* c =
          &table[static_cast<std::size_t>(row) * PAD_BLOCK + static_cast<std::size_t>(f) * PAD_STRESS_COEFFICIENTS];
      c[0] = left[f], c[2] = 2 * (left[f] - 2 * middle[f] + right[f]), c[1] = right[f] - left[f] - c[2];
    }
  }
  return table;
}

/// Points at which the stress is computed, [points] mm, and how many of them make a tactel with which weights.
struct TactelPoints {
  Eigen::MatrixX2d places;
  std::vector<double> weights;  ///< of the points of a tactel, which lie together

  explicit TactelPoints(const fem::PadSensor& sensor) {
    const Eigen::MatrixX2d middles = fem::tactel_places(sensor);
    const double half = sensor.tactel_size / 2;
    const int along = half > 0 ? 3 + static_cast<int>(std::ceil(4 * half / sensor.thickness)) : 1;
    const std::vector<fem::LegendrePoint> points =
        half > 0 ? fem::legendre_points(along) : std::vector<fem::LegendrePoint>{{0, 2}};
    places.resize(middles.rows() * along * along, 2);
    Eigen::Index k = 0;
    for (Eigen::Index tactel = 0; tactel < middles.rows(); ++tactel)
      for (const auto& p : points)
        for (const auto& q : points) {
          places.row(k++) = middles.row(tactel) + half * Eigen::RowVector2d(p.x, q.x);
          if (tactel == 0) weights.push_back(p.weight * q.weight / 4);
        }
  }
};

}  // namespace

template <class Real>
struct PadContact<Real>::State {
  State(Executor& executor, const PadContactOptions& given) : executor(executor), options(given) {
    for (const int known : {8, 12, 16, 24})
      if (given.cells == known) cells = known;
    if (cells == 0) throw ValueError("cells", std::to_string(given.cells), "8, 12, 16 or 24");
    const auto [tolerance, accept] = fem::by_rule<Real>({given.tolerance, given.accept}, fem::slow_on_patch);
    options.tolerance = tolerance, options.accept = accept;
  }

  static Precision precision() { return sizeof(Real) == 4 ? Precision::fp32 : Precision::fp64; }
  int lanes() const { return executor.device().lanes(precision()); }

  fem::PadOptions path_options() const {
    fem::PadOptions o;
    o.cells = cells, o.pressing_increments = options.increments, o.ladder = options.ladder;
    o.halve_turns = options.halve_turns;
    return o;
  }

  const Program& program(int vectors) {
    const std::lock_guard lock(making);
    auto& program = programs[vectors];
    if (!program)
      program = std::make_unique<Program>(executor.device(), "pad_contact.cl",
                                          Defines{{"REAL", real_type(precision())},
                                                  {"LANES", std::to_string(lanes())},
                                                  {"CELLS", std::to_string(cells)},
                                                  {"VECTORS", std::to_string(std::max(vectors, 1))},
                                                  {"OWN_TABLES", std::to_string(vectors == own_tables)}});
    return *program;
  }

  std::shared_ptr<const fem::PadLayer> layer(double poisson) {
    const std::lock_guard lock(making);
    auto& made = layers[poisson];
    if (!made) made = std::make_shared<const fem::PadLayer>(poisson);
    return made;
  }

  InfluenceTable influence(const TableKey& key) {
    const auto& [poisson, hx, hy] = key;
    return {*layer(poisson), side_unit * static_cast<double>(hx), side_unit * static_cast<double>(hy)};
  }

  const std::vector<double>& shared_table(const TableKey& key) {
    auto& made = tables[key];
    if (made.empty()) made = influence(key).shared(cells);
    return made;
  }

  Executor& executor;
  PadContactOptions options;
  int cells = 0;
  std::mutex making;                                 ///< of what is made at first use
  std::map<int, std::unique_ptr<Program>> programs;  ///< by vectors, or own_tables
  std::map<double, std::shared_ptr<const fem::PadLayer>> layers;
  std::map<TableKey, std::vector<double>> tables;  ///< those of groups that share them
};

template <class Real>
struct PadContact<Real>::Batch::State {
  std::shared_ptr<PadContact<Real>::State> contact;
  std::vector<fem::PadScene> scenes;
  std::vector<fem::PadCells> cells;
  std::vector<std::vector<fem::PadIncrement>> paths;
  std::vector<TableKey> keys;            ///< [scenes]
  std::vector<TableKey> table_of_group;  ///< [groups]
  std::vector<std::size_t> place;        ///< [scenes] lane of scene i, counted over all groups
  int slots = 0, most_increments = 0, vectors = 1, blocks = 0;
  std::size_t groups = 0,
              own_groups = 0;  ///< that share a table, of `vectors` vectors; with tables of their own, behind
  bool with_stress = true;
  double seconds = 0;
  std::vector<double> tactel_weights;
  Buffer<Real> tables, own, lane_input, path, heights, result, forces, layer, places, tactels, stress;
  Buffer<std::int32_t> table_of;
  Launch launch, own_launch, stress_launch;

  int n() const { return contact->cells; }
  std::size_t count() const { return static_cast<std::size_t>(n()) * n(); }
  std::size_t width() const { return static_cast<std::size_t>(contact->lanes()); }
  std::size_t all_lanes() const { return (groups * vectors + own_groups) * width(); }
  std::size_t points() const { return blocks * width(); }

  void lay_out();
  void fill_tables();
  void fill();
  void fill_stress();
};

/// Scenes of one table side by side, those of like cost together, so that the lanes of a group finish together. What
/// would not fill most of a group goes to groups where every lane has its own table; the bits are the same.
template <class Real>
void PadContact<Real>::Batch::State::lay_out() {
  std::vector<double> friction;
  for (const fem::PadScene& scene : scenes) friction.push_back(scene.friction);
  const std::vector<int> stratum = strata(friction, pad_friction_strata);
  using Cost = std::tuple<std::size_t, std::size_t, int, double, std::size_t>;
  std::map<TableKey, std::vector<Cost>> by_table;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    keys.push_back(table_key(scenes[i], cells[i]));
    by_table[keys[i]].emplace_back(paths[i].size(), scenes[i].indenter.shape.index(), stratum[i], cells[i].half_size(),
                                   i);
  }
  vectors = contact->options.vectors;
  if (vectors == 0) {  // two vectors share each number of the table, which pays where they are full
    std::size_t full = 0;
    for (const auto& [key, members] : by_table) full += members.size() / (2 * width()) * 2 * width();
    vectors = width() > 1 && n() <= 12 && 2 * full >= scenes.size() ? 2 : 1;
  }
  place.resize(scenes.size());
  const std::size_t size = vectors * width();
  std::vector<Cost> alone;
  for (auto& [key, members] : by_table) {
    std::ranges::sort(members);
    const std::size_t rest = members.size() % size, sharing = members.size() - (5 * rest < 3 * size ? rest : 0);
    for (std::size_t k = 0; k < sharing; ++k) {
      if (k % size == 0) table_of_group.push_back(key);
      place[std::get<4>(members[k])] = (table_of_group.size() - 1) * size + k % size;
    }
    alone.insert(alone.end(), members.begin() + static_cast<std::ptrdiff_t>(sharing), members.end());
  }
  groups = table_of_group.size();
  std::ranges::sort(alone);
  own_groups = (alone.size() + width() - 1) / width();
  for (std::size_t k = 0; k < alone.size(); ++k) place[std::get<4>(alone[k])] = groups * size + k;
}

template <class Real>
void PadContact<Real>::Batch::State::fill_tables() {
  std::map<TableKey, std::int32_t> index;
  std::vector<Real> numbers(1), of_lanes(1);
  std::vector<std::int32_t> at(1);
  const auto copy = [](const auto& from, auto to, std::size_t stride) {
    for (const double number : from) *to = static_cast<Real>(number), to += static_cast<std::ptrdiff_t>(stride);
  };
  at.resize(std::max<std::size_t>(groups, 1));
  for (std::size_t g = 0; g < groups; ++g) {
    const auto [entry, added] = index.emplace(table_of_group[g], static_cast<std::int32_t>(index.size()));
    at[g] = entry->second;
    if (!added) continue;
    const std::vector<double>& table = contact->shared_table(table_of_group[g]);
    numbers.resize(index.size() * table.size());
    copy(table, numbers.end() - static_cast<std::ptrdiff_t>(table.size()), 1);
  }
  const std::size_t side = n() + 1, size = (PAD_TABLE_HEAD + side * side * PAD_OWN_INFLUENCE) * width();
  of_lanes.resize(std::max<std::size_t>(own_groups * size, 1), 1);  // lanes without a scene: no zeros to divide by
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (place[i] < groups * vectors * width()) continue;
    const std::size_t lane = place[i] - groups * vectors * width();
    const InfluenceTable table = contact->influence(keys[i]);
    auto to = of_lanes.begin() + static_cast<std::ptrdiff_t>(lane / width() * size + lane % width());
    copy(table.head(), to, width());
    to += static_cast<std::ptrdiff_t>(PAD_TABLE_HEAD * width());
    for (std::size_t k = 0; k < side * side; ++k, to += static_cast<std::ptrdiff_t>(PAD_OWN_INFLUENCE * width()))
      copy(table.entry(static_cast<int>(k / side), static_cast<int>(k % side)), to, width());
  }
  const Device& device = contact->executor.device();
  tables = Buffer<Real>(device, std::span<const Real>(numbers));
  table_of = Buffer<std::int32_t>(device, std::span<const std::int32_t>(at));
  own = Buffer<Real>(device, std::span<const Real>(of_lanes));
}

template <class Real>
void PadContact<Real>::Batch::State::fill() {
  const auto input = lane_input.map(MapFor::writing), targets = path.map(MapFor::writing),
             profile = heights.map(MapFor::writing);
  for (const auto* view : {&input, &targets, &profile}) std::fill(view->view().begin(), view->view().end(), Real(0));
  const std::size_t ring = (n() + 2) * (n() + 2), tile = width();
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadScene& scene = scenes[i];
    const double H = scene.sensor.thickness, yaw = radians(scene.indenter.yaw), cosine = std::cos(yaw),
                 sine = std::sin(yaw);
    const auto put = [&](auto& to, std::size_t rows, std::size_t row, double value) {
      to[(place[i] / tile * rows + row) * tile + place[i] % tile] = static_cast<Real>(value);
    };
    const auto in = [&](int row, double value) { put(input, PAD_INPUT_ROWS, row, value); };
    in(PAD_MU, scene.friction);
    in(PAD_STEPS, static_cast<double>(paths[i].size()));
    in(PAD_X_MIDDLE, cells[i].x_middle / H), in(PAD_Y_MIDDLE, cells[i].y_middle / H);
    in(PAD_FORCE, scene.sensor.young * H * H), in(PAD_THICKNESS, H);
    in(PAD_COSINE, cosine), in(PAD_SINE, sine);
    in(PAD_BY_FORCE, by_force(scene));
    const Eigen::MatrixXd h = fem::cell_heights(cells[i], scene.indenter);
    for (std::size_t k = 0; k < ring; ++k) {
      const double height = h(static_cast<Eigen::Index>(k) / (n() + 2), static_cast<Eigen::Index>(k) % (n() + 2)) / H;
      put(profile, ring, k, std::min(height, static_cast<double>(PAD_OPEN)));
    }
    int slot = 0;
    for (std::size_t k = 0; k < paths[i].size(); ++k) {
      const auto& [to, asked] = paths[i][k];
      const auto target = [&](int row, double value) {
        put(targets, most_increments * std::size_t{PAD_PATH_ROWS}, k * PAD_PATH_ROWS + row, value);
      };
      target(PAD_NORMAL, to.normal / (by_force(scene) ? scene.sensor.young * H * H : H));
      target(PAD_X, (cosine * to.x + sine * to.y) / H), target(PAD_Y, (cosine * to.y - sine * to.x) / H);
      target(PAD_TWIST, to.twist);
      target(PAD_SLOT, asked ? slot++ : -1);
    }
  }
}

template <class Real>
void PadContact<Real>::Batch::State::fill_stress() {
  std::map<double, int> rows;
  std::vector<Real> table;
  for (const fem::PadScene& scene : scenes) {
    if (!rows.emplace(scene.sensor.poisson, static_cast<int>(rows.size()) * pad_stress_rows).second) continue;
    for (const double value : stress_table(*contact->layer(scene.sensor.poisson)))
      table.push_back(static_cast<Real>(value));
  }
  const Device& device = contact->executor.device();
  layer = Buffer<Real>(device, std::span<const Real>(table));
  const TactelPoints tactel(scenes.front().sensor);
  tactel_weights = tactel.weights;
  blocks = static_cast<int>((tactel.places.rows() + width() - 1) / width());
  std::vector<Real> at(2 * points());
  for (Eigen::Index k = 0; k < tactel.places.rows(); ++k)
    for (int axis = 0; axis < 2; ++axis) at[axis * points() + k] = static_cast<Real>(tactel.places(k, axis));
  tactels = Buffer<Real>(device, std::span<const Real>(at));
  std::vector<Real> of(all_lanes() * PAD_PLACE_ROWS);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadScene& scene = scenes[i];
    const double H = scene.sensor.thickness, yaw = radians(scene.indenter.yaw);
    const auto put = [&](int row, double value) { of[place[i] * PAD_PLACE_ROWS + row] = static_cast<Real>(value); };
    put(PAD_PLACE_X, scene.indenter.position[0] / H), put(PAD_PLACE_Y, scene.indenter.position[1] / H);
    put(PAD_PLACE_COSINE, std::cos(yaw)), put(PAD_PLACE_SINE, std::sin(yaw));
    put(PAD_PLACE_X_MIDDLE, cells[i].x_middle / H), put(PAD_PLACE_Y_MIDDLE, cells[i].y_middle / H);
    put(PAD_PLACE_HX, cells[i].hx / H), put(PAD_PLACE_HY, cells[i].hy / H);
    put(PAD_PLACE_THICKNESS, 1 / H), put(PAD_PLACE_STRESS, 1 / (2 * std::numbers::pi * H * H));
    put(PAD_PLACE_STEPS, static_cast<double>(fem::pad_targets(scene.load).size()));
    put(PAD_PLACE_LAYER, rows[scene.sensor.poisson]);
  }
  places = Buffer<Real>(device, std::span<const Real>(of));
}

template <class Real>
PadContact<Real>::PadContact(Executor& executor, const PadContactOptions& options)
    : state_(std::make_shared<State>(executor, options)) {}

template <class Real>
std::shared_ptr<const fem::PadLayer> PadContact<Real>::layer(double poisson) const {
  return state_->layer(poisson);
}

template <class Real>
typename PadContact<Real>::Batch PadContact<Real>::prepare(std::span<const fem::PadScene> scenes,
                                                           std::span<const fem::PadCells> cells) const {
  Batch batch;
  batch.state_ = std::make_shared<typename Batch::State>();
  auto& b = *batch.state_;
  b.contact = state_;
  b.scenes.assign(scenes.begin(), scenes.end());
  const fem::PadOptions options = state_->path_options();
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSensor &sensor = scenes[i].sensor, &first = scenes[0].sensor;
    if (sensor.tactels != first.tactels || sensor.pitch != first.pitch || sensor.tactel_size != first.tactel_size)
      throw std::invalid_argument("PadContact::prepare: scenes with different tactels in one batch");
    if (cells.empty()) {
      auto [indenter, own] = fem::lay_cells(scenes[i], *layer(sensor.poisson), state_->cells, options.ladder);
      b.scenes[i].indenter = std::move(indenter);
      b.cells.push_back(own);
    } else {
      b.cells.push_back(cells[i]);
    }
    b.paths.push_back(fem::pad_increments(scenes[i].load, options, b.cells[i].half_size()));
    b.slots = std::max(b.slots, static_cast<int>(fem::pad_targets(scenes[i].load).size()));
    b.most_increments = std::max(b.most_increments, static_cast<int>(b.paths[i].size()));
  }
  b.lay_out();
  b.fill_tables();

  const Device& device = state_->executor.device();
  const auto buffer = [&](std::size_t size) { return Buffer<Real>(device, std::max<std::size_t>(size, 1)); };
  const std::size_t all = b.all_lanes(), ring = (b.n() + 2) * (b.n() + 2);
  b.lane_input = buffer(all * PAD_INPUT_ROWS);
  b.path = buffer(all * b.most_increments * PAD_PATH_ROWS);
  b.heights = buffer(all * ring);
  b.result = buffer(all * b.slots * PAD_BLOCK);
  b.forces = buffer(all * b.slots * 3 * b.count());
  b.fill();
  b.fill_stress();
  b.stress = buffer(all * b.slots * 3 * b.points());

  const auto contact_launch = [&](int vectors, const Buffer<Real>& tables, std::size_t first_vector) {
    return state_->executor.prepare(state_->program(vectors), "pad_contact", [&](KernelArguments& kernel) {
      kernel.set("tables", tables);
      kernel.set("table_of", b.table_of);
      kernel.set("first_vector", std::int32_t(first_vector));
      kernel.set("lane_input", b.lane_input);
      kernel.set("path", b.path);
      kernel.set("heights", b.heights);
      kernel.set("increments", std::int32_t(b.most_increments));
      kernel.set("slots", std::int32_t(b.slots));
      kernel.set("write_forces", std::int32_t(1));
      kernel.set("tolerance", Real(state_->options.tolerance));
      kernel.set("accept", Real(state_->options.accept));
      kernel.set("most_sweeps", std::int32_t(state_->options.most_sweeps));
      kernel.set("result", b.result);
      kernel.set("forces", b.forces);
    });
  };
  if (b.groups > 0) b.launch = contact_launch(b.vectors, b.tables, 0);
  if (b.own_groups > 0) b.own_launch = contact_launch(own_tables, b.own, b.groups * b.vectors);
  const Program& program = state_->program(b.own_groups > 0 ? own_tables : b.vectors);
  b.stress_launch = state_->executor.prepare(program, "pad_base_stress", [&](KernelArguments& kernel) {
    kernel.set("layer", b.layer);
    kernel.set("layer_rows", std::int32_t(pad_stress_rows));
    kernel.set("rows_a_thickness", Real(stress_rows_a_thickness));
    kernel.set("places", b.places);
    kernel.set("tactels", b.tactels);
    kernel.set("blocks", std::int32_t(b.blocks));
    kernel.set("slots", std::int32_t(b.slots));
    kernel.set("forces", b.forces);
    kernel.set("stress", b.stress);
  });
  return batch;
}

template <class Real>
void PadContact<Real>::Batch::run(const RunOptions& options) {
  auto& b = *state_;
  std::vector<Job> jobs;
  if (b.own_groups > 0) jobs.push_back({b.own_launch, b.own_groups});
  if (b.groups > 0) jobs.push_back({b.launch, b.groups});
  b.seconds = b.contact->executor.run(jobs, options).seconds;
  if (b.with_stress) b.seconds += b.contact->executor.run(b.stress_launch, b.all_lanes() * b.blocks, options).seconds;
}

template <class Real>
std::size_t PadContact<Real>::Batch::size() const {
  return state_->scenes.size();
}

template <class Real>
std::size_t PadContact<Real>::Batch::steps_in_all() const {
  std::size_t all = 0;
  for (const fem::PadScene& scene : state_->scenes) all += fem::pad_targets(scene.load).size();
  return all;
}

template <class Real>
double PadContact<Real>::Batch::filled() const {
  return static_cast<double>(size()) / static_cast<double>(state_->all_lanes());
}

template <class Real>
double PadContact<Real>::Batch::seconds() const {
  return state_->seconds;
}

template <class Real>
void PadContact<Real>::Batch::set_parts(bool base_stress) {
  state_->with_stress = base_stress;
  if (state_->groups > 0) state_->launch.set("write_forces", std::int32_t(base_stress));
  if (state_->own_groups > 0) state_->own_launch.set("write_forces", std::int32_t(base_stress));
}

template <class Real>
void PadContact<Real>::Batch::fill_outputs(Real value) {
  for (const auto* buffer : {&state_->result, &state_->forces, &state_->stress}) {
    const auto mapped = buffer->map(MapFor::writing);
    std::fill(mapped.view().begin(), mapped.view().end(), value);
  }
}

template <class Real>
double PadContact<Real>::Batch::result(std::size_t i, int step, int row) const {
  Real value;
  state_->result.read(std::span(&value, 1), (state_->place[i] * state_->slots + step) * PAD_BLOCK + row);
  return value;
}

template <class Real>
const fem::PadScene& PadContact<Real>::Batch::scene(std::size_t i) const {
  return state_->scenes[i];
}

template <class Real>
const fem::PadCells& PadContact<Real>::Batch::cells(std::size_t i) const {
  return state_->cells[i];
}

template <class Real>
fem::PadSolution PadContact<Real>::Batch::solution(std::size_t i) const {
  const auto& b = *state_;
  const fem::PadScene& scene = b.scenes[i];
  const fem::PadCells& cells = b.cells[i];
  const Eigen::Index count = cells.count();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(radians(scene.indenter.yaw)).toRotationMatrix();
  const std::vector<fem::PadTarget> targets = fem::pad_targets(scene.load);
  std::vector<Real> forces(3 * b.count()), stress(3 * b.points());
  fem::PadSolution solution;
  solution.cells = cells;
  solution.places.resize(count, 2);
  for (int k = 0; k < count; ++k)
    solution.places.row(k) = (turn * Eigen::Vector2d(cells.x(k / cells.n), cells.y(k % cells.n))).transpose() +
                             Eigen::RowVector2d(scene.indenter.position[0], scene.indenter.position[1]);
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const auto said = [&](int row) { return result(i, static_cast<int>(k), row); };
    const std::size_t at = b.place[i] * b.slots + k;
    b.forces.read(std::span(forces), at * forces.size());
    if (b.with_stress) b.stress.read(std::span(stress), at * stress.size());
    const auto force = [&](int part) {
      return Eigen::Map<const Eigen::VectorX<Real>>(&forces[part * b.count()], count).template cast<double>();
    };
    fem::PadStep step;
    step.indentation = said(PAD_RESULT_DEPTH);
    step.x = targets[k].x, step.y = targets[k].y, step.twist = targets[k].twist;
    step.P = said(PAD_RESULT_P), step.Q = {said(PAD_RESULT_QX), said(PAD_RESULT_QY)}, step.M = said(PAD_RESULT_M);
    const int status = static_cast<int>(said(PAD_RESULT_STATUS));
    if (scene.friction * step.P > 0) {
      step.slip_index = said(PAD_RESULT_S);
      step.force_ratio = step.Q.norm() / (scene.friction * step.P);
    }
    const double stick = said(PAD_RESULT_STICKING), touch = stick + said(PAD_RESULT_SLIPPING);
    step.stick_fraction = touch > 0 ? stick / touch : 0;
    step.sweeps = static_cast<int>(said(PAD_RESULT_SWEEPS));
    step.converged = status == LANE_SOLVED || status == LANE_SLIDING;
    step.residual = {said(PAD_RESULT_PENETRATION), said(PAD_RESULT_COMPLEMENTARITY), said(PAD_RESULT_CONE),
                     said(PAD_RESULT_DRIFT), said(PAD_RESULT_ANGLE)};
    for (int side = 0; side < 4; ++side)
      solution.outside[side] |= (static_cast<int>(said(PAD_RESULT_OUTSIDE)) >> side & 1) != 0;
    step.normal_force = force(0);
    Eigen::MatrixX2d own(count, 2);
    own << force(1), force(2);
    const double inside = std::is_same_v<Real, float> ? 1 - 1e-6 : 1 - 1e-12;
    for (Eigen::Index c = 0; c < count; ++c) {
      const double n = step.normal_force[c];
      step.status.push_back(!(n > 0)                                          ? fem::GapStatus::open
                            : own.row(c).norm() < inside * scene.friction * n ? fem::GapStatus::stick
                                                                              : fem::GapStatus::slip);
    }
    step.tangential_force = own * turn.transpose();
    const auto parts = static_cast<Eigen::Index>(b.tactel_weights.size());
    step.stress = Eigen::MatrixX3d::Zero(scene.sensor.tactels[0] * scene.sensor.tactels[1], 3);
    for (Eigen::Index tactel = 0; b.with_stress && tactel < step.stress.rows(); ++tactel)
      for (int part = 0; part < 3; ++part)
        for (Eigen::Index p = 0; p < parts; ++p)
          step.stress(tactel, part) += b.tactel_weights[p] * stress[part * b.points() + tactel * parts + p];
    solution.steps.push_back(std::move(step));
  }
  return solution;
}

template <class Real>
const PadContactOptions& PadContact<Real>::options() const {
  return state_->options;
}

template <class Real>
std::vector<fem::PadSolution> solve_pad_contact(const PadContact<Real>& contact, std::span<const fem::PadScene> scenes,
                                                std::span<const fem::PadCells> cells, PadContactReport* report) {
  const PadContactOptions& options = contact.options();
  const auto any = [](const std::array<bool, 4>& sides) { return std::ranges::find(sides, true) != sides.end(); };
  const auto solved = [](const fem::PadSolution& s) { return std::ranges::all_of(s.steps, &fem::PadStep::converged); };
  PadContactReport said;
  std::vector<fem::PadSolution> solutions(scenes.size());
  std::vector<fem::PadScene> now(scenes.begin(), scenes.end());
  std::vector<fem::PadCells> laid(cells.begin(), cells.end());
  std::vector<std::size_t> of(scenes.size());
  std::iota(of.begin(), of.end(), 0);
  for (int growths = 0; !now.empty(); ++growths) {
    auto batch = contact.prepare(now, laid);
    batch.run();
    std::vector<fem::PadScene> again;
    std::vector<std::size_t> again_of;
    laid.clear();
    for (std::size_t k = 0; k < now.size(); ++k) {
      fem::PadSolution& solution = solutions[of[k]] = batch.solution(k);
      if (!any(solution.outside) || growths == options.most_growths) continue;
      said.grown += growths == 0;
      again.push_back(batch.scene(k));
      again_of.push_back(of[k]);
      laid.push_back(fem::grown(batch.cells(k), solution.outside, batch.scene(k), options.ladder));
    }
    now = std::move(again);
    of = std::move(again_of);
  }
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (solved(solutions[i])) continue;
    ++said.fell_back;
    fem::PadOptions exact;
    exact.cells = options.cells, exact.pressing_increments = options.increments;
    exact.tolerance = 1e-6, exact.accept = options.accept;
    exact.halve_turns = options.halve_turns, exact.ladder = options.ladder;
    solutions[i] = fem::PadSolver(*contact.layer(scenes[i].sensor.poisson), exact).solve(scenes[i]);
    said.unsolved += !solved(solutions[i]);
  }
  if (report) *report = said;
  return solutions;
}

template class PadContact<float>;
template class PadContact<double>;
template std::vector<fem::PadSolution> solve_pad_contact(const PadContact<float>&, std::span<const fem::PadScene>,
                                                         std::span<const fem::PadCells>, PadContactReport*);
template std::vector<fem::PadSolution> solve_pad_contact(const PadContact<double>&, std::span<const fem::PadScene>,
                                                         std::span<const fem::PadCells>, PadContactReport*);

}  // namespace tactel::host
