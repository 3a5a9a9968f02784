// SPDX-License-Identifier: Apache-2.0

// The transducer chain's kernel against its plain twin, and what sets make of it.
#include "host/sets/transducer_chain.h"

#include <gmock/gmock.h>

#include <cmath>

#include "host/contact/lines/solve_on_rung.h"
#include "host/scenes/sweep_file.h"
#include "host/sets/set_simulator.h"
#include "host/support/errors.h"
#include "tests/host/sets/transducer_cases.h"
#include "tests/host/support/run_tactel.h"
#include "tests/thrown_message.h"

namespace transducer_chain_test {

using namespace tactel;
using namespace tactel::host;
using tactel::host::executor;
using tactel::tests::all_parts;
using tactel::tests::largest_difference;
using tactel::tests::skin_parts;
using tactel::tests::TransducerCase;

class TransducerChannels : public ::testing::TestWithParam<int> {};

// Stresses of 1 through at most 11 steps, each with a handful of roundings of 6e-8; the functions of elementary.h are
// good to 2 units in the last place, on normal numbers of at most 5.8 times 0.03.
TEST_P(TransducerChannels, MatchesTwin) {
  const int channels = GetParam();
  for (const int contacts : {1, 2, 15, 16, 17, 100}) {
    const TransducerCase some(contacts, channels);
    EXPECT_LT(largest_difference(some.on_device(all_parts, channels), some.by_twin(all_parts, channels)), 3e-6);
  }
}

// Each part by itself.
TEST_P(TransducerChannels, PartsMatchTwin) {
  const int channels = GetParam();
  const TransducerCase some(17, channels);
  for (const nn::Transducer& t :
       {nn::Transducer{}, nn::Transducer{.gain_spread = 0.3}, nn::Transducer{.time_constant = 2, .step_time = 1},
        nn::Transducer{.offset_spread = 0.3}, nn::Transducer{.noise = 0.3}, nn::Transducer{.range = 0.5}})
    EXPECT_LT(largest_difference(some.on_device(t, channels), some.by_twin(t, channels)), 3e-6) << nn::description(t);
  const nn::Transducer nothing;
  EXPECT_EQ(some.on_device(nothing, channels), some.stress);
}

// Faults of the rows of tactels: neighbours, failures, slow hysteresis, ranges of spreads.
TEST_P(TransducerChannels, FaultsMatchTwin) {
  const int channels = GetParam();
  const TransducerCase some(17, channels);
  nn::Transducer ranges{.gain_spread = 0.3, .offset_spread = 0.2, .noise = 0.1};
  ranges.gain_spread_from = 0.1, ranges.offset_spread_from = 0, ranges.noise_from = 0.01;
  nn::Transducer all = all_parts;
  all.shift_spread = 0.2, all.crosstalk = 0.1, all.dead = 0.1, all.lag = 0.2, all.lag_time = 0.3;
  all.noise_of_largest = 0.02, all.gain_spread_from = 0.02;
  nn::Transducer slow{.time_constant = 2, .step_time = 0.1};
  slow.time_constant_from = 0.05;
  all.time_constant_from = 0.2;
  for (const nn::Transducer& t :
       {slow, nn::Transducer{.shift_spread = 0.3}, nn::Transducer{.crosstalk = 0.2}, nn::Transducer{.dead = 0.3},
        nn::Transducer{.step_time = 0.1, .lag = 0.3, .lag_time = 0.2}, nn::Transducer{.noise_of_largest = 0.05}, ranges,
        all})
    EXPECT_LT(largest_difference(some.on_device(t, channels), some.by_twin(t, channels)), 3e-6) << nn::description(t);
  // and a contact's bits do not depend on its batch
  const auto together = some.on_device(all, channels);
  TransducerChain chain(executor(), all, 11, channels);
  std::size_t at = 0;
  for (const TransducerChain::Contact& contact : some.contacts) {
    const std::size_t size = std::size_t{contact.steps} * channels;
    std::vector<float> alone(some.stress.begin() + at, some.stress.begin() + at + size);
    chain.run(std::span(&contact, 1), alone);
    EXPECT_TRUE(std::equal(alone.begin(), alone.end(), together.begin() + at));
    at += size;
  }
}

// Nuisances of real skins, each by itself and all together.
TEST_P(TransducerChannels, SkinsMatchTwin) {
  const int channels = GetParam();
  const TransducerCase some(17, channels);
  for (const nn::Transducer& t :
       {nn::Transducer{.step_time = 0.1, .memory = 0.3, .memory_time = 0.2},
        nn::Transducer{.step_time = 0.1, .lag = 0.5, .lag_time = 1, .memory = 0.5, .memory_time = 0.01},
        nn::Transducer{.mixing = 0.2}, nn::Transducer{.drift = 0.2}, nn::Transducer{.repeats = 0.3},
        nn::Transducer{.repeats = 1}, skin_parts})
    EXPECT_LT(largest_difference(some.on_device(t, channels), some.by_twin(t, channels)), 3e-6) << nn::description(t);
}

// Pads of three axes: rows of tactels have neighbours on four sides. A contact's bits do not depend on its batch.
TEST(TransducerPads, MatchTwin) {
  for (const auto& [channels, rows] : {std::pair{3, 1}, {9, 1}, {12, 2}, {48, 4}, {72, 6}, {72, 4}}) {
    const TransducerCase some(17, channels);
    nn::Transducer all = skin_parts;
    all.gain_spread = 0.1, all.offset_spread = 0.01, all.noise = 0.02, all.range = 0.8;
    for (const nn::Transducer& t : {nn::Transducer{.mixing = 0.2}, nn::Transducer{.shift_spread = 0.5},
                                    nn::Transducer{.crosstalk = 0.2}, nn::Transducer{.drift = 0.2}, all})
      EXPECT_LT(largest_difference(some.on_device(t, channels, 3, rows), some.by_twin(t, channels, 3, rows)), 3e-6)
          << channels << ", " << nn::description(t);
    const auto together = some.on_device(all, channels, 3, rows);
    TransducerChain chain(executor(), all, 11, channels, 3, rows);
    std::size_t at = together.size();
    for (std::size_t c = some.contacts.size(); c-- > 0;) {
      const std::size_t size = std::size_t{some.contacts[c].steps} * channels;
      at -= size;
      std::vector<float> alone(some.stress.begin() + at, some.stress.begin() + at + size);
      chain.run(std::span(&some.contacts[c], 1), alone);
      EXPECT_TRUE(std::equal(alone.begin(), alone.end(), together.begin() + at)) << c;
    }
  }
  EXPECT_THROW(TransducerChain(executor(), {}, 11, 47, 3, 4), std::invalid_argument);
}

// Twelve bits: readings are whole quanta within the range, and the twin's but where it stood within 1e-5 of an edge
// (3e-6 of the test above over a quantum of 0.0004, both ways: one in 60 at most).
TEST_P(TransducerChannels, ConvertsAsTwin) {
  const int channels = GetParam();
  const TransducerCase some(100, channels);
  nn::Transducer t = all_parts;
  t.bits = 12;
  const auto reading = some.on_device(t, channels);
  const auto truth = some.by_twin(t, channels);
  std::size_t different = 0;
  for (std::size_t i = 0; i < reading.size(); ++i) {
    const double code = reading[i] / t.quantum();
    ASSERT_NEAR(code, std::rint(code), 2e-4);  // 2048 in single precision
    ASSERT_LE(std::abs(code + 0.5), 2047.5 + 2e-4);
    const double apart = std::abs(code - truth[i] / t.quantum());
    ASSERT_LT(apart, 1.001);
    different += apart > 0.5;
  }
  EXPECT_LT(different, reading.size() / 60);
}

// Bits of each sensor's own: readings are whole quanta of the twin's number of bits, within one of the twin's.
TEST_P(TransducerChannels, ConvertsBySensorAsTwin) {
  const int channels = GetParam();
  const TransducerCase some(100, channels);
  nn::Transducer t = all_parts;
  t.instances = 0, t.bits = 10, t.bits_from = 4;
  const auto reading = some.on_device(t, channels);
  const auto truth = some.by_twin(t, channels);
  for (std::size_t i = 0; i < reading.size(); ++i) {
    const double finest = reading[i] / std::ldexp(t.range, 1 - t.bits);
    ASSERT_NEAR(finest, std::rint(finest), 1e-4);
    ASSERT_LT(std::abs(reading[i] - truth[i]), std::ldexp(t.range, 1 - *t.bits_from) + 3e-6);
  }
  // 3e-6 of 0.8 2^-3 ... 0.8 2^-9 stands at an edge: one in 130 at most
  std::size_t different = 0;
  for (std::size_t i = 0; i < reading.size(); ++i) different += std::abs(reading[i] - truth[i]) > 1e-4;
  EXPECT_LT(different, reading.size() / 130);
}

// A contact's bits: the same alone, in any batch and at any place of it.
TEST_P(TransducerChannels, BitsDoNotDependOnTheBatch) {
  const int channels = GetParam();
  const TransducerCase some(100, channels);
  const auto together = some.on_device(all_parts, channels);
  TransducerChain chain(executor(), all_parts, 11, channels);
  std::size_t at = together.size();
  for (int c = 99; c >= 0; --c) {
    const std::size_t size = std::size_t{some.contacts[c].steps} * channels;
    at -= size;
    std::vector<float> alone(some.stress.begin() + at, some.stress.begin() + at + size);
    chain.run(std::span(&some.contacts[c], 1), alone);
    EXPECT_THAT(alone, ::testing::ElementsAreArray(together.begin() + at, together.begin() + at + size)) << c;
  }
}

INSTANTIATE_TEST_SUITE_P(AroundTheLanes, TransducerChannels, ::testing::Values(4, 16, 30, 32, 34, 42));

const std::string small_sweep =
    "[sweep]\ncontacts = 40\nseed = 3\n[sensor]\ntactels = 8\ncolumns = 21\nrows = 4\n"
    "[[indenter]]\nshape = \"parabola\"\nradius = { uniform = [5, 50] }\n"
    "[load]\nindentation = 0.15\nindentation_steps = 3\ntangential_step = 0.03\ntangential_steps = 5\n";
const std::string chain_table =
    "[transducer]\ngain_spread = 0.1\noffset_spread = 0.01\nnoise = 0.02\ntime_constant = 1\nstep_time = 0.2\n"
    "range = 1\nbits = 12\n";

ContactSet simulated(const std::string& text, std::uint64_t first = 0, std::uint64_t count = 40) {
  const ScratchFolder folder;
  const Sweep sweep = read_sweep(folder.write("sweep.toml", text));
  return SetSimulator(executor(), sweep.source, {}).simulate(first, count);
}

// Rows are the twin's readings of the contact solved by itself, over all of its load steps: those before full
// indentation, which have no rows, charge the amplifiers, too.
TEST(TransducerSet, HoldsReadingsOfAllLoadSteps) {
  const ScratchFolder folder;
  const std::string without_bits = chain_table.substr(0, chain_table.find("bits"));
  const Sweep sweep = read_sweep(folder.write("sweep.toml", small_sweep + without_bits));
  const ContactSet set = SetSimulator(executor(), sweep.source, {}).simulate(0, 40);
  EXPECT_EQ(set.transducer,
            "gain_spread 0.1, time_constant 1 s, step_time 0.2 s, offset_spread 0.01 MPa, "
            "noise 0.02 MPa, range 1 MPa, seed 3");
  ASSERT_EQ(set.rows(), 40u * 6);
  for (std::size_t row = 0; row < set.rows(); row += 6) {
    const fem::Scene scene = sweep.lines("sweep").contact(row / 6).scene;
    const auto steps = solve_on_meshes(executor(), std::span(&scene, 1), Precision::fp32, {})[0].steps;
    nn::RowMatrix<double> stress(8, 16);
    for (int k = 0; k < 8; ++k) stress.row(k) << steps[k].sigma_y.transpose(), steps[k].tau_xy.transpose();
    const auto reading = nn::transducer_chain(sweep.contacts().transducer(), 3, row / 6, stress);
    for (int k = 2; k < 8; ++k)
      for (int channel = 0; channel < 16; ++channel)
        EXPECT_NEAR(set.frames[(row + k - 2) * 16 + channel], reading(k, channel), 3e-6);  // as MatchesTwin
  }
}

// Answers are what they were; the file says what was done to the stresses.
TEST(TransducerSet, LeavesTheAnswersAlone) {
  const ContactSet bare = simulated(small_sweep), read = simulated(small_sweep + chain_table);
  EXPECT_EQ(bare.slip_index, read.slip_index);
  EXPECT_EQ(bare.status, read.status);
  EXPECT_NE(bare.frames, read.frames);
  EXPECT_EQ(bare.transducer, "none");
  const ScratchFolder folder;
  write_contact_set(folder / "set.h5", read);
  EXPECT_EQ(read_contact_set(folder / "set.h5").transducer, read.transducer);
}

TEST(TransducerSet, RowsDoNotDependOnTheRange) {
  const std::string text = small_sweep + chain_table +
                           "memory = { uniform = [0.02, 0.04] }\nmemory_time = { uniform = [0.3, 0.6] }\n"
                           "drift = { uniform = [0, 0.1] }\nrepeats = { uniform = [0, 0.1] }\n"
                           "mixing = { uniform = [0, 0.05] }\n";
  const ContactSet all = simulated(text), part = simulated(text, 17, 9);
  EXPECT_EQ(all.transducer,
            "mixing 0 to 0.05, memory 0.02 to 0.04, memory_time 0.3 to 0.6 s, gain_spread 0.1, time_constant 1 s, "
            "step_time 0.2 s, offset_spread 0.01 MPa, drift 0 to 0.1, noise 0.02 MPa, range 1 MPa, bits 12, "
            "repeats 0 to 0.1, seed 3");
  const std::size_t from = std::ranges::find(all.contact, 17u) - all.contact.begin();
  EXPECT_THAT(part.frames, ::testing::ElementsAreArray(all.frames.begin() + from * 16,
                                                       all.frames.begin() + (from + part.rows()) * 16));
}

std::string message_of(const std::string& table) {
  return thrown_message<ConfigError>([&] { simulated(small_sweep + "[transducer]\n" + table); });
}

TEST(TransducerTableOnDevice, NamesWhatItRejects) {
  EXPECT_THAT(message_of("noise = -1\n"), ::testing::HasSubstr("transducer.noise"));
  EXPECT_THAT(message_of("noise_fraction = 0.1\n"), ::testing::HasSubstr("given with transducer.range"));
  EXPECT_THAT(message_of("bits = 12\n"), ::testing::HasSubstr("transducer.range"));
  EXPECT_THAT(message_of("bits = 1\nrange = 1\n"), ::testing::HasSubstr("2 to 24"));
  EXPECT_THAT(message_of("time_constant = 1\n"), ::testing::HasSubstr("transducer.step_time"));
  EXPECT_THAT(message_of("width = 1\n"), ::testing::HasSubstr("sensor.tactel_width"));
  EXPECT_THAT(message_of("noize = 1\n"), ::testing::HasSubstr("noise"));
  EXPECT_THAT(message_of("gain_spread = { uniform = [-0.1, 0.2] }\n"), ::testing::HasSubstr("transducer.gain_spread"));
  EXPECT_THAT(message_of("noise = { normal = [0.1, 0.01] }\n"), ::testing::HasSubstr("uniform = [least, most]"));
  EXPECT_THAT(message_of("dead = 2\n"), ::testing::HasSubstr("transducer.dead"));
  EXPECT_THAT(message_of("crosstalk = -0.1\n"), ::testing::HasSubstr("transducer.crosstalk"));
  EXPECT_THAT(message_of("shift_spread = 1.5\n"), ::testing::HasSubstr("transducer.shift_spread"));
  EXPECT_THAT(message_of("lag = 0.1\nstep_time = 0.1\n"), ::testing::HasSubstr("transducer.lag_time"));
  for (const char* key : {"mixing", "repeats", "memory", "drift"})
    for (const char* number : {"-0.1", "nan", "{ uniform = [-0.1, 0.2] }", "{ normal = [0.1, 0.01] }"})
      EXPECT_THAT(message_of(key + std::string(" = ") + number +
                             (key == std::string("memory") ? "\nmemory_time = 1\nstep_time = 0.1\n" : "\n")),
                  ::testing::HasSubstr(std::string("transducer.") + key));
  EXPECT_THAT(message_of("memory = 0.1\nmemory_time = { uniform = [0, 1] }\nstep_time = 0.1\n"),
              ::testing::HasSubstr("transducer.memory_time"));
  EXPECT_EQ(message_of("lag = 0.1\nlag_time = 1\nstep_time = 0.1\nnoise = { uniform = [0, 0.01] }\n"), "no error");
  EXPECT_EQ(message_of("noise_fraction = 0.1\nrange = 1\n"), "no error");
  EXPECT_EQ(message_of("time_constant = { uniform = [0.5, 2] }\nstep_time = 0.1\n"), "no error");
  EXPECT_THAT(message_of("time_constant = { uniform = [0, 2] }\nstep_time = 0.1\n"),
              ::testing::HasSubstr("transducer.time_constant"));
  EXPECT_EQ(message_of("bits = { uniform = [8, 12] }\nrange = 1\n"), "no error");
  for (const char* bits : {"8.5, 12", "1, 12", "8, 25"})
    EXPECT_THAT(message_of(std::string("bits = { uniform = [") + bits + "] }\nrange = 1\n"),
                ::testing::HasSubstr("2 to 24"))
        << bits;
}

TEST(TransducerTable, GoesWithThePapersSets) {
  const ScratchFolder folder;
  const Sweep sweep =
      read_sweep(folder.write("sweep.toml", "[sweep]\nset = \"paper-recall\"\nseed = 5\n[transducer]\nnoise = 0.1\n"));
  EXPECT_EQ(sweep.contacts().seed(), 5u);
  EXPECT_EQ(sweep.contacts().transducer(), (nn::Transducer{.noise = 0.1, .seed = 5}));
}

TEST(TransducerTable, PlacesAndWidthsAreTheSensors) {
  const ScratchFolder folder;
  std::string text = small_sweep;
  text.insert(text.find("columns"), "tactel_span = 17.5\ntactel_width = { uniform = [0.5, 2] }\n");
  const Sweep sweep = read_sweep(folder.write("sweep.toml", text));
  EXPECT_EQ(sweep.lines("sweep").sensors().size(), 16u);
  for (const fem::Sensor& sensor : sweep.lines("sweep").sensors()) {
    EXPECT_EQ(sensor.tactel_span, 17.5);
    EXPECT_THAT(sensor.tactel_width, ::testing::AllOf(::testing::Ge(0.5), ::testing::Le(2)));
  }
}

}  // namespace transducer_chain_test
