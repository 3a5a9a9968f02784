// SPDX-License-Identifier: Apache-2.0

// Frames through tactel/live.h: formats and bytes of a user's own, recordings and simulations.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <tactel/live.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <utility>

#include "host/networks/onnx_file.h"
#include "hw/recording.h"
#include "test_paths.h"
#include "tests/fuzz/counted_layout.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/scratch.h"

// Every allocation of the program is counted, those inside the libraries too.
static std::atomic<long> allocations = 0;
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace live_test {

using namespace tactel;

constexpr const char* counted_profile =
    "[device]\nname = \"counted\"\n[format]\nkind = \"generic\"\nsync = [0xA5, 0x5A]\nheader = 8\ncounter_offset = 2\n"
    "counter_width = 2\nclock_offset = 4\nclock_width = 4\nchannels = 4\nchecksum = \"crc16\"\ntrailer = [0x0D]\n"
    "confirmations = 2\n[channels]\nnormal = [0, 1]\nshear = [2, 3]\n[calibration]\noffset = 1.0\ngain = 0.5\n";

std::vector<std::uint8_t> counted_frame(int i) {
  const hw::GenericLayout layout = hw::counted_layout();
  const std::vector<double> samples = {1.0 + i, 2, 3, 5};
  std::vector<std::uint8_t> frame(hw::generic_frame_length(layout));
  hw::write_generic_frame(layout, static_cast<std::uint64_t>(i), 100 * static_cast<std::uint64_t>(i), samples, frame);
  return frame;
}

class PipeEnd : public ByteSource {
 public:
  explicit PipeEnd(int fd) : fd_(fd) {}
  int fd() const override { return fd_; }

 private:
  int fd_;
};

bool readable(int fd, int milliseconds) {
  pollfd wanted{fd, POLLIN, 0};
  return ::poll(&wanted, 1, milliseconds) == 1;
}

class LiveApi : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.write("counted.toml", counted_profile);
    ASSERT_EQ(::pipe2(pipe_, O_CLOEXEC), 0);
  }
  void TearDown() override { ::close(pipe_[0]), ::close(pipe_[1]); }
  void send(const std::vector<std::uint8_t>& bytes) const {
    ASSERT_EQ(::write(pipe_[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  tactel::ScratchFolder folder_;
  int pipe_[2] = {-1, -1};
};

TEST_F(LiveApi, DecodesBytesOfAUsersDescriptor) {
  PipeEnd bytes(pipe_[0]);
  FrameSource source(bytes, (folder_ / "counted.toml").string());
  EXPECT_EQ(source.inputs(), 4u);
  EXPECT_EQ(source.fd(), pipe_[0]);
  Frame frame;
  EXPECT_FALSE(source.poll(frame));
  EXPECT_FALSE(readable(source.fd(), 0));
  std::vector<std::uint8_t> sent;
  for (int i = 0; i < 5; ++i) std::ranges::copy(counted_frame(i), std::back_inserter(sent));
  send({sent.begin(), sent.begin() + 70});  // cut inside a frame
  EXPECT_TRUE(readable(source.fd(), 1000));
  std::uint64_t frames = 0;
  const auto poll_all = [&] {
    while (source.poll(frame)) {
      EXPECT_EQ(frame.number, frames);
      EXPECT_FLOAT_EQ(frame.stress[0], 0.5f * static_cast<float>(frames));
      EXPECT_FLOAT_EQ(frame.stress[3], 2.0f);
      ++frames;
    }
  };
  poll_all();
  send({sent.begin() + 70, sent.end()});
  EXPECT_TRUE(source.wait(frame, 1.0));
  ++frames;
  poll_all();
  EXPECT_EQ(frames, 5u);
  EXPECT_EQ(source.counts().frames, 5u);
  EXPECT_FALSE(source.finished());
  EXPECT_FALSE(source.wait(frame, 0.02));
  ::close(std::exchange(pipe_[1], -1));
  EXPECT_FALSE(source.wait(frame, 1.0));
  EXPECT_TRUE(source.finished());
}

TEST_F(LiveApi, ReplaysARecording) {
  const std::filesystem::path path = folder_ / "run.tactel";
  hw::RecordingWriter writer(path, counted_profile);
  for (int i = 0; i < 4; ++i) writer.write({.bytes = counted_frame(i), .arrival = 0.01 * i});
  writer.finish();
  FrameSource source = FrameSource::open("replay:" + path.string());
  Frame frame;
  int frames = 0;
  while (!source.finished()) {
    ASSERT_TRUE(readable(source.fd(), 1000));
    while (source.poll(frame)) EXPECT_FLOAT_EQ(frame.stress[0], 0.5f * static_cast<float>(frames++));
  }
  EXPECT_EQ(frames, 4);
  EXPECT_DOUBLE_EQ(frame.arrival, 0.03);
}

// The number of a channel is its reading; tactel 0 sends x, y, z as channels 0, 1, 2.
TEST_F(LiveApi, APadHasAllNormalStressesThenShearAlongXThenAlongY) {
  std::string line;
  for (int channel = 0; channel < 48; ++channel) line += (channel > 0 ? "," : "") + std::to_string(channel) + ".0";
  FrameSource source = FrameSource::open("csv:" + folder_.write("pad.csv", line + "\n"), "uskin-4x4");
  Frame frame;
  ASSERT_TRUE(source.wait(frame, 10));
  ASSERT_EQ(source.inputs(), 48u);
  ASSERT_EQ(frame.stress.size(), 48u);
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_FLOAT_EQ(frame.stress[i] / frame.stress[0], static_cast<float>(3 * i + 2) / 2);
    EXPECT_FLOAT_EQ(frame.stress[16 + i] / frame.stress[0], -static_cast<float>(3 * i) / 2);
    EXPECT_FLOAT_EQ(frame.stress[32 + i] / frame.stress[0], -static_cast<float>(3 * i + 1) / 2);
  }
  EXPECT_NE(source.note().find("no zero"), std::string::npos) << source.note();
}

TEST(LiveApiProfile, TellsChannelsAndCalibration) {
  const DeviceProfile pad = read_profile("uskin-4x4");  // lines of x, y, z of each tactel; a pressed one counts upwards
  ASSERT_EQ(pad.channel.size(), 48u);
  EXPECT_EQ((std::vector{pad.channel[1], pad.channel[17], pad.channel[33]}), (std::vector{5, 3, 4}));
  EXPECT_LT(pad.gain[2], 0);
  EXPECT_GT(pad.gain[0], 0);
  EXPECT_TRUE(pad.noise.empty());
  EXPECT_EQ(pad.pads, (std::vector<std::array<int, 2>>{{4, 4}}));
  EXPECT_NE(pad.text.find("uSkin 4 x 4"), std::string::npos);
  EXPECT_THROW(read_profile("no/profile.toml"), InputError);
}

TEST_F(LiveApi, PollsWithoutAllocation) {
  PipeEnd bytes(pipe_[0]);
  FrameSource source(bytes, (folder_ / "counted.toml").string());
  Frame frame;
  int frames = 0;
  long made = 0;  // during polls
  for (int i = 0; i < 100; ++i) {
    send(counted_frame(i));
    const long before = allocations;
    while (source.poll(frame)) ++frames;
    made += allocations - before;
  }
  EXPECT_EQ(frames, 100);
  EXPECT_EQ(made, 0);
  EXPECT_GT(allocations, 0);
}

// Of three signals, with touch-down, rest, dead channels, a slide and a release.
TEST(AlarmApi, NextAllocatesNothing) {
  for (const AlarmSignal signal : {AlarmSignal::left, AlarmSignal::moved}) {
    AlarmOptions options{.at = 0.1f, .touch = 0.002};
    options.signal = signal, options.slide = 0.5f, options.held.at = 3;
    for (std::size_t i = 0; i < 8; ++i) options.held.covariance[i * (i + 3) / 2] = 1e-4f;
    Alarm alarm(16, 3, options);
    std::vector<float> frame(48);
    const long before = allocations;
    for (int i = 0; i < 4000; ++i) {
      const bool holds = i % 1000 < 900;
      for (std::size_t k = 0; k < 48; ++k)
        frame[k] =
            holds ? (k < 16 ? -0.05f : 0.01f) + 1e-4f * static_cast<float>((i * 7 + static_cast<int>(k) * 13) % 11) : 0;
      if (i % 100 == 50) frame[7] = NAN;
      if (i == 500) alarm.rate(1000);
      if (i % 1000 == 700) alarm.slides();
      alarm.next(frame);
    }
    EXPECT_EQ(allocations, before);
  }
}

// A simulated sensor by the clock, through the descriptor alone.
TEST(SimulatedSource, PlaysASceneThroughItsDescriptor) {
  const std::string scene = TACTEL_SOURCE_DIR "/examples/parabola.toml";
  FrameSource source = FrameSource::open("simulate:" + scene + "?rate=200&press=0.05&hold=0.01&drag=0.1&slip=0.01");
  EXPECT_EQ(source.inputs(), 42u);
  Frame frame;
  std::uint64_t frames = 0;
  float largest = 0;
  while (!source.finished()) {
    ASSERT_TRUE(readable(source.fd(), 10000));
    while (source.poll(frame)) {
      EXPECT_EQ(frame.number, frames++);
      for (const float stress : frame.stress) largest = std::max(largest, std::abs(stress));
    }
  }
  EXPECT_GE(frames, 30u);
  EXPECT_EQ(source.counts().frames, frames);
  EXPECT_GT(largest, 0.05f);  // MPa
}

TEST_F(LiveApi, SaysWhatCannotBeOpened) {
  EXPECT_THROW(FrameSource::open("replay:" + (folder_ / "none").string()), HardwareError);
  EXPECT_THROW(FrameSource::open("serial:ttyS0"), InputError);
  PipeEnd bytes(pipe_[0]);
  EXPECT_THROW(FrameSource(bytes, "none.toml"), InputError);
}

/// A line, a pad, and three frames of a line; each with a bound.
std::vector<Network> some_networks(const ScratchFolder& folder) {
  nn::Model line = tactel::tests::bounded_model("8-5-3", nn::ScalingKind::set);
  nn::Model pad = tactel::tests::bounded_model("12-9-3", nn::ScalingKind::frame);
  pad.scaling.axes = 3, pad.bound->tactels = 4;
  nn::Model history = tactel::tests::bounded_model("24-9-3", nn::ScalingKind::frame);
  history.history = {.frames = 3, .stride = 2, .change = 0.07};
  history.scaling.history = 3, history.bound->tactels = 4;
  std::vector<Network> networks;
  for (const nn::Model* model : {&line, &pad, &history, &line}) {
    host::write_onnx(folder / "network.onnx", *model);
    networks.push_back(Network::load(folder / "network.onnx"));
  }
  networks.push_back(networks.front());
  return networks;
}

std::vector<std::uint32_t> bits_of(const Answer& a) {
  const auto bits = [](float x) { return std::isnan(x) ? 0 : std::bit_cast<std::uint32_t>(x); };
  return {bits(a.slip_index),
          bits(a.slip_upper),
          bits(a.slip_interval[0]),
          bits(a.slip_interval[1]),
          a.unlike,
          a.beyond_learnt,
          static_cast<std::uint32_t>(a.status)};
}

// SlipHistory of each sensor is the witness: each device, and host code.
TEST(LiveEstimatorApi, EveryDeviceAnswersAsTheSensorsByThemselves) {
  const ScratchFolder folder;
  const std::vector<Network> networks = some_networks(folder);
  const std::vector<DeviceInfo> found = devices();
  std::vector<std::string> choices{""};
  for (const DeviceInfo& device : found) choices.push_back(std::to_string(device.index));
  ASSERT_GT(choices.size(), 1u);
  for (const std::string& choice : choices) {
    LiveEstimator hand(networks, choice);
    EXPECT_EQ(hand.device(), choice.empty() ? "" : found[static_cast<std::size_t>(std::stoi(choice))].name);
    ASSERT_EQ(hand.sensors(), networks.size());
    ASSERT_EQ(hand.inputs(), 8u + 12u + 8u + 8u + 8u);
    std::vector<std::unique_ptr<SlipHistory>> alone;
    for (const Network& network : networks) alone.push_back(std::make_unique<SlipHistory>(network.estimator()));
    std::vector<Answer> answers(networks.size());
    std::vector<float> frames(hand.inputs());
    int answered = 0;
    for (int k = 0; k < 60; ++k) {
      for (std::size_t i = 0; i < frames.size(); ++i)
        frames[i] = k % 7 == 3 ? 0 : 0.4f * std::sin(0.3f * static_cast<float>(k) + 1.7f * static_cast<float>(i * i));
      if (k % 11 == 5) frames[30] = std::nanf("");  // of the fourth
      if (k == 40) {
        hand.clear();
        for (const auto& sensor : alone) sensor->clear();
      }
      hand.estimate(frames, answers);
      std::span<const float> left = frames;
      for (std::size_t s = 0; s < alone.size(); ++s) {
        ASSERT_EQ(bits_of(answers[s]), bits_of(alone[s]->estimate(left.first(alone[s]->inputs()))))
            << "sensor " << s << ", frame " << k << ", device " << hand.device();
        left = left.subspan(alone[s]->inputs());
        answered += answers[s].status == AnswerStatus::ok;
      }
    }
    EXPECT_GT(answered, 200);
    if (!choice.empty()) continue;
    const long before = allocations;
    hand.estimate(frames, answers);
    EXPECT_EQ(allocations, before);
  }
}

TEST(LiveEstimatorApi, RefusesWhatItCannotTake) {
  const ScratchFolder folder;
  const std::vector<Network> networks = some_networks(folder);
  EXPECT_THROW(LiveEstimator({}), InputError);
  EXPECT_THROW(LiveEstimator(networks, "no such device"), InputError);
  LiveEstimator hand(networks);
  std::vector<float> frames(hand.inputs());
  std::vector<Answer> answers(hand.sensors());
  EXPECT_THROW(hand.estimate(std::span(frames).first(1), answers), InputError);
  EXPECT_THROW(hand.estimate(frames, std::span(answers).first(1)), InputError);
}

}  // namespace live_test
