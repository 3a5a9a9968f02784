// SPDX-License-Identifier: Apache-2.0

// Trainings over topologies, seeds and noise: results, checkpoints, cancelling.
#include "host/networks/network_training.h"

#include <gmock/gmock.h>

#include <fstream>
#include <functional>
#include <memory>
#include <set>

#include "fem/numbers/value_error.h"
#include "host/networks/training_checkpoint.h"
#include "host/support/checksum.h"
#include "host/support/errors.h"
#include "tests/host/networks/network_cases.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace network_training_test {

using namespace tactel;
using namespace tactel::host;
using tactel::tests::bumps;
using tactel::tests::executor;
using tactel::tests::gpu;
namespace fs = std::filesystem;

TrainingPlan small_plan() {
  TrainingPlan plan{.topologies = {nn::Topology::parse("16-16-8-1"), nn::Topology::parse("16-9-1")},
                    .seeds = {3, 4, 11},
                    .noises = {0.0, 0.1}};
  plan.options.cycle_limit = 150;
  return plan;
}

/// The same bits of each network, of its curve and of where it stopped.
void expect_same(const NetworkTraining<float>& found, const NetworkTraining<float>& whole) {
  for (std::size_t i = 0; i < whole.networks().size(); ++i) {
    const TrainedNetwork &network = found.networks()[i], &expected = whole.networks()[i];
    EXPECT_EQ(found.weights(i).values, whole.weights(i).values) << i;
    EXPECT_EQ(network.curve, expected.curve) << i;
    EXPECT_EQ(network.cycles, expected.cycles) << i;
    EXPECT_EQ(network.status, expected.status) << i;
    EXPECT_EQ(network.best_cycle, expected.best_cycle) << i;
  }
}

class NetworkTrainingTest : public ::testing::Test {
 protected:
  fs::path checkpoint() const { return directory_ / "training.checkpoint"; }
  std::string message_of_load(const TrainingPlan& plan, const nn::FrameSet& set) const {
    NetworkTraining<float> training(executor(), set, plan);
    return thrown_message<ConfigError>([&] { training.load(checkpoint()); });
  }

  /// A stop error that half of a plan's networks reach, by what the reference does with mini-batches.
  double stop_of_half(const TrainingPlan& plan) const {
    const nn::InputScaling scaling = nn::fit_scaling(plan.scaling, set_);
    std::vector<double> smallest;
    for (const nn::Topology& topology : plan.topologies)
      for (const double noise : plan.noises)
        for (const std::uint64_t seed : plan.seeds) {
          const auto shown = nn::training_set<double>(nn::with_noise(set_, noise, seed), scaling);
          nn::BatchState<double> state(nn::initial_weights(topology, seed));
          smallest.push_back(1);
          while (state.epoch < static_cast<std::uint32_t>(plan.options.cycle_limit))
            smallest.back() = std::min(smallest.back(), nn::train_epoch(state, shown, *plan.batch, seed).largest);
        }
    return nn::quantile(smallest, 0.5);
  }

  const tactel::ScratchFolder directory_;
  nn::FrameSet set_ = bumps(40, 16, 3);
};

