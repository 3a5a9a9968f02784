// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_simulator.h"

#include <array>
#include <deque>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <type_traits>

#include "fem/contact_laws.h"
#include "fem/layer/linear_elements.h"
#include "host/contact/patch_contact.h"
#include "host/contact/solve.h"
#include "host/contact/solve_on_rung.h"
#include "host/sets/transducer_chain.h"
#include "host/support/errors.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/patch_layout.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;

/// All that a condensation depends on: E only scales it.
fem::Sensor without_young(fem::Sensor sensor) {
  sensor.young = 1;
  return sensor;
}

std::vector<fem::Sensor> distinct_sensors(const SceneSource& source) {
  std::vector<fem::Sensor> distinct;
  for (const fem::Sensor& sensor : source.sensors())
    if (std::ranges::find(distinct, without_young(sensor)) == distinct.end()) distinct.push_back(without_young(sensor));
  return distinct;
}

/// One load step as a row of a set.
struct Row {
  double slip_index = 0, P = 0, Q = 0, indentation = 0, tangential = 0, residual = 0;
  int sticking = 0, slipping = 0, status = LANE_SOLVED;
};

void resize(ContactSet& set, std::size_t rows) {
  set.frames.resize(rows * set.inputs);
  for (auto* list : {&set.slip_index, &set.normal_force, &set.tangential_force, &set.indentation, &set.tangential,
                     &set.friction, &set.stick_fraction, &set.residual})
    list->resize(rows);
  set.contact_nodes.resize(rows), set.indenter.resize(rows);
  if (set.sensors)
    for (auto* list : {&set.poisson, &set.thickness, &set.young, &set.length}) list->resize(rows);
  set.contact.resize(rows), set.step.resize(rows), set.status.resize(rows);
}

/// A contact but for its shape and path, which its launch has.
struct Contact {
  std::uint64_t number = 0;  ///< in the sweep
  fem::Sensor sensor;
  double friction = 0, position = 0;
  std::size_t launch = 0, i = 0;  ///< of the range, and in it
  int first_step = 0;             ///< the first that may be a row
  std::uint16_t kind = 0;
  bool until_sliding = false;
};

/// Fills row `at` but for its frame, whose place it returns.
std::span<float> put_row(ContactSet& set, std::size_t at, const Row& row, const Contact& of, int step) {
  const int touching = row.sticking + row.slipping;
  set.slip_index[at] = static_cast<float>(std::clamp(row.slip_index, -1.0, 1.0));  // rounding apart, Q <= mu P
  set.normal_force[at] = static_cast<float>(row.P);
  set.tangential_force[at] = static_cast<float>(row.Q);
  set.indentation[at] = static_cast<float>(row.indentation);
  set.tangential[at] = static_cast<float>(row.tangential);
  set.friction[at] = static_cast<float>(of.friction);
  set.stick_fraction[at] = touching ? static_cast<float>(row.sticking) / static_cast<float>(touching) : 0;
  set.contact_nodes[at] = static_cast<std::uint16_t>(touching);
  set.contact[at] = of.number;
  set.step[at] = static_cast<std::uint32_t>(step);
  set.indenter[at] = of.kind;
  set.status[at] = static_cast<std::uint8_t>(row.status);
  set.residual[at] = static_cast<float>(row.residual);
  if (set.sensors) {
    set.poisson[at] = static_cast<float>(of.sensor.poisson);
    set.thickness[at] = static_cast<float>(of.sensor.thickness);
    set.young[at] = static_cast<float>(of.sensor.young);
    set.length[at] = static_cast<float>(of.sensor.length);
  }
  return std::span(set.frames).subspan(at * set.inputs, set.inputs);
}

/// Which steps of a contact that the fallback solved become rows.
std::vector<int> rows_of(const fem::ContactSolution& solution, int first) {
  std::vector<int> steps;
  for (int k = first; k < static_cast<int>(solution.steps.size()); ++k)
    if (solution.steps[k].slip_index) steps.push_back(k);
  return steps;
}

void put_stress(const fem::ContactStep& step, std::span<float> frame) {
  std::ranges::copy(step.sigma_y.cast<float>(), frame.begin());
  std::ranges::copy(step.tau_xy.cast<float>(), frame.begin() + step.sigma_y.size());
}

