// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fem/numbers/last_used.h"
#include "host/contact/contact_batch.h"
#include "host/contact/lines/sensor_tables.h"
#include "host/device/executor.h"

namespace tactel::host {

/// Returns the scenes of a launch among many: 8192 on a processor; on a GPU 128 for each compute unit, where that is
/// more.
inline std::size_t scenes_of_a_part(const DeviceInfo& device) {
  const std::size_t least = 8192, each_unit = 128;
  return device.type == DeviceType::cpu ? least
                                        : std::max(least, each_unit * static_cast<std::size_t>(device.compute_units));
}

/// Scenes of one launch: they are added, laid out in lanes, run and read.
template <class Kind>
class ContactLaunch {
 public:
  virtual ~ContactLaunch() = default;
  virtual void add(const typename Kind::Scene& scene, const typename Kind::Path& path) = 0;
  virtual void lay_out() = 0;
  virtual void run(const RunOptions& options) = 0;
  virtual void open() = 0;                                   ///< for reading, until the launch ends
  virtual LaneAnswer answer(std::size_t i) const = 0;        ///< of scene i, in the order of add()
  virtual std::span<const std::size_t> by_lane() const = 0;  ///< scenes in the order of memory
  virtual std::size_t steps() const = 0;                     ///< load steps of all scenes
  /// Lanes times load steps, at most: some 60 MB of results.
  virtual std::size_t most_lane_steps() const { return std::size_t{1} << 18; }
  virtual double seconds() const = 0;  ///< of the run
};

/// The launch of a kernel's launcher, which has Scenes, a Batch and prepare() (GapSweep, PatchContact,
/// PadContact).
template <class Kind, class Launcher>
class LaunchOf final : public ContactLaunch<Kind> {
 public:
  explicit LaunchOf(const Launcher& launcher) : launcher_(launcher), scenes_(launcher) {}
  void add(const typename Kind::Scene& scene, const typename Kind::Path& path) override {
    scenes_.push_back(scene, path);
  }
  void lay_out() override {
    if constexpr (requires { launcher_.prepare(std::move(scenes_), false); })
      batch_.emplace(launcher_.prepare(std::move(scenes_), false));  // without forces of elements
    else
      batch_.emplace(launcher_.prepare(std::move(scenes_)));
  }
  void run(const RunOptions& options) override { batch_->run(options); }
  void open() override { view_.emplace(*batch_); }
  LaneAnswer answer(std::size_t i) const override { return view_->answer(i); }
  std::span<const std::size_t> by_lane() const override { return view_->by_lane(); }
  std::size_t steps() const override { return batch_->steps_in_all(); }
  std::size_t most_lane_steps() const override {
    if constexpr (requires { launcher_.most_lane_steps(scenes_); }) return launcher_.most_lane_steps(scenes_);
    return ContactLaunch<Kind>::most_lane_steps();
  }
  double seconds() const override { return batch_->seconds(); }

