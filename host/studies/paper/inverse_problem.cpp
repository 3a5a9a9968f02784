// SPDX-License-Identifier: Apache-2.0
#include "host/studies/paper/inverse_problem.h"

#include <fmt/format.h>

#include <numeric>

#include "host/networks/training_checkpoint.h"
#include "host/scenes/paper_sets.h"
#include "host/sets/set_simulator.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

constexpr std::uint64_t recall_noise_seed = 1'000'003, learning_noise_seed = 1'000'033;  // no network's own
constexpr double taylor_scale = 10;     // mm: x and y of the Taylor shapes in centimetres
constexpr int most_noisy_copies = 400;  // of the learning set: 18 MB on the device

TrainingPlan paper_plan(const InverseChoice& choice, std::size_t seeds, double noise = 0) {
  TrainingPlan plan;
  plan.noises = {noise};
  plan.options = choice.options;
  for (int number = 1; number <= 6; ++number) plan.topologies.push_back(nn::Topology::paper(number));
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) plan.seeds.push_back(seed);
  return plan;
}

std::string description(const Executor& executor, const nn::FrameSet& set, const TrainingPlan& plan) {
  return training_description(set_description(set), executor.device().lanes(Precision::fp32), Precision::fp32, plan);
}

/// Copies of the learning set with noise, and the plan that shows each of them once a cycle.
std::pair<nn::FrameSet, TrainingPlan> fresh_noise_lesson(const InverseChoice& choice, std::size_t seeds,
                                                         const InverseSets& sets) {
  const int showings = choice.options.cycle_limit > 0 ? choice.options.cycle_limit : enough_noise_cycles;
  const int copies = std::min(showings, most_noisy_copies);
  InverseChoice fresh = choice;
  fresh.options.cycle_limit = showings / copies;
  return {nn::with_frame_noise(sets.learning, paper_noise, learning_noise_seed, copies), paper_plan(fresh, seeds)};
}

/// Index of the median of the mean errors; of an even number, the lower of the two in the middle.
std::size_t typical_seed(const std::vector<nn::ErrorReport>& reports) {
  std::vector<std::size_t> order(reports.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return reports[i].all.mean; });
  return order[(order.size() - 1) / 2];
}

/// The results of a finished training [networks 1 ... 6][seeds].
void add_studies(const NetworkTraining<float>& training, const TrainingPlan& plan, InverseProblem& problem) {
  const nn::FrameSet& recall = problem.sets.recall;
  const auto learning = training.recall_learning_set();
  const auto errors = training.absolute_errors(recall);
  const auto noisy = training.recall(nn::with_noise(recall, paper_noise, recall_noise_seed));
  for (std::size_t t = 0; t < plan.topologies.size(); ++t) {
    NetworkStudy study{.number = static_cast<int>(t) + 1,
                       .topology = plan.topologies[t],
                       .noise = plan.noises[0],
                       .networks = {},
                       .learning = {},
                       .recalling = {},
                       .recalling_noisy = {},
                       .recall_errors = {}};
    for (std::size_t i = t * plan.seeds.size(); i < (t + 1) * plan.seeds.size(); ++i) {
      study.networks.push_back(training.networks()[i]);
      study.learning.push_back(learning[i]);
      study.recalling.push_back(nn::report_errors(errors[i], recall));
      study.recalling_noisy.push_back(noisy[i]);
      study.recall_errors.push_back(errors[i]);
    }
    for (std::size_t i = t * plan.seeds.size(); i < (t + 1) * plan.seeds.size(); ++i)
      study.models.push_back(training.model(i, "learning.h5", learning[i].all));
    study.typical = typical_seed(study.recalling);
    study.slip_index = training.slip_index(t * plan.seeds.size() + study.typical, recall);
    problem.studies.push_back(std::move(study));
  }
}

}  // namespace

InverseChoice inverse_choice() { return {.base = paper_set_scene(), .options = {}}; }

