// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_simulator.h"

#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>

#include "fem/angles.h"
#include "fem/contact_laws.h"
#include "fem/pad/pad_layers.h"
#include "host/contact/contact_stream.h"
#include "host/contact/limits.h"
#include "host/contact/pad_stream.h"
#include "host/contact/sensor_tables.h"
#include "host/sets/hold_simulator.h"
#include "host/sets/transducer_chain.h"
#include "host/support/errors.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;

/// One load step of a contact.
struct Row {
  std::optional<double> slip_index{};  ///< none: the step is no row
  double P = 0, indentation = 0, slip_distance = 0, residual = 0;
  std::array<double, 2> Q{}, tangential{};        ///< of lines the first alone
  double torque = 0, twist = 0, force_ratio = 0;  ///< of pads; degrees
  double slid = 0, slip_path = 0;                 ///< mm, of pads: as fem::PadStep
  double area = 0;                                ///< of pads: mm^2 of the cells that touch
  fem::PadBox reach{fem::nowhere, fem::nowhere};  ///< of pads: around these, from the indenter's axis
  int across = 0;                                 ///< elements or cells over which they extend, along the shorter side
  int sticking = 0, slipping = 0, status = LANE_SOLVED;
};

/// A contact but for its shape and path, which its launch has.
template <class Contacts>
struct Contact {
  static constexpr bool of_lines = std::is_same_v<Contacts, LineContacts>;
  struct NoPath {};

  std::uint64_t number = 0;  ///< in the sweep
  typename Contacts::Sensor sensor;
  double friction = 0;
  int first_step = 0;  ///< the first that may be a row
  int presses = 0;     ///< of pads: steps that press on from first touch (fem/pad/pad_presses.h)
  int least = 0;       ///< elements or cells over which a step must extend: else its row is marked; known by survey
  std::uint16_t kind = 0;
  bool until_sliding = false;
  [[no_unique_address]] std::conditional_t<of_lines, NoPath, PadPath> path{};  ///< of pads: results do not hold it
  std::array<double, 2> position{};                                            ///< of pads, mm
  int outside = 0;                                                             ///< of pads: sum of PadOutside
};
using LineContact = Contact<LineContacts>;
using PadContactOf = Contact<PadContacts>;

/// Elements that touch, or cells over which the contact extends along its shorter side.
int across_of(const LaneAnswer& answer, const LineContact&, int k) {
  return static_cast<int>(answer.result(k, RESULT_STICKING) + answer.result(k, RESULT_SLIPPING));
}
int across_of(const LaneAnswer& answer, const PadContactOf&, int k) {
  return static_cast<int>(answer.result(k, PAD_RESULT_ACROSS));
}

/// What is read of the answer of a kernel.
template <class Contacts>
[[gnu::always_inline]] inline Row row_of(const LaneAnswer& answer, const Contact<Contacts>& contact, int k) {
  const auto result = [&](int row) { return answer.result(k, row); };
  Row row{.slip_index = slip_index(contact.friction, result(RESULT_P), result(RESULT_S)),
          .P = result(RESULT_P),
          .indentation = result(RESULT_DEPTH),
          .slip_distance = result(RESULT_SLIP_DISTANCE),
          .residual = std::max({result(RESULT_PENETRATION), result(RESULT_COMPLEMENTARITY), result(RESULT_CONE),
                                result(RESULT_DRIFT), result(RESULT_OWN_RESIDUAL)}),
          .across = across_of(answer, contact, k),
          .sticking = static_cast<int>(result(RESULT_STICKING)),
          .slipping = static_cast<int>(result(RESULT_SLIPPING)),
          .status = static_cast<int>(result(RESULT_STATUS))};
  if constexpr (Contact<Contacts>::of_lines) {
    row.Q[0] = result(LANE_Q), row.tangential[0] = result(LANE_TANGENTIAL);
  } else {
    const fem::PadTarget& at = contact.path.steps[static_cast<std::size_t>(k)];
    row.Q = {result(PAD_RESULT_QX), result(PAD_RESULT_QY)}, row.tangential = {at.x, at.y};
    row.torque = result(PAD_RESULT_M), row.twist = fem::degrees(at.twist), row.area = result(PAD_RESULT_AREA);
    row.slid = result(PAD_RESULT_SLID), row.slip_path = result(PAD_RESULT_SLIP_PATH);
    row.reach = {{result(PAD_RESULT_LEFT), result(PAD_RESULT_RIGHT)},
                 {result(PAD_RESULT_BELOW), result(PAD_RESULT_ABOVE)}};
    if (row.slip_index) row.force_ratio = std::hypot(row.Q[0], row.Q[1]) / (contact.friction * row.P);
  }
  return row;
}

