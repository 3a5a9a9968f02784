// SPDX-License-Identifier: Apache-2.0
#include "host/studies/floor/floor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <numeric>

#include "fem/value_error.h"
#include "host/networks/forward.h"
#include "host/networks/frame_likelihood.h"
#include "host/sets/set_simulator.h"
#include "host/support/errors.h"
#include "host/support/side_by_side.h"
#include "kernels/shared/contact_layout.h"
#include "nn/bound.h"
#include "nn/noise_words.h"

namespace tactel::host {
namespace {

using Readings = nn::RowMatrix<float>;
using Weights = Eigen::Array<float, 1, Eigen::Dynamic>;

constexpr std::array<double, 8> spreads = {1, 4, 16, 64, 256, 1024, 4096, 16384};
constexpr std::size_t readings_at_once = 32;  // times the rows of the bank: 26 MB at 200 000
constexpr std::size_t contacts_at_once = 4096;

/// The rows of a bank in a new order, or some of them.
FrameBank chosen(const FrameBank& bank, std::span<const std::size_t> rows) {
  FrameBank some{.frames = Readings(rows.size(), bank.frames.cols()), .slip_index = {}, .class_of = {}};
  some.class_of.resize(bank.class_of.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    some.frames.row(k) = bank.frames.row(rows[k]);
    some.slip_index.push_back(bank.slip_index[rows[k]]);
    if (!bank.largest.empty()) some.largest.push_back(bank.largest[rows[k]]);
    for (std::size_t f = 0; f < bank.class_of.size(); ++f) some.class_of[f].push_back(bank.class_of[f][rows[k]]);
  }
  return some;
}

/// The first `count` rows, by increasing S.
FrameBank sorted_bank(const FrameBank& bank, std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t row) { return bank.slip_index[row]; });
  return chosen(bank, order);
}

/// `count` rows at random, none twice; all where there are fewer.
std::vector<std::size_t> drawn_rows(std::size_t rows, std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> order(rows);
  std::iota(order.begin(), order.end(), std::size_t{0});
  count = std::min(count, rows);
  for (std::size_t k = 0; k < count; ++k) {
    const nn::PhiloxCounter words = nn::noise_words(seed, k);
    std::swap(order[k], order[k + ((std::uint64_t{words[0]} << 32 | words[1]) % (rows - k))]);
  }
  order.resize(count);
  return order;
}

FloorError mean_of(const std::vector<double>& errors) {
  FloorError error{.mean = 0, .standard_error = 0, .readings = errors.size()};
  if (errors.empty()) return error;
  const nn::ErrorSummary summary = nn::summarize(errors);
  error.mean = summary.mean;
  error.standard_error = summary.std / std::sqrt(static_cast<double>(errors.size()));
  return error;
}

/// exp((log density - its largest) / spread), all rows of the bank.
Weights weights_of(const auto& logarithms, double spread) {
  return ((logarithms - logarithms.maxCoeff()) / static_cast<float>(spread)).exp();
}

/// S of the rows of a bank sorted by it, where half of the weight lies.
double median_of(const FrameBank& bank, const Weights& weights) {
  return weighted_median(bank.slip_index, {weights.data(), static_cast<std::size_t>(weights.size())});
}

/// Readings of a bank's rows, evaluated under the bank that `likelihood` holds, `readings_at_once` at a time.
/// evaluate(reading, logarithms) is called for each, from several threads.
bool each_reading(FrameLikelihood<float>& likelihood, int threads, const Readings& readings, const Progress& progress,
                  const std::function<void(std::size_t, const Eigen::Ref<const Weights>&)>& evaluate) {
  const auto count = static_cast<std::size_t>(readings.rows());
  for (std::size_t first = 0; first < count; first += readings_at_once) {
    if (progress && !progress(first, count)) return false;
    const std::size_t some = std::min(readings_at_once, count - first);
    const nn::RowMatrix<float> logarithms = likelihood(readings.middleRows(first, some));
    if (!logarithms.allFinite()) throw std::runtime_error("frame_likelihood: a density is not finite");
    side_by_side(some, threads, [&](std::size_t k) { evaluate(first + k, logarithms.row(k).array()); });
  }
  return true;
}