InverseSets simulate_sets(Executor& executor, const InverseChoice& choice) {
  const auto simulate = [&](const SceneFamily& family) {
    ContactSet set = simulate_family(executor, family, Precision::fp64, 0);
    if (std::ranges::count(set.status, LANE_UNSOLVED))
      throw std::runtime_error("the paper's sets: a load step did not meet its tolerance");
    return set;
  };
  const SceneFamily recall_family = paper_recall_family(choice.base);
  ContactSet learning = simulate(paper_learning_family(choice.base, taylor_scale, taylor_scale));
  ContactSet recall = simulate(recall_family);
  auto to_learn = learning.frames_with_answers(), to_recall = recall.frames_with_answers();
  return {.learning = std::move(to_learn),
          .recall = std::move(to_recall),
          .class_names = recall_family.kind_names,
          .learning_contacts = std::move(learning),
          .recall_contacts = std::move(recall)};
}

void expect_own_checkpoint(Executor& executor, const InverseChoice& choice, double noise, std::size_t seeds,
                           const InverseSets& sets, const std::filesystem::path& checkpoint) {
  const TrainingPlan plan = paper_plan(choice, seeds, noise);
  expect_checkpoint_of(checkpoint, description(executor, sets.learning, plan));
}

bool train_and_recall(Executor& executor, const InverseChoice& choice, double noise, std::size_t seeds,
                      const TrainingRunOptions& options, InverseProblem& problem) {
  const TrainingPlan plan = paper_plan(choice, seeds, noise);
  NetworkTraining<float> training(executor, problem.sets.learning, plan);
  if (!options.checkpoint.empty()) training.load(options.checkpoint);
  if (!training.run(options)) return false;
  add_studies(training, plan, problem);
  problem.patterns += training.patterns();
  problem.seconds += training.seconds();
  return true;
}

void expect_own_fresh_noise_checkpoint(Executor& executor, const InverseChoice& choice, std::size_t seeds,
                                       const InverseSets& sets, const std::filesystem::path& checkpoint) {
  const auto [learning, plan] = fresh_noise_lesson(choice, seeds, sets);
  expect_checkpoint_of(checkpoint, description(executor, learning, plan));
}

bool train_on_fresh_noise(Executor& executor, const InverseChoice& choice, std::size_t seeds,
                          const TrainingRunOptions& options, InverseProblem& problem) {
  const auto [learning, plan] = fresh_noise_lesson(choice, seeds, problem.sets);
  NetworkTraining<float> training(executor, learning, plan);
  if (!options.checkpoint.empty()) training.load(options.checkpoint);
  if (!training.run(options)) return false;
  const nn::FrameSet noisy = nn::with_frame_noise(problem.sets.recall, paper_noise, recall_noise_seed, 1);
  const auto clean_errors = training.recall(problem.sets.recall), noisy_errors = training.recall(noisy);
  for (std::size_t t = 0; t < plan.topologies.size(); ++t) {
    const auto of_seeds = [&](const std::vector<nn::ErrorReport>& all) {
      const auto first = all.begin() + static_cast<std::ptrdiff_t>(t * seeds);
      return std::vector(first, first + static_cast<std::ptrdiff_t>(seeds));
    };
    problem.fresh_noise.push_back({.number = static_cast<int>(t) + 1,
                                   .topology = plan.topologies[t],
                                   .recalling = of_seeds(clean_errors),
                                   .recalling_noisy = of_seeds(noisy_errors)});
  }
  problem.patterns += training.patterns();
  problem.seconds += training.seconds();
  return true;
}

const TableTwoRow& paper_table_two(int number) {
  static const std::array<TableTwoRow, 6> rows{{
      {{0, 0.04922, 0.00264, 0.00438}, {0, 0.27284, 0.03558, 0.03401}},
      {{0, 0.05606, 0.00355, 0.00506}, {0, 0.43712, 0.04601, 0.04646}},
      {{0, 0.04602, 0.00253, 0.00416}, {0, 0.26308, 0.03805, 0.03370}},
      {{0, 0.04221, 0.00250, 0.00334}, {0, 0.19630, 0.03436, 0.02856}},
      {{0, 0.04311, 0.00236, 0.00351}, {0, 0.18508, 0.03416, 0.02921}},
      {{0, 0.04082, 0.00130, 0.00258}, {0, 0.17709, 0.03416, 0.02918}},
  }};
  return rows.at(static_cast<std::size_t>(number - 1));
}

}  // namespace tactel::host
