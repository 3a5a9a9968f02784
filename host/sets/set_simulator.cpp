// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_simulator.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>

#include "fem/gap/contact_laws.h"
#include "fem/numbers/angles.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "host/contact/limits.h"
#include "host/contact/lines/contact_stream.h"
#include "host/contact/lines/sensor_tables.h"
#include "host/contact/pads/pad_stream.h"
#include "host/sets/held_contacts.h"
#include "host/sets/transducer_chain.h"
#include "host/support/errors.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;

/// A load step of a contact: its row, and what else the contact is judged by.
struct Step : SetRow {
  bool defined = false;                           ///< S is: else the step is no row
  double slip_distance = 0;                       ///< mm
  double area = 0;                                ///< of pads: mm^2 of the cells that touch
  fem::PadBox reach{fem::nowhere, fem::nowhere};  ///< of pads: around these, from the indenter's axis
  int across = 0;  ///< elements or cells over which the contact extends, along the shorter side
};

/// A contact but for its shape, which its launch has.
template <class Contacts>
struct Contact {
  std::uint64_t number = 0;  ///< in the sweep
  typename Contacts::Sensor sensor;
  double friction = 0;
  bool mapped = false;  ///< each step has its own, the mean over its cells
  std::uint16_t kind = 0;
  int first_step = 0;          ///< the first that may be a row
  bool until_sliding = false;  ///< of lines
  PadPath path{};              ///< of paths on pads: results do not hold it
  int presses = 0;             ///< its steps that press on from first touch (fem/pad/pad_presses.h)
  std::array<double, 2> at{};  ///< of the indenter, mm
  int least = 0, outside = 0;  ///< elements or cells below which a row is marked; sum of PadOutside: known by survey
};
using LineContact = Contact<LineContacts>;
using PathContact = Contact<PadContacts>;
using GripContact = Contact<HeldContacts>;
template <class Contacts>
constexpr bool of_lines = std::is_same_v<Contacts, LineContacts>;
template <class Contacts>
constexpr bool of_paths = std::is_same_v<Contacts, PadContacts>;

void take_path(LineContact& contact, const fem::Scene&, const fem::LoadPath& path) {
  contact.first_step = path.indentation_steps - 1, contact.until_sliding = path.until_sliding;
}
void take_path(PathContact& contact, const fem::PadScene& scene, const PadPath& path) {
  contact.first_step = static_cast<int>(fem::pressing_targets(scene.load)) - 1;
  contact.presses = static_cast<int>(fem::presses_on(scene.load));
  contact.path = path, contact.at = scene.indenter.position, contact.mapped = scene.friction_map.has_value();
}
void take_path(GripContact& contact, const HeldScene& scene, const HeldContacts::Path&) {
  contact.first_step = scene.hold.pressing() - 1;
}

// What the kernel says of step k of an answer in place. A step in memory, written by number and copied by vector,
// stalls.

