// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <type_traits>

#include "fem/gap/accuracy.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/creep.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_solver.h"
#include "fem/pad/pad_table.h"
#include "fem/pad/side_kernel.h"
#include "host/contact/pads/pad_contact_tables.h"
#include "host/contact/pads/pad_step_blocks.h"
#include "host/device/unwritten.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/pad_layout.h"
#include "kernels/shared/pad_step_layout.h"

namespace tactel::host {
namespace {

constexpr int least_grid = 4, most_grid = 24;
constexpr AlongXY<int> usual_grid = 16;
constexpr double usual_cell = 0.5;         ///< mm
constexpr std::size_t widest_vector = 64;  ///< of AVX-512
constexpr double usual_reach = 0.5;        ///< rubber bulges beside an object by less than this part of its depth
constexpr double longest_motion = 0.05;    ///< H, of a solve along the pad
constexpr double least_cover = 1e-3;       ///< of a cell that counts as covered
constexpr double wide_share = 0.7;         ///< of the grid that a contact covers which is split: it takes less time
constexpr int never_wide = most_grid * most_grid + 1;

static_assert(int(step_open) == int(STEP_OPEN) && int(step_slides) == int(STEP_SLIDES));
static_assert(int(step_unmet) == int(STEP_UNMET) && int(step_edge) == int(STEP_EDGE));
static_assert(int(step_invalid) == int(STEP_INVALID) && int(step_deep) == int(STEP_DEEP));
static_assert(int(step_reach) == int(STEP_REACH));

/// Stiffness of a contact of radius a that sticks on the layer, H = E = 1: kt a (1 + a) along it, kr a^3 (1 + a)
/// against a twist. A first guess for the search of a pose: by rigid motions of a disc of cells.
struct StickingDisc {
  double kt, kr;

