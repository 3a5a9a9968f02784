// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_simulator.h"

#include <array>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>

#include "fem/contact_laws.h"
#include "host/contact/contact_stream.h"
#include "host/contact/sensor_tables.h"
#include "host/contact/solve.h"
#include "host/sets/transducer_chain.h"
#include "host/support/errors.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;

/// One load step of a contact.
struct Row {
  std::optional<double> slip_index{};  ///< none: the step is no row
  double P = 0, Q = 0, indentation = 0, tangential = 0, slip_distance = 0, residual = 0;
  int sticking = 0, slipping = 0, status = LANE_SOLVED;
};

/// The steps of an answer in place.
struct StepsOfLane {
  int count() const { return answer.steps; }
  double element() const { return answer.element(); }
  Row row(int k) const {
    const auto result = [&](int row) { return answer.result(k, row); };
    return {.slip_index = slip_index(friction, result(LANE_P), result(LANE_SLIP_INDEX)),
            .P = result(LANE_P),
            .Q = result(LANE_Q),
            .indentation = result(LANE_INDENTATION),
            .tangential = result(LANE_TANGENTIAL),
            .slip_distance = result(LANE_SLIP_DISTANCE),
            .residual = std::max({result(LANE_PENETRATION), result(LANE_CONE), result(LANE_COMPLEMENTARITY),
                                  result(LANE_DRIFT), result(LANE_BALANCE)}),
            .sticking = static_cast<int>(result(LANE_STICKING)),
            .slipping = static_cast<int>(result(LANE_SLIPPING)),
            .status = static_cast<int>(result(LANE_STATUS))};
  }
  void stress(int k, std::span<float> frame) const { answer.tactels(k, frame); }
  bool slid() const { return static_cast<int>(answer.result(answer.steps - 1, LANE_STATUS)) >= LANE_SLIDING; }

  LaneAnswer answer;
  double friction = 0;
};

/// The steps of a contact that was solved again.
struct StepsOfSolution {
  int count() const { return static_cast<int>(solution.steps.size()); }
  double element() const {
    return solution.surface_width.size() > 0 ? solution.surface_width[0] : sensor.length / (sensor.columns - 1);
  }
  Row row(int k) const {
    const fem::ContactStep& step = solution.steps[static_cast<std::size_t>(k)];
    const auto touching = [&](fem::GapStatus status) {
      return static_cast<int>(std::ranges::count(step.status, status));
    };
    const int sticking = touching(fem::GapStatus::stick);
    return {.slip_index = step.slip_index,
            .P = step.P,
            .Q = step.Q,
            .indentation = step.indentation,
            .tangential = step.tangential,
            .slip_distance = step.slip_distance,
            .residual = fem::largest(step.residual),
            .sticking = sticking,
            .slipping = touching(fem::GapStatus::slip),
            .status = !step.converged ? LANE_UNSOLVED
                      : sticking      ? LANE_SOLVED
                                      : LANE_SLIDING};
  }
  void stress(int k, std::span<float> frame) const {
    const fem::ContactStep& step = solution.steps[static_cast<std::size_t>(k)];
    std::ranges::copy(step.sigma_y.cast<float>(), frame.begin());
    std::ranges::copy(step.tau_xy.cast<float>(), frame.begin() + step.sigma_y.size());
  }
  bool slid() const { return solution.sliding; }

  const fem::ContactSolution& solution;
  const fem::Sensor& sensor;
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
  double friction = 0;
  int first_step = 0;  ///< the first that may be a row
  std::uint16_t kind = 0;
  bool until_sliding = false;
};

/// Puts a step into row `at`.
template <class Steps>
void put_row(ContactSet& set, std::size_t at, const Steps& steps, const Row& row, const Contact& of, int step) {
  const int touching = row.sticking + row.slipping;
  set.slip_index[at] = static_cast<float>(std::clamp(*row.slip_index, -1.0, 1.0));  // rounding apart, Q <= mu P
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
  steps.stress(step, std::span(set.frames).subspan(at * set.inputs, set.inputs));
}

/// Whether a step of a contact becomes a row.
bool is_row(const Row& row, const Contact& of, int step) {
  return step >= of.first_step && row.status != LANE_NOT_RUN && row.slip_index;
}

/// Adds what the steps of a contact say together to the counts of a set. Returns how many of them become rows.
template <class Steps>
std::size_t survey(ContactSet& set, const Steps& steps, const Contact& of) {
  const double element = steps.element();
  std::size_t rows = 0;
  double deepest = 0;  // mm
  bool far = false;    // the indenter slides further over the rubber than displacements are small
  for (int k = 0; k < steps.count(); ++k) {
    const Row row = steps.row(k);
    if (row.status == LANE_NOT_RUN) break;
    deepest = std::max(deepest, row.indentation);
    far = far || row.slip_distance > slip_limit(of.sensor, element * (row.sticking + row.slipping));
    rows += is_row(row, of, k);
  }
  set.too_deep += too_deep(of.sensor, deepest);
  set.far_slip += far;
  set.never_slid += rows > 0 && of.until_sliding && !steps.slid();
  return rows;
}

