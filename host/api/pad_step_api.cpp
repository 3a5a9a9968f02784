// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tactel/pad_step.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "fem/numbers/angles.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/side_kernel.h"
#include "host/api/conversion.h"
#include "host/contact/pads/pad_step.h"
#include "host/support/errors.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/pad_step_layout.h"

namespace tactel {
struct PadStepper::State {
  /// Calls function with the stepper of the precision.
  template <class Function>
  auto with(const Function& function) {
    if (auto* stepper = std::get_if<host::PadStepper<double>>(&steps)) return function(*stepper);
    return function(std::get<host::PadStepper<float>>(steps));
  }

  State(const Pad& given, std::size_t count, std::span<const double> friction, const StepOptions& options)
      : executor(host::Device(options.device)), pad(with_layers(given)), count(count), rubber(fem::rubber_of(pad)) {
    host::in_precision(host::precision_named(options.precision), [&]<class Real>() {
      steps.emplace<host::PadStepper<Real>>(executor, pad, count, friction, options);
    });
    with([&](auto& stepper) { cells = stepper.cells(), tactels = stepper.tactels(); });
    places.resize(3 * count);
  }

  void put_shapes(std::span<const double> pose);
  template <class Step>
  void step(const Step& step, std::span<const std::uint8_t> mask = {});
  void take_answer();
  std::span<const float> sums(const auto& get, std::vector<float>& own);