// A network of a training is what the reference makes of its seed, noise and set. 150 cycles in fp64: see
// train_online_test.cpp.
TEST_F(NetworkTrainingTest, TrainsEveryNetworkOnItsOwnSet) {
  NetworkTraining<double> training(executor(), set_, small_plan());
  EXPECT_TRUE(training.run());
  ASSERT_EQ(training.networks().size(), 12u);
  const std::vector<nn::ErrorReport> learnt = training.recall_learning_set();
  for (std::size_t i = 0; i < 12; ++i) {
    const TrainedNetwork& network = training.networks()[i];
    EXPECT_EQ(network.topology.text(), i < 6 ? "16-16-8-1" : "16-9-1");
    EXPECT_EQ(network.noise, i % 6 < 3 ? 0.0 : 0.1);
    EXPECT_EQ(network.seed, small_plan().seeds[i % 3]);
    EXPECT_EQ(network.status, nn::TrainStatus::cycle_limit);
    const nn::FrameSet shown = nn::with_noise(set_, network.noise, network.seed);
    nn::OnlineState<double> reference(nn::initial_weights(network.topology, network.seed));
    nn::OnlineOptions options{.cycle_limit = 150};
    const nn::CycleErrors last =
        nn::train_online(reference, nn::training_set<double>(shown, training.scaling()), options, network.seed, 150);
    EXPECT_LT(tactel::tests::largest_difference(training.weights(i).values, reference.weights.values), 1e-9);
    EXPECT_NEAR(network.sse, last.sse, 1e-6 * last.sse);  // kept as float
    const auto answer = nn::recall(reference.weights, training.scaling(), shown.frames);
    EXPECT_NEAR(learnt[i].all.mean, nn::report_errors(nn::absolute_errors(answer.slip_index, shown), shown).all.mean,
                1e-9);
    EXPECT_EQ(network.curve.front().cycle, 1u);
    EXPECT_EQ(network.curve.back().cycle, 150u);
    EXPECT_EQ(network.curve.back().rows, 150u * 40);
    EXPECT_EQ(network.curve.back().sse, network.sse);
    EXPECT_FLOAT_EQ(network.curve.back().mean_square, network.sse / 40);
  }
  EXPECT_EQ(training.patterns(), 12.0 * 150 * 40);
}

// The same by mini-batches. With a stop error that some of them reach, networks leave the training at different epochs
// and must still be what the reference makes of them alone; fp64, see train_batch_test.cpp.
TEST_F(NetworkTrainingTest, TrainsByMiniBatches) {
  TrainingPlan plan = small_plan();
  plan.options.cycle_limit = 60;
  plan.batch = nn::BatchOptions{.batch = 16, .rate = 0.02};
  const double stop = plan.options.stop_error = stop_of_half(plan);
  NetworkTraining<double> training(executor(), set_, plan);
  EXPECT_TRUE(training.run());
  std::set<nn::TrainStatus> seen;
  for (std::size_t i = 0; i < 12; ++i) {
    const TrainedNetwork& network = training.networks()[i];
    const auto shown = nn::training_set<double>(nn::with_noise(set_, network.noise, network.seed), training.scaling());
    nn::BatchState<double> reference(nn::initial_weights(network.topology, network.seed));
    nn::CycleErrors last{.sse = 0, .largest = 1};
    while (reference.epoch < 60 && last.largest >= stop)
      last = nn::train_epoch(reference, shown, *plan.batch, network.seed);
    EXPECT_EQ(network.cycles, reference.epoch) << i;
    EXPECT_EQ(network.status, last.largest < stop ? nn::TrainStatus::learnt : nn::TrainStatus::cycle_limit) << i;
    EXPECT_LT(tactel::tests::largest_difference(training.weights(i).values, reference.weights.values), 1e-9) << i;
    EXPECT_NEAR(network.sse, last.sse, 1e-6 * last.sse) << i;  // kept as float
    EXPECT_EQ(network.curve.back().cycle, network.cycles) << i;
    seen.insert(network.status);
  }
  EXPECT_EQ(seen.size(), 2u);
}

TEST_F(NetworkTrainingTest, MiniBatchesResumeToTheSameBits) {
  TrainingPlan plan = small_plan();
  plan.options.cycle_limit = 60;
  plan.batch = nn::BatchOptions{.batch = 16, .rate = 0.02};
  plan.options.stop_error = stop_of_half(plan);
  for (Executor* on : {&executor(), &gpu()}) {
    NetworkTraining<float> whole(*on, set_, plan), stopped(*on, set_, plan), resumed(*on, set_, plan);
    EXPECT_TRUE(whole.run());
    int calls = 0;  // one a round: some networks have stopped by then, others have epochs left
    const auto some = [&calls](std::size_t, std::size_t) { return ++calls < 58; };
    EXPECT_FALSE(stopped.run({.progress = some, .checkpoint = checkpoint()}));
    EXPECT_TRUE(resumed.load(checkpoint()));
    std::set<nn::TrainStatus> seen;
    for (const TrainedNetwork& network : resumed.networks()) seen.insert(network.status);
    EXPECT_EQ(seen, (std::set{nn::TrainStatus::running, nn::TrainStatus::learnt}));
    EXPECT_TRUE(resumed.run());
    EXPECT_TRUE(stopped.run());
    expect_same(resumed, whole);
    expect_same(stopped, whole);
    EXPECT_EQ(resumed.patterns(), whole.patterns());
  }
  plan.batch->rate = 0.01;
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("of another training"));
}