/// Errors of readings, with the rows of which they are.
struct Errors {
  std::vector<double> all;                     ///< [readings]
  std::vector<std::vector<double>> by_family;  ///< [families][readings], the class told
};

/// The number below: readings of rows of the bank itself.
std::optional<Errors> errors_below(FrameLikelihood<float>& likelihood, int threads, const FrameBank& bank,
                                   const FrameBank& asked, const Readings& readings, const Progress& progress) {
  std::vector<std::vector<std::vector<std::uint32_t>>> members(bank.class_of.size());  // [families][class] rows
  for (std::size_t f = 0; f < members.size(); ++f)
    for (std::uint32_t row = 0; row < bank.rows(); ++row) {
      const std::uint16_t kind = bank.class_of[f][row];
      if (members[f].size() <= kind) members[f].resize(kind + 1u);
      members[f][kind].push_back(row);
    }
  Errors errors{.all = std::vector<double>(asked.rows()), .by_family = {}};
  errors.by_family.assign(members.size(), std::vector<double>(asked.rows()));
  const auto evaluate = [&](std::size_t k, const Eigen::Ref<const Weights>& logarithms) {
    const double truth = asked.slip_index[k];
    const Weights weights = weights_of(logarithms, 1);
    errors.all[k] = std::abs(median_of(bank, weights) - truth);
    std::vector<float> values, of_class;
    for (std::size_t f = 0; f < members.size(); ++f) {
      values.clear(), of_class.clear();
      for (const std::uint32_t row : members[f][asked.class_of[f][k]])
        values.push_back(bank.slip_index[row]), of_class.push_back(weights[row]);
      errors.by_family[f][k] = std::abs(weighted_median(values, of_class) - truth);
    }
  };
  if (!each_reading(likelihood, threads, readings, progress, evaluate)) return std::nullopt;
  return errors;
}

/// The number above, at every spread: [spreads][readings], of readings of rows outside of the bank.
std::optional<std::vector<std::vector<double>>> errors_above(FrameLikelihood<float>& likelihood, int threads,
                                                             const FrameBank& bank, const FrameBank& asked,
                                                             const Readings& readings, const Progress& progress) {
  std::vector errors(spreads.size(), std::vector<double>(asked.rows()));
  const auto evaluate = [&](std::size_t k, const Eigen::Ref<const Weights>& logarithms) {
    for (std::size_t s = 0; s < spreads.size(); ++s)
      errors[s][k] = std::abs(median_of(bank, weights_of(logarithms, spreads[s])) - asked.slip_index[k]);
  };
  if (!each_reading(likelihood, threads, readings, progress, evaluate)) return std::nullopt;
  return errors;
}

/// The spread with the smallest mean error on the first half of the readings.
std::size_t best_spread(const std::vector<std::vector<double>>& errors) {
  std::size_t best = 0;
  double least = INFINITY;
  for (std::size_t s = 0; s < errors.size(); ++s) {
    const auto middle = errors[s].begin() + static_cast<std::ptrdiff_t>(errors[s].size() / 2);
    const double sum = std::accumulate(errors[s].begin(), middle, 0.0);
    if (sum < least) least = sum, best = s;
  }
  return best;
}