 private:
  Launcher launcher_;
  typename Launcher::Scenes scenes_;
  std::optional<typename Launcher::Batch> batch_;
  std::optional<typename Launcher::Batch::View> view_;
};

/// A model of contact on one sensor: its launches, the worth of their answers, and the way back.
template <class Kind>
class SensorSolver {
 public:
  using Scene = typename Kind::Scene;
  virtual ~SensorSolver() = default;
  virtual std::unique_ptr<ContactLaunch<Kind>> launch() const = 0;
  /// Returns true where the certificate of an answer holds.
  virtual bool holds(const LaneAnswer& answer) const = 0;
  /// Solves scenes with all their forces, and by other means what the kernel does not solve. `known`: the answers of a
  /// launch, which do not hold; empty: there was none.
  virtual std::vector<typename Kind::Solution> solve(std::span<const Scene> scenes,
                                                     std::span<const LaneAnswer> known) const = 0;
};

/// A kind of contact, as StreamOf takes it: LineContacts (contact_stream.h), PadContacts (pad_stream.h), HeldContacts
/// (host/sets/held_contacts.h).
template <class Kind>
concept Contacts = requires {
  typename Kind::Scene;     // one contact: validate() throws ValueError, `sensor` is its Sensor
  typename Kind::Sensor;    // what tables are made of
  typename Kind::Path;      // the load of a scene: `steps`
  typename Kind::Solution;  // an answer with all its forces
  typename Kind::Model;     // how contacts are solved
  typename Kind::Key;       // what scenes of one launch have in common; `sensor`: of their sensors alone
}
&&std::constructible_from<Kind, Executor&, typename Kind::Model>&& std::totally_ordered<typename Kind::Key>&& requires(
    const Kind& kind, const typename Kind::Scene& scene, const typename Kind::Sensor& sensor,
    std::span<const typename Kind::Scene> scenes, std::vector<typename Kind::Solution>& solutions) {
  scene.validate();
  { kind.key(scene) } -> std::same_as<typename Kind::Key>;
  { kind.key(scene.sensor, ContactKind{}) } -> std::same_as<typename Kind::Key>;  // of a sensor's tables
  { Kind::path(scene) } -> std::same_as<typename Kind::Path>;
  { Kind::path(scene).steps.size() } -> std::convertible_to<std::size_t>;
  // Launches on a sensor, what their certificates are worth, and the way back of what does not hold.
  { kind.solver(sensor) } -> std::same_as<std::shared_ptr<const SensorSolver<Kind>>>;
  kind.finish(scenes, solutions);  // solves by other means what all solvers left unsolved
  // Steps of an answer that are coarse on the cells of the others, and the scene that has such a step alone.
  { kind.coarse(scene, std::declval<const LaneAnswer&>()) } -> std::same_as<std::vector<std::size_t>>;
  { kind.alone(scene, std::size_t{}) } -> std::same_as<typename Kind::Scene>;
};

/// Scenes in, answers to a sink. The stream groups scenes by launch, lays them out, launches them beside the ones
/// before, checks certificates, and solves again what does not hold. Answers depend on their scene alone. Threads may
/// use one stream at once.
template <class Kind>
class StreamOf {
  static_assert(Contacts<Kind>);

 public:
  using Scene = typename Kind::Scene;
  using Sensor = typename Kind::Sensor;
  using Solution = typename Kind::Solution;
  using Key = typename Kind::Key;
  using Solver = SensorSolver<Kind>;
  /// Steps of an answer that were solved alone, which stand in place of its own.
  using Alone = std::map<std::size_t, Solution>;
  /// Takes the answer of scene i in place.
  using LaneSink = std::function<void(std::size_t i, const LaneAnswer& answer, Alone&& alone)>;
  /// Returns the steps of the answer of scene i in place that are solved alone.
  using CoarseSteps = std::function<std::vector<std::size_t>(std::size_t i, const LaneAnswer& answer)>;
  /// Takes the answer of a scene that was solved again.
  using SolutionSink = std::function<void(std::size_t i, Solution&& solution)>;

  StreamOf(Executor& executor, typename Kind::Model model)
      : executor_(executor), contacts_(executor, std::move(model)) {}

  /// Makes the tables of these sensors beforehand, on all threads, and keeps them.
  void keep(std::span<const Sensor> sensors) {
    std::map<decltype(Key::sensor), const Sensor*> distinct;
    for (const Sensor& sensor : sensors) distinct.try_emplace(contacts_.key(sensor, {}).sensor, &sensor);
    const std::vector<std::pair<decltype(Key::sensor), const Sensor*>> all(distinct.begin(), distinct.end());
    kept_.keep_at_least(all.size());
    make_tables(executor_, all.size(), [&](std::size_t k) {
      auto made = contacts_.solver(*all[k].second);
      made->launch();  // which makes what launches need
      kept_.get(all[k].first, [&] { return made; });
    });
  }

  /// Scenes of a part of the stream, in its launches.
  class Part {
   public:
    std::size_t size() const { return places_.size(); }
    std::size_t steps() const {  ///< load steps of all scenes
      std::size_t all = 0;
      for (const Launched& launched : launches_) all += launched.launch->steps();
      return all;
    }
    double seconds() const {  ///< in kernels
      double all = 0;
      for (const Launched& launched : launches_) all += launched.launch->seconds();
      return all;
    }
    void lay_out() {
      for (Launched& launched : launches_) launched.launch->lay_out();
    }
    void run(const RunOptions& options = {}) {
      for (Launched& launched : launches_) launched.launch->run(options);
    }
    /// Calls visit(i, answer) for all scenes in the order in which memory is read fast. `stresses`: they are read, too.
    template <class Visit>
    void each(bool stresses, const Visit& visit) const {
      const auto scene_at = [&](std::size_t place) { return order_.empty() ? place : order_[place]; };
      std::array<LaneAnswer, fetched_ahead + 1> answers;
      for (std::size_t place = 0, next = 0; place < size(); ++place) {
        for (; next < std::min(place + answers.size(), size()); ++next) {
          LaneAnswer& ahead = answers[next % answers.size()] = answer(scene_at(next));
          ahead.fetch_results();
          if (stresses) ahead.fetch_stresses();
        }
        visit(scene_at(place), answers[place % answers.size()]);
      }
    }
    LaneAnswer answer(std::size_t i) const { return launches_[places_[i].launch].launch->answer(places_[i].i); }