  host::Executor executor;
  Pad pad;
  std::size_t count, tactels = 0;
  fem::PadCells cells;
  fem::PadBox rubber;
  std::variant<std::monostate, host::PadStepper<float>, host::PadStepper<double>> steps;
  std::vector<fem::PadIndenter> indenters;  ///< one, or [count]; empty: gaps
  std::vector<double> places;               ///< [count][3]
  std::vector<double> put;                  ///< [count][3] places whose heights the device has; empty: none
  std::vector<double> depths;               ///< [count] of gaps
  StepAnswer answer;
  std::vector<float> frames, displacements;  ///< of fp64
};

/// Heights of the shapes where they lie, moved by x, y and twist of the pose.
void PadStepper::State::put_shapes(std::span<const double> pose) {
  if (indenters.empty()) return;
  std::vector<double> axes(2 * count), now(3 * count);
  const bool known = put.size() == now.size();
  with([&](auto& stepper) {
    for (std::size_t c = 0; c < count; ++c) {
      for (std::size_t k = 0; k < 3; ++k) now[3 * c + k] = places[3 * c + k] + (pose.empty() ? 0 : pose[4 * c + 1 + k]);
      axes[2 * c] = now[3 * c], axes[2 * c + 1] = now[3 * c + 1];
      if (known && std::equal(&now[3 * c], &now[3 * c] + 3, &put[3 * c])) continue;
      const fem::PadIndenter& indenter = indenters[indenters.size() == 1 ? 0 : c];
      const std::array place{now[3 * c], now[3 * c + 1]};
      fem::PadSurface surface = fem::pad_surface(cells, indenter, place, now[3 * c + 2], stepper.of_means());
      fem::add_skin(pad, cells, surface.height);
      const double beyond = fem::height_beyond(cells, indenter, place, now[3 * c + 2], rubber);
      stepper.set_surface(c, surface,
                          beyond + fem::fall_of_skin(pad, std::min(cells.x(cells.n), cells.y(cells.ny())), 0));
    }
    stepper.set_axes(axes);
  });
  put = std::move(now);
}

/// Calls step(stepper) and takes its answers. Contacts where the mask is 0 get their states and answers back, and all
/// do where the step is cancelled. A step of few contacts is over too soon for that.
template <class Step>
void PadStepper::State::step(const Step& step, std::span<const std::uint8_t> mask) {
  constexpr std::size_t few = 256;
  const host::StopScope scope(count >= few ? host::StopScope::current() : nullptr);
  with([&](auto& stepper) {
    if (mask.empty() && !host::StopScope::current()) return step(stepper);
    const auto kept = stepper.keep();
    try {
      step(stepper);
    } catch (const Stopped&) {
      stepper.put_back(kept);
      throw;
    }
    if (!mask.empty()) stepper.put_back(kept, mask);
  });
  take_answer();
}

void PadStepper::State::take_answer() {
  with([&](auto& stepper) {
    const auto rows = stepper.results();
    const auto number = [&](std::size_t c, int row) {
      return static_cast<float>(rows[c * STEP_RESULT_ROWS + static_cast<std::size_t>(row)]);
    };
    const auto take = [&](auto& to, int row) {
      to.resize(count);
      for (std::size_t c = 0; c < count; ++c) to[c] = static_cast<std::remove_cvref_t<decltype(to[c])>>(number(c, row));
    };
    answer.force.resize(4 * count), answer.pose.resize(4 * count);
    for (std::size_t c = 0; c < count; ++c) {
      for (int k = 0; k < 4; ++k) {
        answer.force[4 * c + static_cast<std::size_t>(k)] = number(c, STEP_RESULT_P + k);
        answer.pose[4 * c + static_cast<std::size_t>(k)] = number(c, STEP_RESULT_DEPTH + k);
      }
      answer.pose[4 * c + 3] = static_cast<float>(fem::degrees(static_cast<double>(number(c, STEP_RESULT_TWIST))));
    }
    take(answer.slip_index, STEP_RESULT_S), take(answer.stick_fraction, STEP_RESULT_STICK);
    take(answer.flags, STEP_RESULT_FLAGS), take(answer.residual, STEP_RESULT_RESIDUAL);
    take(answer.solves, STEP_RESULT_SOLVES), take(answer.sweeps, STEP_RESULT_SWEEPS);
  });
}

PadStepper::PadStepper(const Pad& pad, std::size_t count, std::span<const double> friction, const StepOptions& options)
    : state_(api::with_public_errors([&] {
        api::check_precision(options.precision);
        return new State(pad, count, friction, options);
      })) {}
PadStepper::~PadStepper() { delete state_; }
PadStepper::PadStepper(PadStepper&& other) noexcept : state_(std::exchange(other.state_, nullptr)) {}
PadStepper& PadStepper::operator=(PadStepper&& other) noexcept {
  std::swap(state_, other.state_);
  return *this;
}

std::size_t PadStepper::count() const { return state_->count; }
std::size_t PadStepper::tactels() const { return state_->tactels; }
std::string PadStepper::device() const { return state_->executor.device().info().name; }
const StepOptions& PadStepper::options() const {
  return *state_->with([](auto& stepper) { return &stepper.options(); });
}

std::vector<double> PadStepper::cell_x() const {
  std::vector<double> all;
  all.reserve(static_cast<std::size_t>(state_->cells.count()));
  for (int i = 0; i < state_->cells.count(); ++i) all.push_back(state_->cells.x(i / state_->cells.ny()));
  return all;
}
std::vector<double> PadStepper::cell_y() const {
  std::vector<double> all;
  all.reserve(static_cast<std::size_t>(state_->cells.count()));
  for (int i = 0; i < state_->cells.count(); ++i) all.push_back(state_->cells.y(i % state_->cells.ny()));
  return all;
}

void PadStepper::set_dt(double dt) {
  api::with_public_errors([&] { state_->with([&](auto& stepper) { stepper.set_dt(dt); }); });
}

void PadStepper::set_friction(std::span<const double> friction) {
  api::with_public_errors([&] { state_->with([&](auto& stepper) { stepper.set_friction(friction); }); });
}

void PadStepper::set_shapes(std::span<const PadIndenter> indenters) {
  State& s = *state_;
  api::with_public_errors([&] {
    if (indenters.size() != 1 && indenters.size() != s.count)
      throw ValueError("shapes", std::to_string(indenters.size()), fmt::format("1 or {}", s.count));
    std::vector<fem::PadIndenter> made;
    for (const PadIndenter& indenter : indenters) {
      PadScene scene;
      scene.indenter = indenter;
      made.push_back(api::to_fem(scene).indenter);
      made.back().validate();
      if (indenter.young)
        throw ValueError("shapes.young", fmt::format("{}", *indenter.young),
                         "left out: StepOptions::object_young, PadStepper(object_young=) is that of all objects");
    }
    for (std::size_t c = 0; c < s.count; ++c) {
      const fem::PadIndenter& own = made[made.size() == 1 ? 0 : c];
      s.places[3 * c] = own.position[0], s.places[3 * c + 1] = own.position[1], s.places[3 * c + 2] = 0;
    }
    s.indenters = std::move(made);
    s.put.clear(), s.depths.clear();
  });
}

void PadStepper::set_places(std::span<const double> places) {
  api::with_public_errors([&] {
    host::check_size("places", places.size(), 3 * state_->count);
    for (const double number : places)
      if (!std::isfinite(number)) throw ValueError("places", fmt::format("{}", number), "finite");
    state_->places.assign(places.begin(), places.end());
  });
}

void PadStepper::set_gaps(std::span<const float> gaps, std::span<const float> cover) {
  State& s = *state_;
  api::with_public_errors([&] {
    const auto cells = static_cast<std::size_t>(s.cells.count());
    host::check_size("gaps", gaps.size(), s.count * cells);
    if (!cover.empty()) host::check_size("cover", cover.size(), gaps.size());
    std::vector<double> heights(gaps.begin(), gaps.end()), covers(cover.begin(), cover.end());
    s.depths.assign(s.count, 0);
    for (std::size_t c = 0; c < s.count; ++c) {
      double lowest = std::numeric_limits<double>::infinity();
      for (std::size_t i = c * cells; i < (c + 1) * cells; ++i)
        if (covers.empty() || covers[i] > 0) lowest = std::min(lowest, heights[i]);
      if (!std::isfinite(lowest)) lowest = 0;
      s.depths[c] = -lowest;
      for (std::size_t i = c * cells; i < (c + 1) * cells; ++i) heights[i] -= lowest;
    }
    s.with([&](auto& stepper) {
      stepper.set_heights(std::span<const double>(heights), std::span<const double>(covers));
      stepper.set_axes(std::vector<double>(2 * s.count));
    });
    s.indenters.clear(), s.put.clear();
  });
}

const StepAnswer& PadStepper::move(std::span<const double> pose, bool travel) {
  State& s = *state_;
  api::with_public_errors([&] {
    host::check_size("pose", pose.size(), 4 * s.count);
    s.put_shapes(travel ? pose : std::span<const double>());
    std::vector<double> to(pose.begin(), pose.end());
    for (std::size_t c = 0; c < s.count; ++c) to[4 * c + 3] = fem::radians(to[4 * c + 3]);
    s.step([&](auto& stepper) { stepper.move(to); });
  });
  return s.answer;
}

const StepAnswer& PadStepper::move_by(std::span<const double> motion) {
  State& s = *state_;
  api::with_public_errors([&] {
    host::check_size("motion", motion.size(), 3 * s.count);
    if (s.depths.empty()) throw ValueError("gaps", "none", "given before a motion");
    std::vector<double> to(4 * s.count);
    s.step([&](auto& stepper) {
      const std::vector<double> from = stepper.poses();
      for (std::size_t c = 0; c < s.count; ++c) {
        to[4 * c] = s.depths[c];
        for (std::size_t k = 0; k < 2; ++k) to[4 * c + 1 + k] = from[4 * c + 1 + k] + motion[3 * c + k];
        to[4 * c + 3] = from[4 * c + 3] + fem::radians(motion[3 * c + 2]);
      }
      stepper.move(to);
    });
  });
  return s.answer;
}

const StepAnswer& PadStepper::press(std::span<const double> wrench, std::span<const std::uint8_t> mask) {
  State& s = *state_;
  api::with_public_errors([&] {
    host::check_size("wrench", wrench.size(), 4 * s.count);
    if (!mask.empty()) host::check_size("mask", mask.size(), s.count);
    s.put_shapes({});
    std::vector<double> to(wrench.begin(), wrench.end());
    for (std::size_t c = 0; c < mask.size(); ++c)
      if (mask[c] == 0) std::fill_n(to.begin() + static_cast<std::ptrdiff_t>(4 * c), 4, 0.0);  // open: soon done
    s.step([&](auto& stepper) { stepper.press(to); }, mask);
  });
  return s.answer;
}

const StepAnswer& PadStepper::answer() const { return state_->answer; }

/// Sums of the stepper; those of fp64 are kept in `own`.
std::span<const float> PadStepper::State::sums(const auto& get, std::vector<float>& own) {
  return api::with_public_errors([&]() -> std::span<const float> {
    if (auto* stepper = std::get_if<host::PadStepper<float>>(&steps)) return get(*stepper);
    const auto all = get(std::get<host::PadStepper<double>>(steps));
    own.assign(all.begin(), all.end());
    return own;
  });
}

std::span<const float> PadStepper::frames() {
  return state_->sums([](auto& stepper) { return stepper.frames(); }, state_->frames);
}

std::span<const float> PadStepper::markers() {
  return state_->sums([](auto& stepper) { return stepper.markers(); }, state_->displacements);
}

std::vector<float> PadStepper::pixels() {
  const StepOptions& given = options();
  if (!given.camera) return {};
  const std::span<const float> all = markers();
  const Eigen::MatrixX3d u = Eigen::Map<const Eigen::Matrix<float, 3, Eigen::Dynamic>>(
                                 all.data(), 3, static_cast<Eigen::Index>(all.size() / 3))
                                 .transpose()
                                 .cast<double>();
  const Eigen::Matrix2Xf seen = fem::pixels_of(*given.camera, *given.markers, u).transpose().cast<float>();
  return {seen.data(), seen.data() + seen.size()};
}

std::vector<double> PadStepper::tractions() const {
  return api::with_public_errors([&] { return state_->with([](auto& stepper) { return stepper.tractions(); }); });
}

void PadStepper::reset() {
  api::with_public_errors([&] { state_->with([](auto& stepper) { stepper.reset(); }); });
}
void PadStepper::reset(std::span<const std::uint8_t> mask) {
  api::with_public_errors([&] { state_->with([&](auto& stepper) { stepper.reset(mask); }); });
}

std::size_t PadStepper::state_size() const {
  return state_->with([](auto& stepper) { return stepper.state_rows(); });
}
std::vector<double> PadStepper::state(std::span<const std::size_t> contacts) const {
  return api::with_public_errors([&] {
    return state_->with([&](auto& stepper) {
      const auto all = stepper.state(contacts);
      return std::vector<double>(all.begin(), all.end());
    });
  });
}
void PadStepper::set_state(std::span<const double> state, std::span<const std::size_t> contacts) {
  api::with_public_errors([&] {
    if (auto* stepper = std::get_if<host::PadStepper<float>>(&state_->steps))
      stepper->set_state(std::vector<float>(state.begin(), state.end()), contacts);
    else
      std::get<host::PadStepper<double>>(state_->steps).set_state(state, contacts);
  });
}

}  // namespace tactel