/// |error of S| of a network on readings, of |S| where it answers that; newest frame alone where the network takes one.
/// [readings]
std::vector<double> network_errors(Executor& executor, const nn::Model& network, const Readings& readings,
                                   const FrameBank& asked, int inputs, const nn::InputHistory& history) {
  const int width = network.weights.topology.inputs();
  if (width != readings.cols() && width != inputs)
    throw ValueError("network", network.weights.topology.text(),
                     fmt::format("a network with {} inputs, as many as a frame", inputs));
  if (width != inputs && network.history != history)
    throw ValueError("network", network.weights.topology.text(),
                     fmt::format("a network with the history of the readings, {}:{} of a change of {}", history.frames,
                                 history.stride, history.change));
  Forward<float> forward(executor, std::span(&network.weights, 1), network.scaling);
  const nn::Recall<float> answer = forward.recall(readings.leftCols(width));
  std::vector<double> errors;
  for (std::size_t k = 0; k < asked.rows(); ++k) {
    const double truth = asked.slip_index[k];
    errors.push_back(std::abs(static_cast<double>(answer.slip_index(static_cast<Eigen::Index>(k))) -
                              (network.magnitude ? std::abs(truth) : truth)));
  }
  return errors;
}

std::vector<double> second_half(const std::vector<double>& values) {
  return {values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end()};
}

/// The values of the readings of one class.
std::vector<double> of_class(const std::vector<double>& values, const std::vector<std::uint16_t>& classes,
                             std::size_t kind) {
  std::vector<double> some;
  for (std::size_t k = 0; k < values.size(); ++k)
    if (classes[k] == kind && !std::isnan(values[k])) some.push_back(values[k]);
  return some;
}

const std::vector<std::string> touching_names = {"1", "2 to 4", "5 to 8", "9 to 15", "16 or more"};
std::uint16_t touching_class(int nodes) {
  return nodes <= 1 ? 0 : nodes <= 4 ? 1 : nodes <= 8 ? 2 : nodes <= 15 ? 3 : 4;
}

const std::vector<std::string> felt_names = {"1 to 3", "4 to 6", "7 to 10", "11 or more"};
std::uint16_t felt_class(std::span<const float> frame) {
  const int count = nn::touching_tactels(frame.data(), static_cast<int>(frame.size() / 2));
  return count <= 3 ? 0 : count <= 6 ? 1 : count <= 10 ? 2 : 3;
}

constexpr double change = 1.0 / 64;  // of a range

/// Frames of a reading: the newest and those that FrameHistory keeps. Steps without a frame are none.
struct Place {
  std::uint64_t contact = 0;
  std::vector<std::optional<std::uint32_t>> steps;  ///< [history] load steps of the contact, the newest first
};

bool answered(const ContactSet& set, std::size_t row) {
  return set.status[row] != LANE_UNSOLVED && std::isfinite(set.slip_index[row]);
}

/// Collects rows whose newest frame has normal stress, each with the frames of its history.
class BankCollector {
 public:
  BankCollector(int inputs, const FloorOptions& options)
      : frames_of_reading_(options.history.frames),
        noise_of_contact_(options.noise_of_contact),
        path_(static_cast<std::size_t>(inputs), options.history) {
    bank_.class_of.resize(3);
  }

  /// Takes the rows of contacts whose number is a multiple of `every`. Returns where the frames of each row stand.
  std::vector<Place> add(const ContactSet& set, std::uint64_t every = 1) {
    std::vector<Place> taken;
    for (std::size_t row = 0, end = 0; row < set.rows(); row = end) {
      while (end < set.rows() && set.contact[end] == set.contact[row]) ++end;
      if (set.contact[row] % every == 0) add_contact(set, row, end, taken);
    }
    return taken;
  }
  std::size_t rows() const { return bank_.rows(); }
  FrameBank take() {
    bank_.frames = Eigen::Map<const Readings>(frames_.data(), static_cast<Eigen::Index>(bank_.rows()),
                                              static_cast<Eigen::Index>(path_.inputs()));
    return std::move(bank_);
  }

