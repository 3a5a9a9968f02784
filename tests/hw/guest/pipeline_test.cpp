// SPDX-License-Identifier: Apache-2.0

// From a USB device through tactel's own commands to OpenCL: S live, S of the recording. Runs in the guest.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>

#include "nn/infer/network_file.h"
#include "tests/hw/guest/rig.h"

namespace tactel::hw::tests {
namespace {

using nlohmann::json;

constexpr int frames = 300;  // 3 s at 100 Hz
constexpr auto period = std::chrono::milliseconds(10);

/// One of tactel's commands, started in a shell that says first who it is. What it says on stderr goes to a file.
class Running {
 public:
  explicit Running(const std::string& arguments)
      : pipe_(popen(("echo $$; exec " + std::string(getenv("TACTEL_PROGRAM")) + " " + arguments).c_str(), "r")) {
    pid_ = std::stoi(line());
  }
  /// The next line; empty at the end.
  std::string line() {
    std::string text;
    for (int c = std::fgetc(pipe_); c != EOF && c != '\n'; c = std::fgetc(pipe_)) text += static_cast<char>(c);
    return text;
  }
  void interrupt() { kill(pid_, SIGINT); }
  /// Waits for the end; the exit code.
  int end() { return WEXITSTATUS(pclose(pipe_)); }

 private:
  FILE* pipe_;
  pid_t pid_;
};

/// Frame i, each as the real glove would send it: five packets at once.
void send_frame(DeviceModel& model, int i) { model.send(glove_frame(7 * i)); }

json slip_of(const std::string& line) { return json::parse(line).at("slip_index"); }

/// A network of the glove's 64 tactels with any weights: any S will do to follow frames through.
void write_network() {
  nn::Model model{nn::Weights<float>(nn::Topology({128, 128, 1})), {nn::ScalingKind::frame, 1.0f}, 7, 0, "", 0, {}};
  std::minstd_rand draw(7);
  for (float& weight : model.weights.values) weight = std::uniform_real_distribution<float>(-0.5f, 0.5f)(draw);
  std::ofstream("network.onnx", std::ios::binary) << infer::network_bytes(model);
}

/// S of each frame, live: the first frame waits until the kernel is compiled, the others come at 100 Hz.
std::vector<json> monitor_live(DeviceModel& model) {
  // In a slow guest a frame may wait for long: none is dropped for that here.
  Running monitor("monitor --source usb:glove --network network.onnx --quiet --late 1000 2> monitor.err");
  send_frame(model, 0);
  std::vector<json> slip{slip_of(monitor.line())};
  std::jthread sender([&] {
    for (int i = 1; i < frames; ++i) std::this_thread::sleep_for(period), send_frame(model, i);
  });
  while (slip.size() < frames) slip.push_back(slip_of(monitor.line()));
  monitor.interrupt();
  EXPECT_EQ(monitor.end(), 130);
  return slip;
}

/// The same frames into a file; more of them until it holds the first 300 (it is written in blocks).
void record(DeviceModel& model) {
  Running record("record --source usb:glove --output usb.tactel --quiet 2> record.err");
  const auto size = [] { return std::filesystem::exists("usb.tactel") ? std::filesystem::file_size("usb.tactel") : 0; };
  const std::size_t enough = frames * 5 * (9 + 9 + 64) + 4096;  // packets with their heads, and the description
  for (int i = 0; i < 20 * frames && size() < enough; ++i) send_frame(model, i), std::this_thread::sleep_for(period);
  record.interrupt();
  EXPECT_EQ(record.end(), 130);
}

std::vector<json> recall() {
  Running monitor("monitor --source replay:usb.tactel --network network.onnx --quiet 2> recall.err");
  std::vector<json> slip;
  for (std::string line = monitor.line(); !line.empty(); line = monitor.line()) slip.push_back(slip_of(line));
  EXPECT_EQ(monitor.end(), 0);
  return slip;
}

void expect_nothing_lost(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const json counts = json::parse(line);
  for (const char* what : {"lost", "bad", "resynchronised", "late", "overruns", "stalls", "transfer_errors"})
    EXPECT_EQ(counts.at(what), 0) << what << " in " << file;
}

TEST(Pipeline, UsbToOpenClAndBackFromARecording) {
  DeviceModel model;
  const auto rig = vhci_rig(model);
  rig->plug_in();
  write_network();
  const auto live = monitor_live(model);
  expect_nothing_lost("monitor.err");
  record(model);
  auto recalled = recall();
  expect_nothing_lost("recall.err");
  ASSERT_GE(recalled.size(), live.size());
  recalled.resize(live.size());
  EXPECT_EQ(live, recalled);  // bit for bit: S is printed so that it reads back to the same float
  EXPECT_GT(std::set<json>(live.begin(), live.end()).size(), frames / 2u) << "S says nothing of the frames";
  std::ofstream("live.json") << json(live);
}

}  // namespace
}  // namespace tactel::hw::tests
