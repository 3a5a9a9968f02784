// SPDX-License-Identifier: Apache-2.0

// How long a frame takes from its last byte to S: an emulated USB device with a clock of its own, an unmodified libusb,
// and what `tactel monitor` is made of. Rows of the table are printed one a run, see --help.
#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "host/live/live_monitor.h"
#include "host/support/progress_line.h"
#include "hw/generic_format.h"
#include "hw/usb_source.h"
#include "nn/forward.h"
#include "tests/hw/usb/emulated_device.h"

namespace {

using namespace tactel;
using Clock = std::chrono::steady_clock;

constexpr int tactels = 8;        // as the paper's real sensor
constexpr int patterns = 64;      // frames that the device sends in turn
constexpr float step = 0x1p-10f;  // MPa of one bit; a power of two, so that readings can be told from stresses exactly
constexpr std::size_t device_queue = 64;  // packets that the device can hold
constexpr double close = 1e-5;            // of S in fp32: some 10 roundings of 6e-8 in each of three layers, and room

struct Options {
  double rate = 1000, seconds = 10;
  int per_packet = 1;
  bool busy = false;
};

// 48 bytes: sync, counter, the device's clock in ns, 16 readings; ten fill a packet of a fast endpoint.
hw::GenericLayout frame_layout() {
  hw::GenericLayout layout;
  layout.sync = {0xA5, 0x5A};
  layout.header = 16;
  layout.counter = {2, 4};
  layout.clock = {6, 8};
  layout.clock_tick = 1e-9;
  layout.channels = 2 * tactels;
  layout.sample = hw::SampleType::i16;
  return layout;
}

host::SensorProfile profile() {
  host::SensorProfile profile;
  profile.name = "emulated board";
  profile.usb = {.vendor = 0x1209, .product = 0x0002};
  profile.format = [] { return hw::generic_format(frame_layout()); };
  for (int i = 0; i < tactels; ++i) {
    profile.map.normal.push_back(i);
    profile.map.shear.push_back(tactels + i);
  }
  profile.map.calibration = {std::vector<double>(2 * tactels, 0.0), std::vector<double>(2 * tactels, step)};
  return profile;
}

// A bump that wanders over the sensor; shear is part of it. [patterns, channels] in bits.
std::vector<std::vector<double>> make_readings() {
  std::vector<std::vector<double>> readings(patterns, std::vector<double>(2 * tactels));
  for (int p = 0; p < patterns; ++p)
    for (int i = 0; i < tactels; ++i) {
      const double x = i - tactels * (p + 0.5) / patterns;
      readings[p][i] = std::round(1000 * std::exp(-x * x));
      readings[p][tactels + i] = std::round(readings[p][i] * p / patterns);
    }
  return readings;
}

std::int64_t nanoseconds() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

/// Times of one run, in us.
struct Times {
  host::LatencyHistogram whole, answer;
  std::uint64_t wrong = 0;  ///< frames whose S is not the twin's
};

void print(const char* what, const host::LatencyHistogram& times) {
  fmt::print("  {:<30} p50 {:8.1f}  p99 {:8.1f}  p99.9 {:8.1f}  max {:8.1f} us\n", what, times.quantile(0.5),
             times.quantile(0.99), times.quantile(0.999), times.largest());
}

/// The device's packets: stamped when they are complete, all frames of a packet alike.
class Sender {
 public:
  explicit Sender(const Options& options)
      : period_(std::llround(1e9 * options.per_packet / options.rate)), per_packet_(options.per_packet) {}
  std::chrono::nanoseconds period() const { return period_; }
  const host::LatencyHistogram& lateness() const { return lateness_; }

  void make(std::size_t packet, hw::tests::ByteVector& bytes) {
    const std::int64_t now = nanoseconds();
    if (packet == 0) start_ = now;
    lateness_.add(1e-3 * static_cast<double>(now - start_ - static_cast<std::int64_t>(packet) * period_.count()));
    const std::size_t length = hw::generic_frame_length(layout_);
    bytes.resize(length * static_cast<std::size_t>(per_packet_));
    for (int i = 0; i < per_packet_; ++i, ++frame_)
      hw::write_generic_frame(layout_, frame_, static_cast<std::uint64_t>(now), readings_[frame_ % patterns],
                              std::span(bytes).subspan(static_cast<std::size_t>(i) * length, length));
  }