/// The same of a contact that was solved again. Both kinds of steps count statuses of nodes or cells alike.
template <class Step>
Row row_common(const Step& step) {
  const auto touching = [&](fem::GapStatus status) {
    return static_cast<int>(std::ranges::count(step.status, status));
  };
  const int sticking = touching(fem::GapStatus::stick);
  return {.slip_index = step.slip_index,
          .P = step.P,
          .indentation = step.indentation,
          .slip_distance = step.slip_distance,
          .sticking = sticking,
          .slipping = touching(fem::GapStatus::slip),
          .status = !step.converged ? LANE_UNSOLVED
                    : sticking      ? LANE_SOLVED
                                    : LANE_SLIDING};
}
Row row_of(const fem::ContactStep& step) {
  Row row = row_common(step);
  row.Q = {step.Q}, row.tangential = {step.tangential}, row.residual = fem::largest(step.residual);
  row.across = row.sticking + row.slipping;
  return row;
}
Row row_of(const fem::PadStep& step) {
  Row row = row_common(step);
  row.Q = {step.Q[0], step.Q[1]}, row.tangential = {step.x, step.y}, row.residual = step.residual.largest();
  row.torque = step.M, row.twist = fem::degrees(step.twist), row.force_ratio = step.force_ratio.value_or(0);
  row.area = step.area, row.reach = step.reach, row.across = step.across, row.slid = step.slid,
  row.slip_path = step.slip_path;
  return row;
}
void put_stress(const fem::ContactStep& step, std::span<float> frame) {
  std::ranges::copy(step.sigma_y.cast<float>(), frame.begin());
  std::ranges::copy(step.tau_xy.cast<float>(), frame.begin() + step.sigma_y.size());
}
void put_stress(const fem::PadStep& step, std::span<float> frame) {  // [tactels, 3] by columns
  std::transform(step.stress.data(), step.stress.data() + frame.size(), frame.begin(),
                 [](double stress) { return static_cast<float>(stress); });
}

/// Contacts that have steps that were solved alone, by their place in the range.
template <class Contacts>
using Alone = std::map<std::uint64_t, typename StreamOf<Contacts>::Alone>;

/// Elements or cells a side of an answer. 0: of a mesh, which is not laid for a contact.
int along_side(const fem::ContactSolution& solution) { return static_cast<int>(solution.surface_width.size()); }
int along_side(const fem::PadSolution& solution) { return solution.cells.n; }

/// Returns over how many elements or cells, of so many, a step must extend. across(k): of a pad's step k.
template <bool of_lines, class Across>
int least_across_of(int along_side, int steps, const Across& across) {
  if (along_side == 0) return 0;
  if constexpr (of_lines) {
    return fem::least_elements;
  } else {
    int widest = 0;
    for (int k = 0; k < steps; ++k) widest = std::max(widest, across(k));
    return fem::least_across(along_side, widest);
  }
}

/// Marks a row whose contact extends over few elements or cells.
void mark(Row& row, int least) {
  const bool solved = row.status == LANE_SOLVED || row.status == LANE_SLIDING;
  if (solved && row.across < least) row.status = coarse_row;
}

