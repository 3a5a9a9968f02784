// SPDX-License-Identifier: Apache-2.0
#include "host/sets/held_contacts.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "fem/gap/accuracy.h"
#include "fem/pad/pad_markers.h"
#include "host/contact/limits.h"
#include "host/contact/pads/pad_step.h"
#include "host/scenes/scene_source.h"
#include "host/support/seconds.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/pad_step_layout.h"

namespace tactel::host {
namespace {

constexpr int most_sweeps = 2000;  ///< of a pose: some need more than a simulator waits for
constexpr double ahead = 0.2;      ///< s

StepOptions step_options(const fem::PadSensor& sensor, const HeldModel& model) {
  const double length = sensor.length.value_or(sensor.tactels[0] * sensor.pitch[0]),
               width = sensor.width.value_or(sensor.tactels[1] * sensor.pitch[1]);
  StepOptions made;
  made.cells = model.cells;
  made.cell = {length / model.cells, width / model.cells};
  made.most_sweeps = most_sweeps;
  if (model.accept > 0) made.tolerance = model.accept / fem::slow_on_patch;
  made.markers = model.markers;
  return made;
}

/// What a result of the stepper says of the contact.
template <class Real>
HeldStep held_step(std::span<const Real> result, double cell_area) {
  HeldStep step;
  std::copy_n(&result[STEP_RESULT_P], 4, step.force.begin());
  std::copy_n(&result[STEP_RESULT_DEPTH], 4, step.pose.begin());
  std::copy_n(&result[STEP_RESULT_MEAN], 3, step.mean.begin());
  step.area = static_cast<int>(result[STEP_RESULT_TOUCH]) * cell_area;
  step.slip = result[STEP_RESULT_SLID];
  step.slides = result[STEP_RESULT_TOUCH] > 0 && result[STEP_RESULT_STICK] == 0;
  return step;
}

/// Grips on one sensor that press in as many frames, frame by frame. A grip that has ended stays where it is.
template <class Real>
class HeldLaunch final : public ContactLaunch<HeldContacts> {
 public:
  HeldLaunch(Executor& executor, const fem::PadSensor& sensor, const HeldModel& model)
      : executor_(executor),
        sensor_(sensor),
        options_(step_options(sensor, model)),
        accept_(fem::by_rule<Real>({options_.tolerance, 0}, fem::slow_on_patch).accept),
        inputs_(static_cast<std::size_t>(inputs_of(sensor))),
        numbers_(inputs_ + 3 * fem::marker_count(model.markers)) {}
  void add(const HeldScene& scene, const HeldContacts::Path&) override { grips_.push_back({scene, {}, {}}); }
  void lay_out() override {}
  void run(const RunOptions& options) override;
  void open() override {}
  LaneAnswer answer(std::size_t i) const override {
    return {static_cast<int>(grips_[i].frames()),
            {grips_[i].results.data(), HELD_RESULT_ROWS, true},
            {grips_[i].stresses.data(), numbers_, false}};
  }
  std::span<const std::size_t> by_lane() const override { return {}; }
  std::size_t steps() const override {
    std::size_t all = 0;
    for (const Grip& grip : grips_) all += grip.frames();
    return all;
  }
  std::size_t most_lane_steps() const override { return std::numeric_limits<std::size_t>::max(); }
  double seconds() const override { return seconds_; }

 private:
  struct Grip {
    HeldScene scene;
    std::vector<double> results;  ///< [frames][HELD_RESULT_ROWS]
    std::vector<float> stresses;  ///< [frames][inputs] MPa, then of markers [z, x, y][markers] mm
    std::size_t frames() const { return scene.hold.frames.size(); }
  };
  void put(std::span<const Real> result, const HeldStep& step, const HeldContact& held, std::span<double> row) const;