void put_rows(ContactSet& set, std::size_t at, const fem::ContactSolution& solution, const Contact& of) {
  for (const int k : rows_of(solution, of.first_step)) {
    const fem::ContactStep& step = solution.steps[k];
    Row row{.slip_index = *step.slip_index,
            .P = step.P,
            .Q = step.Q,
            .indentation = step.indentation,
            .tangential = step.tangential};
    row.sticking = static_cast<int>(std::ranges::count(step.status, fem::GapStatus::stick));
    row.slipping = static_cast<int>(std::ranges::count(step.status, fem::GapStatus::slip));
    row.status = !step.converged ? LANE_UNSOLVED : row.sticking ? LANE_SOLVED : LANE_SLIDING;
    const fem::Residual& r = step.residual;
    row.residual = std::max({r.penetration, r.cone, r.complementarity, r.drift, r.balance});
    put_stress(step, put_row(set, at++, row, of, k));
  }
}

template <class Launcher>
using View = typename Launcher::Batch::View;

template <class Launcher>
using Answer = decltype(std::declval<const View<Launcher>&>().answer(0));

/// What the load steps of a contact say together.
struct Survey {
  bool solved = true;        ///< every step
  std::size_t rows = 0;      ///< steps that become rows
  double deepest = 0;        ///< mm
  bool slides_far = false;   ///< further over the rubber than displacements are small
  bool ran_through = false;  ///< all steps, and did not slide in the last: a drag until sliding then never slid
};

double mesh_spacing(const fem::Sensor& sensor) { return sensor.length / (sensor.columns - 1); }

/// Scenes that the sweeps did not solve, and the launcher of each.
struct Unsolved {
  std::vector<fem::Scene> scenes;
  std::vector<std::size_t> sensor;  ///< [scenes] index of the launcher
};

/// What a set does with the mesh alone, or with patches alone.
template <class Launcher>
struct Solver;

template <class Real>
struct Solver<GapSweep<Real>> {
  using Launcher = GapSweep<Real>;
  using Scenes = std::vector<fem::Scene>;
  static Scenes no_scenes(const Launcher&) { return {}; }
  static void add(fem::Scene&& scene, const fem::LoadPath&, Scenes& scenes) { scenes.push_back(std::move(scene)); }
  static auto prepare(const Launcher& launcher, Scenes scenes) { return launcher.prepare(scenes); }

  static std::vector<Launcher> launchers(Executor& executor, const SceneSource& source,
                                         const std::vector<fem::Sensor>& sensors, const SetOptions& options) {
    if (source.own_sensors())
      throw ConfigError("", "[sweep] sensors", "(missing)", "a number of sensors to draw, for contacts on a mesh");
    make_tables(executor, sensors.size(),
                [&](std::size_t k) { fem::condense_cached(sensors[k], fem::default_cache_directory()); });
    GapSweepOptions sweep;
    sweep.tolerance = options.tolerance, sweep.accept = options.accept;
    sweep.base_forces = false;
    sweep.base_sums = true;
    sweep.nodes = false;
    std::vector<Launcher> all;
    all.reserve(sensors.size());
    for (const fem::Sensor& sensor : sensors) all.emplace_back(executor, sensor, sweep);
    return all;
  }
  static bool large_enough(const SetOptions&, const Contact&, const View<Launcher>&) { return true; }
  static double element_width(const Contact& contact, const View<Launcher>&) { return mesh_spacing(contact.sensor); }
  static GapSweepSolver mesh(Executor& executor, const SetOptions& options) {
    return {executor, options.precision, {.tolerance = options.tolerance, .accept = options.accept, .audit = false}};
  }
  static std::vector<fem::ContactSolution> solve_again(const GapSweepSolver& mesh, const SceneSource&,
                                                       const std::vector<Launcher>&, const Unsolved& unsolved,
                                                       const SetOptions&) {
    return mesh.solve(unsolved.scenes);
  }
};

template <class Real>
struct Solver<PatchContact<Real>> {
  using Launcher = PatchContact<Real>;
  using Scenes = typename Launcher::Scenes;
  static Scenes no_scenes(const Launcher& launcher) { return Scenes(launcher); }
  static void add(fem::Scene&& scene, const fem::LoadPath& path, Scenes& scenes) { scenes.push_back(scene, path); }
  static auto prepare(const Launcher& launcher, Scenes scenes) { return launcher.prepare(std::move(scenes), false); }

