// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fem/gap/accuracy.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "host/contact/pads/pad_contact.h"
#include "host/contact/pads/pad_contact_tables.h"
#include "host/device/unwritten.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/pad_layout.h"
#include "kernels/shared/pad_step_layout.h"

namespace tactel::host {
namespace {

constexpr std::size_t widest_vector = 64;  ///< of AVX-512
constexpr double usual_reach = 0.5;        ///< rubber bulges beside an object by less than this part of its depth
constexpr double longest_motion = 0.05;    ///< H, of a solve along the pad
constexpr double least_cover = 1e-3;       ///< of a cell that counts as covered
constexpr double wide_share = 0.7;         ///< of the grid that a contact covers which is split: it takes less time
constexpr int never_wide = std::numeric_limits<int>::max();

static_assert(int(step_open) == int(STEP_OPEN) && int(step_slides) == int(STEP_SLIDES));
static_assert(int(step_unmet) == int(STEP_UNMET) && int(step_edge) == int(STEP_EDGE));
static_assert(int(step_invalid) == int(STEP_INVALID) && int(step_deep) == int(STEP_DEEP));
static_assert(int(step_reach) == int(STEP_REACH));

/// Sum of 1, 2, 4, 8: sides -x, +x, -y, +y of the grid beyond which there is rubber.
int rubber_beyond(const fem::PadSensor& pad, const fem::PadCells& cells) {
  const fem::PadBox grid = cells.box(), rubber = fem::rubber_of(pad);
  const double rounding = 1e-6 * cells.half_size();
  return 1 * (rubber.x.left < grid.x.left - rounding) + 2 * (rubber.x.right > grid.x.right + rounding) +
         4 * (rubber.y.left < grid.y.left - rounding) + 8 * (rubber.y.right > grid.y.right + rounding);
}

/// What the states of contacts with a pad begin with: PadStateHead.
std::vector<double> head_of_states(const fem::PadSensor& pad, const fem::PadCells& cells,
                                   const fem::SoftObject& object) {
  const double H = pad.thickness;
  const std::array block = free_block(pad);
  std::vector<double> all{double(cells.n), double(cells.ny()), cells.hx / H, cells.hy / H,
                          pad.poisson,     block[0] / H,       block[1] / H};
  static_assert(state_length == 5 && state_width == 6);
  const auto layers = fem::rubber(pad.layers, H, pad.young, pad.poisson).layers;
  const bool creeps = !pad.relaxation.empty();
  if (object.softness > 0 || !layers.empty() || creeps) all.insert(all.end(), {object.softness, object.poisson});
  for (const auto& [thickness, young, poisson] : layers) all.insert(all.end(), {thickness, young, poisson});
  if (creeps) all.push_back(state_relaxation);
  for (const auto& [share, time] : pad.relaxation) all.insert(all.end(), {share, time});
  return all;
}

/// A contact that is one of `count`.
std::size_t checked(std::size_t contact, std::size_t count) {
  if (contact >= count) throw ValueError("contacts", std::to_string(contact), fmt::format("below {}", count));
  return contact;
}

}  // namespace

template <class Real>
PadStepper<Real>::PadStepper(Executor& executor, const fem::PadSensor& pad, std::size_t count,
                             std::span<const double> friction, const StepOptions& options, const PairInfluence& pairs)
    : executor_(&executor), pad_(pad), options_(options), count_(count), cells_(step_grid(pad, options_)) {
  if (options_.object_young > 0) object_ = {pad.young / options_.object_young, options_.object_poisson};
  const std::size_t terms = pad.relaxation.size();
  marked_ = terms > 0 && options_.markers;
  const std::size_t creeping = terms == 0 ? 0 : ((marked_ ? 6 : 3) * (1 + terms) + (marked_ ? 3 : 0)) * cell_count(),
                    state_rows = STEP_FIELDS * cell_count() + STEP_NUMBERS + creeping;
  check_count(state_rows);
  if (free_block(pad)[0] > 0) {
    check_within_pad(pad, options_);
    sides_ = fem::sides_at(pad, {0, 0}, fem::SideBricks::usual, StopScope::checker());
  }
  width_ = static_cast<std::size_t>(device().lanes(precision_of<Real>));
  // As PadContact: two vectors share each number of the table where they are full and their sums fit into registers.
  const bool wide = width_ * sizeof(Real) >= widest_vector && !device().info().halves;
  vectors_ =
      wide && cells_.count() <= 144 && count >= 4 * width_ * static_cast<std::size_t>(executor.threads()) ? 2 : 1;
  places_ = (count + lanes() - 1) / lanes() * lanes();
  make_tables(pairs);
  const auto filled = [&](std::size_t rows, Real number) {
    return LaneArray<Real>(device(), places_, width_, 1, rows).fill(number);
  };
  input_ = filled(STEP_INPUT_ROWS, 0);
  put_input(STEP_BEYOND, std::vector<double>(count, -1), std::array{1.0});
  heights_ = filled(cell_count(), Real(PAD_OPEN)), soft_ = filled(cell_count(), 0);
  state_ = filled(state_rows, 0);
  const auto head = head_of_states(pad, cells_, object_);
  head_.assign(head.begin(), head.end());
  result_ = LaneArray<Real>(device(), places_, 1, 1, STEP_RESULT_ROWS).fill(0);
  if (terms > 0)
    creep_.emplace(Creeping{fem::Creep(pad.relaxation), Buffer<Real>(device(), 1 + CREEP_NUMBERS * terms)});
  make_launches();
  set_friction(friction);
}

template <class Real>
void PadStepper<Real>::make_tables(const PairInfluence& pairs) {
  if (!pairs.empty()) check_size("pairs", pairs.size(), 9 * cell_count() * cell_count());
  dense_ = sides_ || !pairs.empty();
  const StepTables tables(pad_, cells_, object_, sides_, options_.markers, pairs);
  root_zz_ = tables.influence[PAD_ROOT_ZZ], root_tt_ = tables.influence[PAD_ROOT_TT];
  kt_ = tables.kt, kr_ = tables.kr;
  table_ = buffer_of<Real>(device(), tables.influence);
  // From the kernel's numbers, so that tables that are the same there have the same bits.
  const std::vector<Real> own(tables.influence.begin(), tables.influence.end());
  const SplitBlocks split = split_blocks({own.begin(), own.end()}, dense_, cells_.n, cells_.ny());
  wide_from_ = split.numbers.empty() ? never_wide : static_cast<int>(std::ceil(wide_share * cells_.count()));
  blocks_ = buffer_of<Real>(device(), split.numbers);
  rho_n_ = split.rho_n, rho_t_ = split.rho_t;
  const auto take = [&](Sums& sums, std::size_t places, const std::vector<double>& base) {
    sums.base = buffer_of<Real>(device(), base);
    sums.numbers = LaneArray<Real>(device(), places_, 1, 1, 3 * places).fill(0);
  };
  const auto [tactels_x, tactels_y] = pad_.tactels;
  take(stresses_, static_cast<std::size_t>(tactels_x) * static_cast<std::size_t>(tactels_y), tables.stress);
  take(displacements_, fem::marker_count(options_.markers), tables.displacements);
}

template <class Real>
void PadStepper<Real>::make_launches() {
  Defines defines = {{"REAL", real_type(precision_of<Real>)}, {"LANES", std::to_string(width_)},
                     {"CELLS", std::to_string(cells_.n)},     {"CELLS_Y", std::to_string(cells_.ny())},
                     {"VECTORS", std::to_string(vectors_)},   {"DENSE", std::to_string(dense_)}};
  if (creep_) defines.emplace_back("CREEP_TERMS", std::to_string(pad_.relaxation.size()));
  if (mapped_) defines.emplace_back("FRICTION_MAP", "1");
  if (marked_) defines.emplace_back("MARKED", "1");
  const Program program(device(), "pad_step.cl", defines);
  const double H = pad_.thickness;
  const fem::Accuracy accuracy = fem::by_rule<Real>({options_.tolerance, 0}, fem::slow_on_patch);
  step_launch_ = executor_->prepare(program, "pad_step", [&](KernelArguments& kernel) {
    kernel.set("table", table_);
    kernel.set("blocks", blocks_);
    kernel.set("rho_n", Real(rho_n_));
    kernel.set("rho_t", Real(rho_t_));
    kernel.set("wide_from", std::int32_t(wide_from_));
    kernel.set("input", input_.numbers);
    kernel.set("heights", heights_.numbers);
    kernel.set("soft", soft_.numbers);
    kernel.set("by_wrench", std::int32_t(0));
    kernel.set("kt", Real(kt_));
    kernel.set("kr", Real(kr_));
    kernel.set("force", Real(pad_.young * H * H));
    kernel.set("thickness", Real(H));
    kernel.set("tolerance", Real(accuracy.tolerance));
    kernel.set("accept", Real(accuracy.accept));
    kernel.set("force_tolerance", Real(options_.force_tolerance));
    kernel.set("most_sweeps", std::int32_t(options_.most_sweeps));
    kernel.set("most_solves", std::int32_t(options_.most_solves));
    kernel.set("reach", Real(usual_reach));
    kernel.set("travel", Real(longest_motion));
    kernel.set("sides", std::int32_t(rubber_beyond(pad_, cells_)));
    kernel.set("state", state_.numbers);
    kernel.set("result", result_.numbers);
    kernel.set("creep", creep_ ? creep_->numbers : table_);  // elastic rubber does not read it
  });
  for (Sums* sums : {&stresses_, &displacements_})
    if (sums->numbers.rows > 0)
      sums->launch = executor_->prepare(program, "pad_frames", [&](KernelArguments& kernel) {
        kernel.set("base", sums->base);
        kernel.set("rows", std::int32_t(sums->numbers.rows));
        const bool straining = marked_ && sums == &displacements_;
        kernel.set("from", std::int32_t(straining ? state_.rows - 3 * cell_count() : 0));
        kernel.set("state", state_.numbers);
        kernel.set("frames", sums->numbers.numbers);
      });
}

/// Takes a map of friction from now on: its rows follow the others.
template <class Real>
void PadStepper<Real>::take_map() {
  const LaneArray<Real> before = input_;
  input_ = LaneArray<Real>(device(), places_, width_, 1, STEP_INPUT_ROWS + cell_count()).fill(0);
  const auto from = before.numbers.map(MapFor::reading), to = input_.numbers.map();
  for (std::size_t c = 0; c < places_; ++c)
    for (std::size_t k = 0; k < before.rows; ++k) to[input_.at(c, 0, k)] = from[before.at(c, 0, k)];
  mapped_ = true;
  make_launches();
}

template <class Real>
void PadStepper<Real>::check_count(std::size_t state_rows) const {
  if (count_ < 1) throw ValueError("count", "0", "1 or more");
  const auto numbers = state_rows + 2 * cell_count() + STEP_INPUT_ROWS + STEP_RESULT_ROWS +
                       3 * static_cast<std::size_t>(pad_.tactels[0] * pad_.tactels[1]) +
                       3 * fem::marker_count(options_.markers);
  const std::uint64_t bytes = numbers * sizeof(Real), most = memory_of(device().info()) / bytes;
  if (count_ > most)
    throw ValueError("count", std::to_string(count_),
                     fmt::format("{} at most, as each takes {} bytes of the device's memory", most, bytes));
}

/// The state that begins with these numbers.
template <class Real>
void PadStepper<Real>::check_state(std::span<const Real> numbers) const {
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
  if (numbers.size() < head_.size() || !std::ranges::equal(head_, numbers.first(head_.size())))
    throw ValueError("state",
                     numbers.size() < head_.size() ? "too few numbers" : "one of " + text(numbers.first(head_.size())),
                     "one of " + text(head_));
  if (numbers.size() < head_.size() + state_.rows) check_size("state", numbers.size(), head_.size() + state_.rows);
  for (const Real number : numbers.subspan(head_.size(), state_.rows))
    if (!std::isfinite(number)) throw ValueError("state", fmt::format("{}", number), "finite numbers");
}

/// Puts numbers of each contact, times their units, into rows of the input.
template <class Real>
void PadStepper<Real>::put_input(std::size_t first, std::span<const double> from, std::span<const double> units) {
  const auto all = input_.numbers.map();
  for (std::size_t c = 0; c < count_; ++c)
    for (std::size_t k = 0; k < units.size(); ++k)
      all[input_.at(c, 0, first + k)] = static_cast<Real>(from[c * units.size() + k] * units[k]);
}

template <class Real>
void PadStepper<Real>::put_heights(std::size_t contact, const double* height, const double* cover, std::span<Real> all,
                                   std::span<Real> softs) const {
  const double per_H = 1 / pad_.thickness;
  for (std::size_t i = 0; i < cell_count(); ++i) {
    const double f = cover ? cover[i] : 1, h = height[i] * per_H;
    const std::size_t place = heights_.at(contact, 0, i);
    all[place] = h >= PAD_OPEN || f < least_cover ? Real(PAD_OPEN) : static_cast<Real>(h);
    softs[place] = f < least_cover && f >= 0 ? Real(0) : static_cast<Real>(1 / f - 1);
  }
}

/// Returns how much softer rubber that creeps is in the step; 1 of other.
template <class Real>
double PadStepper<Real>::put_creep() {
  if (!creep_) return 1;
  const fem::CreepStep step = creep_->law.step(options_.dt);
  std::vector<Real> numbers{static_cast<Real>(step.softer)};
  for (const auto& term : step.terms)
    for (const double number : creep_numbers(term)) numbers.push_back(static_cast<Real>(number));
  creep_->numbers.write(numbers);
  return step.softer;
}

/// A step was made, or a state set.
template <class Real>
void PadStepper<Real>::forget() {
  for (auto* view : {&result_view_, &stresses_.view, &displacements_.view}) view->reset();
}

template <class Real>
void PadStepper<Real>::step(std::span<const double> to, bool by_wrench) {
  check_size(by_wrench ? "wrench" : "pose", to.size(), 4 * count_);
  const double softer = put_creep(), H = pad_.thickness, force = pad_.young * H * H / softer;
  const std::array by_pose{1 / H, 1 / H, 1 / H, 1.0}, by_force{1 / force, 1 / force, 1 / force, 1 / (force * H)};
  forget();
  put_input(STEP_TO, to, by_wrench ? by_force : by_pose);
  step_launch_.set("by_wrench", std::int32_t(by_wrench));
  if (creep_) step_launch_.set("force", Real(force));
  if (!writes_) result_.fill(std::numeric_limits<Real>::quiet_NaN());
  const std::size_t groups = places_ / lanes();
  if (groups == 1 && device().info().low_latency)
    executor_->run_here(step_launch_);
  else
    executor_->run(step_launch_, groups);
  if (writes_) return;
  const auto numbers = result_.numbers.map(MapFor::reading);
  for (std::size_t c = 0; c < count_; ++c)
    if (std::isnan(numbers[result_.at(c, 0, STEP_RESULT_P)])) refuse_unwritten(device());
  writes_ = true;
}

template <class Real>
void PadStepper<Real>::set_friction(std::span<const double> friction) {
  std::vector<double> all(friction.begin(), friction.end());
  if (all.size() == 1) all.assign(count_, all.front());
  const std::size_t each = all.size() == count_ * cell_count() ? cell_count() : 1;
  check_size("friction", all.size(), each * count_);
  for (const double mu : all)
    if (!(mu >= 0 && mu <= 1e6)) throw ValueError("friction", fmt::format("{}", mu), "0 to 1e6");
  if (each > 1 && !mapped_) take_map();
  const auto input = input_.numbers.map();
  for (std::size_t c = 0; c < count_; ++c) {
    input[input_.at(c, 0, STEP_MU)] = static_cast<Real>(all[c * each]);
    for (std::size_t i = 0; mapped_ && i < cell_count(); ++i)
      input[input_.at(c, 0, STEP_INPUT_ROWS + i)] = static_cast<Real>(all[c * each + i % each]);
  }
}

template <class Real>
void PadStepper<Real>::set_heights(std::span<const double> heights, std::span<const double> cover) {
  check_size("heights", heights.size(), count_ * cell_count());
  if (!cover.empty()) check_size("cover", cover.size(), heights.size());
  put_input(STEP_BEYOND, std::vector<double>(count_, -1), std::array{1.0});
  const auto all = heights_.numbers.map(), softs = soft_.numbers.map();
  for (std::size_t c = 0; c < count_; ++c)
    put_heights(c, &heights[c * cell_count()], cover.empty() ? nullptr : &cover[c * cell_count()], all.view(),
                softs.view());
}

template <class Real>
void PadStepper<Real>::set_surface(std::size_t contact, const fem::PadSurface& surface, double beyond) {
  const auto all = heights_.numbers.map(), softs = soft_.numbers.map();
  put_heights(contact, surface.height.data(), surface.cover.data(), all.view(), softs.view());
  input_.numbers.map()[input_.at(contact, 0, STEP_BEYOND)] =
      static_cast<Real>(std::min(beyond / pad_.thickness, double{PAD_OPEN}));
}

template <class Real>
void PadStepper<Real>::set_axes(std::span<const double> axes) {
  check_size("axes", axes.size(), 2 * count_);
  const double per_H = 1 / pad_.thickness;
  put_input(STEP_AXIS_X, axes, std::array{per_H, per_H});
}

template <class Real>
std::span<const Real> PadStepper<Real>::results() const {
  if (!result_view_) result_view_ = std::make_unique<Mapping>(result_.numbers, MapFor::reading);
  return result_view_->view().first(count_ * result_.rows);
}

template <class Real>
std::span<const Real> PadStepper<Real>::made(Sums& sums) {
  if (sums.numbers.rows == 0) return {};
  if (!sums.view) {
    executor_->run(sums.launch, places_ / lanes(), {.equal_groups = true});
    sums.view = std::make_unique<Mapping>(sums.numbers.numbers, MapFor::reading);
  }
  return sums.view->view().first(count_ * sums.numbers.rows);
}

template <class Real>
std::vector<double> PadStepper<Real>::tractions() const {
  const auto all = state_.numbers.map(MapFor::reading);
  const std::size_t rows = 3 * cell_count();
  std::vector<double> made(count_ * rows);
  for (std::size_t c = 0; c < count_; ++c)
    for (std::size_t k = 0; k < rows; ++k)
      made[c * rows + k] = all[state_.at(c, 0, k)] * pad_.young / (k < cell_count() ? root_zz_ : root_tt_);
  return made;
}

template <class Real>
std::vector<double> PadStepper<Real>::poses() const {
  const auto all = state_.numbers.map(MapFor::reading);
  std::vector<double> made(4 * count_);
  for (std::size_t c = 0; c < count_; ++c)
    for (std::size_t k = 0; k < 4; ++k)
      made[4 * c + k] = static_cast<double>(all[state_.at(c, 0, STEP_FIELDS * cell_count() + STEP_POSE + k)]) *
                        (k < 3 ? pad_.thickness : 1);
  return made;
}

template <class Real>
void PadStepper<Real>::reset(std::span<const std::uint8_t> mask) {
  check_size("mask", mask.size(), count_);
  const auto all = state_.numbers.map();
  for (std::size_t c = 0; c < count_; ++c)
    for (std::size_t k = 0; k < state_.rows && mask[c] != 0; ++k) all[state_.at(c, 0, k)] = 0;
}

template <class Real>
std::vector<Real> PadStepper<Real>::state(std::span<const std::size_t> contacts) const {
  const auto all = state_.numbers.map(MapFor::reading);
  const std::size_t asked = contacts.empty() ? count_ : contacts.size();
  std::vector<Real> made;
  made.reserve(asked * state_rows());
  for (std::size_t c = 0; c < asked; ++c) {
    const std::size_t contact = contacts.empty() ? c : checked(contacts[c], count_);
    made.insert(made.end(), head_.begin(), head_.end());
    for (std::size_t k = 0; k < state_.rows; ++k) made.push_back(all[state_.at(contact, 0, k)]);
  }
  return made;
}

template <class Real>
void PadStepper<Real>::set_state(std::span<const Real> numbers, std::span<const std::size_t> contacts) {
  const std::size_t given = contacts.empty() ? count_ : contacts.size(), rows = state_rows();
  if (numbers.size() % rows == 0) check_size("state", numbers.size(), given * rows);
  for (const std::size_t contact : contacts) checked(contact, count_);
  for (std::size_t c = 0; c < given; ++c) check_state(numbers.subspan(std::min(c * rows, numbers.size())));
  check_size("state", numbers.size(), given * rows);
  const auto all = state_.numbers.map();
  for (std::size_t c = 0; c < given; ++c)
    state_.put(all.view(), contacts.empty() ? c : contacts[c],
               numbers.subspan((c + 1) * rows - state_.rows, state_.rows));
}

template <class Real>
typename PadStepper<Real>::Kept PadStepper<Real>::keep() const {
  const auto all = [](const LaneArray<Real>& array) {
    const auto numbers = array.numbers.map(MapFor::reading);
    return std::vector<Real>(numbers.view().begin(), numbers.view().end());
  };
  return {all(state_), all(result_)};
}

template <class Real>
void PadStepper<Real>::put_back(const Kept& kept, std::span<const std::uint8_t> mask) {
  if (!mask.empty()) check_size("mask", mask.size(), count_);
  forget();
  for (const auto& [array, from] : {std::pair{&state_, &kept.state}, {&result_, &kept.result}}) {
    const auto all = array->numbers.map();
    for (std::size_t c = 0; c < count_; ++c)
      for (std::size_t k = 0; k < array->rows && (mask.empty() || mask[c] == 0); ++k)
        all[array->at(c, 0, k)] = (*from)[array->at(c, 0, k)];
  }
}

template <class Real>
void PadStepper<Real>::set_dt(double dt) {
  StepOptions options = options_;
  options.dt = dt;
  check_step_options(options);
  options_ = options;
}

template <class Real>
void PadStepper<Real>::set_wide_share(double share) {
  if (wide_from_ != never_wide) step_launch_.set("wide_from", std::int32_t(std::ceil(share * cells_.count())));
}

template class PadStepper<float>;
template class PadStepper<double>;

}  // namespace tactel::host
