#include "host/sets/set_simulator.h"

#include <atomic>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <system_error>
#include <thread>

#include "fem/contact_laws.h"
#include "host/contact/solve.h"
#include "host/sets/transducer_chain.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

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

/// Fills the condensation cache, one sensor a thread at a time. Throws what the first thread that failed threw.
void condense_side_by_side(const std::vector<fem::Sensor>& sensors, int threads) {
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::exception_ptr error;
  const auto work = [&] {
    try {
      for (std::size_t k = next++; k < sensors.size(); k = next++)
        fem::condense_cached(sensors[k], fem::default_cache_directory());
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
      next = sensors.size();
    }
  };
  {
    std::vector<std::jthread> team;
    try {
      for (int i = 1; i < std::min<int>(threads, static_cast<int>(sensors.size())); ++i) team.emplace_back(work);
    } catch (const std::system_error&) {
      // The system creates no more threads: the existing ones do all the work.
    }
    work();
  }
  if (error) std::rethrow_exception(error);
}

/// One load step as a row of a set.
struct Row {
  double slip_index = 0, P = 0, Q = 0, residual = 0;
  int sticking = 0, slipping = 0, status = LANE_SOLVED;
};

void resize(ContactSet& set, std::size_t rows) {
  set.frames.resize(rows * set.inputs);
  for (auto* list :
       {&set.slip_index, &set.normal_force, &set.tangential_force, &set.friction, &set.stick_fraction, &set.residual})
    list->resize(rows);
  set.contact_nodes.resize(rows), set.indenter.resize(rows);
  set.contact.resize(rows), set.step.resize(rows), set.status.resize(rows);
}