/// Contacts whose rows go into a set, the next of each into row `at`.
template <class Steps>
struct RowsFrom {
  const Contact* contact = nullptr;
  std::size_t at = 0;
  Steps steps;
};

/// Lanes whose numbers lie side by side in memory are read together, step by step.
template <class Steps>
void put_rows(ContactSet& set, std::span<RowsFrom<Steps>> contacts) {
  int most = 0;
  for (const auto& from : contacts) most = std::max(most, from.steps.count());
  for (int k = 0; k < most; ++k)
    for (auto& from : contacts) {
      if (k < from.contact->first_step || k >= from.steps.count()) continue;
      const Row row = from.steps.row(k);
      if (is_row(row, *from.contact, k)) put_row(set, from.at++, from.steps, row, *from.contact, k);
    }
}

/// Contacts that are solved again, by their place in the range.
using Fallen = std::map<std::uint64_t, fem::ContactSolution>;

struct Chunk : SetSimulator::Range {
  std::vector<Contact> contacts;
  std::vector<float> parameters;  ///< [contacts][columns]
  ContactStream::Part part;
};

/// Numbers of a cache line, which a processor reads together.
constexpr std::size_t side_by_side_answers = 16;

ContactModel model_for(Executor& executor, const SceneSource& source, const SetOptions& options) {
  if (!options.patch && source.model() != fem::SurfaceModel::patch) {
    if (source.own_sensors())
      throw ConfigError("", "[sweep] sensors", "(missing)", "a number of sensors to draw, for contacts on a mesh");
    return {MeshModel{{.tolerance = options.tolerance, .accept = options.accept, .audit = false}}, options.precision};
  }
  Rung rung = options.patch.value_or(usual_patch());
  rung.precision = options.precision;
  if (options.tolerance > 0) rung.tolerance = options.tolerance;
  if (options.accept > 0) rung.accept_at_most(options.accept);
  ContactModel model = model_of(rung);
  PatchModel& patch = std::get<PatchModel>(model.surface);
  patch.mesh.force_error = false;
  if (source.own_sensors())
    patch.family =
        std::make_shared<const fem::SensorFamily>(sensor_family(executor, *source.own_sensors(), rung.sides));
  return model;
}

}  // namespace

struct SetSimulator::State {
  State(Executor& executor, const SceneSource& source, const SetOptions& options)
      : executor(executor),
        source(source),
        parameters(source.parameters()),
        columns(columns_of(source)),
        stream(executor, model_for(executor, source, options)) {
    if (!source.own_sensors()) stream.keep(source.sensors());  // of others the family has the tables
    if (source.transducer().present())
      chain.emplace(executor, source.transducer(), source.seed(), 2 * source.tactels());
  }
  void measure(ContactSet& set, const std::vector<std::size_t>& rows, const Chunk& chunk, const Fallen& fallen);

  Executor& executor;
  const SceneSource& source;
  ContactParameters parameters;
  SetColumns columns;
  ContactStream stream;
  std::optional<TransducerChain> chain;  ///< where there is more than bare stresses; used by collect alone
  std::mutex chain_turn;
};

/// Readings in place of stresses, in the rows of a chunk. They depend on all load steps up to them, so these go through
/// the chain, rows or not.
void SetSimulator::State::measure(ContactSet& set, const std::vector<std::size_t>& rows, const Chunk& chunk,
                                  const Fallen& fallen) {
  const std::size_t inputs = set.inputs;
  std::vector<TransducerChain::Contact> contacts;
  std::vector<float> signal;
  chunk.part.each(true, [&](std::size_t k, const LaneAnswer& answer) {
    contacts.push_back({chunk.first + k, rows[k] == rows[k + 1] ? 0 : set.step[rows[k + 1] - 1] + 1});
    const auto solution = fallen.find(k);
    for (std::uint32_t step = 0; step < contacts.back().steps; ++step) {
      signal.resize(signal.size() + inputs);
      const auto frame = std::span(signal).last(inputs);
      if (solution == fallen.end())
        answer.tactels(static_cast<int>(step), frame);
      else
        StepsOfSolution{solution->second, chunk.contacts[k].sensor}.stress(static_cast<int>(step), frame);
    }
  });
  {
    const std::lock_guard turn(chain_turn);
    chain->run(contacts, signal);
  }
  auto reading = signal.begin();
  for (const TransducerChain::Contact& contact : contacts) {
    const std::uint64_t k = contact.number - chunk.first;
    for (std::size_t row = rows[k]; row < rows[k + 1]; ++row)
      std::copy_n(reading + set.step[row] * inputs, inputs, set.frames.begin() + row * inputs);
    reading += contact.steps * inputs;
  }
}

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
    : state_(std::make_unique<State>(executor, source, options)) {}