   private:
    friend class StreamOf;
    struct Launched {
      Key key;
      std::shared_ptr<const Solver> solver;
      std::unique_ptr<ContactLaunch<Kind>> launch;
      std::size_t longest = 0;           ///< steps of a scene
      std::vector<std::size_t> which{};  ///< scenes
    };
    struct Place {
      std::uint32_t launch = 0, i = 0;
    };
    /// Where lanes take turns in memory they are read as they lie there; else in the order of the scenes.
    void open() {
      for (Launched& launched : launches_) {
        launched.launch->open();
        if (launched.launch->answer(0).stride == 1) continue;
        for (const std::size_t i : launched.launch->by_lane()) order_.push_back(launched.which[i]);
      }
    }
    std::vector<Launched> launches_;
    std::vector<Place> places_;       ///< [scenes]
    std::vector<std::size_t> order_;  ///< of reading; empty: that of the scenes
  };
  void add(Part& part, const Scene& scene, const typename Kind::Path& path) const {
    const Key key = contacts_.key(scene);
    const std::size_t steps = path.steps.size();
    std::size_t l = part.launches_.size();
    while (l > 0 && part.launches_[l - 1].key != key) --l;
    const auto full = [&](const auto& launched) {
      return (launched.which.size() + 1) * std::max(steps, launched.longest) > launched.launch->most_lane_steps();
    };
    if (l == 0 || full(part.launches_[l - 1])) {
      auto made = solver(key, scene.sensor);
      auto launch = made->launch();
      part.launches_.push_back({key, std::move(made), std::move(launch)});
      l = part.launches_.size();
    }
    auto& launched = part.launches_[l - 1];
    launched.launch->add(scene, path);
    launched.longest = std::max(launched.longest, steps);
    part.places_.push_back({static_cast<std::uint32_t>(l - 1), static_cast<std::uint32_t>(launched.which.size())});
    launched.which.push_back(part.places_.size() - 1);
  }
  /// Gives the answers of a part that has run: lane() where the certificate holds, then solution(), then lane() of
  /// those with steps that are solved alone. `scene`: returns scene i; `coarse`: which steps of answer i are solved
  /// alone. The part can be read until it ends.
  void collect(Part& part, const std::function<Scene(std::size_t i)>& scene, const CoarseSteps& coarse,
               const LaneSink& lane, const SolutionSink& solution) const {
    part.open();
    Groups others(part.launches_.size());
    std::vector<std::pair<std::size_t, std::vector<std::size_t>>> with_coarse;  // answers, their steps
    part.each(false, [&](std::size_t i, const LaneAnswer& answer) {
      const std::size_t launch = part.places_[i].launch;
      if (!part.launches_[launch].solver->holds(answer))
        others[launch].push_back(i);
      else if (auto steps = coarse(i, answer); !steps.empty())
        with_coarse.emplace_back(i, std::move(steps));
      else
        lane(i, answer, {});
    });
    for (std::size_t launch = 0; launch < others.size(); ++launch) {
      for (std::span<const std::size_t> rest = others[launch]; !rest.empty();) {
        const auto some = rest.first(std::min(rest.size(), solved_again_at_once));
        rest = rest.subspan(some.size());
        std::vector<Scene> scenes;
        std::vector<LaneAnswer> known;
        for (const std::size_t i : some) scenes.push_back(scene(i)), known.push_back(part.answer(i));
        std::vector<Solution> solutions = part.launches_[launch].solver->solve(scenes, known);
        contacts_.finish(scenes, solutions);
        for (std::size_t k = 0; k < some.size(); ++k) solution(some[k], std::move(solutions[k]));
      }
    }
    std::vector<Scene> scenes;
    for (const auto& [i, steps] : with_coarse)
      for (const std::size_t step : steps) scenes.push_back(contacts_.alone(scene(i), step));
    std::vector<Solution> solutions = solve(scenes);
    auto next = solutions.begin();
    for (const auto& [i, steps] : with_coarse) {
      Alone alone;
      for (const std::size_t step : steps) alone.emplace(step, std::move(*next++));
      lane(i, part.answer(i), std::move(alone));
    }
  }