template <class Contacts>
[[gnu::always_inline]] inline Step common_step(const LaneAnswer& answer, const Contact<Contacts>& contact, int k) {
  const auto result = [&](int row) { return answer.result(k, row); };
  const auto sticking = static_cast<int>(result(RESULT_STICKING));
  Step step;
  step.P = result(RESULT_P), step.indentation = result(RESULT_DEPTH);
  step.friction = contact.mapped ? result(PAD_RESULT_MU) : contact.friction;
  const std::optional<double> index = slip_index(step.friction, step.P, result(RESULT_S));
  step.defined = index.has_value(), step.slip_index = index.value_or(0);
  step.slip_distance = result(RESULT_SLIP_DISTANCE), step.status = static_cast<int>(result(RESULT_STATUS));
  step.touching = sticking + static_cast<int>(result(RESULT_SLIPPING));
  step.stick_fraction = step.touching ? static_cast<double>(sticking) / step.touching : 0;
  step.residual = std::max({result(RESULT_PENETRATION), result(RESULT_COMPLEMENTARITY), result(RESULT_CONE),
                            result(RESULT_DRIFT), result(RESULT_OWN_RESIDUAL)});
  return step;
}
template <class Contacts>
[[gnu::always_inline]] inline Step common_pad_step(const LaneAnswer& answer, const Contact<Contacts>& contact, int k) {
  const auto result = [&](int row) { return answer.result(k, row); };
  Step step = common_step(answer, contact, k);
  step.Q = {result(PAD_RESULT_QX), result(PAD_RESULT_QY)}, step.M = result(PAD_RESULT_M);
  if (step.defined) step.force_ratio = std::hypot(step.Q[0], step.Q[1]) / (step.friction * step.P);
  step.slid = result(PAD_RESULT_SLID), step.slip_path = result(PAD_RESULT_SLIP_PATH);
  step.area = result(PAD_RESULT_AREA), step.across = static_cast<int>(result(PAD_RESULT_ACROSS));
  return step;
}
[[gnu::always_inline]] inline Step step_of(const LaneAnswer& answer, const LineContact& contact, int k) {
  Step step = common_step(answer, contact, k);
  step.Q[0] = answer.result(k, LANE_Q), step.tangential[0] = answer.result(k, LANE_TANGENTIAL);
  step.across = step.touching;
  return step;
}
[[gnu::always_inline]] inline Step step_of(const LaneAnswer& answer, const PathContact& contact, int k) {
  const auto result = [&](int row) { return answer.result(k, row); };
  Step step = common_pad_step(answer, contact, k);
  const fem::PadTarget& at = contact.path.steps[static_cast<std::size_t>(k)];
  step.tangential = {at.x, at.y}, step.twist = fem::degrees(at.twist);
  step.reach = {{result(PAD_RESULT_LEFT), result(PAD_RESULT_RIGHT)},
                {result(PAD_RESULT_BELOW), result(PAD_RESULT_ABOVE)}};
  return step;
}
Step step_of(const LaneAnswer& answer, const GripContact& contact, int k) {
  const auto result = [&](int row) { return answer.result(k, row); };
  Step step = common_pad_step(answer, contact, k);
  step.tangential = {result(HELD_X), result(HELD_Y)}, step.twist = fem::degrees(result(HELD_TWIST));
  step.stick_fraction = result(HELD_STICK);
  step.net_slip = {result(HELD_NET_X), result(HELD_NET_Y)}, step.net_turn = result(HELD_NET_TURN);
  step.slid_ahead = result(HELD_SLID_AHEAD), step.outside = static_cast<int>(result(HELD_OUTSIDE));
  return step;
}

double element_of(const LaneAnswer& answer, const LineContact&) { return answer.element(); }
template <class Contacts>
double element_of(const LaneAnswer& answer, const Contact<Contacts>&) {
  return answer.result(0, PAD_RESULT_CELL);
}

// The same of a contact that was solved again.

template <class From>
Step common_step(const From& from) {
  const auto count = [&](fem::GapStatus status) { return static_cast<int>(std::ranges::count(from.status, status)); };
  const int sticking = count(fem::GapStatus::stick);
  Step step;
  step.P = from.P, step.indentation = from.indentation, step.slip_distance = from.slip_distance;
  step.defined = from.slip_index.has_value(), step.slip_index = from.slip_index.value_or(0);
  step.touching = sticking + count(fem::GapStatus::slip);
  step.stick_fraction = step.touching ? static_cast<double>(sticking) / step.touching : 0;
  step.status = !from.converged ? LANE_UNSOLVED : sticking ? LANE_SOLVED : LANE_SLIDING;
  return step;
}
Step step_of(const fem::ContactStep& from) {
  Step step = common_step(from);
  step.Q[0] = from.Q, step.tangential[0] = from.tangential, step.residual = fem::largest(from.residual);
  step.across = step.touching;
  return step;
}
Step step_of(const fem::PadStep& from) {
  Step step = common_step(from);
  step.Q = {from.Q[0], from.Q[1]}, step.M = from.M, step.force_ratio = from.force_ratio.value_or(0);
  step.tangential = {from.x, from.y}, step.twist = fem::degrees(from.twist), step.residual = from.residual.largest();
  step.slid = from.slid, step.slip_path = from.slip_path, step.friction = from.mu;
  step.area = from.area, step.across = from.across, step.reach = from.reach;
  return step;
}