/// Fills row `at` but for its frame, whose place it returns.
std::span<float> put_row(ContactSet& set, std::size_t at, const Row& row, const SceneSource::Contact& contact,
                         std::uint64_t number, int step) {
  const int touching = row.sticking + row.slipping;
  set.slip_index[at] = static_cast<float>(row.slip_index);
  set.normal_force[at] = static_cast<float>(row.P);
  set.tangential_force[at] = static_cast<float>(row.Q);
  set.friction[at] = static_cast<float>(contact.scene.friction);
  set.stick_fraction[at] = touching ? static_cast<float>(row.sticking) / static_cast<float>(touching) : 0;
  set.contact_nodes[at] = static_cast<std::uint16_t>(touching);
  set.contact[at] = number;
  set.step[at] = static_cast<std::uint32_t>(step);
  set.indenter[at] = contact.kind;
  set.status[at] = static_cast<std::uint8_t>(row.status);
  set.residual[at] = static_cast<float>(row.residual);
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

void put_rows(ContactSet& set, std::size_t at, const fem::ContactSolution& solution, int first,
              const SceneSource::Contact& contact, std::uint64_t number) {
  for (const int k : rows_of(solution, first)) {
    const fem::ContactStep& step = solution.steps[k];
    Row row{.slip_index = *step.slip_index, .P = step.P, .Q = step.Q};
    row.sticking = static_cast<int>(std::ranges::count(step.status, fem::GapStatus::stick));
    row.slipping = static_cast<int>(std::ranges::count(step.status, fem::GapStatus::slip));
    row.status = !step.converged ? LANE_UNSOLVED : row.sticking ? LANE_SOLVED : LANE_SLIDING;
    const fem::Residual& r = step.residual;
    row.residual = std::max({r.penetration, r.cone, r.complementarity, r.drift, r.balance});
    put_stress(step, put_row(set, at++, row, contact, number, k));
  }
}

template <class Real>
using View = typename GapSweep<Real>::Batch::View;

template <class Real>
int status_of(const View<Real>& view, std::size_t i, int step) {
  return static_cast<int>(view.result(i, step, LANE_STATUS));
}

template <class Real>
bool solved(const View<Real>& view, std::size_t i) {
  for (int k = 0; k < view.path_steps(i); ++k)
    if (const int status = status_of<Real>(view, i, k); status == LANE_UNSOLVED || status == LANE_INVALID) return false;
  return true;
}

double deepest(const fem::ContactSolution& solution) {
  double most = 0;  // mm
  for (const fem::ContactStep& step : solution.steps) most = std::max(most, step.indentation);
  return most;
}

template <class Real>
double deepest(const View<Real>& view, std::size_t i) {
  double most = 0;  // mm
  for (int k = 0; k < view.path_steps(i) && status_of<Real>(view, i, k) != LANE_NOT_RUN; ++k)
    most = std::max(most, static_cast<double>(view.result(i, k, LANE_INDENTATION)));
  return most;
}

/// Whether the indenter slides further over the rubber than displacements are small.
bool slides_far(const fem::Scene& scene, const fem::ContactSolution& solution) {
  return std::ranges::any_of(solution.steps, [&](const fem::ContactStep& step) {
    const auto touches = [](fem::GapStatus status) { return status != fem::GapStatus::open; };
    const auto touching = static_cast<int>(std::ranges::count_if(step.status, touches));
    return step.slip_distance > slip_limit(scene.sensor, touching);
  });
}

template <class Real>
bool slides_far(const fem::Scene& scene, const View<Real>& view, std::size_t i) {
  for (int k = 0; k < view.path_steps(i) && status_of<Real>(view, i, k) != LANE_NOT_RUN; ++k) {
    const auto touching = static_cast<int>(view.result(i, k, LANE_STICKING) + view.result(i, k, LANE_SLIPPING));
    if (static_cast<double>(view.result(i, k, LANE_SLIP_DISTANCE)) > slip_limit(scene.sensor, touching)) return true;
  }
  return false;
}

/// Whether a drag until sliding went through all its steps: one that slides ends there, and one that touches nothing.
template <class Real>
bool never_slid(const fem::Scene& scene, const View<Real>& view, std::size_t i) {
  const int last = view.path_steps(i) - 1;
  const int status = status_of<Real>(view, i, last);
  return fem::load_path(scene.load).until_sliding && status != LANE_NOT_RUN && status != LANE_SLIDING;
}

/// Which steps of a contact that the sweeps solved become rows.
template <class Real>
std::vector<int> rows_of(const View<Real>& view, std::size_t i, int first, double mu) {
  std::vector<int> steps;
  for (int k = first; k < view.path_steps(i) && status_of<Real>(view, i, k) != LANE_NOT_RUN; ++k)
    if (slip_index(mu, view.result(i, k, LANE_P), 0)) steps.push_back(k);
  return steps;
}

template <class Real>
void put_rows(ContactSet& set, std::size_t at, const View<Real>& view, std::size_t i, int first,
              const SceneSource::Contact& contact, std::uint64_t number) {
  const double mu = contact.scene.friction;
  for (const int k : rows_of<Real>(view, i, first, mu)) {
    const auto said = [&](int row) { return static_cast<double>(view.result(i, k, row)); };
    const Row row{.slip_index = *slip_index(mu, said(LANE_P), said(LANE_SLIP_INDEX)),
                  .P = said(LANE_P),
                  .Q = said(LANE_Q),
                  .residual = std::max({said(LANE_PENETRATION), said(LANE_CONE), said(LANE_COMPLEMENTARITY),
                                        said(LANE_DRIFT), said(LANE_BALANCE)}),
                  .sticking = static_cast<int>(said(LANE_STICKING)),
                  .slipping = static_cast<int>(said(LANE_SLIPPING)),
                  .status = static_cast<int>(said(LANE_STATUS))};
    view.tactels(i, k, put_row(set, at++, row, contact, number, k));
  }
}

/// Contacts that share a launch: same sensor but for E, same kind.
template <class Real>
struct SharedLaunch {
  std::size_t sensor = 0;
  ContactKind kind;
  int steps = 0;  ///< of the longest path
  std::vector<fem::Scene> scenes{};
  std::vector<std::uint64_t> which{};  ///< [scenes] contact, counted from the range's first
  std::optional<typename GapSweep<Real>::Batch> batch{};
};

/// Contacts that the exact fallback solved, by their place in the range.
using Fallen = std::map<std::uint64_t, fem::ContactSolution>;

/// Lanes times load steps of a launch, at most: some 60 MB of results.
constexpr std::size_t most_lane_steps = 1u << 18;

template <class Real>
struct RangeOf : SetSimulator::Range {
  std::vector<SceneSource::Contact> contacts;
  std::vector<int> first_step;  ///< [contacts] the step at full indentation
  std::vector<SharedLaunch<Real>> launches;

  /// The launch that a contact goes to; a new one where the last of its kind is full.
  SharedLaunch<Real>& launch_for(std::size_t sensor, ContactKind kind, int steps) {
    for (auto launch = launches.rbegin(); launch != launches.rend(); ++launch) {
      if (launch->sensor != sensor || launch->kind != kind) continue;
      if ((launch->scenes.size() + 1) * std::max(steps, launch->steps) <= most_lane_steps) return *launch;
      break;
    }
    launches.push_back({.sensor = sensor, .kind = kind});
    return launches.back();
  }
};

}  // namespace