/// The steps of an answer in place, but for those that were solved alone.
template <class Contacts>
struct StepsOfLane {
  int count() const { return answer.steps; }
  double element() const {
    if constexpr (Contact<Contacts>::of_lines) return answer.element();
    return answer.result(0, PAD_RESULT_CELL);
  }
  [[gnu::always_inline]] Row row(int k) const {  // a row in memory, written by number and copied by vector, stalls
    const auto* const exact = solved_alone(k);
    Row row = exact ? row_of(exact->steps.back()) : row_of(answer, *contact, k);
    if (!exact) mark(row, contact->least);
    return row;
  }
  int least() const {
    return least_across_of<Contact<Contacts>::of_lines>(along_side, answer.steps,
                                                        [&](int k) { return across_of(answer, *contact, k); });
  }
  void stress(int k, std::span<float> frame) const {
    if (const auto* exact = solved_alone(k))
      put_stress(exact->steps.back(), frame);
    else
      answer.tactels(k, frame);
  }
  const typename Contacts::Solution* solved_alone(int k) const {  ///< none: the step is the answer's; of lines all are
    if constexpr (!Contact<Contacts>::of_lines)
      if (alone)
        if (const auto exact = alone->find(static_cast<std::size_t>(k)); exact != alone->end()) return &exact->second;
    return nullptr;
  }
  bool slid() const { return static_cast<int>(answer.result(answer.steps - 1, RESULT_STATUS)) >= LANE_SLIDING; }
  void fetch(int k, std::size_t part, std::size_t parts) const { answer.fetch_step(k, part, parts); }

  LaneAnswer answer;
  const Contact<Contacts>* contact;
  const typename StreamOf<Contacts>::Alone* alone;  ///< none: no step was
  int along_side;
};

/// The steps of a contact that was solved again.
template <class Contacts>
struct StepsOfSolution {
  int count() const { return static_cast<int>(solution.steps.size()); }
  double element() const {
    if constexpr (Contact<Contacts>::of_lines)
      return solution.surface_width.size() > 0 ? solution.surface_width[0]
                                               : contact->sensor.length / (contact->sensor.columns - 1);
    else
      return std::max(solution.cells.hx, solution.cells.hy);
  }
  Row row(int k) const {
    Row row = row_of(solution.steps[static_cast<std::size_t>(k)]);
    mark(row, contact->least);
    return row;
  }
  int least() const {
    return least_across_of<Contact<Contacts>::of_lines>(along_side(solution), count(), [&](int k) {
      return row_of(solution.steps[static_cast<std::size_t>(k)]).across;
    });
  }
  void stress(int k, std::span<float> frame) const { put_stress(solution.steps[static_cast<std::size_t>(k)], frame); }
  bool slid() const { return solution.sliding; }
  void fetch(int, std::size_t, std::size_t) const {}  ///< it is one

  const typename Contacts::Solution& solution;
  const Contact<Contacts>* contact;
};

void resize(ContactSet& set, std::size_t rows) {
  each_dataset(set, [rows](const char*, auto& values, int columns, const char*) {
    values.resize(rows * static_cast<std::size_t>(std::max(columns, 1)));
  });
}

void put_sensor(ContactSet& set, std::size_t at, const auto& sensor) {
  set.poisson[at] = static_cast<float>(sensor.poisson);
  set.thickness[at] = static_cast<float>(sensor.thickness);
  set.young[at] = static_cast<float>(sensor.young);
  if constexpr (std::is_same_v<decltype(sensor), const fem::Sensor&>)
    set.length[at] = static_cast<float>(sensor.length);
}