// What a process that died has left: its last checkpoint, of a round before.
TEST_F(NetworkTrainingTest, TakesUpFromTheCheckpointOfOneThatDiedOnAGpu) {
  TrainingPlan online = small_plan(), large = small_plan();
  online.options.cycle_limit = large.options.cycle_limit = 30;
  large.batch = nn::BatchOptions{.batch = 16, .average = 0.9};
  set_ = bumps(300, 16, 3);
  TrainingPlan small = large;
  large.batch->batch = 200;
  for (const TrainingPlan& plan : {online, small, large}) {
    NetworkTraining<float> whole(gpu(), set_, plan), died(gpu(), set_, plan), resumed(gpu(), set_, plan);
    EXPECT_TRUE(whole.run());
    int calls = 0;
    const auto die = [&calls](std::size_t, std::size_t) -> bool {
      return ++calls < 5 ? true : throw std::runtime_error("died");
    };
    EXPECT_THROW(died.run({.progress = die, .checkpoint = checkpoint(), .checkpoint_seconds = 0}), std::runtime_error);
    ASSERT_TRUE(resumed.load(checkpoint()));
    EXPECT_GT(resumed.networks()[0].cycles, 0u);
    EXPECT_TRUE(resumed.networks()[0].running());
    EXPECT_TRUE(resumed.run());
    expect_same(resumed, whole);
    fs::remove(checkpoint());
  }
}

/// Rows whose S is that of the learning set turned round, 1 - S: what helps there is a fault here.
std::shared_ptr<const nn::FrameSet> contrary(nn::FrameSet set) {
  set.slip_index = 1 - set.slip_index.array();
  return std::make_shared<nn::FrameSet>(std::move(set));
}

// What a training by the reference keeps and where it stops: by the validation set's errors, of the mean of the
// weights. On a contrary set every network stops early, on the learning set itself some learn to the end.
TEST_F(NetworkTrainingTest, KeepsTheBestWeightsOfAValidationSet) {
  for (const bool against : {true, false}) {
    TrainingPlan plan = small_plan();
    plan.options.cycle_limit = 60;
    plan.options.stop_error = 0;
    plan.batch = nn::BatchOptions{.batch = 16, .rate = 0.02, .cosine = true, .planned_rows = 60 * 40, .average = 0.5};
    plan.validation = against ? contrary(set_) : std::make_shared<nn::FrameSet>(set_);
    plan.patience = 7;
    NetworkTraining<double> training(executor(), set_, plan);
    EXPECT_TRUE(training.run());
    std::uint32_t late = 0;
    for (std::size_t i = 0; i < 12; ++i) {
      const TrainedNetwork& network = training.networks()[i];
      const auto shown =
          nn::training_set<double>(nn::with_noise(set_, network.noise, network.seed), training.scaling());
      nn::BatchState<double> reference(nn::initial_weights(network.topology, network.seed));
      nn::Weights<double> best = reference.weights;
      double least = 1;
      std::uint32_t at = 0;
      while (reference.epoch < 60 && reference.epoch - at < 7) {
        nn::train_epoch(reference, shown, *plan.batch, network.seed);
        const auto answer = nn::recall(reference.mean, training.scaling(), plan.validation->frames);
        const double error = nn::summarize(nn::absolute_errors(answer.slip_index, *plan.validation)).mean;
        if (error < least) least = error, at = reference.epoch, best = reference.mean;
      }
      EXPECT_EQ(network.status, reference.epoch < 60 ? nn::TrainStatus::early_stop : nn::TrainStatus::cycle_limit) << i;
      EXPECT_TRUE(!against || network.cycles < 60) << i;
      late = std::max(late, network.best_cycle);
      EXPECT_EQ(network.cycles, reference.epoch) << i;
      EXPECT_EQ(network.best_cycle, at) << i;
      EXPECT_NEAR(network.best_error, least, 1e-9) << i;  // as the weights, below
      EXPECT_LT(tactel::tests::largest_difference(training.weights(i).values, best.values), 1e-9) << i;
      EXPECT_EQ(network.curve.back().cycle, network.cycles) << i;
      EXPECT_GE(network.curve.back().validation, network.best_error) << i;
      EXPECT_EQ(training.model(i, "bumps", {}).cycles, network.best_cycle) << i;
    }
    EXPECT_TRUE(against || late > 50) << late;
  }
}