 private:
  const hw::GenericLayout layout_ = frame_layout();
  const std::vector<std::vector<double>> readings_ = make_readings();
  std::chrono::nanoseconds period_;
  int per_packet_;
  std::uint64_t frame_ = 0;
  std::int64_t start_ = 0;
  host::LatencyHistogram lateness_;  ///< us: how late its clock woke it, which is no part of the latency
};

nn::Model make_model() {
  const nn::Topology topology({2 * tactels, 2 * tactels, tactels, 1});
  return {.weights = nn::initial_weights(topology, 1),
          .scaling = {nn::ScalingKind::set, 1.0f},
          .learning_set = "",
          .learning_errors = {}};
}

/// What each pattern is in MPa, and its S by the Eigen twin in fp64.
class Answers {
 public:
  explicit Answers(const nn::Model& model) : frames_(patterns, 2 * tactels) {
    const auto readings = make_readings();
    for (int p = 0; p < patterns; ++p)
      for (int i = 0; i < 2 * tactels; ++i) frames_(p, i) = step * static_cast<float>(readings[p][i]);
    slip_index_ = nn::recall(nn::Weights<double>(model.weights), model.scaling, frames_).slip_index;
  }
  bool right(const host::MonitorLine& line) const {
    for (std::uint64_t k = 0; k < patterns; ++k) {  // where frames were lost it is not the first
      const auto p = static_cast<Eigen::Index>((line.frame.number + k) % patterns);
      if (std::equal(line.stresses.begin(), line.stresses.end(), frames_.row(p).data()))
        return std::abs(line.answer.slip_index - slip_index_(p)) < close;
    }
    return false;
  }

 private:
  nn::RowMatrix<float> frames_;  ///< [patterns, 2 tactels] MPa
  nn::Vector<double> slip_index_;
};

host::MonitorEvents make_events(const Options& options, const Answers& answers, Times& times,
                                host::ProgressLine& progress) {
  host::MonitorEvents events;
  events.line = [&](const host::MonitorLine& line) {
    times.whole.add(1e-3 * static_cast<double>(nanoseconds()) - 1e6 * *line.frame.device_time);
    times.answer.add(line.answer_time);
    times.wrong += !answers.right(line);
  };
  const auto start = Clock::now();
  const auto passed = [start] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  events.second = [&, passed](const host::MonitorSummary& summary) {
    progress.show(static_cast<std::size_t>(passed()), static_cast<std::size_t>(options.seconds),
                  fmt::format("{} frames, p99 {:.0f} us", summary.decoder.frames, times.whole.quantile(0.99)));
  };
  events.stop = [&, passed] { return passed() >= options.seconds; };
  return events;
}

void report(const Options& options, const host::MonitorSummary& summary, const Times& times, const Sender& sender,
            std::size_t lost_by_device) {
  fmt::print("{} Hz, {} a packet, {} s{}: {} frames, {} lost, {} dropped as late, {} with another S than the twin's\n",
             options.rate, options.per_packet, options.seconds, options.busy ? ", a core busy" : "",
             summary.decoder.frames, summary.decoder.lost, summary.late, times.wrong);
  if (lost_by_device + summary.transport.overruns > 0)
    fmt::print("  packets lost: {} in the device, {} in the ring\n", lost_by_device, summary.transport.overruns);
  print("last byte to S", times.whole);
  print("of it, decoded frame to S", times.answer);
  print("(its clock woke it late by)", sender.lateness());
}

int run(const Options& options) {
  const nn::Model model = make_model();
  const Answers answers(model);
  Times times;
  Sender sender(options);
  host::LiveMonitor monitor(model, profile(), {});
  hw::tests::EmulatedDevice device(hw::tests::fast_kind());
  const auto source = hw::open_usb(profile().usb);
  std::atomic<bool> done{false};
  std::thread busy([&] {
    const sched_param ordinary{};  // also where the rest has real-time priority
    pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
    while (options.busy && !done) {
    }
  });
  host::ProgressLine progress("latency", "s", false);
  device.send_by_clock(sender.period(), device_queue,
                       [&](std::size_t i, hw::tests::ByteVector& bytes) { sender.make(i, bytes); });
  const host::MonitorSummary summary = monitor.run(*source, make_events(options, answers, times, progress));
  device.stop_clock();
  done = true;
  busy.join();
  progress.clear();
  report(options, summary, times, sender, device.lost());
  return times.wrong == 0 && times.whole.count() > 0 ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
  const char* preloaded = std::getenv("LD_PRELOAD");
  if (preloaded == nullptr || std::strstr(preloaded, "umockdev") == nullptr) {  // anew, where libusb sees the device
    std::vector<char*> again{const_cast<char*>("umockdev-wrapper")};
    again.insert(again.end(), arguments, arguments + count + 1);
    execvp(again[0], again.data());
    std::perror("umockdev-wrapper");
    return 1;
  }
  Options options;
  CLI::App app{"Latency from a frame's last byte to S, over an emulated USB device"};
  app.add_option("--rate", options.rate, "frames a second")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--per-packet", options.per_packet, "frames that come together")
      ->check(CLI::Range(1, 10))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "how long")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_flag("--busy", options.busy, "one more thread, of ordinary priority, that takes all it can of a core");
  CLI11_PARSE(app, count, arguments);
  try {
    return run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "tactel_usb_latency: {}\n", error.what());
    return 1;
  }
}
