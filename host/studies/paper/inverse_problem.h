// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "fem/scenes/scene.h"
#include "host/device/executor.h"
#include "host/networks/network_training.h"
#include "host/sets/contact_set.h"
#include "host/studies/study_report.h"

namespace tactel::host {

/// Section V of the paper: six networks learn the slippage index from 32 Taylor shapes and are judged on other
/// shapes. The result depends on the initial weights. Each network is therefore trained from many.

/// Choice of the parameters that the paper leaves open, and its learning rule.
struct InverseChoice {
  fem::Scene base;  ///< all but the indenter
  nn::OnlineOptions options;
};
/// Returns the defaults, with the scene of the paper's sets (paper_set_scene).
InverseChoice inverse_choice();

/// The sets of a choice, simulated.
struct InverseSets {
  nn::FrameSet learning, recall;
  std::vector<std::string> class_names;           ///< of the recall set
  ContactSet learning_contacts, recall_contacts;  ///< the same rows as in a set file
};
InverseSets simulate_sets(Executor& executor, const InverseChoice& choice);

/// A network of the paper at a noise level, over seeds.
struct NetworkStudy {
  int number = 0;  ///< 1 ... 6
  nn::Topology topology;
  double noise = 0;
  std::vector<TrainedNetwork> networks;            ///< [seeds]
  Reports learning, recalling;                     ///< [seeds]
  Reports recalling_noisy;                         ///< [seeds] on the recall set with 10 % noise
  std::vector<std::vector<double>> recall_errors;  ///< [seeds][rows of the recall set] |error of S|
  std::size_t typical = 0;                         ///< the seed whose mean recall error is the median
  std::vector<double> slip_index{};                ///< [rows of the recall set] S of that seed's network
  std::vector<nn::Model> models{};                 ///< [seeds] as in their files
};

/// A network of the paper that learnt from noise drawn anew at each showing, relative to each frame's own largest
/// stress; over seeds.
struct FreshNoiseStudy {
  int number = 0;  ///< 1 ... 6
  nn::Topology topology;
  Reports recalling, recalling_noisy;  ///< [seeds] without noise, and with noise of the same kind
};

struct InverseProblem {
  InverseSets sets;
  std::vector<NetworkStudy> studies;         ///< noise-free 1 ... 6, then with noise 1 ... 6
  std::vector<FreshNoiseStudy> fresh_noise;  ///< 1 ... 6
  double patterns = 0, seconds = 0;          ///< of training
};

/// Limit of the cycles that train on noise. By then the networks fit their noisy set; their recall is no better
/// after the paper's 10 000 or 15 000 cycles (`tactel reproduce --noise-cycles 0`).
inline constexpr int enough_noise_cycles = 4000;

/// Noise of the paper's sets, over the largest stress (section V.B).
inline constexpr double paper_noise = 0.1;

/// Throws ConfigError where `checkpoint` exists and is not of train_and_recall with these arguments and sets. Call
/// it before the work, which overwrites the file at its end.
void expect_own_checkpoint(Executor& executor, const InverseChoice& choice, double noise, std::size_t seeds,
                           const InverseSets& sets, const std::filesystem::path& checkpoint);

/// Trains the six networks on the problem's sets at one noise level from seeds 1 ... `seeds`, and adds their
/// studies. Progress and checkpoint as in NetworkTraining::run; resumes from a checkpoint of the same training.
/// Returns false where progress stopped it. Throws ConfigError for a checkpoint of another training.
bool train_and_recall(Executor& executor, const InverseChoice& choice, double noise, std::size_t seeds,
                      const TrainingRunOptions& options, InverseProblem& problem);

/// Throws as expect_own_checkpoint, for a checkpoint of train_on_fresh_noise.
void expect_own_fresh_noise_checkpoint(Executor& executor, const InverseChoice& choice, std::size_t seeds,
                                       const InverseSets& sets, const std::filesystem::path& checkpoint);

/// The same for noise drawn anew at each showing: fills problem.fresh_noise. A network is shown the learning set
/// `choice.options.cycle_limit` times (0: enough_noise_cycles), each time with other noise, up to a limit of memory.
bool train_on_fresh_noise(Executor& executor, const InverseChoice& choice, std::size_t seeds,
                          const TrainingRunOptions& options, InverseProblem& problem);

/// A row of Table II as printed. The paper does not state which rows were trained with noise.
struct TableTwoRow {
  nn::ErrorSummary learning, recalling;  ///< without counts
};
/// Returns row `number`, 1 ... 6.
const TableTwoRow& paper_table_two(int number);

/// Returns table2.json: for each network and noise the medians over seeds of max, mean and standard deviation,
/// learning and recalling, with the 5 and 95 % quantiles as "low" and "high".
nlohmann::ordered_json table_two_json(const InverseProblem& problem);

struct InverseBaselines;

/// Adds to the report Table II as a distribution, with the estimators without a network; learning curves, and errors
/// by class and by nodes in contact. Adds the effect of noise.
void report_inverse_problem(Page& page, const InverseProblem& problem, const InverseChoice& choice,
                            const InverseBaselines& baselines);

}  // namespace tactel::host