std::vector<float> stress_of(const fem::ContactStep& step) {
  std::vector<float> frame(step.sigma_y.begin(), step.sigma_y.end());
  frame.insert(frame.end(), step.tau_xy.begin(), step.tau_xy.end());
  return frame;
}
std::vector<float> stress_of(const fem::PadStep& step) {  // [tactels, 3] by columns; of markers z, x, y
  std::vector<float> frame(step.stress.data(), step.stress.data() + step.stress.size());
  for (const int axis : {2, 0, 1})
    for (const double u : step.markers.col(axis)) frame.push_back(static_cast<float>(u));
  return frame;
}

double element_of(const fem::ContactSolution& solution, const fem::Sensor& sensor) {
  return solution.surface_width.size() > 0 ? solution.surface_width[0] : sensor.length / (sensor.columns - 1);
}
double element_of(const fem::PadSolution& solution, const fem::PadSensor&) {
  return std::max(solution.cells.hx, solution.cells.hy);
}

/// Elements or cells a side of an answer. 0: of a mesh, which is not laid for a contact.
int along_side(const fem::ContactSolution& solution) { return static_cast<int>(solution.surface_width.size()); }
int along_side(const fem::PadSolution& solution) { return solution.cells.n; }

bool slides(const fem::ContactSolution& solution) { return solution.sliding; }
bool slides(const fem::PadSolution&) { return true; }

/// What stands in place of the answer of a launch.
struct SolvedAgain {
  std::vector<Step> steps{};
  std::vector<std::vector<float>> stresses{};  ///< [steps][inputs]; empty: the launch's
  double element = 0;                          ///< mm
  bool slides = true;                          ///< the last step, as a whole
};

template <class Contacts>
SolvedAgain solved_again(const typename Contacts::Solution& solution, const Contact<Contacts>& contact) {
  SolvedAgain again{.element = element_of(solution, contact.sensor), .slides = slides(solution)};
  for (const auto& step : solution.steps)
    again.steps.push_back(step_of(step)), again.stresses.push_back(stress_of(step));
  return again;
}
/// Of an answer with steps that were solved alone. These extend over cells enough.
template <class Contacts>
SolvedAgain solved_again(const LaneAnswer& answer, const typename StreamOf<Contacts>::Alone& alone,
                         const Contact<Contacts>& contact) {
  SolvedAgain again{.element = element_of(answer, contact)};
  again.stresses.resize(static_cast<std::size_t>(answer.steps));
  int widest = 0;
  for (int k = 0; k < answer.steps; ++k) {
    again.steps.push_back(step_of(answer, contact, k));
    widest = std::max(widest, again.steps.back().across);
  }
  for (const auto& [k, solution] : alone) {
    again.steps[k] = step_of(solution.steps.back()), again.stresses[k] = stress_of(solution.steps.back());
    again.steps[k].across = widest;
  }
  return again;
}

/// The steps of a contact.
template <class Contacts>
struct Steps {
  int count() const { return again ? static_cast<int>(again->steps.size()) : answer.steps; }
  double element() const { return again ? again->element : element_of(answer, *contact); }
  /// Where the contact extends over few elements or cells, it is marked.
  [[gnu::always_inline]] Step step(int k) const {
    Step step = again ? again->steps[static_cast<std::size_t>(k)] : step_of(answer, *contact, k);
    if (solved(step.status) && step.across < contact->least) step.status = coarse_row;
    return step;
  }
  void stress(int k, std::span<float> frame) const {
    if (again && !again->stresses[static_cast<std::size_t>(k)].empty())
      std::copy_n(again->stresses[static_cast<std::size_t>(k)].begin(), frame.size(), frame.begin());
    else
      answer.tactels(k, frame);
  }
  /// [markers][x, y, z], from the end of the stresses: [z, x, y][markers].
  void markers(int k, std::span<float> u) const {
    std::vector<float> zxy(again ? again->stresses[static_cast<std::size_t>(k)] : std::vector<float>{});
    if (zxy.empty()) zxy.resize(answer.stresses()), answer.tactels(k, std::span(zxy));
    const std::size_t count = u.size() / 3;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t m = 0; m < count; ++m) u[3 * m + axis] = zxy[zxy.size() - u.size() + (axis + 1) % 3 * count + m];
  }
  bool slid() const {
    return again ? again->slides : static_cast<int>(answer.result(answer.steps - 1, RESULT_STATUS)) >= LANE_SLIDING;
  }

  LaneAnswer answer;
  const Contact<Contacts>* contact;
  const SolvedAgain* again;  ///< none: the launch's answer holds
};