  static std::vector<Launcher> launchers(Executor& executor, const SceneSource& source,
                                         const std::vector<fem::Sensor>& sensors, const SetOptions& options) {
    if (source.own_sensors())
      return {Launcher(executor, sensor_family(executor, *source.own_sensors(), options.patch->sides),
                       patch_options(*options.patch))};
    std::vector<std::optional<fem::LayerModel>> models(sensors.size());
    make_tables(executor, sensors.size(), [&](std::size_t k) { models[k] = fem::layer_model(sensors[k]); });
    std::vector<Launcher> all;
    all.reserve(models.size());
    for (const auto& model : models) all.emplace_back(executor, *model, patch_options(*options.patch));
    return all;
  }
  static bool large_enough(const SetOptions& options, const Contact& contact, const View<Launcher>& view) {
    return !fem::needs_linear_pressure(contact.sensor, element_width(contact, view)) &&
           !grown_contact<Real>(view, contact.i, options.patch->elements);
  }
  static double element_width(const Contact& contact, const View<Launcher>& view) {
    return view.patch(contact.i, PATCH_ELEMENT);
  }
  static GapSweepSolver mesh(Executor& executor, const SetOptions& options) {
    return mesh_solver(executor, *options.patch, true, false);
  }
  static std::vector<fem::ContactSolution> solve_again(const GapSweepSolver& mesh, const SceneSource& source,
                                                       const std::vector<Launcher>& launchers, const Unsolved& unsolved,
                                                       const SetOptions& options) {
    std::vector<fem::ContactSolution> answers(unsolved.scenes.size());
    for (std::size_t sensor = 0; sensor < launchers.size(); ++sensor) {
      std::vector<fem::Scene> scenes;
      std::vector<std::size_t> places;
      for (std::size_t i = 0; i < answers.size(); ++i)
        if (unsolved.sensor[i] == sensor) scenes.push_back(unsolved.scenes[i]), places.push_back(i);
      auto solved = solve_patch_contact(launchers[sensor], scenes);
      if (!source.own_sensors()) finish_on_mesh(mesh, scenes, *options.patch, solved);
      for (std::size_t k = 0; k < places.size(); ++k) answers[places[k]] = std::move(solved[k]);
    }
    return answers;
  }
};

double deepest(const fem::ContactSolution& solution) {
  double most = 0;  // mm
  for (const fem::ContactStep& step : solution.steps) most = std::max(most, step.indentation);
  return most;
}

/// Whether the indenter slides further over the rubber than displacements are small.
bool slides_far(const fem::Scene& scene, const fem::ContactSolution& solution) {
  const bool patch = solution.surface_width.size() > 0;
  const double element = patch ? solution.surface_width[0] : mesh_spacing(scene.sensor);
  return std::ranges::any_of(solution.steps, [&](const fem::ContactStep& step) {
    const auto touches = [](fem::GapStatus status) { return status != fem::GapStatus::open; };
    const auto touching = static_cast<double>(std::ranges::count_if(step.status, touches));
    return step.slip_distance > slip_limit(scene.sensor, element * touching);
  });
}

template <class Launcher>
Survey survey(const View<Launcher>& view, const Contact& contact) {
  const double element = Solver<Launcher>::element_width(contact, view);
  const Answer<Launcher> answer = view.answer(contact.i);
  Survey found;
  for (int k = 0; k < answer.steps; ++k) {
    const auto said = [&](int row) { return static_cast<double>(answer.result(k, row)); };
    const int status = static_cast<int>(said(LANE_STATUS));
    if (status == LANE_NOT_RUN) break;
    found.solved = found.solved && status != LANE_UNSOLVED && status != LANE_INVALID;
    found.deepest = std::max(found.deepest, said(LANE_INDENTATION));
    found.slides_far =
        found.slides_far ||
        said(LANE_SLIP_DISTANCE) > slip_limit(contact.sensor, element * (said(LANE_STICKING) + said(LANE_SLIPPING)));
    found.rows += k >= contact.first_step && slip_index(contact.friction, said(LANE_P), 0);
    found.ran_through = k == answer.steps - 1 && status != LANE_SLIDING;
  }
  return found;
}