 private:
  void add_contact(const ContactSet& set, std::size_t first, std::size_t end, std::vector<Place>& taken) {
    const auto frame_of = [&](std::size_t row) {
      return std::span(set.frames.data() + row * path_.width(), path_.width());
    };
    float largest = 0;
    for (const float stress : std::span(set.frames).subspan(first * path_.width(), (end - first) * path_.width()))
      largest = std::max(largest, std::abs(stress));
    std::vector<std::uint32_t> pushed;  // load steps of the frames in the history
    for (std::size_t row = first; row < end; ++row) {
      if (!answered(set, row)) continue;
      if (pushed.empty() || set.step[row] != pushed.back() + 1) path_.clear(), pushed.clear();
      const auto frame = frame_of(row);
      path_.push(frame.data());
      pushed.push_back(set.step[row]);
      if (std::ranges::all_of(frame.first(frame.size() / 2), [](float stress) { return stress == 0; })) continue;
      frames_.resize(frames_.size() + path_.inputs());
      path_.write(frames_.data() + frames_.size() - path_.inputs());
      if (noise_of_contact_) bank_.largest.push_back(largest);
      bank_.slip_index.push_back(set.slip_index[row]);
      bank_.class_of[0].push_back(set.indenter[row]);
      bank_.class_of[1].push_back(touching_class(set.contact_nodes[row]));
      bank_.class_of[2].push_back(felt_class(frame));
      taken.push_back({set.contact[row], {set.step[row]}});
      for (int m = 1; m < frames_of_reading_; ++m) {
        const auto age = path_.age(m);
        taken.back().steps.push_back(age ? std::optional(pushed[pushed.size() - 1 - *age]) : std::nullopt);
      }
    }
  }

  int frames_of_reading_;
  bool noise_of_contact_;
  nn::FrameHistory path_;
  FrameBank bank_;
  std::vector<float> frames_;
};

/// Rows of a set by contact and load step.
class RowsOfSteps {
 public:
  explicit RowsOfSteps(const ContactSet& set) : set_(&set) {
    for (std::size_t row = 0; row < set.rows(); ++row)
      if (answered(set, row)) row_of_[{set.contact[row], set.step[row]}] = row;
  }
  /// Returns S of the newest frame and the frames [history][inputs] MPa. None where a frame is not there.
  std::optional<double> read(std::uint64_t contact, const Place& place, std::span<double> frames) const {
    const std::size_t inputs = frames.size() / place.steps.size();
    std::ranges::fill(frames, 0.0);
    double slip_index = 0;
    for (std::size_t m = 0; m < place.steps.size(); ++m) {
      if (!place.steps[m]) continue;
      const auto found = row_of_.find({contact, *place.steps[m]});
      if (found == row_of_.end()) return std::nullopt;
      if (m == 0) slip_index = set_->slip_index[found->second];
      std::copy_n(set_->frames.data() + found->second * inputs, inputs, frames.subspan(m * inputs).begin());
    }
    return slip_index;
  }

 private:
  const ContactSet* set_;
  std::map<std::pair<std::uint64_t, std::uint32_t>, std::size_t> row_of_;
};

/// nn::linear_error of a row, with derivatives by differences: contacts place.contact + 1 ... + `numbers` have one of
/// the numbers changed.
double estimate_of(const nn::ReadingModel& model, const RowsOfSteps& rows, const Place& place, std::uint64_t numbers,
                   double largest) {
  std::vector<double> truth(static_cast<std::size_t>(model.size())), moved(truth.size());
  const double slip_index = *rows.read(place.contact, place, truth);
  nn::RowMatrix<double> j = nn::RowMatrix<double>::Zero(model.size(), static_cast<Eigen::Index>(numbers));
  nn::Vector<double> g = nn::Vector<double>::Zero(j.cols());
  for (Eigen::Index n = 0; n < j.cols(); ++n) {
    const auto changed = rows.read(place.contact + 1 + static_cast<std::uint64_t>(n), place, moved);
    if (!changed) continue;
    for (Eigen::Index k = 0; k < j.rows(); ++k) j(k, n) = (moved[k] - truth[k]) / change;
    g(n) = (*changed - slip_index) / change;
  }
  const std::vector<float> frames(truth.begin(), truth.end());
  return nn::linear_error(model, frames, j, g, largest);
}