/// Puts a step into row `at`.
template <class Steps, class Contact>
[[gnu::always_inline]] inline void put_row(ContactSet& set, std::size_t at, const Steps& steps, const Row& row,
                                           const Contact& contact, int step) {
  const int touching = row.sticking + row.slipping;
  set.slip_index[at] = static_cast<float>(std::clamp(*row.slip_index, -1.0, 1.0));  // rounding apart, Q <= mu P
  set.normal_force[at] = static_cast<float>(row.P);
  set.indentation[at] = static_cast<float>(row.indentation);
  if constexpr (Contact::of_lines) {
    set.tangential_force[at] = static_cast<float>(row.Q[0]);
    set.tangential[at] = static_cast<float>(row.tangential[0]);
  } else {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      set.tangential_force[2 * at + axis] = static_cast<float>(row.Q[axis]);
      set.tangential[2 * at + axis] = static_cast<float>(row.tangential[axis]);
    }
    set.torque[at] = static_cast<float>(row.torque);
    set.twist[at] = static_cast<float>(row.twist);
    set.force_ratio[at] = static_cast<float>(row.force_ratio);
    set.outside[at] = static_cast<std::uint8_t>(contact.outside);
  }
  set.friction[at] = static_cast<float>(contact.friction);
  set.stick_fraction[at] = touching ? static_cast<float>(row.sticking) / static_cast<float>(touching) : 0;
  set.contact_nodes[at] = static_cast<std::uint16_t>(touching);
  set.contact[at] = contact.number;
  set.step[at] = static_cast<std::uint32_t>(step);
  set.indenter[at] = contact.kind;
  set.status[at] = static_cast<std::uint8_t>(row.status);
  set.residual[at] = static_cast<float>(row.residual);
  if (set.sensors) put_sensor(set, at, contact.sensor);
  steps.stress(step, std::span(set.frames).subspan(at * set.inputs, set.inputs));
}

/// Whether a step of a contact becomes a row.
template <class Contact>
bool is_row(const Row& row, const Contact& contact, int step) {
  return step >= contact.first_step && row.status != LANE_NOT_RUN && row.slip_index;
}

/// Adds what the steps of a contact say together to the counts of a set. Returns how many of them become rows.
template <class Steps, class Contact>
std::size_t survey(ContactSet& set, const Steps& steps, Contact& contact) {
  contact.least = steps.least();
  const double element = steps.element();  // mm
  std::size_t rows = 0;
  double deepest = 0;  // mm
  bool far = false;    // the indenter slides further over the rubber than displacements are small
  fem::PadBox reach{fem::nowhere, fem::nowhere};
  for (int k = 0; k < steps.count(); ++k) {
    const Row row = steps.row(k);
    if (row.status == LANE_NOT_RUN) break;
    deepest = std::max(deepest, row.indentation);
    if constexpr (Contact::of_lines)
      far = far || row.slip_distance > slip_limit(contact.sensor, element * (row.sticking + row.slipping));
    else
      far = far || (row.P > 0 && row.slip_distance > slip_limit(std::sqrt(row.area))), reach.cover(row.reach);
    if (is_row(row, contact, k)) ++rows, set.coarse += row.status == coarse_row;
  }
  set.too_deep += too_deep(contact.sensor.thickness, deepest);
  set.far_slip += far;
  if constexpr (!Contact::of_lines) {
    contact.outside = outside_model(contact.sensor, contact.position, reach, element);
    set.near_edge += (contact.outside & outside_edges) != 0;
    set.unseen += (contact.outside & outside_tactels) != 0;
    set.wide_cells += (contact.outside & outside_cells) != 0;
  }
  if constexpr (Contact::of_lines) set.never_slid += rows > 0 && contact.until_sliding && !steps.slid();
  return rows;
}

/// How far the contact on a pad, and how far its cells, have slid since first touch over its elastic limit, the shear
/// of a layer that bears mu times the mean pressure.
class Slide {
 public:
  void add(const Row& row, const PadContactOf& contact) {
    const auto& [poisson, thickness, young] =
        std::tie(contact.sensor.poisson, contact.sensor.thickness, contact.sensor.young);
    const double limit = contact.friction * row.P / row.area * thickness * 2 * (1 + poisson) / young *
                         fem::softer_in_shear(contact.sensor);
    whole_.add(row.slid, limit), cells_.add(row.slip_path, limit);
  }
  double whole() const { return whole_.over_limit; }
  double cells() const { return cells_.over_limit; }