/// Returns over how many of so many elements or cells a step must extend.
template <class Contacts>
int least_across(const Steps<Contacts>& steps, int along_side) {
  if (along_side == 0 || of_lines<Contacts>) return along_side == 0 ? 0 : fem::least_elements;
  int widest = 0;
  for (int k = 0; k < steps.count(); ++k) widest = std::max(widest, steps.step(k).across);
  return fem::least_across(along_side, widest);
}

void resize(ContactSet& set, std::size_t rows) {
  each_dataset(set, [rows](const char*, auto& values, int columns, const char*) {
    values.resize(rows * static_cast<std::size_t>(std::max(columns, 1)));
  });
}

/// Whether a step of a contact becomes a row.
template <class Contacts>
bool is_row(const Step& step, const Contact<Contacts>& contact, int k) {
  return k >= contact.first_step && step.status != LANE_NOT_RUN && step.defined;
}

/// Adds what the steps of a contact say together to the counts of a set. Returns how many of them become rows.
template <class Contacts>
std::size_t survey(ContactSet& set, const Steps<Contacts>& steps, Contact<Contacts>& contact, int along_side) {
  contact.least = least_across(steps, along_side);
  const double element = steps.element();  // mm
  std::size_t rows = 0;
  double deepest = 0;  // mm
  bool far = false;    // the indenter slides further over the rubber than displacements are small
  fem::PadBox reach{fem::nowhere, fem::nowhere};
  bool unsolved = false;
  for (int k = 0; k < steps.count(); ++k) {
    const Step step = steps.step(k);
    if (step.status == LANE_NOT_RUN) break;
    deepest = std::max(deepest, step.indentation);
    if constexpr (of_lines<Contacts>)
      far = far || step.slip_distance > slip_limit(contact.sensor, element * step.touching);
    else
      far = far || (step.P > 0 && step.slip_distance > slip_limit(std::sqrt(step.area)));
    reach.cover(step.reach), contact.outside |= step.outside;
    if (!is_row(step, contact, k)) continue;
    ++rows, set.coarse += step.status == coarse_row;
    unsolved = unsolved || step.status == LANE_UNSOLVED;
  }
  set.too_deep += too_deep(contact.sensor.thickness, deepest);
  set.far_slip += far;
  if constexpr (of_paths<Contacts>) contact.outside = outside_model(contact.sensor, contact.at, reach, element);
  if (std::is_same_v<Contacts, HeldContacts>) set.unsolved += unsolved;
  set.near_edge += (contact.outside & outside_edges) != 0;
  set.unseen += (contact.outside & outside_tactels) != 0;
  set.wide_cells += (contact.outside & outside_cells) != 0;
  set.never_slid += rows > 0 && contact.until_sliding && !steps.slid();
  return rows;
}

/// How far the contact on a pad, and how far its cells, have slid since first touch over its elastic limit, the shear
/// of a layer that bears mu times the mean pressure.
class Slide {
 public:
  /// Of a path, whose steps say mm; those of grips are over the limit.
  void take(Step& step, const PathContact& contact) {
    const auto& [poisson, thickness, young] =
        std::tie(contact.sensor.poisson, contact.sensor.thickness, contact.sensor.young);
    const double limit = step.friction * step.P / step.area * thickness * 2 * (1 + poisson) / young *
                         fem::softer_in_shear(contact.sensor);
    step.slid = whole_.add(step.slid, limit), step.slip_path = cells_.add(step.slip_path, limit);
  }

 private:
  struct Way {
    double way = 0, over_limit = 0;  ///< mm, 1
    double add(double to, double limit) {
      if (limit > 0) over_limit += std::max(0.0, to - way) / limit;  // a step solved alone has a path of its own
      way = to;
      return over_limit;
    }
  };
  Way whole_, cells_;
};

/// A contact whose rows go into a set, the next into row `at`.
template <class Contacts>
struct RowsFrom {
  std::size_t at = 0;
  Steps<Contacts> steps;
  Slide slide{};
};

void put_sensor(SetRow& row, const fem::Sensor& sensor) { row.length = sensor.length; }
void put_sensor(SetRow&, const fem::PadSensor&) {}

/// The markers of a set, and the camera that sees them.
struct Seen {
  std::optional<Markers> markers{};
  std::optional<Camera> camera{};