/// Fills the estimates of the floor and its classes, from contacts first ... of the source.
void measure_estimates(Executor& executor, const SceneSource& source, std::uint64_t first,
                       const nn::ReadingModel& model, const FloorOptions& options, Floor& floor) {
  const SceneSource changed = source.changed(change);
  const std::uint64_t n = changed.changes();
  const SetSimulator simulator(executor, changed, {.precision = Precision::fp64, .tolerance = 1e-8});
  std::vector<double> all;
  std::vector<std::vector<std::uint16_t>> classes(3);
  constexpr std::uint64_t contacts = 128;
  for (std::uint64_t next = first; all.size() < options.readings; next += contacts) {
    const ContactSet set = simulator.simulate(next * n, contacts * n);
    const RowsOfSteps rows(set);
    BankCollector collector(model.inputs, options);
    const std::vector<Place> places = collector.add(set, n);
    const FrameBank bank = collector.take();
    const std::size_t before = all.size();
    all.resize(before + places.size());
    side_by_side(places.size(), executor.threads(), [&](std::size_t k) {
      all[before + k] = estimate_of(model, rows, places[k], n - 1, bank.largest.empty() ? 0 : bank.largest[k]);
    });
    for (std::size_t f = 0; f < classes.size(); ++f)
      classes[f].insert(classes[f].end(), bank.class_of[f].begin(), bank.class_of[f].end());
  }
  floor.all.estimate = mean_of(all);
  for (FloorClass& one : floor.classes) one.estimate = mean_of(of_class(all, classes[one.family_number], one.number));
}

}  // namespace

double weighted_median(std::span<const float> values, std::span<const float> weights) {
  const Eigen::Map<const Eigen::ArrayXf> all(weights.data(), static_cast<Eigen::Index>(weights.size()));
  const double half = 0.5 * all.cast<double>().sum();
  // Blocks first, then the rows of the block in which half of the weight is passed.
  constexpr Eigen::Index block = 512;
  double sum = 0;
  for (Eigen::Index first = 0; first < all.size(); first += block) {
    const Eigen::Index count = std::min(block, all.size() - first);
    const double more = all.segment(first, count).cast<double>().sum();
    if (sum + more < half && first + count < all.size()) {
      sum += more;
      continue;
    }
    for (Eigen::Index k = first; k < first + count; ++k)
      if (sum += all[k]; sum >= half) return values[static_cast<std::size_t>(k)];
  }
  return values.back();
}

