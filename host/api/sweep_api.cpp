// SPDX-License-Identifier: Apache-2.0
#include <tactel/sweep.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "host/answers/planner.h"
#include "host/api/conversion.h"
#include "host/scenes/ladder.h"
#include "host/scenes/sweep_file.h"
#include "host/scenes/unit_warnings.h"
#include "host/sets/set_production.h"
#include "host/sets/set_recipe.h"
#include "host/sets/set_simulator.h"
#include "host/support/errors.h"

namespace tactel {

struct Sweep::State {
  State(std::string path, host::Sweep sweep, bool as_in_file)
      : path(std::move(path)), sweep(std::move(sweep)), as_in_file(as_in_file) {}
  std::string path;
  host::Sweep sweep;
  bool as_in_file;  ///< the text is all of it
};

namespace {

std::size_t axes_of(const host::AnySource& source) {
  const auto* pads = std::get_if<host::PadSource>(&source);
  return pads ? static_cast<std::size_t>(pads->sensors().front().axes) : 2;
}

/// A sweep with its device and model, ready to simulate.
class Simulation {
 public:
  Simulation(const host::Sweep& sweep, const SweepOptions& options)
      : text_(sweep.text), source_(sweep.source), executor_(host::Device(options.device)) {
    api::check_precision(options.precision);
    host::SetOptions set;
    const std::optional<host::Rung> rung =
        std::visit([&](auto& source) { return choose_model(source, options, set); }, source_);
    if (!options.transducer) host::common(source_).measure_with({}, source().seed());
    if (options.tolerance) set.tolerance = *options.tolerance;
    set.precision = host::precision_named(options.precision, set.precision);
    rung_ = host::model_text(source_, rung, set, options.accuracy);
    plan_ = host::recipe_of(sweep, rung, set).conditions;
    simulator_ = std::make_unique<host::SetSimulator>(executor_, source_, set);
  }
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  const host::ContactSource& source() const { return host::common(source_); }
  const std::string& plan() const { return plan_; }
  /// Contacts that are simulated at once; of pads, which take seconds, fewer.
  std::uint64_t chunk() const {
    const std::uint64_t chunk = host::contacts_of_chunk(source_);
    return std::holds_alternative<host::PadSource>(source_) ? chunk / 4 : chunk;
  }
  /// A set without rows.
  Set empty_set() const {
    Set set;
    set.inputs = static_cast<std::size_t>(source().inputs()), set.axes = axes_of(source_);
    set.indenter_names = source().kind_names();
    set.sweep = text_, set.seed = source().seed();
    set.press_rows = source().press_rows();
    set.rung = rung_, set.device = executor_.device().info().name;
    set.transducer = nn::description(source().transducer());
    return set;
  }
  host::ContactSet rows(std::uint64_t first, std::uint64_t count) const { return simulator_->simulate(first, count); }

 private:
  std::optional<host::Rung> choose_model(host::SceneSource& source, const SweepOptions& options,
                                         host::SetOptions& set) {
    const SolveOptions modelling{.accuracy = options.accuracy, .rung = options.rung};
    auto rung = host::rung_for_many(
        executor_, modelling,
        {source.contacts(), [&](std::uint64_t k) { return source.contact(k).scene; }, source.own_sensors()});
    if (!rung && source.model() == fem::SurfaceModel::patch) rung = host::usual_patch();
    if (rung) model_on(*rung, source, set);
    return rung;
  }
  std::optional<host::Rung> choose_model(host::PadSource&, const SweepOptions& options, host::SetOptions& set) {
    if (options.accuracy)
      throw InputError("accuracy", std::to_string(*options.accuracy), "leave it out for a sweep of pads: give a rung");
    if (!options.rung.empty()) set.pad = host::rung_named<host::PadRung>(options.rung);
    if (set.pad.exact) throw InputError("rung", options.rung, "must be pad-8, -12, -16 or -24 for a sweep");
    if (options.tolerance) set.accept = fem::slow_on_patch * *options.tolerance;
    return {};
  }