TEST_F(NetworkTrainingTest, ValidatedTrainingsResumeToTheSameBits) {
  TrainingPlan plan = small_plan();
  plan.options.cycle_limit = 40;
  plan.options.stop_error = 0;
  plan.batch = nn::BatchOptions{.batch = 16, .rate = 0.02, .cosine = true, .average = 0.9};
  plan.validation = contrary(set_);
  plan.patience = 12;
  NetworkTraining<float> whole(executor(), set_, plan);
  EXPECT_TRUE(whole.run());
  std::set<std::uint32_t> ends;
  for (const TrainedNetwork& network : whole.networks()) ends.insert(network.cycles);
  for (const int rounds : {1, static_cast<int>(*ends.begin()) - 1, static_cast<int>(*ends.begin()) + 1}) {
    NetworkTraining<float> stopped(executor(), set_, plan), resumed(executor(), set_, plan);
    int calls = 0;
    const auto some = [&](std::size_t, std::size_t) { return ++calls < 2 * rounds; };
    stopped.run({.progress = some, .checkpoint = checkpoint()});
    ASSERT_TRUE(resumed.load(checkpoint()));
    EXPECT_TRUE(resumed.run());
    SCOPED_TRACE(rounds);
    expect_same(resumed, whole);
  }
  plan.patience = 13;
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("of another training"));
  plan.patience = 12;
  plan.validation = std::make_shared<nn::FrameSet>(set_);
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("of another training"));
}

// A single network is a single group of work: it, too, must hear that it shall stop.
TEST_F(NetworkTrainingTest, StopsASingleNetwork) {
  TrainingPlan plan = small_plan();
  plan.topologies.resize(1, nn::Topology::parse("16-16-8-1"));
  plan.seeds = {3};
  plan.noises = {0};
  plan.options.stop_error = 0;
  plan.options.cycle_limit = 1'000'000;
  NetworkTraining<float> training(executor(), set_, plan);
  EXPECT_FALSE(training.run({.progress = [](std::size_t, std::size_t) { return false; }, .checkpoint = {}}));
  EXPECT_LT(training.networks()[0].cycles, 1'000'000u);
}

// Stopped at any time, written, read by another training and finished: the same bits as never stopped, curves included.
TEST_F(NetworkTrainingTest, ResumesToTheSameBits) {
  NetworkTraining<float> whole(executor(), set_, small_plan());
  EXPECT_TRUE(whole.run());
  {
    NetworkTraining<float> stopped(executor(), set_, small_plan());
    int calls = 0;
    EXPECT_FALSE(
        stopped.run({.progress = [&](std::size_t done, std::size_t all) { return done <= all && ++calls < 20; },
                     .checkpoint = checkpoint()}));
  }
  NetworkTraining<float> resumed(executor(), set_, small_plan());
  EXPECT_TRUE(resumed.load(checkpoint()));
  const bool some_left =
      std::any_of(resumed.networks().begin(), resumed.networks().end(), [](const auto& n) { return n.cycles < 150; });
  EXPECT_TRUE(some_left);
  EXPECT_TRUE(resumed.run({.progress = {}, .checkpoint = checkpoint()}));
  NetworkTraining<float> finished(executor(), set_, small_plan());
  EXPECT_TRUE(finished.load(checkpoint()));
  EXPECT_TRUE(finished.run());
  expect_same(resumed, whole);
  expect_same(finished, whole);
}