/// A contact of the sweeps whose rows go into a set.
template <class Launcher>
struct RowsFrom {
  const Contact* contact = nullptr;
  std::size_t at = 0;
  Answer<Launcher> answer;
};

/// Lanes whose numbers lie side by side in memory are read together, step by step.
template <class Launcher>
void put_rows(ContactSet& set, std::span<RowsFrom<Launcher>> contacts) {
  int steps = 0;
  for (const auto& rows : contacts) steps = std::max(steps, rows.answer.steps);
  for (int k = 0; k < steps; ++k)
    for (RowsFrom<Launcher>& rows : contacts) {
      const Contact& contact = *rows.contact;
      if (k < contact.first_step || k >= rows.answer.steps) continue;
      const auto said = [&](int row) { return static_cast<double>(rows.answer.result(k, row)); };
      const int status = static_cast<int>(said(LANE_STATUS));
      if (status == LANE_NOT_RUN) continue;
      const auto S = slip_index(contact.friction, said(LANE_P), said(LANE_SLIP_INDEX));
      if (!S) continue;
      const Row row{.slip_index = *S,
                    .P = said(LANE_P),
                    .Q = said(LANE_Q),
                    .indentation = said(LANE_INDENTATION),
                    .tangential = said(LANE_TANGENTIAL),
                    .residual = std::max({said(LANE_PENETRATION), said(LANE_CONE), said(LANE_COMPLEMENTARITY),
                                          said(LANE_DRIFT), said(LANE_BALANCE)}),
                    .sticking = static_cast<int>(said(LANE_STICKING)),
                    .slipping = static_cast<int>(said(LANE_SLIPPING)),
                    .status = status};
      rows.answer.tactels(k, put_row(set, rows.at++, row, contact, k));
    }
}

/// Contacts that share a launch: same sensor but for E, same kind.
template <class Launcher>
struct SharedLaunch {
  std::size_t sensor = 0;
  ContactKind kind;
  int steps = 0;                             ///< of the longest path
  typename Solver<Launcher>::Scenes scenes;  ///< until they are in the batch
  std::vector<std::uint64_t> which{};        ///< [scenes] contact, counted from the range's first
  std::optional<typename Launcher::Batch> batch{};
};

/// Contacts that are solved again, by their place in the range.
struct FallenContact {
  fem::Scene scene;
  fem::ContactSolution solution;
};
using Fallen = std::map<std::uint64_t, FallenContact>;

/// Lanes times load steps of a launch, at most: some 60 MB of results.
constexpr std::size_t most_lane_steps = 1u << 18;

template <class Launcher>
struct RangeOf : SetSimulator::Range {
  std::vector<Contact> contacts;
  std::vector<float> parameters;  ///< [contacts][columns]
  std::vector<SharedLaunch<Launcher>> launches;

  /// The launch that a contact goes to; a new one where the last of its kind is full.
  std::size_t launch_for(std::size_t sensor, ContactKind kind, int steps, const std::vector<Launcher>& launchers) {
    for (std::size_t l = launches.size(); l-- > 0;) {
      const SharedLaunch<Launcher>& launch = launches[l];
      if (launch.sensor != sensor || launch.kind != kind) continue;
      if ((launch.which.size() + 1) * std::max(steps, launch.steps) <= most_lane_steps) return l;
      break;
    }
    launches.push_back({.sensor = sensor, .kind = kind, .scenes = Solver<Launcher>::no_scenes(launchers[sensor])});
    return launches.size() - 1;
  }
};

}  // namespace

struct SetSimulator::State {
  State(Executor& executor, const SceneSource& source, const SetOptions& options)
      : executor(executor),
        source(source),
        options(options),
        sensors(distinct_sensors(source)),
        parameters(source.parameters()),
        columns(columns_of(source)) {
    if (source.transducer().present())
      chain.emplace(executor, source.transducer(), source.seed(), 2 * source.tactels());
  }
  virtual ~State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  virtual std::unique_ptr<Range> prepare(std::uint64_t first, std::uint64_t count) const = 0;
  virtual void run(Range& range, const RunOptions& run_options) const = 0;
  virtual ContactSet collect(Range& range) = 0;

  Executor& executor;
  const SceneSource& source;
  SetOptions options;
  std::vector<fem::Sensor> sensors;  ///< distinct ones
  ContactParameters parameters;
  SetColumns columns;
  std::optional<TransducerChain> chain;  ///< where there is more than bare stresses; used by collect alone
  std::mutex chain_turn;
};