 private:
  struct Way {
    double way = 0, over_limit = 0;  ///< mm, 1
    void add(double now, double limit) {
      if (limit > 0) over_limit += std::max(0.0, now - way) / limit;  // a step solved alone has a path of its own
      way = now;
    }
  };
  Way whole_, cells_;
};

/// Contacts whose rows go into a set, the next of each into row `at`.
template <class Steps>
struct RowsFrom {
  std::size_t at = 0;
  Steps steps;
  Slide slide{};
};

/// Lanes whose numbers lie side by side in memory are read together, step by step.
template <class Steps>
void put_rows(ContactSet& set, std::span<RowsFrom<Steps>> contacts) {
  int most = 0;
  for (const auto& from : contacts) most = std::max(most, from.steps.count());
  for (int k = 0; k < most; ++k)
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      auto& from = contacts[i];
      const auto& contact = *from.steps.contact;
      from.steps.fetch(k + 1, i, contacts.size());
      if (k >= from.steps.count()) continue;
      constexpr bool of_pads = requires { from.slide.add(Row(), contact); };
      if (!of_pads && k < contact.first_step) continue;
      const Row row = from.steps.row(k);
      if constexpr (of_pads) from.slide.add(row, contact);
      if (!is_row(row, contact, k)) continue;
      if constexpr (of_pads) set.slid[from.at] = static_cast<float>(from.slide.whole());
      if constexpr (of_pads) set.slip_path[from.at] = static_cast<float>(from.slide.cells());
      put_row(set, from.at++, from.steps, row, contact, k);
    }
}

/// Contacts that are solved again, by their place in the range.
template <class Contacts>
using Fallen = std::map<std::uint64_t, typename Contacts::Solution>;

template <class Contacts>
struct Chunk : SetSimulator::Range {
  std::vector<Contact<Contacts>> contacts;
  std::vector<float> parameters;  ///< [contacts][columns]
  typename StreamOf<Contacts>::Part part;
};

/// Lanes that are read together, at most: those of a group lie side by side.
constexpr std::size_t side_by_side_answers = 32;

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

int along_side(const SceneSource& source, const SetOptions& options) {
  if (!options.patch && source.model() != fem::SurfaceModel::patch) return 0;
  return options.patch.value_or(usual_patch()).elements;
}
int along_side(const PadSource&, const SetOptions& options) { return options.pad.cells; }

int rows_of_tactels(const fem::Sensor&) { return 1; }
int rows_of_tactels(const fem::PadSensor& sensor) { return sensor.tactels[1]; }

PadModel model_for(Executor&, const PadSource& source, const SetOptions& options) {
  PadModel model{{.cells = options.pad.cells, .pressing_increments = options.pad.increments}, options.precision};
  model.options.any_poisson = source.own_sensors() && source.own_sensors()->any_poisson;
  if (options.accept > 0) model.options.tolerance = 0, model.options.accept = options.accept;
  return model;
}

}  // namespace

namespace {

template <class Contacts>
class Simulator final : public SetSimulator::State {
  using Source = SourceOf<typename Contacts::Scene>;
  using Chunk = host::Chunk<Contacts>;
  using Fallen = host::Fallen<Contacts>;
  using Range = SetSimulator::Range;

 public:
  Simulator(Executor& executor, const Source& source, const SetOptions& options)
      : executor_(executor),
        source_(source),
        parameters_(source.parameters()),
        columns_(columns_of(source)),
        along_side_(along_side(source, options)),
        stream_(executor, model_for(executor, source, options)) {
    if (!source.own_sensors()) stream_.keep(source.sensors());  // of others the family has the tables
    if (source.transducer().present())
      chain_.emplace(executor, source.transducer(), source.seed(), source.inputs(), columns_.axes,
                     rows_of_tactels(source.sensors().front()));
  }
  std::unique_ptr<Range> prepare(std::uint64_t first, std::uint64_t count) const override;
  void run(Range& range, const RunOptions& options) const override {
    const auto start = Clock::now();
    auto& part = static_cast<Chunk&>(range).part;
    part.run(options);
    range.kernel_seconds += part.seconds();
    range.seconds.solve = seconds_since(start);
  }
  ContactSet collect(Range& range) override;