struct SetSimulator::State {
  State(Executor& executor, const SceneSource& source, const SetOptions& options)
      : executor(executor), source(source), options(options), sensors(distinct_sensors(source)) {
    GapSweepOptions sweep;
    sweep.tolerance = options.tolerance;
    sweep.base_forces = false;
    sweep.base_sums = true;
    sweep.nodes = false;
    condense_side_by_side(sensors, executor.threads());
    for (const fem::Sensor& sensor : sensors) {
      if (options.precision == Precision::fp32)
        sweeps32.emplace_back(executor, sensor, sweep);
      else
        sweeps64.emplace_back(executor, sensor, sweep);
    }
    if (source.transducer().present())
      chain.emplace(executor, source.transducer(), source.seed(), 2 * source.tactels());
  }

  template <class Real>
  const std::vector<GapSweep<Real>>& sweeps() const {
    if constexpr (sizeof(Real) == 4)
      return sweeps32;
    else
      return sweeps64;
  }

  template <class Real>
  std::unique_ptr<Range> prepare(std::uint64_t first, std::uint64_t count) const;
  template <class Real>
  void run(RangeOf<Real>& range, const RunOptions& options) const;
  template <class Real>
  ContactSet collect(RangeOf<Real>& range);
  template <class Real>
  void measure(ContactSet& set, const std::vector<std::size_t>& rows, const SharedLaunch<Real>& launch,
               const View<Real>& view, const Fallen& fallen, std::uint64_t first);

  Executor& executor;
  const SceneSource& source;
  SetOptions options;
  std::vector<fem::Sensor> sensors;        ///< distinct ones
  std::vector<GapSweep<float>> sweeps32;   ///< [sensors] or empty
  std::vector<GapSweep<double>> sweeps64;  ///< [sensors] or empty
  std::optional<TransducerChain> chain;    ///< where there is more than bare stresses; used by collect alone
};

template <class Real>
std::unique_ptr<SetSimulator::Range> SetSimulator::State::prepare(std::uint64_t first, std::uint64_t count) const {
  auto range = std::make_unique<RangeOf<Real>>();
  range->first = first, range->count = count;
  for (std::uint64_t k = 0; k < count; ++k) {
    range->contacts.push_back(source.contact(first + k));
    const fem::Scene& scene = range->contacts.back().scene;
    const fem::LoadPath path = fem::load_path(scene.load);
    const int steps = static_cast<int>(path.steps.size());
    range->first_step.push_back(path.indentation_steps - 1);
    const auto sensor = std::ranges::find(sensors, without_young(scene.sensor)) - sensors.begin();
    SharedLaunch<Real>& launch = range->launch_for(static_cast<std::size_t>(sensor), kind_of(scene), steps);
    launch.steps = std::max(launch.steps, steps);
    launch.scenes.push_back(scene);
    launch.which.push_back(k);
  }
  for (SharedLaunch<Real>& launch : range->launches) {
    launch.batch = sweeps<Real>()[launch.sensor].prepare(launch.scenes);
    range->steps += launch.batch->steps_in_all();
  }
  return range;
}

template <class Real>
void SetSimulator::State::run(RangeOf<Real>& range, const RunOptions& run_options) const {
  for (SharedLaunch<Real>& launch : range.launches) {
    launch.batch->run(run_options);
    range.kernel_seconds += launch.batch->seconds();
  }
}

/// Readings in place of stresses, in the rows of a launch's contacts. They depend on all load steps up to them, so
/// these go through the chain, rows or not.
template <class Real>
void SetSimulator::State::measure(ContactSet& set, const std::vector<std::size_t>& rows,
                                  const SharedLaunch<Real>& launch, const View<Real>& view, const Fallen& fallen,
                                  std::uint64_t first) {
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
        view.tactels(i, static_cast<int>(step), std::span(at, inputs));
      else
        put_stress(solution->second.steps[step], std::span(at, inputs));
    }
  }
  chain->run(contacts, signal);
  auto reading = signal.begin();
  for (std::size_t c = 0; c < contacts.size(); reading += contacts[c++].steps * inputs) {
    const std::uint64_t k = launch.which[view.by_lane()[c]];
    for (std::size_t row = rows[k]; row < rows[k + 1]; ++row)
      std::copy_n(reading + set.step[row] * inputs, inputs, set.frames.begin() + row * inputs);
  }
}