namespace {

template <class Launcher>
struct Simulation : SetSimulator::State {
  Simulation(Executor& executor, const SceneSource& source, const SetOptions& options)
      : State(executor, source, options),
        launchers(Solver<Launcher>::launchers(executor, source, sensors, options)),
        mesh(Solver<Launcher>::mesh(executor, options)) {}

  std::unique_ptr<SetSimulator::Range> prepare(std::uint64_t first, std::uint64_t count) const override;
  void run(SetSimulator::Range& range, const RunOptions& run_options) const override;
  ContactSet collect(SetSimulator::Range& range) override;
  void measure(ContactSet& set, const std::vector<std::size_t>& rows, const SharedLaunch<Launcher>& launch,
               const View<Launcher>& view, const Fallen& fallen, std::uint64_t first);

  std::vector<Launcher> launchers;  ///< [sensors]
  GapSweepSolver mesh;              ///< of contacts that these do not solve
};

template <class Launcher>
std::unique_ptr<SetSimulator::Range> Simulation<Launcher>::prepare(std::uint64_t first, std::uint64_t count) const {
  auto range = std::make_unique<RangeOf<Launcher>>();
  range->first = first, range->count = count;
  const std::size_t numbers = parameters.columns().size();
  range->contacts.reserve(count);
  range->parameters.resize(count * numbers);
  const auto start = Clock::now();
  for (std::uint64_t k = 0; k < count; ++k) {
    auto [scene, indenter] = source.contact(first + k);
    const fem::LoadPath path = fem::load_path(scene.load);
    const int steps = static_cast<int>(path.steps.size());
    parameters.put(scene, indenter, std::span(range->parameters).subspan(k * numbers, numbers));
    const auto sensor =
        source.own_sensors() ? 0 : std::ranges::find(sensors, without_young(scene.sensor)) - sensors.begin();
    const std::size_t l = range->launch_for(static_cast<std::size_t>(sensor), kind_of(scene), steps, launchers);
    SharedLaunch<Launcher>& launch = range->launches[l];
    range->contacts.push_back({.number = first + k,
                               .sensor = scene.sensor,
                               .friction = scene.friction,
                               .position = scene.indenter.position,
                               .launch = l,
                               .i = launch.which.size(),
                               .first_step = source.press_rows() ? 0 : path.indentation_steps - 1,
                               .kind = indenter,
                               .until_sliding = path.until_sliding});
    launch.steps = std::max(launch.steps, steps);
    Solver<Launcher>::add(std::move(scene), path, launch.scenes);
    launch.which.push_back(k);
  }
  range->seconds.draw = seconds_since(start);
  for (SharedLaunch<Launcher>& launch : range->launches) {
    launch.batch = Solver<Launcher>::prepare(launchers[launch.sensor], std::move(launch.scenes));
    range->steps += launch.batch->steps_in_all();
  }
  range->seconds.lay_out = seconds_since(start) - range->seconds.draw;
  return range;
}

template <class Launcher>
void Simulation<Launcher>::run(SetSimulator::Range& range, const RunOptions& run_options) const {
  const auto start = Clock::now();
  for (SharedLaunch<Launcher>& launch : static_cast<RangeOf<Launcher>&>(range).launches) {
    launch.batch->run(run_options);
    range.kernel_seconds += launch.batch->seconds();
  }
  range.seconds.solve = seconds_since(start);
}

/// Readings in place of stresses, in the rows of a launch's contacts. They depend on all load steps up to them, so
/// these go through the chain, rows or not.
template <class Launcher>
void Simulation<Launcher>::measure(ContactSet& set, const std::vector<std::size_t>& rows,
                                   const SharedLaunch<Launcher>& launch, const View<Launcher>& view,
                                   const Fallen& fallen, std::uint64_t first) {
  const std::size_t inputs = set.inputs;
  std::vector<TransducerChain::Contact> contacts;
  std::size_t steps = 0;
  for (const std::size_t i : view.by_lane()) {
    const std::uint64_t k = launch.which[i];
    contacts.push_back({first + k, rows[k] == rows[k + 1] ? 0 : set.step[rows[k + 1] - 1] + 1});
    steps += contacts.back().steps;
  }
  std::vector<float> signal(steps * inputs);
  auto at = signal.begin();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const std::size_t i = view.by_lane()[c];
    const auto solution = fallen.find(launch.which[i]);
    for (std::uint32_t step = 0; step < contacts[c].steps; ++step, at += inputs) {
      if (solution == fallen.end())
        view.answer(i).tactels(static_cast<int>(step), std::span(at, inputs));
      else
        put_stress(solution->second.solution.steps[step], std::span(at, inputs));
    }
  }
  {
    const std::lock_guard turn(chain_turn);
    chain->run(contacts, signal);
  }
  auto reading = signal.begin();
  for (std::size_t c = 0; c < contacts.size(); reading += contacts[c++].steps * inputs) {
    const std::uint64_t k = launch.which[view.by_lane()[c]];
    for (std::size_t row = rows[k]; row < rows[k + 1]; ++row)
      std::copy_n(reading + set.step[row] * inputs, inputs, set.frames.begin() + row * inputs);
  }
}

