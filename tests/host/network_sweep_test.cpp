// Sweeps over topologies, seeds and noise: results, checkpoints, cancelling.
#include "host/network_sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "fem/value_error.h"
#include "network_cases.h"

namespace {

using namespace tactel;
using namespace tactel::host;
using tactel::testing::bumps;
using tactel::testing::executor;
namespace fs = std::filesystem;

SweepPlan small_plan() {
  SweepPlan plan;
  plan.topologies = {nn::Topology::parse("16-16-8-1"), nn::Topology::parse("16-9-1")};
  plan.seeds = {3, 4, 11};
  plan.noises = {0.0, 0.1};
  plan.options.cycle_limit = 150;
  return plan;
}

class NetworkSweepTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = fs::temp_directory_path() /
                 ("tactel_sweep_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(directory_);
    fs::create_directories(directory_);
  }
  void TearDown() override { fs::remove_all(directory_); }
  fs::path checkpoint() const { return directory_ / "sweep.checkpoint"; }
  std::string message_of_load(const SweepPlan& plan, const nn::FrameSet& set) const {
    NetworkSweep<float> sweep(executor(), set, plan);
    try {
      sweep.load(checkpoint());
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "no error";
  }

  /// A stop error that half of a plan's networks reach, by what the reference does with mini-batches.
  double stop_of_half(const SweepPlan& plan) const {
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

  fs::path directory_;
  nn::FrameSet set_ = bumps(40, 16, 3);
};

// A network of a sweep is what the reference makes of its seed, noise and set. 150 cycles in fp64: see
// train_online_test.cpp.
TEST_F(NetworkSweepTest, TrainsEveryNetworkOnItsOwnSet) {
  NetworkSweep<double> sweep(executor(), set_, small_plan());
  EXPECT_TRUE(sweep.run());
  ASSERT_EQ(sweep.networks().size(), 12u);
  const std::vector<nn::ErrorReport> learnt = sweep.recall_learning_set();
  for (std::size_t i = 0; i < 12; ++i) {
    const SweepNetwork& network = sweep.networks()[i];
    EXPECT_EQ(network.topology.text(), i < 6 ? "16-16-8-1" : "16-9-1");
    EXPECT_EQ(network.noise, i % 6 < 3 ? 0.0 : 0.1);
    EXPECT_EQ(network.seed, small_plan().seeds[i % 3]);
    EXPECT_EQ(network.status, nn::TrainStatus::cycle_limit);
    const nn::FrameSet shown = nn::with_noise(set_, network.noise, network.seed);
    nn::OnlineState<double> reference(nn::initial_weights(network.topology, network.seed));
    nn::OnlineOptions options{.cycle_limit = 150};
    const nn::CycleErrors last =
        nn::train_online(reference, nn::training_set<double>(shown, sweep.scaling()), options, network.seed, 150);
    EXPECT_LT(tactel::testing::largest_difference(sweep.weights(i).values, reference.weights.values), 1e-9);
    EXPECT_NEAR(network.sse, last.sse, 1e-6 * last.sse);  // kept as float
    const auto answer = nn::recall(reference.weights, sweep.scaling(), shown.frames);
    EXPECT_NEAR(learnt[i].all.mean, nn::report_errors(nn::absolute_errors(answer.slip_index, shown), shown).all.mean,
                1e-9);
    EXPECT_EQ(network.curve.cycle.front(), 1u);
    EXPECT_EQ(network.curve.cycle.back(), 150u);
    EXPECT_EQ(network.curve.sse.back(), network.sse);
  }
  EXPECT_EQ(sweep.patterns(), 12.0 * 150 * 40);
}

// The same by mini-batches. With a stop error that some of them reach, networks leave the sweep at different epochs and
// must still be what the reference makes of them alone; fp64, see train_batch_test.cpp.
TEST_F(NetworkSweepTest, TrainsByMiniBatches) {
  SweepPlan plan = small_plan();
  plan.options.cycle_limit = 60;
  plan.batch = nn::BatchOptions{.batch = 16, .rate = 0.02};
  const double stop = plan.options.stop_error = stop_of_half(plan);
  NetworkSweep<double> sweep(executor(), set_, plan);
  EXPECT_TRUE(sweep.run());
  std::set<nn::TrainStatus> seen;
  for (std::size_t i = 0; i < 12; ++i) {
    const SweepNetwork& network = sweep.networks()[i];
    const auto shown = nn::training_set<double>(nn::with_noise(set_, network.noise, network.seed), sweep.scaling());
    nn::BatchState<double> reference(nn::initial_weights(network.topology, network.seed));
    nn::CycleErrors last{.sse = 0, .largest = 1};
    while (reference.epoch < 60 && last.largest >= stop)
      last = nn::train_epoch(reference, shown, *plan.batch, network.seed);
    EXPECT_EQ(network.cycles, reference.epoch) << i;
    EXPECT_EQ(network.status, last.largest < stop ? nn::TrainStatus::learnt : nn::TrainStatus::cycle_limit) << i;
    EXPECT_LT(tactel::testing::largest_difference(sweep.weights(i).values, reference.weights.values), 1e-9) << i;
    EXPECT_NEAR(network.sse, last.sse, 1e-6 * last.sse) << i;  // kept as float
    EXPECT_EQ(network.curve.cycle.back(), network.cycles) << i;
    seen.insert(network.status);
  }
  EXPECT_EQ(seen.size(), 2u);
}

TEST_F(NetworkSweepTest, MiniBatchesResumeToTheSameBits) {
  SweepPlan plan = small_plan();
  plan.options.cycle_limit = 60;
  plan.batch = nn::BatchOptions{.batch = 16, .rate = 0.02};
  plan.options.stop_error = stop_of_half(plan);
  NetworkSweep<float> whole(executor(), set_, plan), stopped(executor(), set_, plan), resumed(executor(), set_, plan);
  EXPECT_TRUE(whole.run());
  int calls = 0;  // one a round: some networks have stopped by then, others have epochs left
  const auto some = [&calls](std::size_t, std::size_t) { return ++calls < 58; };
  EXPECT_FALSE(stopped.run({.progress = some, .checkpoint = checkpoint()}));
  EXPECT_TRUE(resumed.load(checkpoint()));
  std::set<nn::TrainStatus> seen;
  for (const SweepNetwork& network : resumed.networks()) seen.insert(network.status);
  EXPECT_EQ(seen, (std::set{nn::TrainStatus::running, nn::TrainStatus::learnt}));
  EXPECT_TRUE(resumed.run());
  EXPECT_TRUE(stopped.run());
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(resumed.weights(i).values, whole.weights(i).values) << i;
    EXPECT_EQ(stopped.weights(i).values, whole.weights(i).values) << i;
    EXPECT_EQ(resumed.networks()[i].curve.sse, whole.networks()[i].curve.sse) << i;
    EXPECT_EQ(resumed.networks()[i].cycles, whole.networks()[i].cycles) << i;
  }
  EXPECT_EQ(resumed.patterns(), whole.patterns());
  plan.batch->rate = 0.01;
  EXPECT_THAT(message_of_load(plan, set_), ::testing::HasSubstr("of another training"));
}

// A single network is a single group of work: it, too, must hear that it shall stop.
TEST_F(NetworkSweepTest, StopsASingleNetwork) {
  SweepPlan plan = small_plan();
  plan.topologies.resize(1, nn::Topology::parse("16-16-8-1"));
  plan.seeds = {3};
  plan.noises = {0};
  plan.options.stop_error = 0;
  plan.options.cycle_limit = 1'000'000;
  NetworkSweep<float> sweep(executor(), set_, plan);
  EXPECT_FALSE(sweep.run({.progress = [](std::size_t, std::size_t) { return false; }, .checkpoint = {}}));
  EXPECT_LT(sweep.networks()[0].cycles, 1'000'000u);
}

// Stopped at any time, written, read by another sweep and finished: the same bits as never stopped, curves included.
TEST_F(NetworkSweepTest, ResumesToTheSameBits) {
  NetworkSweep<float> whole(executor(), set_, small_plan());
  EXPECT_TRUE(whole.run());
  {
    NetworkSweep<float> stopped(executor(), set_, small_plan());
    int calls = 0;
    EXPECT_FALSE(
        stopped.run({.progress = [&](std::size_t done, std::size_t all) { return done <= all && ++calls < 20; },
                     .checkpoint = checkpoint()}));
  }
  NetworkSweep<float> resumed(executor(), set_, small_plan());
  EXPECT_TRUE(resumed.load(checkpoint()));
  const bool some_left =
      std::any_of(resumed.networks().begin(), resumed.networks().end(), [](const auto& n) { return n.cycles < 150; });
  EXPECT_TRUE(some_left);
  EXPECT_TRUE(resumed.run({.progress = {}, .checkpoint = checkpoint()}));
  NetworkSweep<float> finished(executor(), set_, small_plan());
  EXPECT_TRUE(finished.load(checkpoint()));
  EXPECT_TRUE(finished.run());
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(resumed.weights(i).values, whole.weights(i).values) << i;
    EXPECT_EQ(finished.weights(i).values, whole.weights(i).values) << i;
    EXPECT_EQ(resumed.networks()[i].curve.cycle, whole.networks()[i].curve.cycle) << i;
    EXPECT_EQ(resumed.networks()[i].curve.sse, whole.networks()[i].curve.sse) << i;
    EXPECT_EQ(finished.networks()[i].curve.largest, whole.networks()[i].curve.largest) << i;
  }
}