  StickingDisc(const fem::PadLayer& layer) {
    constexpr int n = 10;
    constexpr double h = 0.14;
    const std::vector<fem::CellInfluence> all = layer.influences(1, h, h, n);
    std::vector<std::array<int, 2>> in;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (std::hypot(i - (n - 1) / 2.0, j - (n - 1) / 2.0) < n / 2.0) in.push_back({i, j});
    const auto count = static_cast<Eigen::Index>(in.size());
    Eigen::MatrixXd C(2 * count, 2 * count), rigid = Eigen::MatrixXd::Zero(2 * count, 2);
    for (Eigen::Index p = 0; p < count; ++p) {
      for (Eigen::Index q = 0; q < count; ++q) {
        const int dx = in[p][0] - in[q][0], dy = in[p][1] - in[q][1];
        const fem::CellInfluence& c =
            all[static_cast<std::size_t>(std::abs(dx)) * (n + 1) + static_cast<std::size_t>(std::abs(dy))];
        C(p, q) = c.xx, C(count + p, count + q) = c.yy;
        C(p, count + q) = C(count + p, q) = dx * dy < 0 ? -c.xy : c.xy;
      }
      rigid(p, 0) = 1;
      rigid(p, 1) = -(in[p][1] - (n - 1) / 2.0) * h, rigid(count + p, 1) = (in[p][0] - (n - 1) / 2.0) * h;
    }
    const Eigen::MatrixXd tractions = C.partialPivLu().solve(rigid);
    const double a = std::sqrt(static_cast<double>(count) * h * h / std::numbers::pi);
    kt = rigid.col(0).dot(tractions.col(0)) * h * h / (a * (1 + a));
    kr = rigid.col(1).dot(tractions.col(1)) * h * h / (a * a * a * (1 + a));
  }
};

/// Numbers that a traction of 1 of the state adds to sums, as the kernel takes them: [blocks of rows][cells][n, t_x,
/// t_y][STEP_FRAME_BLOCK], zeros behind the last row.
struct SumBlocks {
  SumBlocks(std::size_t rows, std::size_t cells)
      : rows(rows),
        cells(cells),
        numbers((rows + STEP_FRAME_BLOCK - 1) / STEP_FRAME_BLOCK * cells * 3 * STEP_FRAME_BLOCK) {}
  double& at(std::size_t row, std::size_t cell, std::size_t part) {
    return numbers[((row / STEP_FRAME_BLOCK * cells + cell) * 3 + part) * STEP_FRAME_BLOCK + row % STEP_FRAME_BLOCK];
  }
  std::size_t rows, cells;
  std::vector<double> numbers;
};

void check_size(const char* key, std::size_t size, std::size_t allowed) {
  if (size != allowed) throw ValueError(key, fmt::format("{} numbers", size), fmt::format("{} numbers", allowed));
}

void check(const StepOptions& options) {
  for (const int cells : {options.cells.x, options.cells.y})
    if (cells < least_grid || cells > most_grid) throw ValueError("cells", std::to_string(cells), "4 to 24");
  for (const double cell : {options.cell.x, options.cell.y})
    if (!(cell > 0) || !std::isfinite(cell)) throw ValueError("cell", fmt::format("{}", cell), "above 0 mm");
  const auto positive = [](const char* key, double number) {
    if (!(number > 0 && number <= 0.1)) throw ValueError(key, fmt::format("{}", number), "above 0 and at most 0.1");
  };
  positive("tolerance", options.tolerance), positive("force_tolerance", options.force_tolerance);
  if (options.object_young != 0 && !(options.object_young >= 1e-9 && options.object_young <= 1e12))
    throw ValueError("object_young", fmt::format("{}", options.object_young), "1e-9 to 1e12 MPa, or 0 (rigid)");
  if (!(options.dt >= 0 && options.dt <= 1e12))
    throw ValueError("dt", fmt::format("{}", options.dt), "seconds, 0 to 1e12");
  if (!(options.object_poisson >= 0 && options.object_poisson <= 0.5))
    throw ValueError("object_poisson", fmt::format("{}", options.object_poisson), "0 to 0.5");
  if (options.most_sweeps < 1) throw ValueError("most_sweeps", std::to_string(options.most_sweeps), "1 or more");
  if (options.most_solves < 1) throw ValueError("most_solves", std::to_string(options.most_solves), "1 or more");
}

/// The kernel's table of pairs, after the head of one of the layer alone.
std::vector<double> table_of_pairs(const PairInfluence& pairs, const std::vector<double>& of_layer, double thickness) {
  constexpr int x = 0, y = 1, z = 2;
  const double zz = of_layer[PAD_ROOT_ZZ] * of_layer[PAD_ROOT_ZZ], tt = of_layer[PAD_ROOT_TT] * of_layer[PAD_ROOT_TT],
               zt = of_layer[PAD_ROOT_ZZ] * of_layer[PAD_ROOT_TT];
  std::vector<double> table(of_layer.begin(), of_layer.begin() + PAD_TABLE_HEAD);
  for (std::size_t k = 0; k < pairs.size(); k += 9) {
    const auto number = [&](int to, int by) { return pairs[k + static_cast<std::size_t>(3 * to + by)] / thickness; };
    double entry[PAD_PAIR] = {};  // n is the negative of a force along z
    entry[PAD_ZZ] = number(z, z) / zz, entry[PAD_XX] = number(x, x) / tt, entry[PAD_YY] = number(y, y) / tt;
    entry[PAD_XY] = number(x, y) / tt, entry[PAD_XZ] = number(x, z) / zt, entry[PAD_YZ] = number(y, z) / zt;
    entry[PAD_PAIR_ZX] = -number(z, x) / zt, entry[PAD_PAIR_ZY] = -number(z, y) / zt;
    entry[PAD_PAIR_YX] = number(y, x) / tt;
    table.insert(table.end(), std::begin(entry), std::end(entry));
  }
  return table;
}

/// mm of a side of a pad with free ones over which a grid may extend: all of it, or what lies 2 H from the ends of the
/// block that stands for a longer pad.
double gridded(double side, double thickness) {
  constexpr double within_block = fem::longest_block - 4;
  return side <= fem::longest_block * thickness ? side : within_block * thickness;
}

/// A grid on a pad with free sides lies within it.
void check_within(const fem::PadSensor& pad, const StepOptions& options) {
  const auto check = [&](double side, int cells, double cell) {
    const double most = gridded(side, pad.thickness);
    if (cells * cell > most * (1 + 1e-9))
      throw ValueError("cell", fmt::format("{}", cell),
                       fmt::format("{:.6g} mm at most, as {} cells lie within {}", most / cells, cells,
                                   most < side ? "8 thicknesses of a pad longer than 12" : "the pad"));
  };
  check(*pad.length, options.cells.x, options.cell.x), check(*pad.width, options.cells.y, options.cell.y);
}

/// Some 256 nearly square cells over the pad.
AlongXY<int> cells_over(double length, double width) {
  const double side = std::sqrt(length * width / (usual_grid.x * usual_grid.y));
  const auto along = [side](double whole) {
    return std::clamp(static_cast<int>(std::lround(whole / side)), least_grid, most_grid);
  };
  return {along(length), along(width)};
}

/// Options with a grid, as the pad asks where none is given.
StepOptions with_grid(const fem::PadSensor& pad, StepOptions options) {
  const bool fits = fem::has_free_sides(pad) && !options.cell.given;
  if (!fits) {
    if (!options.cells.given) options.cells = usual_grid;
    if (!options.cell.given) options.cell = usual_cell;
    return options;
  }
  const double length = gridded(*pad.length, pad.thickness), width = gridded(*pad.width, pad.thickness);
  if (!options.cells.given) options.cells = cells_over(length, width);
  options.cell = {length / options.cells.x, width / options.cells.y};
  return options;
}

PairInfluence pairs_of(const fem::PadTable& table, const fem::PadCells& cells) {
  const int ny = cells.ny();
  PairInfluence pairs;
  for (int place = 0; place < cells.count(); ++place)
    for (int source = 0; source < cells.count(); ++source)
      for (int to = 0; to < 3; ++to)
        for (int by = 0; by < 3; ++by) pairs.push_back(table.row(place / ny, place % ny, to, by)[source]);
  return pairs;
}

/// Of a table of square grids the part that this one takes.
std::vector<double> of_offsets(const std::vector<double>& square, int most, const fem::PadCells& cells) {
  const auto numbers = std::size_t{PAD_INFLUENCE};
  std::vector<double> table(square.begin(), square.begin() + PAD_TABLE_HEAD);
  for (int dx = -cells.n; dx <= cells.n; ++dx) {
    const auto first = static_cast<std::size_t>((most + dx) * (2 * most + 1) + most - cells.ny());
    const auto from = square.begin() + static_cast<std::ptrdiff_t>(PAD_TABLE_HEAD + numbers * first);
    table.insert(table.end(), from, from + static_cast<std::ptrdiff_t>(numbers * (2 * cells.ny() + 1)));
  }
  return table;
}

fem::PadCells cells_of(const StepOptions& options) {
  return fem::fixed_cells({options.cells.x, options.cells.y}, {options.cell.x, options.cell.y});
}

}  // namespace

template <class Real>
struct PadStepper<Real>::State {
  State(Executor& executor, const fem::PadSensor& pad, std::size_t count, const StepOptions& given, PairInfluence pairs)
      : executor(executor), pad(pad), count(count) {
    fem::validate(pad);
    options = with_grid(pad, given);
    check(options);
    if (options.object_young > 0) object = {pad.young / options.object_young, options.object_poisson};
    cells = cells_of(options);
    const fem::Interval solvable = fem::solvable_sides(pad.thickness, 0.1 * pad.thickness);
    for (const double cell : {cells.hx, cells.hy})
      if (cell < solvable.left || cell > solvable.right)
        throw ValueError("cell", fmt::format("{}", cell),
                         fmt::format("{} to {} mm on this rubber", solvable.left, solvable.right));
    if (options.markers) fem::validate(*options.markers, pad);
    if (options.camera) fem::validate(*options.camera);
    if (options.camera && !options.markers) throw ValueError("camera", "without markers", "given with markers");
    check_count();
    if (fem::has_free_sides(pad)) {
      check_within(pad, options);
      sides = fem::sides_at(pad, {0, 0}, fem::SideBricks::usual, StopScope::checker());
      if (pairs.empty())
        pairs = pairs_of(
            {fem::pad_layer(pad.poisson).beside(object), *sides, cells, Eigen::Matrix2d::Identity(), {0, 0}}, cells);
    }
    const Device& device = executor.device();
    const Precision precision = sizeof(Real) == 4 ? Precision::fp32 : Precision::fp64;
    width = static_cast<std::size_t>(device.lanes(precision));
    // As PadContact: two vectors share each number of the table where they are full and their sums fit into registers.
    const bool wide = width * sizeof(Real) >= widest_vector && !device.info().halves;
    const auto threads = static_cast<std::size_t>(executor.threads());
    vectors = wide && cells.count() <= 144 && count >= 4 * width * threads ? 2 : 1;
    places = (count + lanes() - 1) / lanes() * lanes();
    defines = {{"REAL", real_type(precision)},       {"LANES", std::to_string(width)},
               {"CELLS", std::to_string(cells.n)},   {"CELLS_Y", std::to_string(cells.ny())},
               {"VECTORS", std::to_string(vectors)}, {"DENSE", std::to_string(!pairs.empty())}};
    if (!pad.relaxation.empty()) defines.emplace_back("CREEP_TERMS", std::to_string(pad.relaxation.size()));
    wide_from = static_cast<int>(std::ceil(wide_share * cells.count()));
    make_tables(pairs);
    make_arrays();
    make_launches();
  }