 private:
  /// The steps of contact k of a range.
  StepsOfLane<Contacts> steps_of(const LaneAnswer& answer, const Chunk& chunk, std::uint64_t k,
                                 const Alone<Contacts>& alone) const {
    const auto found = alone.find(k);
    return {answer, &chunk.contacts[k], found == alone.end() ? nullptr : &found->second, along_side_};
  }
  std::vector<std::size_t> to_solve_alone(const LaneAnswer& answer, const Contact<Contacts>& contact) const;
  void measure(ContactSet& set, const std::vector<std::size_t>& rows, const Chunk& chunk, const Fallen& fallen,
               const Alone<Contacts>& alone);

  Executor& executor_;
  const Source& source_;
  ContactParametersOf<typename Contacts::Scene> parameters_;
  SetColumns columns_;
  int along_side_;  ///< elements or cells of a contact; 0: on a mesh
  StreamOf<Contacts> stream_;
  std::optional<TransducerChain> chain_;  ///< where there is more than bare stresses; used by collect alone
  std::mutex chain_turn_;
};

/// Returns the steps of a contact on a pad that are rows, or that readings of rows depend on, and coarse, and can be
/// solved alone.
template <class Contacts>
std::vector<std::size_t> Simulator<Contacts>::to_solve_alone(const LaneAnswer& answer,
                                                             const Contact<Contacts>& contact) const {
  if constexpr (Contact<Contacts>::of_lines)
    return {};
  else {
    std::vector<std::size_t> steps =
        fem::coarse_presses(std::span(contact.path.steps), contact.presses, along_side_,
                            [&](std::size_t k) { return across_of(answer, contact, static_cast<int>(k)); });
    if (!chain_) std::erase_if(steps, [&](std::size_t k) { return static_cast<int>(k) < contact.first_step; });
    return steps;
  }
}

/// Readings in place of stresses, in the rows of a chunk. They depend on all load steps up to them, so these go through
/// the chain, rows or not.
template <class Contacts>
void Simulator<Contacts>::measure(ContactSet& set, const std::vector<std::size_t>& rows, const Chunk& chunk,
                                  const Fallen& fallen, const Alone<Contacts>& alone) {
  const std::size_t inputs = set.inputs;
  std::vector<TransducerChain::Contact> contacts;
  std::vector<float> signal;
  chunk.part.each(true, [&](std::size_t k, const LaneAnswer& answer) {
    contacts.push_back({chunk.first + k, rows[k] == rows[k + 1] ? 0 : set.step[rows[k + 1] - 1] + 1});
    const auto solution = fallen.find(k);
    const StepsOfLane<Contacts> steps = steps_of(answer, chunk, k, alone);
    for (std::uint32_t step = 0; step < contacts.back().steps; ++step) {
      signal.resize(signal.size() + inputs);
      const auto frame = std::span(signal).last(inputs);
      if (solution == fallen.end())
        steps.stress(static_cast<int>(step), frame);
      else
        put_stress(solution->second.steps[step], frame);
    }
  });
  {
    const std::lock_guard turn(chain_turn_);
    chain_->run(contacts, signal);
  }
  auto reading = signal.begin();
  for (const TransducerChain::Contact& contact : contacts) {
    const std::uint64_t k = contact.number - chunk.first;
    for (std::size_t row = rows[k]; row < rows[k + 1]; ++row)
      std::copy_n(reading + set.step[row] * inputs, inputs, set.frames.begin() + row * inputs);
    reading += contact.steps * inputs;
  }
}

int pressing_steps(const fem::Scene&, const fem::LoadPath& path) { return path.indentation_steps; }
int pressing_steps(const fem::PadScene& scene, const PadPath&) {
  return static_cast<int>(fem::pressing_targets(scene.load));
}
bool until_sliding(const fem::LoadPath& path) { return path.until_sliding; }
bool until_sliding(const PadPath&) { return false; }

template <class Contacts>
std::unique_ptr<SetSimulator::Range> Simulator<Contacts>::prepare(std::uint64_t first, std::uint64_t count) const {
  auto chunk = std::make_unique<Chunk>();
  chunk->first = first, chunk->count = count;
  const std::size_t numbers = parameters_.columns().size();
  chunk->contacts.reserve(count);
  chunk->parameters.resize(count * numbers);
  const auto start = Clock::now();
  for (std::uint64_t k = 0; k < count; ++k) {
    const auto [scene, indenter] = source_.contact(first + k);
    const typename Contacts::Path path = Contacts::path(scene);
    parameters_.put(scene, indenter, std::span(chunk->parameters).subspan(k * numbers, numbers));
    chunk->contacts.push_back({.number = first + k,
                               .sensor = scene.sensor,
                               .friction = scene.friction,
                               .first_step = source_.press_rows() ? 0 : pressing_steps(scene, path) - 1,
                               .kind = indenter,
                               .until_sliding = until_sliding(path)});
    if constexpr (!Contact<Contacts>::of_lines) {
      chunk->contacts.back().presses = static_cast<int>(fem::presses_on(scene.load));
      chunk->contacts.back().path = path;
      chunk->contacts.back().position = scene.indenter.position;
    }
    stream_.add(chunk->part, scene, path);
  }
  chunk->seconds.draw = seconds_since(start);
  chunk->part.lay_out();
  chunk->steps = chunk->part.steps();
  chunk->seconds.lay_out = seconds_since(start) - chunk->seconds.draw;
  return chunk;
}

template <class Contacts>
ContactSet Simulator<Contacts>::collect(Range& range) {
  auto& chunk = static_cast<Chunk&>(range);
  const auto start = Clock::now();
  ContactSet set(columns_);
  std::vector<std::size_t> rows(chunk.count + 1, 0);  // of contact k: rows[k] ... rows[k + 1] - 1
  Fallen fallen;
  const auto answered = [&] {
    if (range.answered) ++*range.answered;
  };
  Alone<Contacts> alone;
  std::optional<Clock::time_point> begin_again;
  stream_.collect(
      chunk.part,
      [&](std::size_t k) {
        if (!begin_again) begin_again = Clock::now();
        return source_.contact(chunk.contacts[k].number).scene;
      },
      [&](std::size_t k, const LaneAnswer& answer) { return to_solve_alone(answer, chunk.contacts[k]); },
      [&](std::size_t k, const LaneAnswer& answer, typename StreamOf<Contacts>::Alone&& solved_alone) {
        if (!solved_alone.empty()) alone.emplace(k, std::move(solved_alone));
        rows[k + 1] = survey(set, steps_of(answer, chunk, k, alone), chunk.contacts[k]);
        answered();
      },
      [&](std::size_t k, typename Contacts::Solution&& solution) {
        auto& contact = chunk.contacts[k];
        set.fell_back += solution.fell_back;
        set.unsolved += std::ranges::any_of(solution.steps, [](const auto& step) { return !step.converged; });
        rows[k + 1] = survey(set, StepsOfSolution<Contacts>{solution, &contact}, contact);
        fallen[k] = std::move(solution);
        answered();
      });
  if (begin_again) range.seconds.solve_again = seconds_since(*begin_again);
  set.contacts = chunk.count;
  set.without_rows = static_cast<std::uint64_t>(std::count(rows.begin() + 1, rows.end(), std::size_t{0}));
  std::partial_sum(rows.begin(), rows.end(), rows.begin());
  resize(set, rows.back());
  std::vector<RowsFrom<StepsOfLane<Contacts>>> together;
  const auto put = [&] {
    put_rows(set, std::span(together));
    together.clear();
  };
  chunk.part.each(true, [&](std::size_t k, const LaneAnswer& answer) {
    if (rows[k] == rows[k + 1] || fallen.contains(k)) return;
    together.push_back({rows[k], steps_of(answer, chunk, k, alone)});
    if (together.size() == std::min(answer.stride, side_by_side_answers)) put();
  });
  put();
  for (const auto& [k, solution] : fallen) {
    RowsFrom<StepsOfSolution<Contacts>> row_of_fallen{rows[k], {solution, &chunk.contacts[k]}};
    put_rows(set, std::span(&row_of_fallen, 1));
  }
  set.contact_parameters = std::move(chunk.parameters);
  if (chain_) measure(set, rows, chunk, fallen, alone);
  chunk.part = {};  // its memory, before the rows are written
  set.indenter_names = source_.kind_names();
  set.transducer = nn::description(source_.transducer());
  set.device = executor_.device().info().name;
  set.seed = source_.seed();
  set.press_rows = source_.press_rows();
  range.seconds.gather = seconds_since(start) - range.seconds.solve_again;
  return set;
}

template <class Scene>
SetColumns columns_of_kind(const SourceOf<Scene>& source) {
  SetColumns columns(source.inputs(), source.own_sensors().has_value(), !SourceOf<Scene>::of_lines);
  if constexpr (!SourceOf<Scene>::of_lines) columns.axes = source.sensors().front().axes;
  const auto parameters = source.parameters();
  for (const auto& column : parameters.columns()) {
    columns.parameters.push_back(column.name);
    columns.parameter_units.push_back(column.unit);
  }
  columns.tactel_x = source.tactel_x();
  if constexpr (!SourceOf<Scene>::of_lines) columns.tactel_y = source.tactel_y();
  if (!source.has_rate()) columns.left_out = {"net_slip", "net_turn", "slid_ahead"};
  return columns;
}

}  // namespace

