// SPDX-License-Identifier: Apache-2.0
#include "host/sets/hold_simulator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>

#include "fem/accuracy.h"
#include "fem/angles.h"
#include "fem/contact_laws.h"
#include "fem/pad/pad_presses.h"
#include "fem/pad/pad_solver.h"
#include "host/contact/limits.h"
#include "host/contact/pad_step.h"
#include "host/sets/held_contact.h"
#include "host/sets/transducer_chain.h"
#include "host/support/stop_scope.h"
#include "kernels/shared/pad_step_layout.h"
#include "kernels/shared/result_rows.h"

namespace tactel::host {
namespace {

constexpr int most_sweeps = 2000;  ///< of a pose: some need more than a simulator waits for

/// What a frame of a contact keeps until its rows are gathered.
struct Kept {
  HeldStep step;
  double S = 0, stick = 0, residual = 0, slid = 0, slip_path = 0;
  std::array<double, 3> net_slip{};
  int touch = 0, flags = 0;
};

struct Grip {
  std::uint64_t number = 0;  ///< in the sweep
  fem::PadScene scene;
  Hold hold;
  std::uint16_t kind = 0;
  std::vector<Kept> kept;     ///< [frames]
  std::vector<float> frames;  ///< [frames][inputs] MPa
};

struct HoldChunk : SetSimulator::Range {
  std::vector<Grip> grips;
  std::vector<float> parameters;  ///< [grips][columns]
};

StepOptions step_options(const fem::PadSensor& sensor, const SetOptions& options) {
  const double length = sensor.length.value_or(sensor.tactels[0] * sensor.pitch[0]),
               width = sensor.width.value_or(sensor.tactels[1] * sensor.pitch[1]);
  StepOptions made;
  made.cells = options.pad.cells;
  made.cell = {length / options.pad.cells, width / options.pad.cells};
  made.most_sweeps = most_sweeps;
  if (options.accept > 0) made.tolerance = options.accept / fem::slow_on_patch;
  return made;
}

double accepted_residual(const fem::PadSensor& sensor, const SetOptions& options) {
  const fem::Accuracy asked{step_options(sensor, options).tolerance, 0};
  return options.precision == Precision::fp64 ? fem::by_rule<double>(asked, fem::slow_on_patch).accept
                                              : fem::by_rule<float>(asked, fem::slow_on_patch).accept;
}

template <class Real>
Kept kept_of(std::span<const Real> row, double cell_area) {
  const auto number = [&](int k) { return static_cast<double>(row[static_cast<std::size_t>(k)]); };
  Kept kept;
  for (int k = 0; k < 4; ++k) {
    kept.step.force[static_cast<std::size_t>(k)] = number(STEP_RESULT_P + k);
    kept.step.pose[static_cast<std::size_t>(k)] = number(STEP_RESULT_DEPTH + k);
  }
  kept.S = number(STEP_RESULT_S), kept.stick = number(STEP_RESULT_STICK), kept.residual = number(STEP_RESULT_RESIDUAL);
  kept.touch = static_cast<int>(number(STEP_RESULT_TOUCH)), kept.flags = static_cast<int>(number(STEP_RESULT_FLAGS));
  kept.step.area = kept.touch * cell_area;
  for (int k = 0; k < 3; ++k) kept.step.mean[static_cast<std::size_t>(k)] = number(STEP_RESULT_MEAN + k);
  kept.step.slip = number(STEP_RESULT_SLID), kept.step.slides = kept.touch > 0 && kept.stick == 0;
  return kept;
}

class HoldSimulator final : public SetSimulator::State {
  using Range = SetSimulator::Range;

 public:
  HoldSimulator(Executor& executor, const PadSource& source, const SetOptions& options)
      : executor_(executor),
        source_(source),
        options_(options),
        parameters_(source.parameters()),
        columns_(columns_of(source)),
        accepted_(accepted_residual(source.sensors().front(), options)) {
    if (source.transducer().present())
      chain_.emplace(executor, source.transducer(), source.seed(), source.inputs(), columns_.axes,
                     source.sensors().front().tactels[1]);
  }