SetSimulator::~SetSimulator() = default;

std::unique_ptr<SetSimulator::Range> SetSimulator::prepare(std::uint64_t first, std::uint64_t count) const {
  const State& state = *state_;
  auto chunk = std::make_unique<Chunk>();
  chunk->first = first, chunk->count = count;
  const std::size_t numbers = state.parameters.columns().size();
  chunk->contacts.reserve(count);
  chunk->parameters.resize(count * numbers);
  const auto start = Clock::now();
  for (std::uint64_t k = 0; k < count; ++k) {
    const auto [scene, indenter] = state.source.contact(first + k);
    const fem::LoadPath path = fem::load_path(scene.load);
    state.parameters.put(scene, indenter, std::span(chunk->parameters).subspan(k * numbers, numbers));
    chunk->contacts.push_back({.number = first + k,
                               .sensor = scene.sensor,
                               .friction = scene.friction,
                               .first_step = state.source.press_rows() ? 0 : path.indentation_steps - 1,
                               .kind = indenter,
                               .until_sliding = path.until_sliding});
    state.stream.add(chunk->part, scene, path);
  }
  chunk->seconds.draw = seconds_since(start);
  chunk->part.lay_out();
  chunk->steps = chunk->part.steps();
  chunk->seconds.lay_out = seconds_since(start) - chunk->seconds.draw;
  return chunk;
}

void SetSimulator::run(Range& range, const RunOptions& options) const {
  const auto start = Clock::now();
  ContactStream::Part& part = static_cast<Chunk&>(range).part;
  part.run(options);
  range.kernel_seconds += part.seconds();
  range.seconds.solve = seconds_since(start);
}

ContactSet SetSimulator::collect(Range& range) const {
  State& state = *state_;
  auto& chunk = static_cast<Chunk&>(range);
  const auto start = Clock::now();
  ContactSet set(state.columns);
  std::vector<std::size_t> rows(chunk.count + 1, 0);  // of contact k: rows[k] ... rows[k + 1] - 1
  Fallen fallen;
  std::optional<Clock::time_point> begin_again;
  state.stream.collect(
      chunk.part,
      [&](std::size_t k) {
        if (!begin_again) begin_again = Clock::now();
        return state.source.contact(chunk.contacts[k].number).scene;
      },
      [&](std::size_t k, const LaneAnswer& answer) {
        const Contact& contact = chunk.contacts[k];
        rows[k + 1] = survey(set, StepsOfLane{answer, contact.friction}, contact);
      },
      [&](std::size_t k, fem::ContactSolution&& solution) {
        const Contact& contact = chunk.contacts[k];
        set.fell_back += solution.fell_back;
        set.unsolved += std::ranges::any_of(solution.steps, [](const auto& step) { return !step.converged; });
        rows[k + 1] = survey(set, StepsOfSolution{solution, contact.sensor}, contact);
        fallen[k] = std::move(solution);
      });
  if (begin_again) range.seconds.solve_again = seconds_since(*begin_again);
  set.contacts = chunk.count;
  set.without_rows = static_cast<std::uint64_t>(std::count(rows.begin() + 1, rows.end(), std::size_t{0}));
  std::partial_sum(rows.begin(), rows.end(), rows.begin());
  resize(set, rows.back());
  std::vector<RowsFrom<StepsOfLane>> together;
  const auto put = [&] {
    put_rows(set, std::span(together));
    together.clear();
  };
  chunk.part.each(true, [&](std::size_t k, const LaneAnswer& answer) {
    if (rows[k] == rows[k + 1] || fallen.contains(k)) return;
    together.push_back({&chunk.contacts[k], rows[k], {answer, chunk.contacts[k].friction}});
    if (together.size() == std::min(answer.stride, side_by_side_answers)) put();
  });
  put();
  for (const auto& [k, solution] : fallen) {
    RowsFrom<StepsOfSolution> one{&chunk.contacts[k], rows[k], {solution, chunk.contacts[k].sensor}};
    put_rows(set, std::span(&one, 1));
  }
  set.contact_parameters = std::move(chunk.parameters);
  if (state.chain) state.measure(set, rows, chunk, fallen);
  chunk.part = {};  // its memory, before the rows are written
  set.indenter_names = state.source.kind_names();
  set.transducer = nn::description(state.source.transducer());
  set.device = state.executor.device().info().name;
  set.seed = state.source.seed();
  set.press_rows = state.source.press_rows();
  range.seconds.gather = seconds_since(start) - range.seconds.solve_again;
  return set;
}

ContactSet SetSimulator::simulate(std::uint64_t first, std::uint64_t count) const {
  const auto range = prepare(first, count);
  run(*range);
  return collect(*range);
}

}  // namespace tactel::host