  Executor& executor_;
  fem::PadSensor sensor_;
  StepOptions options_;
  double accept_;                 ///< residual of a frame that is solved
  std::size_t inputs_, numbers_;  ///< of a frame; with those of markers
  std::vector<Grip> grips_;
  double seconds_ = 0;
};

template <class Real>
void HeldLaunch<Real>::run(const RunOptions& options) {
  const std::size_t count = grips_.size();
  std::vector<double> friction;
  for (const Grip& grip : grips_) friction.push_back(grip.scene.friction);
  PadStepper<Real> steps(executor_, sensor_, count, friction, options_);
  if (!sensor_.relaxation.empty()) steps.set_dt(1 / grips_.front().scene.hold.rate);
  const fem::PadCells& cells = steps.cells();
  const auto field = static_cast<std::size_t>(cells.count()), all_inputs = 3 * steps.tactels();
  std::vector<HeldContact> held;
  std::size_t longest = 0;
  for (Grip& grip : grips_) {
    held.emplace_back(grip.scene, grip.scene.hold, cells);
    longest = std::max(longest, grip.frames());
    grip.results.resize(grip.frames() * HELD_RESULT_ROWS);
    grip.stresses.resize(grip.frames() * numbers_);
  }
  std::vector<double> heights(count * field), cover(count * field), axes(2 * count), to(4 * count);
  for (std::size_t k = 0; k < longest; ++k) {
    StopScope::check();
    if (options.progress && !options.progress(0, count)) return;
    for (std::size_t c = 0; c < count; ++c) {
      if (k >= grips_[c].frames()) continue;
      std::array<double, 2> axis{};
      const auto target = held[c].ask(k, std::span(heights).subspan(c * field, field),
                                      std::span(cover).subspan(c * field, field), axis);
      std::ranges::copy(target, to.begin() + static_cast<std::ptrdiff_t>(4 * c));
      std::ranges::copy(axis, axes.begin() + static_cast<std::ptrdiff_t>(2 * c));
    }
    const auto start = std::chrono::steady_clock::now();
    steps.set_heights(std::span<const double>(heights), std::span<const double>(cover));
    steps.set_axes(axes);
    if (held.front().by_wrench(k))
      steps.press(to);
    else
      steps.move(to);
    const auto results = steps.results();
    const auto frames = steps.frames();
    const auto markers = steps.markers();
    const std::size_t marker_count = (numbers_ - inputs_) / 3;
    seconds_ += seconds_since(start);
    for (std::size_t c = 0; c < count; ++c) {
      Grip& grip = grips_[c];
      if (k >= grip.frames()) continue;
      const auto result = results.subspan(c * STEP_RESULT_ROWS, STEP_RESULT_ROWS);
      const HeldStep step = held_step(result, cells.area());
      held[c].take(k, step);
      put(result, step, held[c], std::span(grip.results).subspan(k * HELD_RESULT_ROWS, HELD_RESULT_ROWS));
      const auto all = std::span(grip.stresses).subspan(k * numbers_, numbers_);
      std::ranges::transform(frames.subspan(c * all_inputs, inputs_), all.begin(),
                             [](Real stress) { return static_cast<float>(stress); });
      for (std::size_t u = 0; u < 3 * marker_count; ++u)  // [z, x, y][markers]
        all[inputs_ + (u + 1) % 3 * marker_count + u / 3] = static_cast<float>(markers[3 * marker_count * c + u]);
    }
  }
  for (Grip& grip : grips_) {
    const double rate = grip.scene.hold.rate;
    const auto then = static_cast<std::size_t>(std::lround(ahead * rate));
    const auto row = [&](std::size_t k, int number) -> double& { return grip.results[k * HELD_RESULT_ROWS + number]; };
    for (std::size_t k = 0; k < grip.frames(); ++k)
      row(k, HELD_SLID_AHEAD) = rate > 0 && k + then < grip.frames()
                                    ? row(k + then, PAD_RESULT_SLID) - row(k, PAD_RESULT_SLID)
                                    : std::numeric_limits<double>::quiet_NaN();
  }
}

template <class Real>
void HeldLaunch<Real>::put(std::span<const Real> result, const HeldStep& step, const HeldContact& held,
                           std::span<double> row) const {
  const int flags = static_cast<int>(result[STEP_RESULT_FLAGS]);
  const double touch = result[STEP_RESULT_TOUCH], residual = result[STEP_RESULT_RESIDUAL];
  row[RESULT_P] = step.force[0], row[PAD_RESULT_M] = step.force[3];
  row[PAD_RESULT_QX] = step.force[1], row[PAD_RESULT_QY] = step.force[2];
  row[RESULT_DEPTH] = step.pose[0], row[HELD_TWIST] = step.pose[3];
  row[HELD_X] = step.pose[1], row[HELD_Y] = step.pose[2];
  row[RESULT_S] = std::clamp<double>(result[STEP_RESULT_S], 0, 1);
  row[RESULT_SLIPPING] = touch, row[HELD_STICK] = result[STEP_RESULT_STICK];
  row[PAD_RESULT_ACROSS] = std::floor(std::sqrt(touch)), row[PAD_RESULT_AREA] = step.area;
  row[RESULT_PENETRATION] = residual;
  row[RESULT_STATUS] = !(residual <= accept_) ? LANE_UNSOLVED : flags & STEP_SLIDES ? LANE_SLIDING : LANE_SOLVED;
  row[PAD_RESULT_SLID] = held.slid(), row[PAD_RESULT_SLIP_PATH] = held.slip_path();
  std::ranges::copy(held.net_slip(), &row[HELD_NET_X]);
  row[HELD_OUTSIDE] = flags & STEP_EDGE && !fem::has_free_sides(sensor_) ? outside_edges : 0;
}

template <class Real>
class OnHeldPads final : public SensorSolver<HeldContacts> {
 public:
  OnHeldPads(Executor& executor, const fem::PadSensor& sensor, const HeldModel& model)
      : executor_(executor), sensor_(sensor), model_(model) {}
  std::unique_ptr<ContactLaunch<HeldContacts>> launch() const override {
    return std::make_unique<HeldLaunch<Real>>(executor_, sensor_, model_);
  }
  bool holds(const LaneAnswer&) const override { return true; }
  std::vector<fem::PadSolution> solve(std::span<const HeldScene>, std::span<const LaneAnswer>) const override {
    throw std::logic_error("no grip is solved again");
  }

 private:
  Executor& executor_;
  fem::PadSensor sensor_;
  HeldModel model_;
};

}  // namespace

HeldKey HeldContacts::key(const fem::PadSensor& sensor, ContactKind) const {
  return {static_cast<std::size_t>(std::ranges::find(model_.sensors, sensor) - model_.sensors.begin()), 0};
}

std::shared_ptr<const SensorSolver<HeldContacts>> HeldContacts::solver(const fem::PadSensor& sensor) const {
  if (model_.precision == Precision::fp64) return std::make_shared<OnHeldPads<double>>(executor_, sensor, model_);
  return std::make_shared<OnHeldPads<float>>(executor_, sensor, model_);
}

}  // namespace tactel::host