template <class Real>
ContactSet SetSimulator::State::collect(RangeOf<Real>& range) {
  std::deque<View<Real>> views;                       // they cannot be moved
  std::vector<std::size_t> rows(range.count + 1, 0);  // of contact k: rows[k] ... rows[k + 1] - 1
  Fallen fallen;
  for (const SharedLaunch<Real>& launch : range.launches) {
    const View<Real>& view = views.emplace_back(*launch.batch);
    for (const std::size_t i : view.by_lane()) {
      const std::uint64_t k = launch.which[i];
      if (solved<Real>(view, i)) {
        rows[k + 1] = rows_of<Real>(view, i, range.first_step[k], launch.scenes[i].friction).size();
      } else {
        auto again = solve_gap_sweep(executor, std::span(&launch.scenes[i], 1), options.precision,
                                     {.tolerance = options.tolerance, .audit = false});
        rows[k + 1] = rows_of(again[0], range.first_step[k]).size();
        fallen[k] = std::move(again[0]);
      }
    }
  }
  ContactSet set;
  set.contacts = range.count;
  set.without_rows = static_cast<std::uint64_t>(std::count(rows.begin() + 1, rows.end(), std::size_t{0}));
  std::partial_sum(rows.begin(), rows.end(), rows.begin());
  set.inputs = 2 * source.tactels();
  resize(set, rows.back());
  for (std::size_t l = 0; l < views.size(); ++l) {
    for (const std::size_t i : views[l].by_lane()) {
      const std::uint64_t k = range.launches[l].which[i];
      if (fallen.contains(k)) continue;
      const fem::Scene& scene = range.contacts[k].scene;
      put_rows<Real>(set, rows[k], views[l], i, range.first_step[k], range.contacts[k], range.first + k);
      set.too_deep += too_deep(scene.sensor, deepest<Real>(views[l], i));
      set.far_slip += slides_far<Real>(scene, views[l], i);
      set.never_slid += rows[k] < rows[k + 1] && never_slid<Real>(scene, views[l], i);
    }
  }
  for (const auto& [k, solution] : fallen) {
    const fem::Scene& scene = range.contacts[k].scene;
    put_rows(set, rows[k], solution, range.first_step[k], range.contacts[k], range.first + k);
    set.fell_back += solution.fell_back;
    set.too_deep += too_deep(scene.sensor, deepest(solution));
    set.far_slip += slides_far(scene, solution);
    set.never_slid += rows[k] < rows[k + 1] && never_slid(scene, solution);
    set.unsolved += std::ranges::any_of(solution.steps, [](const auto& step) { return !step.converged; });
  }
  for (std::size_t l = 0; chain && l < views.size(); ++l)
    measure<Real>(set, rows, range.launches[l], views[l], fallen, range.first);
  return set;
}

SetSimulator::SetSimulator(Executor& executor, const SceneSource& source, const SetOptions& options)
    : state_(std::make_unique<State>(executor, source, options)) {}

SetSimulator::~SetSimulator() = default;

std::unique_ptr<SetSimulator::Range> SetSimulator::prepare(std::uint64_t first, std::uint64_t count) const {
  return state_->options.precision == Precision::fp32 ? state_->prepare<float>(first, count)
                                                      : state_->prepare<double>(first, count);
}

void SetSimulator::run(Range& range, const RunOptions& options) const {
  if (state_->options.precision == Precision::fp32)
    state_->run(static_cast<RangeOf<float>&>(range), options);
  else
    state_->run(static_cast<RangeOf<double>&>(range), options);
}

ContactSet SetSimulator::collect(Range& range) const {
  ContactSet set = state_->options.precision == Precision::fp32 ? state_->collect(static_cast<RangeOf<float>&>(range))
                                                                : state_->collect(static_cast<RangeOf<double>&>(range));
  set.indenter_names = state_->source.kind_names();
  set.transducer = nn::description(state_->source.transducer());
  set.device = state_->executor.device().info().name;
  set.seed = state_->source.seed();
  return set;
}

ContactSet SetSimulator::simulate(std::uint64_t first, std::uint64_t count) const {
  const auto range = prepare(first, count);
  run(*range);
  return collect(*range);
}

}  // namespace tactel::host