  /// Puts where they are seen, displaced by `moved`, [markers][x, y, z] mm, with the noise of a step.
  void put(std::span<const float> moved, std::uint64_t seed, const SetRow& row, std::span<float> pixels) const {
    const Eigen::Map<const Eigen::Matrix3Xf> u(moved.data(), 3, static_cast<Eigen::Index>(moved.size() / 3));
    Eigen::Map<Eigen::Matrix2Xf>(pixels.data(), 2, u.cols()) =
        fem::pixels_of(*camera, *markers, u.cast<double>().transpose()).transpose().cast<float>();
    if (camera->noise_px > 0)
      nn::add_pixel_noise(pixels, camera->noise_px, seed, row.contact, static_cast<std::uint32_t>(row.step));
  }
};

/// Lanes whose numbers lie side by side in memory are read together, step by step.
template <class Contacts>
void put_rows(ContactSet& set, std::span<RowsFrom<Contacts>> contacts, const Seen& seen) {
  const auto columns = set_columns(set);
  const auto inputs = static_cast<std::size_t>(set.inputs), directions = static_cast<std::size_t>(set.directions());
  const auto markers = static_cast<std::size_t>(set.marker_numbers), pixels = markers / 3 * 2;
  int most = 0;
  for (const auto& from : contacts) most = std::max(most, from.steps.count());
  for (int k = 0; k < most; ++k)
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      auto& from = contacts[i];
      const Contact<Contacts>& contact = *from.steps.contact;
      from.steps.answer.fetch_step(k + 1, i, contacts.size());
      if (k >= from.steps.count() || (!of_paths<Contacts> && k < contact.first_step)) continue;
      Step step = from.steps.step(k);
      if constexpr (of_paths<Contacts>) from.slide.take(step, contact);
      if (!is_row(step, contact, k)) continue;
      step.slip_index = std::clamp(step.slip_index, -1.0, 1.0);  // rounding apart, Q <= mu P
      if (!contact.mapped) step.friction = contact.friction;
      step.outside = contact.outside, step.contact = contact.number;
      step.step = k, step.kind = contact.kind;
      step.poisson = contact.sensor.poisson, step.thickness = contact.sensor.thickness;
      step.young = contact.sensor.young, put_sensor(step, contact.sensor);
      each(columns, [&](const auto& column) { column.put(from.at, step, directions); });
      if (markers > 0) from.steps.markers(k, std::span(set.markers).subspan(from.at * markers, markers));
      if (seen.camera)
        seen.put(std::span(set.markers).subspan(from.at * markers, markers), set.seed, step,
                 std::span(set.pixels).subspan(from.at * pixels, pixels));
      from.steps.stress(k, std::span(set.frames).subspan(from.at++ * inputs, inputs));
    }
}

template <class Contacts>
struct Chunk : SetSimulator::Range {
  std::vector<Contact<Contacts>> contacts;
  std::vector<float> parameters;  ///< [contacts][columns]
  typename StreamOf<Contacts>::Part part;
  std::map<std::uint64_t, SolvedAgain> again{};  ///< by place in the range
};

/// Lanes that are read together, at most: those of a group lie side by side.
constexpr std::size_t side_by_side_answers = 32;