  const Device& device() const { return executor.device(); }
  std::size_t lanes() const { return width * static_cast<std::size_t>(vectors); }
  std::size_t cell_count() const { return static_cast<std::size_t>(cells.count()); }
  std::size_t rows() const {
    const std::size_t creeps = pad.relaxation.empty() ? 0 : 3 * (1 + pad.relaxation.size()) * cell_count();
    return STEP_FIELDS * cell_count() + STEP_NUMBERS + creeps;
  }
  /// Where number `row` of a contact lies in an array of `rows` numbers each.
  std::size_t at(std::size_t contact, std::size_t row, std::size_t rows) const {
    return (contact / width * rows + row) * width + contact % width;
  }

  std::size_t input_rows() const { return STEP_INPUT_ROWS + mapped * cell_count(); }

  void check_count() const;
  void take_map();
  std::vector<Real> head() const;
  void check_state(std::span<const Real> numbers) const;
  void make_tables(const PairInfluence& pairs);
  void make_arrays();
  void make_launches();
  int rubber_beyond() const;
  void put_input(std::size_t first, std::size_t numbers, std::span<const double> from, std::span<const double> units);
  void run(const Launch& launch);
  void step(std::span<const double> to, bool by_wrench);
  template <class Number>
  void put_heights(std::size_t contact, const Number* height, const Number* cover, std::span<Real> all,
                   std::span<Real> softs) const;

  Executor& executor;
  fem::PadSensor pad;
  StepOptions options;
  fem::SoftObject object{};
  std::size_t count, width = 1, places = 0;  ///< places: contacts with those that fill up a work-item
  int vectors = 1;
  fem::PadCells cells;
  std::optional<fem::PadSides> sides{};  ///< free ones
  double root_zz = 0, root_tt = 0, rho_n = 1, rho_t = 1, kt = 0, kr = 0;
  double reach = usual_reach;
  int wide_from = 0;    ///< cells in the window of a contact that is split
  bool mapped = false;  ///< each cell has its own mu
  Defines defines;
  std::optional<Program> program;
  Buffer<Real> table, blocks, input, heights, soft, state, result;
  std::optional<Launch> step_launch;
  bool writes = false;  ///< the driver's kernel does, as the first step has shown
  using Mapping = typename Buffer<Real>::Mapping;
  mutable std::unique_ptr<Mapping> result_view;