TEST_F(NetworkTrainingTest, RefusesCheckpointsThatAreNotItsOwn) {
  TrainingPlan plan = small_plan();
  plan.options.cycle_limit = 2;
  NetworkTraining<float> training(executor(), set_, plan);
  EXPECT_FALSE(training.load(checkpoint()));  // there is none
  training.run({.progress = {}, .checkpoint = checkpoint()});
  EXPECT_EQ(message_of_load(plan, set_), "no error");

  TrainingPlan other = plan;
  other.seeds[0] = 5;
  EXPECT_THAT(message_of_load(other, set_), ::testing::HasSubstr("of another training"));
  nn::FrameSet other_set = set_;
  other_set.frames(7, 3) += 1e-3f;
  EXPECT_THAT(message_of_load(plan, other_set), ::testing::HasSubstr("of another training"));

  const auto size = fs::file_size(checkpoint());
  fs::resize_file(checkpoint(), size - 5);
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("damaged"));
  fs::resize_file(checkpoint(), 22);
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("cut short"));
  std::ofstream(checkpoint()) << "[sensor]\nlength = 20\n";
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("not a checkpoint"));
  EXPECT_THROW(training.save(directory_ / "nowhere" / "file"), ConfigError);
}

/// Records as the training of a plan keeps them, to be changed.
std::vector<NetworkRecord<float>> records_of(const TrainingPlan& plan, std::uint32_t cycles) {
  std::vector<NetworkRecord<float>> records;
  for (const nn::Topology& topology : plan.topologies)
    for (const double noise : plan.noises)
      for (const std::uint64_t seed : plan.seeds) {
        NetworkRecord<float> record{.network = {.topology = topology, .seed = seed, .noise = noise, .cycles = cycles},
                                    .state = nn::BatchState<float>(nn::initial_weights(topology, seed))};
        if (!plan.batch) record.state.second.values.clear();
        records.push_back(std::move(record));
      }
  return records;
}

struct CraftedCheckpoint {
  const char* name;
  bool batch;
  std::function<void(std::vector<NetworkRecord<float>>&)> change;
};

// Checkpoints with a right checksum and plan that no training wrote: refused, without a crash, a hang, or memory asked
// for by a number in the file.
TEST_F(NetworkTrainingTest, CraftedCheckpointsAreRefused) {
  using Records = std::vector<NetworkRecord<float>>;
  const std::vector<CraftedCheckpoint> all = {
      {"running at the limit", false, [](Records& r) { r[0].network.cycles = 150; }},
      {"beyond the limit", false, [](Records& r) { r[1].network.cycles = 0xffffffff; }},
      {"running at the limit", true, [](Records& r) { r[0].network.cycles = 150; }},
      {"at different epochs", true, [](Records& r) { r[0].network.cycles = 7; }},
      {"status that is none", false, [](Records& r) { r[2].network.status = static_cast<nn::TrainStatus>(9); }},
      {"negative status", false, [](Records& r) { r[2].network.status = static_cast<nn::TrainStatus>(255); }},
      {"seconds NaN", false, [](Records& r) { r[0].network.seconds = std::nan(""); }},
      {"seconds negative", false, [](Records& r) { r[0].network.seconds = -1; }},
      {"curve that falls", false,
       [](Records& r) {
         r[0].network.curve = {{.cycle = 2}, {.cycle = 1}};
       }},
      {"curve of the future", false, [](Records& r) { r[0].network.curve = {{.cycle = 149}}; }},
      {"weights of another", false, [](Records& r) { r[0].state.weights.values.pop_back(); }},
      {"no weights", true, [](Records& r) { r[0].state.weights.values.clear(); }},
      {"moments too many", true, [](Records& r) { r[0].state.second.values.resize(10'000); }},
      {"a mean without one", true, [](Records& r) { r[0].state.mean.values.resize(r[0].state.weights.values.size()); }},
      {"best weights without a set", true,
       [](Records& r) {
         r[0].best.resize(r[0].state.weights.values.size());
         r[0].network.best_cycle = 1;
       }},
      {"best weights too few", true, [](Records& r) { r[0].best.resize(3); }},
      {"best error NaN", true, [](Records& r) { r[0].network.best_error = std::nan(""); }},
      {"one network less", false, [](Records& r) { r.pop_back(); }},
      {"one network more", false, [](Records& r) { r.push_back(r[0]); }},
  };
  for (const CraftedCheckpoint& crafted : all) {
    TrainingPlan plan = small_plan();
    if (crafted.batch) plan.batch = nn::BatchOptions{.batch = 16, .rate = 0.02};
    const std::string description = NetworkTraining<float>(executor(), set_, plan).description();
    std::vector<NetworkRecord<float>> records = records_of(plan, 5);
    write_checkpoint<float>(checkpoint(), description, records);
    EXPECT_EQ(message_of_load(plan, set_), "no error") << crafted.name;
    crafted.change(records);
    write_checkpoint<float>(checkpoint(), description, records);
    EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("must be")) << crafted.name;
  }
}

// The length of an item is the file's word: it must not be believed.
TEST_F(NetworkTrainingTest, LengthsInACheckpointAreNotBelieved) {
  const TrainingPlan plan = small_plan();
  const std::string magic = "tactel checkpoint 5\n",
                    text = NetworkTraining<float>(executor(), set_, plan).description();
  const auto bytes = [](std::uint64_t number) { return std::string(reinterpret_cast<char*>(&number), sizeof number); };
  for (const std::uint64_t length :
       {std::uint64_t{1} << 62, ~std::uint64_t{0}, ~std::uint64_t{0} - 7, std::uint64_t{1} << 40}) {
    for (const std::string& body : {bytes(length), bytes(text.size()) + text + bytes(length) + "1234567890123456"}) {
      std::ofstream(checkpoint(), std::ios::binary) << magic << bytes(checksum(body)) << body;
      EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("cut short"));
    }
  }
  std::ofstream(checkpoint(), std::ios::binary) << "tactel checkpoint 4\n";
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("another version"));
  fs::resize_file(checkpoint(), std::uintmax_t{1} << 40);  // a hole: it takes no room
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("larger than"));
  fs::remove(checkpoint());
  fs::create_symlink("/dev/zero", checkpoint());
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("it is no regular file"));
  fs::remove(checkpoint());
  fs::create_directory(checkpoint());
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("it is a folder"));
}