ContactModel line_model(Executor& executor, const SceneSource& source, const SetOptions& options) {
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

PadModel pad_model(const PadSource& source, const SetOptions& options) {
  PadModel model{{.cells = options.pad.cells, .pressing_increments = options.pad.increments}, options.precision};
  model.options.any_poisson = source.own_sensors() && source.own_sensors()->any_poisson;
  if (options.accept > 0) model.options.tolerance = 0, model.options.accept = options.accept;
  return model;
}

int along_side(const SceneSource& source, const SetOptions& options) {
  if (!options.patch && source.model() != fem::SurfaceModel::patch) return 0;
  return options.patch.value_or(usual_patch()).elements;
}
int along_side(const PadSource&, const SetOptions& options) { return options.pad.cells; }

int rows_of_tactels(const fem::Sensor&) { return 1; }
int rows_of_tactels(const fem::PadSensor& sensor) { return sensor.tactels[1]; }

template <class Contacts>
class Simulator final : public SetSimulator::State {
  using Source = std::conditional_t<of_lines<Contacts>, SceneSource, PadSource>;
  using Chunk = host::Chunk<Contacts>;
  using Range = SetSimulator::Range;
  using Alone = typename StreamOf<Contacts>::Alone;
  using Scene = typename Contacts::Scene;

 public:
  Simulator(Executor& executor, const Source& source, const SetOptions& options, typename Contacts::Model model)
      : executor_(executor),
        source_(source),
        parameters_(source.parameters()),
        columns_(columns_of(source)),
        along_side_(along_side(source, options)),
        stream_(executor, std::move(model)) {
    // Of other sensors the family has the tables, and grips have none.
    if (!source.own_sensors() && !source.holds()) stream_.keep(source.sensors());
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
  std::pair<Scene, std::uint16_t> contact(std::uint64_t number) const {
    auto [scene, kind] = source_.contact(number);
    if constexpr (std::is_same_v<Contacts, HeldContacts>)
      return {{std::move(scene), source_.hold(number)}, kind};
    else
      return {std::move(scene), kind};
  }
  /// The steps of contact k of a range.
  Steps<Contacts> steps_of(const LaneAnswer& answer, const Chunk& chunk, std::uint64_t k) const {
    const auto found = chunk.again.find(k);
    return {answer, &chunk.contacts[k], found == chunk.again.end() ? nullptr : &found->second};
  }
  std::vector<std::size_t> to_solve_alone(const LaneAnswer& answer, const Contact<Contacts>& contact) const;
  void measure(ContactSet& set, const std::vector<std::size_t>& rows, const Chunk& chunk);

  Executor& executor_;
  const Source& source_;
  decltype(std::declval<Source>().parameters()) parameters_;
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
  std::vector<std::size_t> steps = fem::coarse_presses(
      std::span(contact.path.steps), contact.presses, along_side_,
      [&](std::size_t k) { return static_cast<int>(answer.result(static_cast<int>(k), PAD_RESULT_ACROSS)); });
  if (!chain_) std::erase_if(steps, [&](std::size_t k) { return static_cast<int>(k) < contact.first_step; });
  return steps;
}

/// Readings in place of stresses, in the rows of a chunk. They depend on all load steps up to them, so these go through
/// the chain, rows or not.
template <class Contacts>
void Simulator<Contacts>::measure(ContactSet& set, const std::vector<std::size_t>& rows, const Chunk& chunk) {
  const std::size_t inputs = set.inputs;
  std::vector<TransducerChain::Contact> contacts;
  std::vector<float> signal;
  chunk.part.each(true, [&](std::size_t k, const LaneAnswer& answer) {
    contacts.push_back({chunk.first + k, rows[k] == rows[k + 1] ? 0 : set.step[rows[k + 1] - 1] + 1});
    const Steps<Contacts> steps = steps_of(answer, chunk, k);
    for (std::uint32_t step = 0; step < contacts.back().steps; ++step) {
      signal.resize(signal.size() + inputs);
      steps.stress(static_cast<int>(step), std::span(signal).last(inputs));
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

template <class Contacts>
std::unique_ptr<SetSimulator::Range> Simulator<Contacts>::prepare(std::uint64_t first, std::uint64_t count) const {
  auto chunk = std::make_unique<Chunk>();
  chunk->first = first, chunk->count = count;
  const std::size_t numbers = parameters_.columns().size();
  chunk->contacts.reserve(count);
  chunk->parameters.resize(count * numbers);
  const auto start = Clock::now();
  for (std::uint64_t k = 0; k < count; ++k) {
    const auto [scene, kind] = contact(first + k);
    const typename Contacts::Path path = Contacts::path(scene);
    parameters_.put(scene, kind, std::span(chunk->parameters).subspan(k * numbers, numbers));
    chunk->contacts.push_back({.number = first + k, .sensor = scene.sensor, .friction = scene.friction, .kind = kind});
    take_path(chunk->contacts.back(), scene, path);
    if (source_.press_rows()) chunk->contacts.back().first_step = 0;
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
  const auto take = [&](std::size_t k, const LaneAnswer& answer, int along_side) {
    rows[k + 1] = survey(set, steps_of(answer, chunk, k), chunk.contacts[k], along_side);
    if (range.answered) ++*range.answered;
  };
  std::optional<Clock::time_point> begin_again;
  stream_.collect(
      chunk.part,
      [&](std::size_t k) {
        if (!begin_again) begin_again = Clock::now();
        return contact(chunk.contacts[k].number).first;
      },
      [&](std::size_t k, const LaneAnswer& answer) { return to_solve_alone(answer, chunk.contacts[k]); },
      [&](std::size_t k, const LaneAnswer& answer, Alone&& alone) {
        if (!alone.empty()) chunk.again.emplace(k, solved_again(answer, alone, chunk.contacts[k]));
        take(k, answer, along_side_);
      },
      [&](std::size_t k, typename Contacts::Solution&& solution) {
        set.fell_back += solution.fell_back;
        set.unsolved += std::ranges::any_of(solution.steps, [](const auto& step) { return !step.converged; });
        chunk.again.emplace(k, solved_again(solution, chunk.contacts[k]));
        take(k, {}, along_side(solution));
      });
  if (begin_again) range.seconds.solve_again = seconds_since(*begin_again);
  set.contacts = chunk.count, set.seed = source_.seed();
  set.without_rows = static_cast<std::uint64_t>(std::count(rows.begin() + 1, rows.end(), std::size_t{0}));
  std::partial_sum(rows.begin(), rows.end(), rows.begin());
  resize(set, rows.back());
  const Seen seen{source_.markers(), source_.camera()};
  std::vector<RowsFrom<Contacts>> together;
  const auto put = [&] {
    put_rows(set, std::span(together), seen);
    together.clear();
  };
  chunk.part.each(true, [&](std::size_t k, const LaneAnswer& answer) {
    if (rows[k] == rows[k + 1]) return;
    together.push_back({rows[k], steps_of(answer, chunk, k)});
    if (together.size() == std::min(answer.stride, side_by_side_answers)) put();
  });
  put();
  set.parameters = std::move(chunk.parameters);
  if (chain_) measure(set, rows, chunk);
  chunk.part = {}, chunk.again = {};  // their memory, before the rows are written
  set.indenter_names = source_.kind_names();
  set.transducer = nn::description(source_.transducer());
  set.device = executor_.device().info().name;
  set.press_rows = source_.press_rows();
  range.seconds.gather = seconds_since(start) - range.seconds.solve_again;
  return set;
}

template <class Scene>
SetColumns columns_of_kind(const SourceOf<Scene>& source) {
  SetColumns columns(source.inputs(), source.own_sensors().has_value(), !SourceOf<Scene>::of_lines);
  if constexpr (!SourceOf<Scene>::of_lines)
    columns.axes = source.sensors().front().axes, columns.tactel_y = source.tactel_y(),
    columns.marker_numbers = 3 * static_cast<int>(fem::marker_count(source.markers())),
    columns.pixel_numbers = source.camera() ? columns.marker_numbers / 3 * 2 : 0;
  const auto parameters = source.parameters();
  for (const auto& column : parameters.columns()) {
    columns.parameter_names.push_back(column.name);
    columns.parameter_units.push_back(column.unit);
  }
  columns.tactel_x = source.tactel_x();
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
    : state_(std::make_unique<Simulator<LineContacts>>(executor, source, options,
                                                       line_model(executor, source, options))) {}
SetSimulator::SetSimulator(Executor& executor, const PadSource& source, const SetOptions& options) {
  if (source.holds())
    state_ = std::make_unique<Simulator<HeldContacts>>(
        executor, source, options,
        HeldModel{source.sensors(), options.pad.cells, options.accept, options.precision, source.markers()});
  else
    state_ = std::make_unique<Simulator<PadContacts>>(executor, source, options, pad_model(source, options));
}
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

std::optional<std::string> unsolved_warning(const ContactSet& set) {
  if (set.unsolved == 0) return std::nullopt;
  return fmt::format("{} of {} contacts have a load step that did not meet its tolerance", set.unsolved, set.contacts);
}

ContactSet simulate_family(Executor& executor, const SceneFamily& family, Precision precision, double tolerance) {
  const SceneSource source = source_of(family);
  ContactSet set = SetSimulator(executor, source, {precision, tolerance}).simulate(0, source.contacts());
  if (const auto warning = unsolved_warning(set)) executor.device().log(LogLevel::warning, *warning);
  return set;
}

}  // namespace tactel::host