  std::unique_ptr<Range> prepare(std::uint64_t first, std::uint64_t count) const override;
  void run(Range& range, const RunOptions& options) const override;
  ContactSet collect(Range& range) override;

 private:
  template <class Real>
  void step(const std::vector<Grip*>& grips, const std::function<bool()>& goes_on, Range& range) const;
  std::size_t first_row(const Grip& grip) const {
    return source_.press_rows() ? 0 : static_cast<std::size_t>(grip.hold.pressing() - 1);
  }
  void put(ContactSet& set, std::size_t at, const Grip& grip, std::size_t k, int least, int outside) const;
  int outside(const Grip& grip) const;
  void measure(std::vector<Grip>& grips);

  Executor& executor_;
  const PadSource& source_;
  SetOptions options_;
  ContactParametersOf<fem::PadScene> parameters_;
  SetColumns columns_;
  double accepted_;  ///< residual of a row that is solved
  std::optional<TransducerChain> chain_;
  std::mutex chain_turn_;
};

std::unique_ptr<SetSimulator::Range> HoldSimulator::prepare(std::uint64_t first, std::uint64_t count) const {
  auto chunk = std::make_unique<HoldChunk>();
  chunk->first = first, chunk->count = count;
  const auto start = std::chrono::steady_clock::now();
  const std::size_t numbers = parameters_.columns().size();
  chunk->parameters.resize(count * numbers);
  for (std::uint64_t k = 0; k < count; ++k) {
    const auto [scene, kind] = source_.contact(first + k);
    parameters_.put(scene, kind, std::span(chunk->parameters).subspan(k * numbers, numbers));
    chunk->grips.push_back({first + k, scene, source_.hold(first + k), kind, {}, {}});
    chunk->steps += chunk->grips.back().hold.frames.size();
  }
  chunk->seconds.draw = seconds_since(start);
  return chunk;
}

/// Steps grips on one sensor that press in as many frames, frame by frame. A grip that has ended stays where it is.
template <class Real>
void HoldSimulator::step(const std::vector<Grip*>& grips, const std::function<bool()>& goes_on, Range& range) const {
  const fem::PadSensor& sensor = grips.front()->scene.sensor;
  const std::size_t count = grips.size();
  std::vector<double> friction;
  friction.reserve(count);
  for (const Grip* grip : grips) friction.push_back(grip->scene.friction);
  PadStepper<Real> steps(executor_, sensor, count, friction, step_options(sensor, options_));
  const fem::PadCells& cells = steps.cells();
  const auto field = static_cast<std::size_t>(cells.count()), inputs = static_cast<std::size_t>(columns_.inputs),
             all_inputs = 3 * steps.tactels();
  std::vector<HeldContact> held;
  std::size_t longest = 0;
  for (Grip* grip : grips) {
    held.emplace_back(grip->scene, grip->hold, cells);
    longest = std::max(longest, grip->hold.frames.size());
    grip->kept.resize(grip->hold.frames.size());
    grip->frames.resize(grip->kept.size() * inputs);
  }
  std::vector<double> heights(count * field), cover(count * field), axes(2 * count), to(4 * count);
  for (std::size_t k = 0; k < longest; ++k) {
    if (!goes_on()) return;
    for (std::size_t c = 0; c < count; ++c) {
      if (k >= grips[c]->kept.size()) continue;
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
    range.kernel_seconds += seconds_since(start);
    for (std::size_t c = 0; c < count; ++c) {
      if (k >= grips[c]->kept.size()) continue;
      Kept& kept = grips[c]->kept[k] = kept_of(results.subspan(c * STEP_RESULT_ROWS, STEP_RESULT_ROWS), cells.area());
      held[c].take(k, kept.step);
      kept.slid = held[c].slid(), kept.slip_path = held[c].slip_path();
      kept.net_slip = held[c].net_slip();
      std::transform(frames.begin() + static_cast<std::ptrdiff_t>(c * all_inputs),
                     frames.begin() + static_cast<std::ptrdiff_t>(c * all_inputs + inputs),
                     grips[c]->frames.begin() + static_cast<std::ptrdiff_t>(k * inputs),
                     [](Real stress) { return static_cast<float>(stress); });
    }
  }
  if (range.answered) *range.answered += count;
}

void HoldSimulator::run(Range& range, const RunOptions& options) const {
  auto& chunk = static_cast<HoldChunk&>(range);
  const auto start = std::chrono::steady_clock::now();
  std::map<std::pair<std::size_t, int>, std::vector<Grip*>>
      groups;  // a launch is by wrench or by motion of all contacts
  const std::vector<fem::PadSensor>& sensors = source_.sensors();
  for (Grip& grip : chunk.grips) {
    const auto sensor = static_cast<std::size_t>(std::ranges::find(sensors, grip.scene.sensor) - sensors.begin());
    groups[{sensor, grip.hold.pressing()}].push_back(&grip);
  }
  const std::function<bool()> goes_on = [&] {
    StopScope::check();
    return !options.progress || options.progress(0, chunk.grips.size());
  };
  for (const auto& [key, grips] : groups) {
    if (options_.precision == Precision::fp64)
      step<double>(grips, goes_on, range);
    else
      step<float>(grips, goes_on, range);
    if (!goes_on()) return;
  }
  range.seconds.solve = seconds_since(start);
}

/// Whether a frame becomes a row: S is defined.
bool becomes_row(const Grip& grip, std::size_t k) {
  return fem::slip_index(grip.scene.friction, grip.kept[k].step.force[0], grip.kept[k].S).has_value();
}

/// How far a grip slides as a whole in the next 0.2 s, over the elastic limit; NaN where it ends before.
double slid_ahead(const Grip& grip, std::size_t k) {
  const auto then = k + static_cast<std::size_t>(std::lround(0.2 * grip.hold.rate));
  if (!(grip.hold.rate > 0) || then >= grip.kept.size()) return std::numeric_limits<double>::quiet_NaN();
  return grip.kept[then].slid - grip.kept[k].slid;
}

int HoldSimulator::outside(const Grip& grip) const {
  const bool ends = fem::has_free_sides(grip.scene.sensor);
  const bool edge = std::ranges::any_of(grip.kept, [](const Kept& kept) { return (kept.flags & STEP_EDGE) != 0; });
  return edge && !ends ? outside_edges : 0;
}

void HoldSimulator::put(ContactSet& set, std::size_t at, const Grip& grip, std::size_t k, int least,
                        int outside) const {
  const Kept& kept = grip.kept[k];
  const auto f = [](double number) { return static_cast<float>(number); };
  const auto& [P, Qx, Qy, M] = kept.step.force;
  set.slip_index[at] = f(std::clamp(kept.S, 0.0, 1.0));
  set.normal_force[at] = f(P);
  set.tangential_force[2 * at] = f(Qx), set.tangential_force[2 * at + 1] = f(Qy);
  set.torque[at] = f(M);
  set.force_ratio[at] = f(std::hypot(Qx, Qy) / (grip.scene.friction * P));
  set.slid[at] = f(kept.slid), set.slip_path[at] = f(kept.slip_path);
  if (!set.net_slip.empty()) {
    set.net_slip[2 * at] = f(kept.net_slip[0]), set.net_slip[2 * at + 1] = f(kept.net_slip[1]);
    set.net_turn[at] = f(kept.net_slip[2]);
    set.slid_ahead[at] = f(slid_ahead(grip, k));
  }
  set.indentation[at] = f(kept.step.pose[0]);
  set.tangential[2 * at] = f(kept.step.pose[1]), set.tangential[2 * at + 1] = f(kept.step.pose[2]);
  set.twist[at] = f(fem::degrees(kept.step.pose[3]));
  set.friction[at] = f(grip.scene.friction);
  set.stick_fraction[at] = f(kept.stick);
  set.contact_nodes[at] = static_cast<std::uint16_t>(kept.touch);
  set.outside[at] = static_cast<std::uint8_t>(outside);
  set.contact[at] = grip.number;
  set.step[at] = static_cast<std::uint32_t>(k);
  set.indenter[at] = grip.kind;
  set.status[at] = static_cast<std::uint8_t>(!(kept.residual <= accepted_)     ? LANE_UNSOLVED
                                             : kept.touch < least * least      ? coarse_row
                                             : (kept.flags & STEP_SLIDES) != 0 ? LANE_SLIDING
                                                                               : LANE_SOLVED);
  set.residual[at] = f(kept.residual);
  std::copy_n(grip.frames.begin() + static_cast<std::ptrdiff_t>(k * set.inputs), set.inputs,
              set.frames.begin() + static_cast<std::ptrdiff_t>(at * set.inputs));
}

/// Readings in place of stresses.
void HoldSimulator::measure(std::vector<Grip>& grips) {
  std::vector<TransducerChain::Contact> contacts;
  std::vector<float> signal;
  for (const Grip& grip : grips) {
    contacts.push_back({grip.number, static_cast<std::uint32_t>(grip.kept.size())});
    signal.insert(signal.end(), grip.frames.begin(), grip.frames.end());
  }
  {
    const std::lock_guard turn(chain_turn_);
    chain_->run(contacts, signal);
  }
  auto reading = signal.begin();
  for (Grip& grip : grips) {
    std::copy_n(reading, grip.frames.size(), grip.frames.begin());
    reading += static_cast<std::ptrdiff_t>(grip.frames.size());
  }
}

ContactSet HoldSimulator::collect(Range& range) {
  auto& chunk = static_cast<HoldChunk&>(range);
  const auto start = std::chrono::steady_clock::now();
  ContactSet set(columns_);
  if (chain_) measure(chunk.grips);
  std::size_t rows = 0;
  for (const Grip& grip : chunk.grips)
    for (std::size_t k = first_row(grip); k < grip.kept.size(); ++k) rows += becomes_row(grip, k);
  each_dataset(set, [rows](const char*, auto& values, int columns, const char*) {
    values.resize(rows * static_cast<std::size_t>(std::max(columns, 1)));
  });
  std::size_t at = 0;
  for (const Grip& grip : chunk.grips) {
    const std::size_t first = at;
    int widest = 0;
    double deepest = 0;
    for (const Kept& kept : grip.kept)
      widest = std::max(widest, kept.touch), deepest = std::max(deepest, kept.step.pose[0]);
    const int least = fem::least_across(options_.pad.cells, static_cast<int>(std::sqrt(widest)));
    const int outside = this->outside(grip);
    for (std::size_t k = first_row(grip); k < grip.kept.size(); ++k)
      if (becomes_row(grip, k)) put(set, at++, grip, k, least, outside);
    const auto any = [&](int status) {
      return std::ranges::count(std::span(set.status).subspan(first, at - first), status);
    };
    set.unsolved += any(LANE_UNSOLVED) > 0;
    set.coarse += static_cast<std::uint64_t>(any(coarse_row));
    set.without_rows += at == first;
    set.too_deep += too_deep(grip.scene.sensor.thickness, deepest);
    set.near_edge += outside != 0;
  }
  set.contacts = chunk.count;
  set.contact_parameters = std::move(chunk.parameters);
  chunk.grips = {};
  set.indenter_names = source_.kind_names();
  set.transducer = nn::description(source_.transducer());
  set.device = executor_.device().info().name;
  set.seed = source_.seed();
  set.press_rows = source_.press_rows();
  range.seconds.gather = seconds_since(start);
  return set;
}

}  // namespace

std::unique_ptr<SetSimulator::State> hold_simulator(Executor& executor, const PadSource& source,
                                                    const SetOptions& options) {
  return std::make_unique<HoldSimulator>(executor, source, options);
}

}  // namespace tactel::host