TEST_F(NetworkTrainingTest, JudgesNetworksOnAnotherSet) {
  TrainingPlan plan = small_plan();
  plan.options.cycle_limit = 400;
  plan.noises = {0.0};
  NetworkTraining<float> training(executor(), set_, plan);
  training.run();
  nn::FrameSet other = bumps(25, 16, 8);
  for (int row = 0; row < 25; ++row) other.shape_class.push_back(static_cast<std::uint16_t>(row % 3));
  const std::vector<nn::ErrorReport> reports = training.recall(other);
  ASSERT_EQ(reports.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto answer = nn::recall(training.weights(i), training.scaling(), other.frames);
    const nn::ErrorReport expected = nn::report_errors(nn::absolute_errors(answer.slip_index, other), other);
    EXPECT_NEAR(reports[i].all.max, expected.all.max, 1e-6);  // fp32 and the activation's bound
    EXPECT_EQ(reports[i].by_class.size(), 3u);
    EXPECT_LT(reports[i].all.mean, 0.2);  // it has learnt something: guessing 0.5 gives 0.25
  }
  const nn::Model model = training.model(4, "bumps", training.recall_learning_set()[4].all);
  EXPECT_EQ(model.weights.values, training.weights(4).values);
  EXPECT_EQ(model.seed, 4u);
  EXPECT_EQ(model.cycles, 400u);
  EXPECT_EQ(model.learning_errors.count, 40u);
}

TEST_F(NetworkTrainingTest, RefusesPlansThatCannotWork) {
  TrainingPlan plan = small_plan();
  plan.validation = std::make_shared<nn::FrameSet>(set_);  // pattern by pattern
  EXPECT_THROW(NetworkTraining<float>(executor(), set_, plan), ValueError);
  plan = small_plan();
  plan.seeds.clear();
  EXPECT_THROW(NetworkTraining<float>(executor(), set_, plan), ValueError);
  plan = small_plan();
  for (const double noise : {-0.1, 1.001, std::nan("")}) {
    plan.noises = {noise};
    EXPECT_THROW(NetworkTraining<float>(executor(), set_, plan), ValueError);
  }
  plan = small_plan();
  plan.topologies.push_back(nn::Topology::paper(1));
  EXPECT_THROW(NetworkTraining<float>(executor(), set_, plan), ValueError);
}

}  // namespace network_training_test