TEST_F(NetworkSweepTest, RefusesCheckpointsThatAreNotItsOwn) {
  SweepPlan plan = small_plan();
  plan.options.cycle_limit = 2;
  NetworkSweep<float> sweep(executor(), set_, plan);
  EXPECT_FALSE(sweep.load(checkpoint()));  // there is none
  sweep.run({.progress = {}, .checkpoint = checkpoint()});
  EXPECT_EQ(message_of_load(plan, set_), "no error");

  SweepPlan other = plan;
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
  EXPECT_THROW(sweep.save(directory_ / "nowhere" / "file"), ConfigError);
}

TEST_F(NetworkSweepTest, JudgesNetworksOnAnotherSet) {
  SweepPlan plan = small_plan();
  plan.options.cycle_limit = 400;
  plan.noises = {0.0};
  NetworkSweep<float> sweep(executor(), set_, plan);
  sweep.run();
  nn::FrameSet other = bumps(25, 16, 8);
  for (int row = 0; row < 25; ++row) other.shape_class.push_back(static_cast<std::uint16_t>(row % 3));
  const std::vector<nn::ErrorReport> reports = sweep.recall(other);
  ASSERT_EQ(reports.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto answer = nn::recall(sweep.weights(i), sweep.scaling(), other.frames);
    const nn::ErrorReport expected = nn::report_errors(nn::absolute_errors(answer.slip_index, other), other);
    EXPECT_NEAR(reports[i].all.max, expected.all.max, 1e-6);  // fp32 and the activation's bound
    EXPECT_EQ(reports[i].by_class.size(), 3u);
    EXPECT_LT(reports[i].all.mean, 0.2);  // it has learnt something: guessing 0.5 gives 0.25
  }
  const nn::Model model = sweep.model(4, "bumps");
  EXPECT_EQ(model.weights.values, sweep.weights(4).values);
  EXPECT_EQ(model.seed, 4u);
  EXPECT_EQ(model.cycles, 400u);
  EXPECT_EQ(model.learning_errors.count, 40u);
}

TEST_F(NetworkSweepTest, RefusesPlansThatCannotWork) {
  SweepPlan plan = small_plan();
  plan.seeds.clear();
  EXPECT_THROW(NetworkSweep<float>(executor(), set_, plan), ValueError);
  plan = small_plan();
  plan.noises = {-0.1};
  EXPECT_THROW(NetworkSweep<float>(executor(), set_, plan), ValueError);
  plan = small_plan();
  plan.topologies.push_back(nn::Topology::paper(1));
  EXPECT_THROW(NetworkSweep<float>(executor(), set_, plan), ValueError);
}

}  // namespace