  /// Numbers of each contact that are sums over its tractions: made where they are asked for.
  struct Sums {
    std::size_t rows = 0;
    Buffer<Real> base, numbers;
    std::optional<Launch> launch{};
    bool made = false;
    std::unique_ptr<Mapping> view{};
  };
  Sums stresses{}, displacements{};

  /// Of rubber that creeps.
  struct Creeping {
    fem::Creep law;
    Buffer<Real> heights, numbers;  ///< above what has crept; of the step
    std::optional<Launch> begin{}, end{};
  };
  std::optional<Creeping> creep{};
  double begin_creep();
  void prepare(Sums& sums, const SumBlocks& blocks);
  std::span<const Real> made(Sums& sums);
  /// A step was made, or a state set.
  void forget() {
    result_view.reset();
    for (Sums* sums : {&stresses, &displacements}) sums->view.reset(), sums->made = false;
  }
};

template <class Real>
void PadStepper<Real>::State::make_tables(const PairInfluence& pairs) {
  const double H = pad.thickness;
  const auto real = [](const std::vector<double>& numbers) {
    return std::vector<Real>(numbers.begin(), numbers.end());
  };
  const int most = std::max(cells.n, cells.ny());
  const PadTables tables(fem::rubber(pad), most, true);
  std::vector<double> influence = of_offsets(tables.shared_influence(cell_size(cells, H), object), most, cells);
  root_zz = influence[PAD_ROOT_ZZ], root_tt = influence[PAD_ROOT_TT];
  if (!pairs.empty()) {
    check_size("pairs", pairs.size(), 9 * cell_count() * cell_count());
    influence = table_of_pairs(pairs, influence, H);
  }
  const std::vector<Real> own = real(influence);
  table = Buffer<Real>(device(), std::span<const Real>(own));
  // From the kernel's numbers, so that tables that are the same there have the same bits.
  const SplitBlocks split = split_blocks({own.begin(), own.end()}, !pairs.empty(), cells.n, cells.ny());
  if (split.numbers.empty()) wide_from = never_wide;
  blocks = Buffer<Real>(device(), std::span<const Real>(split.numbers.empty() ? own : real(split.numbers)));
  rho_n = split.rho_n, rho_t = split.rho_t;
  const StickingDisc disc(tables.layer()->beside(object));
  kt = disc.kt, kr = disc.kr;
  const TactelPoints points(pad);
  const std::size_t parts = points.weights.size(), tactels = static_cast<std::size_t>(points.places.rows()) / parts;
  SumBlocks stress(3 * tactels, cell_count());
  const double unit[3] = {-pad.young / root_zz, pad.young / root_tt, pad.young / root_tt};  // f_z = -n
  constexpr int column[3] = {2, 0, 1};
  const auto put = [&](SumBlocks& to, const Eigen::MatrixXd& all) {
    for (std::size_t row = 0; row < to.rows; ++row)
      for (std::size_t i = 0; i < cell_count(); ++i)
        for (std::size_t part = 0; part < 3; ++part)
          to.at(row, i, part) = std::abs(unit[part]) *
                                all(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(part * cell_count() + i));
  };
  fem::PadScene alone;
  alone.sensor = pad;
  if (sides) put(stress, fem::base_stress_of_cells(*tables.layer(), alone, cells, *sides));
  for (std::size_t k = 0; k < static_cast<std::size_t>(points.places.rows()) && !sides; ++k) {
    const auto at = points.places.row(static_cast<Eigen::Index>(k));
    const auto all = tables.layer()->base_stresses(H, cells.hx, cells.hy, most, at[0] - cells.x(0), at[1] - cells.y(0));
    for (std::size_t i = 0; i < cell_count(); ++i) {
      const auto ny = static_cast<std::size_t>(cells.ny());
      const auto& stress_of = all[i / ny * static_cast<std::size_t>(most) + i % ny];
      for (std::size_t part = 0; part < 3; ++part)
        for (std::size_t stress_row = 0; stress_row < 3; ++stress_row) {
          const std::size_t row = stress_row * tactels + k / parts;
          stress.at(row, i, part) +=
              points.weights[k % parts] * unit[part] * stress_of(static_cast<Eigen::Index>(stress_row), column[part]);
        }
    }
  }
  prepare(stresses, stress);
  if (!options.markers) return;
  const Eigen::MatrixXd of_markers = fem::marker_rows(*options.markers, alone, cells, StopScope::checker());
  SumBlocks displacement(static_cast<std::size_t>(of_markers.rows()), cell_count());
  put(displacement, of_markers);
  prepare(displacements, displacement);
}

template <class Real>
void PadStepper<Real>::State::prepare(Sums& sums, const SumBlocks& blocks) {
  sums.rows = blocks.rows;
  const std::vector<Real> numbers(blocks.numbers.begin(), blocks.numbers.end());
  sums.base = Buffer<Real>(device(), std::span<const Real>(numbers));
}

template <class Real>
void PadStepper<Real>::State::make_arrays() {
  const auto filled = [&](std::size_t rows, Real number) {
    Buffer<Real> buffer(device(), places * rows);
    const auto all = buffer.map(MapFor::writing);
    std::ranges::fill(all.view(), number);
    return buffer;
  };
  input = filled(input_rows(), 0);
  put_input(STEP_BEYOND, 1, std::vector<double>(count, -1), std::array{1.0});
  heights = filled(cell_count(), Real(PAD_OPEN)), soft = filled(cell_count(), 0);
  state = filled(rows(), 0), result = filled(STEP_RESULT_ROWS, 0);
  if (!pad.relaxation.empty())
    creep.emplace(Creeping{fem::Creep(pad.relaxation), filled(cell_count(), Real(PAD_OPEN)),
                           Buffer<Real>(device(), CREEP_NUMBERS * pad.relaxation.size())});
  for (Sums* sums : {&stresses, &displacements})
    if (sums->rows > 0) sums->numbers = filled(sums->rows, 0);
}

template <class Real>
void PadStepper<Real>::State::make_launches() {
  Defines all = defines;
  if (mapped) all.emplace_back("FRICTION_MAP", "1");
  program.emplace(device(), "pad_step.cl", all);
  const double H = pad.thickness;
  const fem::Accuracy accuracy = fem::by_rule<Real>({options.tolerance, 0}, fem::slow_on_patch);
  step_launch = executor.prepare(*program, "pad_step", [&](KernelArguments& kernel) {
    kernel.set("table", table);
    kernel.set("blocks", blocks);
    kernel.set("rho_n", Real(rho_n));
    kernel.set("rho_t", Real(rho_t));
    kernel.set("wide_from", std::int32_t(wide_from));
    kernel.set("input", input);
    kernel.set("heights", creep ? creep->heights : heights);
    kernel.set("soft", soft);
    kernel.set("by_wrench", std::int32_t(0));
    kernel.set("kt", Real(kt));
    kernel.set("kr", Real(kr));
    kernel.set("force", Real(pad.young * H * H));
    kernel.set("thickness", Real(H));
    kernel.set("tolerance", Real(accuracy.tolerance));
    kernel.set("accept", Real(accuracy.accept));
    kernel.set("force_tolerance", Real(options.force_tolerance));
    kernel.set("most_sweeps", std::int32_t(options.most_sweeps));
    kernel.set("most_solves", std::int32_t(options.most_solves));
    kernel.set("reach", Real(reach));
    kernel.set("travel", Real(longest_motion));
    kernel.set("sides", std::int32_t(rubber_beyond()));
    kernel.set("state", state);
    kernel.set("result", result);
  });
  if (creep) {
    creep->begin = executor.prepare(*program, "pad_creep_begin", [&](KernelArguments& kernel) {
      kernel.set("table", table);
      kernel.set("numbers", creep->numbers);
      kernel.set("softer", Real(1));
      kernel.set("heights", heights);
      kernel.set("crept_heights", creep->heights);
      kernel.set("state", state);
    });
    creep->end = executor.prepare(*program, "pad_creep_end", [&](KernelArguments& kernel) {
      kernel.set("table", table);
      kernel.set("numbers", creep->numbers);
      kernel.set("softer", Real(1));
      kernel.set("soft", soft);
      kernel.set("state", state);
    });
  }
  for (Sums* sums : {&stresses, &displacements})
    if (sums->rows > 0)
      sums->launch = executor.prepare(*program, "pad_frames", [&](KernelArguments& kernel) {
        kernel.set("base", sums->base);
        kernel.set("rows", std::int32_t(sums->rows));
        kernel.set("state", state);
        kernel.set("frames", sums->numbers);
      });
}

/// Takes a map of friction from now on: its rows follow the others of each vector.
template <class Real>
void PadStepper<Real>::State::take_map() {
  const std::size_t vector = STEP_INPUT_ROWS * width, more = cell_count() * width;
  std::vector<Real> before(input.size()), all(places * (STEP_INPUT_ROWS + cell_count()));
  input.read(before);
  for (std::size_t k = 0; k < before.size(); ++k) all[k + k / vector * more] = before[k];
  input = Buffer<Real>(device(), std::span<const Real>(all));
  mapped = true;
  make_launches();
}

template <class Real>
void PadStepper<Real>::State::check_count() const {
  if (count < 1) throw ValueError("count", "0", "1 or more");
  const auto numbers = rows() + 2 * cell_count() + input_rows() + STEP_RESULT_ROWS +
                       3 * static_cast<std::size_t>(pad.tactels[0] * pad.tactels[1]) +
                       (options.markers ? 3 * fem::marker_places(*options.markers).size() : 0);
  const std::uint64_t bytes = numbers * sizeof(Real), most = memory_of(device().info()) / bytes;
  if (count > most)
    throw ValueError("count", std::to_string(count),
                     fmt::format("{} at most, as each takes {} bytes of the device's memory", most, bytes));
}

template <class Real>
std::vector<Real> PadStepper<Real>::State::head() const {
  const double H = pad.thickness;
  std::vector<double> all{double(cells.n), double(cells.ny()), cells.hx / H, cells.hy / H, pad.poisson, 0, 0};
  if (sides) all[state_length] = *pad.length / H, all[state_width] = *pad.width / H;
  const auto layers = fem::rubber(pad).layers;
  const bool creeps = !pad.relaxation.empty();
  if (object.softness > 0 || !layers.empty() || creeps) all.insert(all.end(), {object.softness, object.poisson});
  for (const auto& [thickness, young, poisson] : layers) all.insert(all.end(), {thickness, young, poisson});
  if (creeps) all.push_back(state_relaxation);
  for (const auto& [share, time] : pad.relaxation) all.insert(all.end(), {share, time});
  return {all.begin(), all.end()};
}

/// The state that begins with these numbers.
template <class Real>
void PadStepper<Real>::State::check_state(std::span<const Real> numbers) const {
  const auto own = head();
  const auto text = [](std::span<const Real> of) {
    std::string words = fmt::format("{} x {} cells of {:.6g} x {:.6g} H, nu {:.6g}", of[0], of[1], of[2], of[3], of[4]);
    if (of[state_length] > 0) words += fmt::format(", sides {:.6g} x {:.6g} H", of[5], of[6]);
    if (of.size() > state_head && of[7] > 0)
      words += fmt::format(", objects {:.6g} times as soft, nu {:.6g}", of[7], of[8]);
    std::size_t k = state_head + 2;
    for (; k < of.size() && of[k] > 0; k += 3)
      words += fmt::format(", layer {:.6g} H, {:.6g} E, nu {:.6g}", of[k], of[k + 1], of[k + 2]);
    for (++k; k < of.size(); k += 2) words += fmt::format(", {:.6g} of E relaxes in {:.6g} s", of[k], of[k + 1]);
    return words;
  };
  if (numbers.size() < own.size() || !std::ranges::equal(own, numbers.first(own.size())))
    throw ValueError("state",
                     numbers.size() < own.size() ? "too few numbers" : "one of " + text(numbers.first(own.size())),
                     "one of " + text(own));
  if (numbers.size() < own.size() + rows()) check_size("state", numbers.size(), own.size() + rows());
  for (const Real number : numbers.subspan(own.size(), rows()))
    if (!std::isfinite(number)) throw ValueError("state", fmt::format("{}", number), "finite numbers");
}

/// Sum of 1, 2, 4, 8: sides -x, +x, -y, +y of the grid beyond which there is rubber.
template <class Real>
int PadStepper<Real>::State::rubber_beyond() const {
  const fem::PadBox grid = cells.box(), rubber = fem::rubber_of(pad);
  const double rounding = 1e-6 * cells.half_size();
  return 1 * (rubber.x.left < grid.x.left - rounding) + 2 * (rubber.x.right > grid.x.right + rounding) +
         4 * (rubber.y.left < grid.y.left - rounding) + 8 * (rubber.y.right > grid.y.right + rounding);
}

/// Puts `numbers` numbers of each contact, times their units, into rows of the input.
template <class Real>
void PadStepper<Real>::State::put_input(std::size_t first, std::size_t numbers, std::span<const double> from,
                                        std::span<const double> units) {
  const auto all = input.map();
  for (std::size_t c = 0; c < count; ++c)
    for (std::size_t k = 0; k < numbers; ++k)
      all[at(c, first + k, input_rows())] = static_cast<Real>(from[c * numbers + k] * units[k]);
}

template <class Real>
template <class Number>
void PadStepper<Real>::State::put_heights(std::size_t contact, const Number* height, const Number* cover,
                                          std::span<Real> all, std::span<Real> softs) const {
  const double per_H = 1 / pad.thickness;
  for (std::size_t i = 0; i < cell_count(); ++i) {
    const double f = cover ? static_cast<double>(cover[i]) : 1, h = static_cast<double>(height[i]) * per_H;
    const std::size_t place = at(contact, i, cell_count());
    all[place] = h >= PAD_OPEN || f < least_cover ? Real(PAD_OPEN) : static_cast<Real>(h);
    softs[place] = f < least_cover && f >= 0 ? Real(0) : static_cast<Real>(1 / f - 1);
  }
}

template <class Real>
void PadStepper<Real>::State::run(const Launch& launch) {
  const std::size_t groups = places / lanes();
  if (groups == 1 && device().info().low_latency)
    executor.run_here(launch);
  else
    executor.run(launch, groups);
}

/// Returns how much softer rubber that creeps is in the step; 1 of other.
template <class Real>
double PadStepper<Real>::State::begin_creep() {
  if (!creep) return 1;
  const fem::CreepStep step = creep->law.step(options.dt);
  std::vector<Real> numbers;
  for (const auto& [c, e, b] : step.terms)
    for (const double number : {c, 1 - e, b - e, 1 - b}) numbers.push_back(static_cast<Real>(number));
  creep->numbers.write(numbers);
  for (Launch* launch : {&*creep->begin, &*creep->end}) launch->set("softer", static_cast<Real>(step.softer));
  run(*creep->begin);
  return step.softer;
}

template <class Real>
void PadStepper<Real>::State::step(std::span<const double> to, bool by_wrench) {
  check_size(by_wrench ? "wrench" : "pose", to.size(), 4 * count);
  const double softer = begin_creep(), H = pad.thickness, force = pad.young * H * H / softer;
  const std::array by_pose{1 / H, 1 / H, 1 / H, 1.0}, by_force{1 / force, 1 / force, 1 / force, 1 / (force * H)};
  forget();
  put_input(STEP_TO, 4, to, by_wrench ? by_force : by_pose);
  step_launch->set("by_wrench", std::int32_t(by_wrench));
  if (creep) step_launch->set("force", Real(force));
  if (!writes) std::ranges::fill(result.map(MapFor::writing).view(), std::numeric_limits<Real>::quiet_NaN());
  run(*step_launch);
  if (creep) run(*creep->end);
  if (writes) return;
  const auto numbers = result.map(MapFor::reading);
  for (std::size_t c = 0; c < count; ++c)
    if (std::isnan(numbers[c * STEP_RESULT_ROWS + STEP_RESULT_P])) refuse_unwritten(device());
  writes = true;
}

template <class Real>
PadStepper<Real>::PadStepper(Executor& executor, const fem::PadSensor& pad, std::size_t count,
                             std::span<const double> friction, const StepOptions& options, const PairInfluence& pairs)
    : state_(std::make_unique<State>(executor, pad, count, options, pairs)) {
  set_friction(friction);
}
template <class Real>
PadStepper<Real>::~PadStepper() = default;
template <class Real>
PadStepper<Real>::PadStepper(PadStepper&&) noexcept = default;
template <class Real>
PadStepper<Real>& PadStepper<Real>::operator=(PadStepper&&) noexcept = default;

template <class Real>
std::size_t PadStepper<Real>::count() const {
  return state_->count;
}
template <class Real>
std::size_t PadStepper<Real>::tactels() const {
  return state_->stresses.rows / 3;
}
template <class Real>
const fem::PadCells& PadStepper<Real>::cells() const {
  return state_->cells;
}
template <class Real>
const StepOptions& PadStepper<Real>::options() const {
  return state_->options;
}
template <class Real>
std::size_t PadStepper<Real>::lanes() const {
  return state_->lanes();
}
template <class Real>
std::size_t PadStepper<Real>::state_rows() const {
  return state_->head().size() + state_->rows();
}

template <class Real>
void PadStepper<Real>::set_friction(std::span<const double> friction) {
  State& s = *state_;
  std::vector<double> all(friction.begin(), friction.end());
  if (all.size() == 1) all.assign(count(), all.front());
  const std::size_t each = all.size() == count() * s.cell_count() ? s.cell_count() : 1;
  check_size("friction", all.size(), each * count());
  for (const double mu : all)
    if (!(mu >= 0 && mu <= 1e6)) throw ValueError("friction", fmt::format("{}", mu), "0 to 1e6");
  if (each > 1 && !s.mapped) s.take_map();
  const auto input = s.input.map();
  for (std::size_t c = 0; c < count(); ++c) {
    input[s.at(c, STEP_MU, s.input_rows())] = static_cast<Real>(all[c * each]);
    for (std::size_t i = 0; s.mapped && i < s.cell_count(); ++i)
      input[s.at(c, STEP_INPUT_ROWS + i, s.input_rows())] = static_cast<Real>(all[c * each + i % each]);
  }
}

template <class Real>
template <class Number>
void PadStepper<Real>::set_heights(std::span<const Number> heights, std::span<const Number> cover) {
  State& s = *state_;
  check_size("heights", heights.size(), count() * s.cell_count());
  if (!cover.empty()) check_size("cover", cover.size(), heights.size());
  const auto all = s.heights.map();
  const auto softs = s.soft.map();
  s.put_input(STEP_BEYOND, 1, std::vector<double>(count(), -1), std::array{1.0});
  for (std::size_t c = 0; c < count(); ++c)
    s.put_heights(c, &heights[c * s.cell_count()], cover.empty() ? nullptr : &cover[c * s.cell_count()], all.view(),
                  softs.view());
}

template <class Real>
void PadStepper<Real>::set_surface(std::size_t contact, const fem::PadSurface& surface, double beyond) {
  State& s = *state_;
  const auto all = s.heights.map();
  const auto softs = s.soft.map();
  s.put_heights(contact, surface.height.data(), surface.cover.data(), all.view(), softs.view());
  s.input.map()[s.at(contact, STEP_BEYOND, s.input_rows())] =
      static_cast<Real>(std::min(beyond / s.pad.thickness, double{PAD_OPEN}));
}

template <class Real>
void PadStepper<Real>::set_axes(std::span<const double> axes) {
  check_size("axes", axes.size(), 2 * count());
  const double per_H = 1 / state_->pad.thickness;
  state_->put_input(STEP_AXIS_X, 2, axes, std::array{per_H, per_H});
}

template <class Real>
void PadStepper<Real>::move(std::span<const double> pose) {
  state_->step(pose, false);
}
template <class Real>
void PadStepper<Real>::press(std::span<const double> wrench) {
  state_->step(wrench, true);
}

template <class Real>
std::span<const Real> PadStepper<Real>::results() const {
  State& s = *state_;
  if (!s.result_view) s.result_view = std::make_unique<typename State::Mapping>(s.result, MapFor::reading);
  return s.result_view->view().first(count() * STEP_RESULT_ROWS);
}

template <class Real>
std::span<const Real> PadStepper<Real>::State::made(Sums& sums) {
  if (!sums.made) {
    sums.view.reset();
    executor.run(*sums.launch, places / lanes(), {.equal_groups = true});
    sums.made = true;
  }
  if (!sums.view) sums.view = std::make_unique<Mapping>(sums.numbers, MapFor::reading);
  return sums.view->view().first(count * sums.rows);
}

template <class Real>
std::span<const Real> PadStepper<Real>::frames() {
  return state_->made(state_->stresses);
}

template <class Real>
std::span<const Real> PadStepper<Real>::markers() {
  if (state_->displacements.rows == 0) return {};
  return state_->made(state_->displacements);
}

template <class Real>
std::vector<double> PadStepper<Real>::tractions() const {
  const State& s = *state_;
  const std::size_t cells = s.cell_count();
  const auto all = s.state.map(MapFor::reading);
  std::vector<double> made(count() * 3 * cells);
  for (std::size_t c = 0; c < count(); ++c)
    for (std::size_t k = 0; k < 3 * cells; ++k)
      made[c * 3 * cells + k] = all[s.at(c, k, s.rows())] * s.pad.young / (k < cells ? s.root_zz : s.root_tt);
  return made;
}

template <class Real>
std::vector<double> PadStepper<Real>::poses() const {
  const State& s = *state_;
  const auto all = s.state.map(MapFor::reading);
  std::vector<double> made(4 * count());
  for (std::size_t c = 0; c < count(); ++c)
    for (std::size_t k = 0; k < 4; ++k)
      made[4 * c + k] = static_cast<double>(all[s.at(c, STEP_FIELDS * s.cell_count() + STEP_POSE + k, s.rows())]) *
                        (k < 3 ? s.pad.thickness : 1);
  return made;
}

template <class Real>
void PadStepper<Real>::reset(std::span<const std::uint8_t> mask) {
  State& s = *state_;
  check_size("mask", mask.size(), count());
  const auto all = s.state.map();
  for (std::size_t c = 0; c < count(); ++c)
    if (mask[c] != 0)
      for (std::size_t k = 0; k < s.rows(); ++k) all[s.at(c, k, s.rows())] = 0;
}

template <class Real>
void PadStepper<Real>::reset() {
  const auto all = state_->state.map(MapFor::writing);
  std::ranges::fill(all.view(), Real(0));
}

template <class Real>
std::vector<Real> PadStepper<Real>::state(std::span<const std::size_t> contacts) const {
  const State& s = *state_;
  const auto all = s.state.map(MapFor::reading);
  std::vector<Real> made;
  const std::size_t asked = contacts.empty() ? count() : contacts.size();
  const auto head = s.head();
  made.reserve(asked * state_rows());
  for (std::size_t c = 0; c < asked; ++c) {
    const std::size_t contact = contacts.empty() ? c : contacts[c];
    if (contact >= count()) throw ValueError("contacts", std::to_string(contact), fmt::format("below {}", count()));
    made.insert(made.end(), head.begin(), head.end());
    for (std::size_t k = 0; k < s.rows(); ++k) made.push_back(all[s.at(contact, k, s.rows())]);
  }
  return made;
}

template <class Real>
void PadStepper<Real>::set_state(std::span<const Real> numbers, std::span<const std::size_t> contacts) {
  State& s = *state_;
  const std::size_t given = contacts.empty() ? count() : contacts.size();
  const std::size_t rows = state_rows();
  if (numbers.size() % rows == 0) check_size("state", numbers.size(), given * rows);
  for (const std::size_t contact : contacts)
    if (contact >= count()) throw ValueError("contacts", std::to_string(contact), fmt::format("below {}", count()));
  for (std::size_t c = 0; c < given; ++c) s.check_state(numbers.subspan(std::min(c * rows, numbers.size())));
  check_size("state", numbers.size(), given * rows);
  const auto all = s.state.map();
  for (std::size_t c = 0; c < given; ++c)
    for (std::size_t k = 0; k < s.rows(); ++k)
      all[s.at(contacts.empty() ? c : contacts[c], k, s.rows())] = numbers[(c + 1) * rows - s.rows() + k];
}

template <class Real>
typename PadStepper<Real>::Kept PadStepper<Real>::keep() const {
  const auto all = [](const Buffer<Real>& buffer) {
    const auto numbers = buffer.map(MapFor::reading);
    return std::vector<Real>(numbers.view().begin(), numbers.view().end());
  };
  return {all(state_->state), all(state_->result)};
}

template <class Real>
void PadStepper<Real>::put_back(const Kept& kept, std::span<const std::uint8_t> mask) {
  State& s = *state_;
  if (!mask.empty()) check_size("mask", mask.size(), count());
  s.forget();
  const auto put = [&](Buffer<Real>& buffer, const std::vector<Real>& from, std::size_t rows, const auto& at) {
    const auto all = buffer.map();
    for (std::size_t c = 0; c < count(); ++c)
      for (std::size_t k = 0; k < rows && (mask.empty() || mask[c] == 0); ++k) all[at(c, k)] = from[at(c, k)];
  };
  put(s.state, kept.state, s.rows(), [&](std::size_t c, std::size_t k) { return s.at(c, k, s.rows()); });
  put(s.result, kept.result, STEP_RESULT_ROWS, [](std::size_t c, std::size_t k) { return c * STEP_RESULT_ROWS + k; });
}

template <class Real>
void PadStepper<Real>::set_dt(double dt) {
  StepOptions options = state_->options;
  options.dt = dt;
  check(options);
  state_->options = options;
}

template <class Real>
void PadStepper<Real>::set_reach(double reach) {
  state_->step_launch->set("reach", static_cast<Real>(std::min(reach, 1e20)));
}

template <class Real>
void PadStepper<Real>::set_wide_share(double share) {
  if (state_->wide_from != never_wide)
    state_->step_launch->set("wide_from", std::int32_t(std::ceil(share * state_->cells.count())));
}

template class PadStepper<float>;
template class PadStepper<double>;
template void PadStepper<float>::set_heights(std::span<const float>, std::span<const float>);
template void PadStepper<float>::set_heights(std::span<const double>, std::span<const double>);
template void PadStepper<double>::set_heights(std::span<const float>, std::span<const float>);
template void PadStepper<double>::set_heights(std::span<const double>, std::span<const double>);

}  // namespace tactel::host