std::optional<Floor> floor_of(Executor& executor, const FrameBank& bank, const FrameBank& outside,
                              const nn::ReadingModel& model, const std::vector<ClassFamily>& families,
                              std::span<const nn::Model> networks, const FloorOptions& options) {
  model.validate();
  if (bank.rows() < 2 || outside.rows() < 2)
    throw ValueError("bank", fmt::format("{} rows", std::min(bank.rows(), outside.rows())), "at least 2 rows");
  const auto start = std::chrono::steady_clock::now();
  const FrameBank judged = chosen(outside, drawn_rows(outside.rows(), 2 * options.readings, options.seed));
  const Readings readings = nn::draw_readings(model, judged.frames, options.seed + 2, judged.largest);
  Floor floor{.all = {}, .classes = {}, .convergence = {}, .bank = bank.rows()};
  std::optional<Errors> below;
  FrameBank asked;
  std::vector<double> above;
  // Smaller banks first: work 1/16, 1/4 and 1 of the whole.
  const std::array<std::size_t, 3> shares = {16, 4, 1};
  std::size_t parts = 0;
  const Progress progress = [&](std::size_t done, std::size_t count) {
    return !options.progress || options.progress(parts * count + done, 2 * shares.size() * count);
  };
  for (const std::size_t share : shares) {
    const std::size_t rows = std::max<std::size_t>(bank.rows() / share, 1);
    const FrameBank some = sorted_bank(bank, rows);
    asked = chosen(some, drawn_rows(rows, options.readings, options.seed + 4));
    FrameLikelihood<float> likelihood(executor, model, some.frames, some.largest);
    below = errors_below(likelihood, executor.threads(), some, asked,
                         nn::draw_readings(model, asked.frames, options.seed + 6, asked.largest), progress);
    if (!below) return std::nullopt;
    ++parts;
    const auto at_spreads = errors_above(likelihood, executor.threads(), some, judged, readings, progress);
    if (!at_spreads) return std::nullopt;
    ++parts;
    const std::size_t best = best_spread(*at_spreads);
    above = second_half((*at_spreads)[best]);
    floor.spread = spreads[best];
    floor.convergence.push_back({.bank = rows, .lower = mean_of(below->all).mean, .upper = mean_of(above).mean});
  }
  floor.all = {.family_number = 0,
               .number = 0,
               .family = "",
               .name = "all",
               .lower = mean_of(below->all),
               .estimate = {},
               .upper = mean_of(above),
               .networks = {}};
  std::vector<std::vector<double>> of_networks;
  for (const nn::Model& network : networks) {
    of_networks.push_back(
        second_half(network_errors(executor, network, readings, judged, model.inputs, options.history)));
    std::vector<double> answered;
    std::ranges::copy_if(of_networks.back(), std::back_inserter(answered), [](double e) { return !std::isnan(e); });
    floor.all.networks.push_back(mean_of(answered));
  }
  for (std::size_t f = 0; f < families.size(); ++f) {
    const std::vector<std::uint16_t> judged_classes(
        judged.class_of[f].begin() + static_cast<std::ptrdiff_t>(judged.rows() / 2), judged.class_of[f].end());
    for (std::size_t kind = 0; kind < families[f].classes.size(); ++kind) {
      FloorClass one{.family_number = f,
                     .number = static_cast<std::uint16_t>(kind),
                     .family = families[f].name,
                     .name = families[f].classes[kind],
                     .lower = mean_of(of_class(below->by_family[f], asked.class_of[f], kind)),
                     .estimate = {},
                     .upper = mean_of(of_class(above, judged_classes, kind)),
                     .networks = {}};
      for (const auto& errors : of_networks) one.networks.push_back(mean_of(of_class(errors, judged_classes, kind)));
      if (one.lower.readings + one.upper.readings > 0) floor.classes.push_back(std::move(one));
    }
  }
  floor.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return floor;
}

std::optional<Floor> measure_floor(Executor& executor, const SceneSource& sweep, std::span<const nn::Model> networks,
                                   const FloorOptions& options) {
  SceneSource source = sweep;
  source.measure_with({}, sweep.seed());
  const nn::ReadingModel model{
      .inputs = 2 * source.tactels(), .history = options.history.frames, .noise = options.noise, .gain = options.gain};
  model.validate();
  const SetSimulator simulator(executor, source, {});
  std::uint64_t next = 0;
  const auto collect = [&](std::size_t rows) {
    BankCollector collector(model.inputs, options);
    for (std::size_t tried = 0; collector.rows() < rows; ++tried) {
      if (tried > 64 && collector.rows() == 0)
        throw ConfigError("sweep", "contacts", "no row with normal stress", "contacts that press on a tactel");
      collector.add(simulator.simulate(next, contacts_at_once));
      next += contacts_at_once;
    }
    return collector.take();
  };
  const FrameBank bank = collect(options.bank), outside = collect(2 * options.readings);
  auto floor = floor_of(executor, bank, outside, model,
                        {{"indenter", source.kind_names()},
                         {"elements that touch", touching_names},
                         {"tactels above 5 % of the largest", felt_names}},
                        networks, options);
  if (floor) measure_estimates(executor, source, next, model, options, *floor);
  return floor;
}

}  // namespace tactel::host