/// Numbers of a cache line, which a processor reads together.
constexpr std::size_t side_by_side_answers = 16;
/// Contacts between the request of an answer and its use: some 5 kB.
constexpr std::size_t fetched_ahead = 2;

/// Returns the contacts of a range as they lie in memory where they take turns there; else in their own order, so that
/// their rows are written one after the other.
template <class Launcher>
std::vector<std::uint64_t> reading_order(const RangeOf<Launcher>& range, const std::deque<View<Launcher>>& views) {
  std::vector<std::uint64_t> order(range.contacts.size());
  std::iota(order.begin(), order.end(), std::uint64_t{0});
  if (views.empty() || views[0].interleaved() == 1) return order;
  auto next = order.begin();
  for (std::size_t l = 0; l < views.size(); ++l)
    for (const std::size_t i : views[l].by_lane()) *next++ = range.launches[l].which[i];
  return order;
}

template <class Launcher>
ContactSet Simulation<Launcher>::collect(SetSimulator::Range& any_range) {
  auto& range = static_cast<RangeOf<Launcher>&>(any_range);
  const auto start = Clock::now();
  std::deque<View<Launcher>> views;                   // they cannot be moved
  std::vector<std::size_t> rows(range.count + 1, 0);  // of contact k: rows[k] ... rows[k + 1] - 1
  std::vector<std::uint64_t> unsolved;                // contacts, counted from the range's first
  Unsolved again_from;
  Fallen fallen;
  std::uint64_t deep = 0, far = 0, never = 0;  // as in ContactSet
  for (const SharedLaunch<Launcher>& launch : range.launches) views.emplace_back(*launch.batch);
  const std::vector<std::uint64_t> order = reading_order(range, views);
  const auto answer_of = [&](std::size_t place) {
    const Contact& contact = range.contacts[order[std::min(place, order.size() - 1)]];
    return views[contact.launch].answer(contact.i);
  };
  for (std::size_t place = 0; place < order.size(); ++place) {
    answer_of(place + fetched_ahead).fetch_results();
    const std::uint64_t k = order[place];
    const Contact& contact = range.contacts[k];
    const View<Launcher>& view = views[contact.launch];
    const Survey found = survey<Launcher>(view, contact);
    if (found.solved && Solver<Launcher>::large_enough(options, contact, view)) {
      rows[k + 1] = found.rows;
      deep += too_deep(contact.sensor, found.deepest);
      far += found.slides_far;
      never += found.rows > 0 && contact.until_sliding && found.ran_through;
    } else {
      unsolved.push_back(k);
      const fem::Scene& scene = fallen[k].scene = source.contact(contact.number).scene;
      again_from.scenes.push_back(scene);
      again_from.sensor.push_back(range.launches[contact.launch].sensor);
    }
  }
  const auto begin_again = Clock::now();
  if (!unsolved.empty()) {
    auto again = Solver<Launcher>::solve_again(mesh, source, launchers, again_from, options);
    for (std::size_t j = 0; j < unsolved.size(); ++j) {
      const std::uint64_t k = unsolved[j];
      rows[k + 1] = rows_of(again[j], range.contacts[k].first_step).size();
      fallen[k].solution = std::move(again[j]);
    }
  }
  range.seconds.solve_again = seconds_since(begin_again);
  ContactSet set(columns);
  set.contacts = range.count;
  set.without_rows = static_cast<std::uint64_t>(std::count(rows.begin() + 1, rows.end(), std::size_t{0}));
  std::partial_sum(rows.begin(), rows.end(), rows.begin());
  resize(set, rows.back());
  set.too_deep = deep, set.far_slip = far, set.never_slid = never;
  std::vector<RowsFrom<Launcher>> together;
  const auto put = [&] {
    put_rows<Launcher>(set, together);
    together.clear();
  };
  for (std::size_t place = 0; place < order.size(); ++place) {
    const auto ahead = answer_of(place + fetched_ahead);
    ahead.fetch_results(), ahead.fetch_stresses();
    const std::uint64_t k = order[place];
    if (rows[k] == rows[k + 1] || fallen.contains(k)) continue;
    together.push_back({&range.contacts[k], rows[k], answer_of(place)});
    if (together.size() == std::min(together.back().answer.stride, side_by_side_answers)) put();
  }
  put();
  for (const auto& [k, contact] : fallen) {
    const auto& [scene, solution] = contact;
    put_rows(set, rows[k], solution, range.contacts[k]);
    set.fell_back += solution.fell_back;
    set.too_deep += too_deep(scene.sensor, deepest(solution));
    set.far_slip += slides_far(scene, solution);
    set.never_slid += rows[k] < rows[k + 1] && host::never_slid(scene, solution);
    set.unsolved += std::ranges::any_of(solution.steps, [](const auto& step) { return !step.converged; });
  }
  set.contact_parameters = std::move(range.parameters);
  for (std::size_t l = 0; chain && l < views.size(); ++l)
    measure(set, rows, range.launches[l], views[l], fallen, range.first);
  views.clear();
  range.launches.clear();  // their memory, before the rows are written
  range.seconds.gather = seconds_since(start) - range.seconds.solve_again;
  return set;
}

