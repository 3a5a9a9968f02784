// SPDX-License-Identifier: Apache-2.0

// The forward kernels against their Eigen twin, against each other, and against what every recall must obey.
#include "host/networks/forward.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "fem/numbers/value_error.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/host/networks/network_cases.h"

namespace forward_test {

using namespace tactel;
using namespace tactel::host;
using nn::FrameStatus;
using nn::ScalingKind;
using tactel::tests::bumps;
using tactel::tests::executor;

template <class Real>
std::vector<nn::Weights<Real>> some_networks(const nn::Topology& topology, int count) {
  std::vector<nn::Weights<Real>> networks;
  networks.reserve(static_cast<std::size_t>(count));
  for (int seed = 0; seed < count; ++seed) networks.emplace_back(nn::initial_weights(topology, seed));
  return networks;
}

bool same_bits(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

const nn::InputScaling by_set{ScalingKind::set, 1.3f}, by_frame{ScalingKind::frame, 1.0f};

class ForwardTopology : public ::testing::TestWithParam<const char*> {};

// fp64: sums of at most 84 terms of size 0.5 in another order, through three layers whose slope is at most 1/4 a
// weight: some 1e-15. fp32: the same with 6e-8, and an activation that is right to 1.7e-7; measured 2e-7. Leaky
// rectifiers pass sums on, of size 1 by their initial weights.
TEST_P(ForwardTopology, MatchesReference) {
  const nn::Topology topology = nn::Topology::parse(GetParam());
  const nn::RowMatrix<float> frames = bumps(203, topology.inputs(), 4).frames;
  for (const nn::InputScaling& scaling : {by_set, by_frame}) {
    const auto fp64 = some_networks<double>(topology, 1);
    const auto fp32 = some_networks<float>(topology, 1);
    const nn::Recall<double> truth = nn::recall(fp64[0], scaling, frames);
    const nn::Recall<double> d = Forward<double>(executor(), fp64, scaling).recall(frames);
    const nn::Recall<float> f = Forward<float>(executor(), fp32, scaling).recall(frames);
    EXPECT_LT((d.slip_index - truth.slip_index).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((f.slip_index.cast<double>() - truth.slip_index).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_EQ(d.status, truth.status);
    EXPECT_EQ(f.status, truth.status);
  }
}

INSTANTIATE_TEST_SUITE_P(Topologies, ForwardTopology,
                         ::testing::Values("1", "16-16-8-1", "2-1-1", "16-16-8-3", "16-16-8-3_leaky-relu"));
INSTANTIATE_TEST_SUITE_P(Nightly, ForwardTopology,
                         ::testing::Values("5", "18-33-3", "18-33-1_leaky-relu", "30-31-33-1",
                                           "30-31-33-3_leaky-relu"));

// The heads of a bound: the reference's quantiles to the tolerances above, a frame alone as in a batch bit for bit, and
// S that of the network with its first head alone, bit for bit.
TEST(ForwardHeads, MatchTheReferenceAndTheNetworkOfOneOutput) {
  for (const char* name : {"16-16-8-3", "16-16-8-3_leaky-relu"}) {
    const nn::Topology topology = nn::Topology::parse(name);
    const nn::RowMatrix<float> frames = bumps(203, topology.inputs(), 4).frames;
    const auto fp64 = some_networks<double>(topology, 2);
    const auto fp32 = some_networks<float>(topology, 2);
    std::vector<int> widths = topology.widths();
    widths.back() = 1;
    nn::Weights<float> first_head{nn::Topology(widths, topology.hidden_activation())};
    std::copy_n(fp32[1].values.begin(), first_head.values.size(), first_head.values.begin());
    Forward<double> d(executor(), fp64, by_frame);
    Forward<float> f(executor(), fp32, by_frame);
    const DeviceFrames on_device(executor().device(), frames);
    d.run(on_device);
    f.run(on_device);
    const nn::Recall<double> truth = nn::recall(fp64[1], by_frame, frames), double_answer = d.result(1);
    const nn::Recall<float> answer = f.result(1);
    EXPECT_LT((double_answer.upper - truth.upper).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((double_answer.lower - truth.lower).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((answer.upper.cast<double>() - truth.upper).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((answer.lower.cast<double>() - truth.lower).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_GT(answer.upper.maxCoeff() - answer.upper.minCoeff(), 1e-3);
    EXPECT_EQ(answer.slip_index,
              Forward<float>(executor(), std::span(&first_head, 1), by_frame).recall(frames).slip_index);
    Forward<float> one(executor(), std::span(&fp32[1], 1), by_frame);
    for (int row = 0; row < 203; ++row) {
      const nn::Recall<float> alone = one.recall(frames.row(row));
      EXPECT_EQ(alone.slip_index(0), answer.slip_index(row)) << row;
      EXPECT_EQ(alone.upper(0), answer.upper(row)) << row;
      EXPECT_EQ(alone.lower(0), answer.lower(row)) << row;
    }
  }
}

// A sum that overflows in one head leaves no answer at all.
TEST(ForwardHeads, HaveNoAnswerWhereOneOverflows) {
  const nn::Topology topology = nn::Topology::parse("14-9-3");
  const nn::RowMatrix<float> frames = bumps(5, 14, 4).frames;
  auto networks = some_networks<float>(topology, 1);
  networks[0].layer(1).row(1).setConstant(3e38f);
  networks[0].layer(1)(1, 0) = -3e38f;
  networks[0].layer(0).leftCols(14).row(0).setConstant(0);
  networks[0].layer(0)(0, 14) = 30;  // the first neuron gives 1/2, the others what they like: infinity minus infinity
  networks[0].layer(0).rightCols(1).setConstant(30);
  networks[0].layer(1)(1, 9) = 3e38f;
  const nn::Recall<float> answer = Forward<float>(executor(), networks, by_frame).recall(frames);
  for (int row = 0; row < 5; ++row) {
    if (answer.status[row] == FrameStatus::ok) continue;
    EXPECT_EQ(answer.status[row], FrameStatus::overflow);
    EXPECT_TRUE(std::isnan(answer.slip_index(row)) && std::isnan(answer.upper(row)) && std::isnan(answer.lower(row)));
  }
}

/// Of one network's bound another, with fewer edges and other tables.
nn::Bound other_bound(const nn::Model& model) {
  nn::Bound bound = *model.bound;
  bound.distance.clear(), bound.touching = {1.5f};
  bound.upper_correction.assign(bound.classes(), 0.01f), bound.interval_correction.assign(bound.classes(), 0.03f);
  bound.unlike_above = 0.3f * model.bound->unlike_above;
  return bound;
}

// The bound of two networks in a launch: the bits of the twin on the kernel's own quantiles, at ragged sizes and in
// every lane. Frames that are not finite have no bound.
TEST(ForwardBound, MatchesTheTwinBitForBit) {
  for (const char* topology : {"14-9-3"}) {  // 14 columns are one block and a part
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
      nn::Model models[] = {tactel::tests::bounded_model(topology, kind), tactel::tests::bounded_model(topology, kind)};
      for (float& w : models[1].weights.values) w *= 0.7f;
      models[1].bound = other_bound(models[0]);
      const std::vector<nn::Weights<float>> networks{models[0].weights, models[1].weights};
      const nn::Bound* const bounds[] = {&*models[0].bound, &*models[1].bound};
      for (const int lanes : {16, 1}) {
        Executor some{device().with_lanes(lanes), {.threads = 1}};
        Forward<float> quantiles(some, networks, models[0].scaling), bounded(some, networks, models[0].scaling, bounds);
        for (const int rows : {1, 5, 16, 33, 203}) {
          nn::RowMatrix<float> frames = bumps(rows, networks[0].topology.inputs(), 4).frames;
          frames(rows / 2, 3) = std::numeric_limits<float>::quiet_NaN();
          if (rows > 2) frames.row(rows - 2) *= -1e3f, frames.row(rows - 1).setZero();
          const DeviceFrames on_device(some.device(), frames);
          quantiles.run(on_device), bounded.run(on_device);
          for (std::size_t n = 0; n < 2; ++n) {
            const nn::Recall<float> truth = quantiles.result(n), found = bounded.result(n);
            const auto expected = tactel::tests::bounds_of(models[n], truth, frames);
            EXPECT_EQ(found.status, truth.status);
            int different = 0;
            for (std::size_t row = 0; row < expected.size(); ++row) {
              const nn::BoundAnswer &a = found.bounds[row], &b = expected[row];
              const auto same = [](float x, float y) { return same_bits(x, y) || (std::isnan(x) && std::isnan(y)); };
              different += !same(found.slip_index(static_cast<Eigen::Index>(row)),
                                 truth.slip_index(static_cast<Eigen::Index>(row))) ||
                           !same(a.upper, b.upper) || !same(a.interval[0], b.interval[0]) ||
                           !same(a.interval[1], b.interval[1]) || a.unlike != b.unlike;
            }
            EXPECT_EQ(different, 0) << topology << ' ' << nn::name(kind) << ' ' << lanes << ' ' << rows << ' ' << n;
            EXPECT_TRUE(std::isnan(found.bounds[static_cast<std::size_t>(rows / 2)].upper));
          }
        }
      }
    }
  }
}

class ForwardBatch : public ::testing::TestWithParam<int> {};

// A frame's bits: the same alone and at every place of batches around the tile's size; of the largest, at some places.
TEST_P(ForwardBatch, GivesAFrameTheSameBitsEverywhere) {
  const nn::Topology topology = nn::Topology::paper(6);
  const int rows = GetParam();
  nn::RowMatrix<float> frames =
      bumps(std::min(rows, 997), topology.inputs(), 4).frames.replicate((rows + 996) / 997, 1);
  frames.conservativeResize(rows, Eigen::NoChange);
  for (const nn::InputScaling& scaling : {by_set, by_frame}) {
    const auto networks = some_networks<float>(topology, 1);
    const nn::Recall<float> batch = Forward<float>(executor(), networks, scaling).recall(frames);
    Forward<float> one(executor(), networks, scaling);
    int different = 0;
    for (int row = 0; row < rows; row += 1 + rows / 997)
      different += !same_bits(one.recall(frames.row(row)).slip_index(0), batch.slip_index(row));
    EXPECT_EQ(different, 0) << nn::name(scaling.kind);
  }
}

INSTANTIATE_TEST_SUITE_P(AroundTheTile, ForwardBatch, ::testing::Values(1, 7, 16, 31, 32, 33, 64, 100));
INSTANTIATE_TEST_SUITE_P(Slow, ForwardBatch, ::testing::Values(100000));

TEST(ForwardTest, RunsManyNetworksAsEachAlone) {
  const nn::Topology topology = nn::Topology::parse("16-16-8-1");
  const nn::RowMatrix<float> frames = bumps(45, 16, 4).frames;
  const auto networks = some_networks<float>(topology, 9);
  Forward<float> all(executor(), networks, by_set);
  all.run(DeviceFrames(executor().device(), frames));
  for (std::size_t i = 0; i < networks.size(); ++i) {
    const auto alone = Forward<float>(executor(), std::span(&networks[i], 1), by_set).recall(frames);
    EXPECT_EQ(alone.slip_index, all.result(i).slip_index);
  }
}

// A launch keeps its arguments while it runs on the same frames.
TEST(ForwardTest, RunsOnOtherFramesInTurn) {
  const nn::Topology topology = nn::Topology::parse("16-16-8-1");
  const auto networks = some_networks<float>(topology, 1);
  Forward<float> forward(executor(), networks, by_set);
  for (const int rows : {5, 5, 40, 3, 40}) {
    const DeviceFrames frames(executor().device(), bumps(rows, 16, rows).frames);
    const nn::Recall<float> alone = Forward<float>(executor(), networks, by_set).recall(bumps(rows, 16, rows).frames);
    for (int times = 0; times < 2; ++times) {
      forward.run(frames);
      EXPECT_EQ(forward.result(0).slip_index, alone.slip_index) << rows;
      EXPECT_EQ(forward.result(0).status, alone.status) << rows;
    }
  }
}

// With 21 normal and 21 shear stresses, scaling by frame makes S free of a common factor; a power of two even bit for
// bit.
TEST(ForwardTest, ScalingByFrameForgetsACommonFactor) {
  const auto networks = some_networks<float>(nn::Topology::paper(6), 1);
  Forward<float> forward(executor(), networks, by_frame);
  const nn::RowMatrix<float> frames = bumps(64, 42, 4).frames;
  EXPECT_EQ(forward.recall(frames).slip_index, forward.recall(frames * 1024.0f).slip_index);
}

// The reciprocal of a stress above 2^126 MPa is no normal number in fp32: it must not make zeros of the frame. A frame
// times a power of two keeps its bits, so the answers are those of the same frame at the usual size.
TEST(ForwardTest, ScalingByFrameHoldsUpToTheLargestFloat) {
  const auto networks = some_networks<float>(nn::Topology::paper(6), 1);
  Forward<float> forward(executor(), networks, by_frame);
  nn::RowMatrix<float> frames = bumps(64, 42, 4).frames;
  frames *= 1.9f / frames.cwiseAbs().maxCoeff();
  const nn::Recall<float> usual = forward.recall(frames);
  EXPECT_GT(usual.slip_index.maxCoeff() - usual.slip_index.minCoeff(), 0.01);
  for (const float factor : {0x1p125f, 0x1p126f, 0x1p127f}) {
    const nn::RowMatrix<float> large = frames * factor;
    EXPECT_EQ(forward.recall(large).slip_index, usual.slip_index) << factor;
    EXPECT_LT((nn::recall(networks[0], by_frame, large).slip_index - usual.slip_index).cwiseAbs().maxCoeff(), 1e-5)
        << factor;
  }
}

// Whatever comes in: a status and NaN, or S within 0..1; the same as the reference says, in every lane, without
// touching neighbours.
TEST(ForwardTest, NeverAnswersNaNWithoutAStatus) {
  constexpr float inf = std::numeric_limits<float>::infinity(), not_a_number = std::numeric_limits<float>::quiet_NaN();
  const nn::Topology topology = nn::Topology::parse("16-16-8-1");
  nn::RowMatrix<float> frames = bumps(64, 16, 4).frames;
  const nn::Vector<float> usual = frames.row(0);
  frames.row(3).setConstant(1e4f);
  frames.row(4).setConstant(-1e4f);
  frames.row(5).setZero();
  frames(6, 0) = inf;
  frames(7, 15) = -inf;
  frames(8, 8) = not_a_number;
  frames.row(9).setConstant(not_a_number);
  frames.row(10).setConstant(3e38f);
  frames.row(11).setConstant(1e-13f);
  frames.row(12).setConstant(1e-40f);
  for (const float saturation : {1.0f, 1e4f, 1e20f, 3e38f}) {
    auto networks = some_networks<float>(topology, 1);
    for (float& w : networks[0].values) w *= saturation;
    for (const nn::InputScaling& scaling : {by_set, by_frame}) {
      const nn::Recall<float> answer = Forward<float>(executor(), networks, scaling).recall(frames);
      const nn::Recall<float> reference = nn::recall(networks[0], scaling, frames);
      Forward<float> one(executor(), networks, scaling);
      for (int row = 0; row < frames.rows(); ++row) {
        const FrameStatus status = answer.status[row];
        const float s = answer.slip_index(row);
        const nn::Recall<float> alone = one.recall(frames.row(row));
        const bool none = status == FrameStatus::not_finite || status == FrameStatus::overflow;
        EXPECT_EQ(std::isnan(s), none) << "row " << row;
        EXPECT_TRUE(none || (s >= 0 && s <= 1)) << "row " << row << ": " << s;
        EXPECT_EQ(status, alone.status[0]) << "row " << row;
        EXPECT_TRUE(none || same_bits(s, alone.slip_index(0))) << "row " << row;
        // Which sums overflow depends on the order of terms; all else is agreed.
        const bool agreed = status == reference.status[row] || reference.status[row] == FrameStatus::overflow;
        EXPECT_TRUE(status == FrameStatus::overflow || agreed) << "row " << row;
      }
    }
  }
}

TEST(ForwardTest, RefusesWhatDoesNotFit) {
  const auto networks = some_networks<float>(nn::Topology::parse("16-16-8-1"), 1);
  Forward<float> forward(executor(), networks, by_set);
  EXPECT_THROW(forward.recall(nn::RowMatrix<float>::Zero(3, 42)), ValueError);
  EXPECT_THROW(Forward<float>(executor(), networks, nn::InputScaling{ScalingKind::set, 0.0f}), ValueError);
}

// The activation's stated bound, over one float in 257 of all that matter (every float was tried when the coefficients
// were chosen), and what it does at the ends.
TEST(Activation, KeepsItsBound) {
  const char* text =
      "#include \"shared/activation.h\"\n#include \"shared/group.h\"\n"
      "kernel void probe(uint first_group, global real *z) { TAKE_GROUP(group); STORE(activation(LOAD(z + group * "
      "LANES)), z + group * LANES); }";
  const Device& device = executor().device();
  const int lanes = device.lanes(Precision::fp32);
  std::vector<float> z;
  for (std::uint32_t bits = 0; bits < 0x7f800000u; bits += bits < 0x30000000u ? 0x100001u : 257u * 16u) {
    float value;
    std::memcpy(&value, &bits, sizeof value);
    z.push_back(value);
    z.push_back(-value);
  }
  z.insert(z.end(), {0.0f, std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(), NAN});
  while (z.size() % lanes) z.push_back(0);
  Buffer<float> buffer(device, std::span<const float>(z));
  const Program program =
      Program::from_text(device, "probe.cl", text, {{"LANES", std::to_string(lanes)}, {"REAL", "float"}});
  executor().run(program, "probe", z.size() / lanes, [&](KernelArguments& kernel) { kernel.set(1, buffer); });
  std::vector<float> f(z.size());
  buffer.read(f);
  double worst = 0, worst_relative = 0, largest = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (std::isnan(z[i])) {
      EXPECT_TRUE(std::isnan(f[i]));
      continue;
    }
    const double truth = nn::activation<double>(z[i]), error = std::abs(f[i] - truth);
    worst = std::max(worst, error);
    if (std::abs(truth) > 1e-30) worst_relative = std::max(worst_relative, error / std::abs(truth));
    largest = std::max(largest, std::abs(double{f[i]}));
  }
  EXPECT_LT(worst, 1.7e-7);
  EXPECT_LT(worst_relative, 3.3e-7);
  EXPECT_LT(largest, 0.5);
}

}  // namespace forward_test