  /// Solves scenes with all their forces. Throws ValueError for an invalid scene.
  std::vector<Solution> solve(std::span<const Scene> scenes) const {
    for (const Scene& scene : scenes) scene.validate();
    std::vector<Solution> all(scenes.size());
    for (const auto& which : alike(scenes)) {
      std::vector<Scene> copies;
      if (which.size() < scenes.size())
        for (const std::size_t i : which) copies.push_back(scenes[i]);
      const std::span<const Scene> group = copies.empty() ? scenes : copies;
      const Scene& first = group.front();
      std::vector<Solution> solutions = solver(contacts_.key(first), first.sensor)->solve(group, {});
      contacts_.finish(group, solutions);
      for (std::size_t k = 0; k < which.size(); ++k) all[which[k]] = std::move(solutions[k]);
    }
    return all;
  }
  /// Solves many scenes without their forces, part by part. The sinks are called in one other thread. Returns false
  /// where progress, in scenes, did.
  bool solve(std::span<const Scene> scenes, const LaneSink& lane, const SolutionSink& solution,
             const std::function<bool(std::size_t done)>& progress) const {
    std::vector<std::size_t> order;
    for (const auto& group : alike(scenes)) order.insert(order.end(), group.begin(), group.end());
    const std::size_t most = scenes_of_a_part(executor_.device().info());
    const auto begin = [&](std::size_t first) {
      return std::async(std::launch::async, [&, first] {
        Part part;
        for (std::size_t k = first; k < std::min(first + most, order.size()); ++k)
          add(part, scenes[order[k]], Kind::path(scenes[order[k]]));
        part.lay_out();
        return part;
      });
    };
    const auto gather = [&](Part& part, std::size_t first) {
      collect(
          part, [&](std::size_t k) { return scenes[order[first + k]]; },
          [&](std::size_t k, const LaneAnswer& answer) { return contacts_.coarse(scenes[order[first + k]], answer); },
          [&](std::size_t k, const LaneAnswer& answer, Alone&& alone) {
            lane(order[first + k], answer, std::move(alone));
          },
          [&](std::size_t k, Solution&& solved) { solution(order[first + k], std::move(solved)); });
    };
    std::future<void> gathered;
    std::future<Part> next;
    for (std::size_t first = 0; first < order.size(); first += most) {
      if (!progress(first)) return false;
      auto part = std::make_shared<Part>(first == 0 ? begin(0).get() : next.get());
      if (first + most < order.size()) next = begin(first + most);
      part->run();
      if (gathered.valid()) gathered.get();
      gathered = std::async(std::launch::async, [&gather, part, first] { gather(*part, first); });
    }
    if (gathered.valid()) gathered.get();
    return true;
  }

 private:
  using Groups = std::vector<std::vector<std::size_t>>;
  /// Groups of scenes with equal keys, in the order of their first scene.
  Groups alike(std::span<const Scene> scenes) const {
    Groups groups;
    std::map<Key, std::size_t> places;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const auto [place, is_new] = places.try_emplace(contacts_.key(scenes[i]), groups.size());
      if (is_new) groups.emplace_back();
      groups[place->second].push_back(i);
    }
    return groups;
  }
  std::shared_ptr<const Solver> solver(const Key& key, const Sensor& sensor) const {
    return kept_.get(key.sensor, [&] { return contacts_.solver(sensor); });
  }

  static constexpr std::size_t solved_again_at_once = 64;  ///< each may take a second
  /// Contacts between the request of an answer and its use: some 5 kB.
  static constexpr std::size_t fetched_ahead = 2;

  Executor& executor_;
  Kind contacts_;
  mutable fem::LastUsed<decltype(Key::sensor), std::shared_ptr<const Solver>> kept_{16};
};

}  // namespace tactel::host