void model_on(const Rung& rung, SceneSource& source, SetOptions& options) {
  source.model_on(rung);
  options.precision = rung.precision, options.tolerance = rung.tolerance;
  if (rung.patch()) options.patch = rung;
}

SetColumns columns_of(const SceneSource& source) { return columns_of_kind(source); }
SetColumns columns_of(const PadSource& source) { return columns_of_kind(source); }
SetColumns columns_of(const AnySource& source) {
  return std::visit([](const auto& kind) { return columns_of_kind(kind); }, source);
}

SetSimulator::SetSimulator(Executor& executor, const SceneSource& source, const SetOptions& options)
    : state_(std::make_unique<Simulator<LineContacts>>(executor, source, options)) {}
SetSimulator::SetSimulator(Executor& executor, const PadSource& source, const SetOptions& options)
    : state_(source.holds() ? hold_simulator(executor, source, options)
                            : std::make_unique<Simulator<PadContacts>>(executor, source, options)) {}
SetSimulator::SetSimulator(Executor& executor, const AnySource& source, const SetOptions& options)
    : SetSimulator(std::visit([&](const auto& kind) { return SetSimulator(executor, kind, options); }, source)) {}

SetSimulator::~SetSimulator() = default;
SetSimulator::SetSimulator(SetSimulator&&) noexcept = default;

std::unique_ptr<SetSimulator::Range> SetSimulator::prepare(std::uint64_t first, std::uint64_t count) const {
  return state_->prepare(first, count);
}
void SetSimulator::run(Range& range, const RunOptions& options) const { state_->run(range, options); }
ContactSet SetSimulator::collect(Range& range) const { return state_->collect(range); }

ContactSet SetSimulator::simulate(std::uint64_t first, std::uint64_t count) const {
  const auto range = prepare(first, count);
  run(*range);
  return collect(*range);
}

}  // namespace tactel::host