  std::string text_, rung_, plan_;
  host::AnySource source_;
  host::Executor executor_;
  std::unique_ptr<host::SetSimulator> simulator_;
};

/// Appends the rows and counts of a set.
void append(Set& to, Set&& more) {
  const auto join = [](auto& all, const auto& part) { all.insert(all.end(), part.begin(), part.end()); };
  host::each_pair(host::set_columns(to), host::set_columns(more), join);
  join(to.parameters, more.parameters);
  to.parameter_names = std::move(more.parameter_names), to.parameter_units = std::move(more.parameter_units);
  to.tactel_x = std::move(more.tactel_x), to.tactel_y = std::move(more.tactel_y);
  to.fell_back += more.fell_back, to.unsolved += more.unsolved, to.without_rows += more.without_rows;
}

/// Throws where the rows of `all` contacts would not fit into memory, judged by those of `count`.
void check_memory(const host::ContactSet& rows, std::uint64_t count, std::uint64_t all) {
  const double bytes = static_cast<double>(rows.rows() * row_bytes(rows) + sizeof(float) * rows.parameters.size());
  const double most = host::memory_bytes() / std::max(bytes, 1.0) * static_cast<double>(count);
  if (static_cast<double>(all) > most)
    throw InputError("contacts", std::to_string(all),
                     "must be at most " + std::to_string(static_cast<std::uint64_t>(most)) +
                         ", whose rows fit into memory; batches() takes them in parts, tactel generate writes a file");
}

/// Rows of contacts first ... first + count - 1, chunk by chunk; of pads by smaller ones, as each takes seconds.
Set rows_of(const Simulation& simulation, std::uint64_t first, std::uint64_t count, const ProgressFunction& progress) {
  Set set = simulation.empty_set();
  set.contacts = count;
  const std::uint64_t chunk = simulation.chunk();
  for (std::uint64_t done = 0; done < count; done += chunk) {
    if (!progress(done, count)) throw Cancelled("sweep: cancelled by progress");
    const std::uint64_t some = std::min(chunk, count - done);
    host::ContactSet rows = simulation.rows(first + done, some);
    if (done == 0) check_memory(rows, some, count);
    append(set, api::from_host(std::move(rows)));
  }
  progress(count, count);
  return set;
}

[[noreturn]] void throw_past_end(const std::string& place, std::uint64_t asked, std::uint64_t contacts) {
  throw InputError(place, std::to_string(asked) + " contacts",
                   "must be at most " + std::to_string(contacts) + ", the scenes that this sweep lists");
}

}  // namespace

Sweep::Sweep(const std::string& path, std::optional<std::uint64_t> seed, const SensorChange& sensor)
    : state_(api::with_public_errors([&] {
        return new State(path, host::read_sweep_of_sensor(path, seed, sensor.tactels, sensor.thickness),
                         !seed && !sensor.tactels && !sensor.thickness);
      })) {}
Sweep::~Sweep() { delete state_; }
Sweep::Sweep(Sweep&& other) noexcept : state_(std::exchange(other.state_, nullptr)) {}
Sweep& Sweep::operator=(Sweep&& other) noexcept {
  std::swap(state_, other.state_);
  return *this;
}

std::string Sweep::text() const { return state_->sweep.text; }
std::uint64_t Sweep::contacts() const { return state_->sweep.contacts().contacts(); }
bool Sweep::endless() const { return state_->sweep.contacts().endless(); }
std::uint64_t Sweep::seed() const { return state_->sweep.contacts().seed(); }
std::size_t Sweep::axes() const { return axes_of(state_->sweep.source); }
std::size_t Sweep::tactels() const { return static_cast<std::size_t>(state_->sweep.contacts().inputs()) / axes(); }
std::vector<std::string> Sweep::indenter_names() const { return state_->sweep.contacts().kind_names(); }
std::vector<std::string> Sweep::warnings() const {
  return api::with_public_errors([&] { return host::unit_warnings(state_->sweep.source); }, state_->path);
}

Scene Sweep::scene(std::uint64_t k) const {
  if (!endless() && k >= contacts()) throw_past_end(state_->path, k + 1, contacts());
  return api::with_public_errors([&] { return api::from_fem(state_->sweep.lines(state_->path).contact(k).scene); },
                                 state_->path);
}
PadScene Sweep::pad_scene(std::uint64_t k) const {
  const auto* pads = std::get_if<host::PadSource>(&state_->sweep.source);
  if (!pads) throw InputError(state_->path, "a sweep of lines", "take scene(), or give a sweep of pads");
  return api::with_public_errors([&] { return api::from_fem(pads->contact(k).scene); }, state_->path);
}

std::vector<bool> Sweep::numbers() const {
  return std::visit([](const auto& source) { return source.numbers(); }, state_->sweep.source);
}
Sweep Sweep::of_quantiles(std::span<const double> quantiles) const {
  if (!endless()) throw InputError(state_->path, "a listed set", "a sweep that draws its contacts (sweep.contacts)");
  const std::size_t count = numbers().size();
  if (quantiles.empty() || quantiles.size() % count != 0)
    throw InputError("quantiles", std::to_string(quantiles.size()) + " of them",
                     "give " + std::to_string(count) + " for each contact");
  if (!std::ranges::all_of(quantiles, [](double u) { return u >= 0 && u < 1; }))
    throw InputError("quantiles", "one that is NaN, below 0, 1 or above", "give numbers in [0, 1)");
  auto source = std::visit([&](const auto& drawn) { return host::AnySource(drawn.of_quantiles(quantiles)); },
                           state_->sweep.source);
  return Sweep(new State{state_->path, host::Sweep{state_->sweep.text, std::move(source)}, false});
}

Set Sweep::generate(std::optional<std::uint64_t> contacts, const SweepOptions& options,
                    const ProgressFunction& progress) const {
  const std::uint64_t count = contacts.value_or(this->contacts());
  if (!endless() && count > this->contacts()) throw_past_end(state_->path, count, this->contacts());
  return api::with_public_errors(
      [&] {
        const Simulation simulation(state_->sweep, options);
        Set set = rows_of(simulation, 0, count, progress);
        if (state_->as_in_file && count == this->contacts() && options.transducer) set.plan = simulation.plan();
        return set;
      },
      state_->path);
}

struct SweepBatches::State {
  State(const Sweep::State& sweep, std::uint64_t contacts, const SweepOptions& options, std::uint64_t first)
      : path(sweep.path), simulation(sweep.sweep, options), batch(contacts), next(first) {}
  std::string path;
  Simulation simulation;
  std::uint64_t batch, next;
};

SweepBatches::SweepBatches(const Sweep& sweep, std::uint64_t contacts, const SweepOptions& options, std::uint64_t first)
    : state_(nullptr) {
  if (contacts == 0) throw InputError("contacts", "0", "must be at least 1 a batch");
  state_ =
      api::with_public_errors([&] { return new State(*sweep.state_, contacts, options, first); }, sweep.state_->path);
}
SweepBatches::~SweepBatches() { delete state_; }
SweepBatches::SweepBatches(SweepBatches&& other) noexcept : state_(std::exchange(other.state_, nullptr)) {}
SweepBatches& SweepBatches::operator=(SweepBatches&& other) noexcept {
  std::swap(state_, other.state_);
  return *this;
}

bool SweepBatches::next(Set& rows) {
  const host::ContactSource& source = state_->simulation.source();
  std::uint64_t count = state_->batch;
  if (!source.endless()) count = std::min(count, source.contacts() - std::min(state_->next, source.contacts()));
  if (count == 0) return false;
  rows = api::with_public_errors([&] { return rows_of(state_->simulation, state_->next, count, {}); }, state_->path);
  state_->next += count;
  return true;
}

}  // namespace tactel
