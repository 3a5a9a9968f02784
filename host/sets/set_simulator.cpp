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
  double friction = 0;
  int first_step = 0;  ///< the first that may be a row
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

/// What the load steps of a contact say together.
struct Survey {
  std::size_t rows = 0;      ///< steps that become rows
  double deepest = 0;        ///< mm
  bool slides_far = false;   ///< further over the rubber than displacements are small
  bool ran_through = false;  ///< all steps, and did not slide in the last: a drag until sliding then never slid
};

double deepest(const fem::ContactSolution& solution) {
  double most = 0;  // mm
  for (const fem::ContactStep& step : solution.steps) most = std::max(most, step.indentation);
  return most;
}

/// Whether the indenter slides further over the rubber than displacements are small.
bool slides_far(const fem::Scene& scene, const fem::ContactSolution& solution) {
  const bool patch = solution.surface_width.size() > 0;
  const double element = patch ? solution.surface_width[0] : scene.sensor.length / (scene.sensor.columns - 1);
  return std::ranges::any_of(solution.steps, [&](const fem::ContactStep& step) {
    const auto touches = [](fem::GapStatus status) { return status != fem::GapStatus::open; };
    const auto touching = static_cast<double>(std::ranges::count_if(step.status, touches));
    return step.slip_distance > slip_limit(scene.sensor, element * touching);
  });
}

Survey survey(const LaneAnswer& answer, const Contact& contact) {
  const double element = answer.element();
  Survey found;
  for (int k = 0; k < answer.steps; ++k) {
    const auto result = [&](int row) { return answer.result(k, row); };
    const int status = static_cast<int>(result(LANE_STATUS));
    if (status == LANE_NOT_RUN) break;
    found.deepest = std::max(found.deepest, result(LANE_INDENTATION));
    found.slides_far =
        found.slides_far || result(LANE_SLIP_DISTANCE) >
                                slip_limit(contact.sensor, element * (result(LANE_STICKING) + result(LANE_SLIPPING)));
    found.rows += k >= contact.first_step && slip_index(contact.friction, result(LANE_P), 0);
    found.ran_through = k == answer.steps - 1 && status != LANE_SLIDING;
  }
  return found;
}

/// A contact of the sweeps whose rows go into a set.
struct RowsFrom {
  const Contact* contact = nullptr;
  std::size_t at = 0;  ///< its next row
  LaneAnswer answer;
};

/// Lanes whose numbers lie side by side in memory are read together, step by step.
void put_rows(ContactSet& set, std::span<RowsFrom> contacts) {
  int steps = 0;
  for (const auto& rows : contacts) steps = std::max(steps, rows.answer.steps);
  for (int k = 0; k < steps; ++k)
    for (RowsFrom& rows : contacts) {
      const Contact& contact = *rows.contact;
      if (k < contact.first_step || k >= rows.answer.steps) continue;
      const auto result = [&](int row) { return rows.answer.result(k, row); };
      const int status = static_cast<int>(result(LANE_STATUS));
      if (status == LANE_NOT_RUN) continue;
      const auto S = slip_index(contact.friction, result(LANE_P), result(LANE_SLIP_INDEX));
      if (!S) continue;
      const Row row{.slip_index = *S,
                    .P = result(LANE_P),
                    .Q = result(LANE_Q),
                    .indentation = result(LANE_INDENTATION),
                    .tangential = result(LANE_TANGENTIAL),
                    .residual = std::max({result(LANE_PENETRATION), result(LANE_CONE), result(LANE_COMPLEMENTARITY),
                                          result(LANE_DRIFT), result(LANE_BALANCE)}),
                    .sticking = static_cast<int>(result(LANE_STICKING)),
                    .slipping = static_cast<int>(result(LANE_SLIPPING)),
                    .status = status};
      rows.answer.tactels(k, put_row(set, rows.at++, row, contact, k));
    }
}

/// Contacts that are solved again, by their place in the range.
struct FallenContact {
  fem::Scene scene;
  fem::ContactSolution solution;
};
using Fallen = std::map<std::uint64_t, FallenContact>;

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
    stream.keep(source.sensors());
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
        put_stress(solution->second.solution.steps[step], frame);
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
        return fallen[k].scene = state.source.contact(chunk.contacts[k].number).scene;
      },
      [&](std::size_t k, const LaneAnswer& answer) {
        const Contact& contact = chunk.contacts[k];
        const Survey found = survey(answer, contact);
        rows[k + 1] = found.rows;
        set.too_deep += too_deep(contact.sensor, found.deepest);
        set.far_slip += found.slides_far;
        set.never_slid += found.rows > 0 && contact.until_sliding && found.ran_through;
      },
      [&](std::size_t k, fem::ContactSolution&& solution) {
        rows[k + 1] = rows_of(solution, chunk.contacts[k].first_step).size();
        fallen[k].solution = std::move(solution);
      });
  if (begin_again) range.seconds.solve_again = seconds_since(*begin_again);
  set.contacts = chunk.count;
  set.without_rows = static_cast<std::uint64_t>(std::count(rows.begin() + 1, rows.end(), std::size_t{0}));
  std::partial_sum(rows.begin(), rows.end(), rows.begin());
  resize(set, rows.back());
  std::vector<RowsFrom> together;
  const auto put = [&] {
    put_rows(set, together);
    together.clear();
  };
  chunk.part.each(true, [&](std::size_t k, const LaneAnswer& answer) {
    if (rows[k] == rows[k + 1] || fallen.contains(k)) return;
    together.push_back({&chunk.contacts[k], rows[k], answer});
    if (together.size() == std::min(answer.stride, side_by_side_answers)) put();
  });
  put();
  for (const auto& [k, contact] : fallen) {
    const fem::Scene& scene = contact.scene;
    const fem::ContactSolution& solution = contact.solution;
    put_rows(set, rows[k], solution, chunk.contacts[k]);
    set.fell_back += solution.fell_back;
    set.too_deep += too_deep(scene.sensor, deepest(solution));
    set.far_slip += slides_far(scene, solution);
    set.never_slid += rows[k] < rows[k + 1] && never_slid(scene, solution);
    set.unsolved += std::ranges::any_of(solution.steps, [](const auto& step) { return !step.converged; });
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