std::unique_ptr<SetSimulator::State> simulation(Executor& executor, const SceneSource& source, SetOptions options) {
  if (!options.patch && source.model() == fem::SurfaceModel::patch) options.patch = usual_patch();
  if (options.patch) {
    options.patch->precision = options.precision;
    if (options.tolerance > 0) options.patch->tolerance = options.tolerance;
    if (options.accept > 0) options.patch->accept_at_most(options.accept);
  }
  const bool fp32 = options.precision == Precision::fp32;
  const auto made = [&]<class Launcher>(std::type_identity<Launcher>) -> std::unique_ptr<SetSimulator::State> {
    return std::make_unique<Simulation<Launcher>>(executor, source, options);
  };
  if (options.patch)
    return fp32 ? made(std::type_identity<PatchContact<float>>()) : made(std::type_identity<PatchContact<double>>());
  return fp32 ? made(std::type_identity<GapSweep<float>>()) : made(std::type_identity<GapSweep<double>>());
}

}  // namespace

SetColumns columns_of(const SceneSource& source) {
  SetColumns columns(2 * source.tactels(), source.own_sensors().has_value());
  const ContactParameters parameters = source.parameters();
  for (const ContactParameters::Column& column : parameters.columns()) {
    columns.parameters.push_back(column.name);
    columns.parameter_units.push_back(column.unit);
  }
  columns.tactel_x = source.tactel_x();
  return columns;
}

SetSimulator::SetSimulator(Executor& executor, const SceneSource& source, const SetOptions& options)
    : state_(simulation(executor, source, options)) {}

SetSimulator::~SetSimulator() = default;

std::unique_ptr<SetSimulator::Range> SetSimulator::prepare(std::uint64_t first, std::uint64_t count) const {
  return state_->prepare(first, count);
}

void SetSimulator::run(Range& range, const RunOptions& options) const { state_->run(range, options); }

ContactSet SetSimulator::collect(Range& range) const {
  ContactSet set = state_->collect(range);
  set.indenter_names = state_->source.kind_names();
  set.transducer = nn::description(state_->source.transducer());
  set.device = state_->executor.device().info().name;
  set.seed = state_->source.seed();
  set.press_rows = state_->source.press_rows();
  return set;
}

ContactSet SetSimulator::simulate(std::uint64_t first, std::uint64_t count) const {
  const auto range = prepare(first, count);
  run(*range);
  return collect(*range);
}

}  // namespace tactel::host
