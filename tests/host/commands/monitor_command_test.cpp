// SPDX-License-Identifier: Apache-2.0

// tactel monitor as a user runs it, on a simulated sensor.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "hw/generic_format.h"
#include "hw/recording.h"
#include "tests/host/commands/live_command.h"
#include "tests/host/networks/bounded_model.h"

namespace tactel::host::monitor_command_test {

using ::testing::HasSubstr;

class Monitor : public LiveCommand {};

TEST_F(Monitor, GivesALineForEachFrameAndASummary) {
  const ChildResult result = run_tactel({"monitor", "--source", simulation, "--network", network_});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto lines = lines_of(result.out);
  ASSERT_EQ(lines.size(), 321u);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i]["frame"], i);
    EXPECT_NEAR(lines[i]["device_time"].get<double>(), 0.01 * static_cast<double>(i), 1e-6);
    EXPECT_GE(lines[i]["latency_us"].get<double>(), 0);
    ASSERT_EQ(lines[i]["slip_index"].is_null(), lines[i]["contact"] == false) << i;
    if (lines[i]["contact"] == false) continue;
    const double s = lines[i]["slip_index"];
    EXPECT_TRUE(s > 0 && s < 1);
  }
  const auto summary = lines_of(result.err).back();
  EXPECT_EQ(summary["frames"], 321);
  for (const char* key : {"lost", "bad", "resynchronised", "late"}) EXPECT_EQ(summary[key], 0) << key;
  for (const char* key : {"p50", "p99", "p99.9", "max"}) EXPECT_TRUE(summary["latency_us"].contains(key)) << key;
}

TEST_F(Monitor, ARecordingReplaysToTheSameFramesAndTheSameS) {
  ASSERT_EQ(
      run_tactel({"record", "--source", simulation, "--output", recording_, "--frames", (folder_ / "a.csv").string()})
          .exit_code,
      0);
  const std::string replay = "replay:" + recording_;
  const ChildResult again = run_tactel({"record", "--source", replay, "--output", (folder_ / "again.tactel").string(),
                                        "--frames", (folder_ / "b.csv").string()});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(text_of(folder_ / "a.csv"), text_of(folder_ / "b.csv"));
  EXPECT_EQ(text_of(recording_), text_of(folder_ / "again.tactel"));

  const auto live = lines_of(run_tactel({"monitor", "--source", simulation, "--network", network_}).out);
  const auto replayed = lines_of(run_tactel({"monitor", "--source", replay, "--network", network_}).out);
  ASSERT_EQ(live.size(), replayed.size());
  for (std::size_t i = 0; i < live.size(); ++i) {
    EXPECT_EQ(live[i]["slip_index"], replayed[i]["slip_index"]) << i;
    EXPECT_EQ(live[i]["device_time"], replayed[i]["device_time"]) << i;
  }
}

TEST_F(Monitor, EveryThinsTheLinesAndViewDrawsThem) {
  const auto thinned =
      run_tactel({"monitor", "--source", simulation, "--network", network_, "--every", "100", "--quiet"});
  EXPECT_EQ(lines_of(thinned.out).size(), 4u);
  const auto view = run_tactel({"monitor", "--source", simulation, "--network", network_, "--view"});
  EXPECT_EQ(view.exit_code, 0);
  EXPECT_THAT(view.out, HasSubstr("normal |"));
  EXPECT_THAT(view.out, ::testing::Not(HasSubstr("\x1b"))) << "escapes belong on terminals alone";
  EXPECT_THAT(view.out, HasSubstr("frame 320,")) << "the last frame is shown, however fast the source";
}

// A network that learnt another column says so in each line; alarm and view are for S.
TEST_F(Monitor, NamesWhatANetworkOfAnotherTargetReads) {
  nn::Model model = network(21);
  model.target = nn::Target::stick_fraction;
  const std::string other = folder_ / "other.onnx";
  write_onnx(other, model);
  const auto lines = lines_of(run_tactel({"monitor", "--source", simulation, "--network", other}).out),
             of_s = lines_of(run_tactel({"monitor", "--source", simulation, "--network", network_}).out);
  ASSERT_EQ(lines.size(), of_s.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_FALSE(lines[i].contains("slip_index"));
    EXPECT_EQ(lines[i]["stick_fraction"], of_s[i]["slip_index"]) << i;  // the same weights
  }
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--view"}, {"--alarm", "0.8"}})
    EXPECT_TRUE(is_refused(run_tactel({"monitor", "--source", simulation, "--network", other}, option),
                           {option[0], "network of stick_fraction"}));
}

TEST_F(Monitor, WrongInputIsNamed) {
  write_onnx(folder_ / "eight.onnx", network(8));
  EXPECT_TRUE(is_refused(
      run_tactel({"monitor", "--source", simulation, "--network", (folder_ / "eight.onnx").string()}), {"42 inputs"}));
  EXPECT_EQ(run_tactel({"monitor", "--source", "replay:" + network_, "--network", network_}).exit_code, 2);
  EXPECT_EQ(run_tactel({"monitor", "--source", "usb:mitten", "--network", network_}).exit_code, 2);
  EXPECT_THAT(run_tactel({"monitor", "--source", "sim:a.toml", "--network", network_}).err,
              HasSubstr("; did you mean simulate?"));
  EXPECT_THAT(run_tactel({"monitor", "--source", "csv:-", "--profile", "uskin-4x5", "--network", network_}).err,
              HasSubstr("--profile = uskin-4x5: must be a readable TOML file; did you mean uskin-4x4?"));
  const auto absent = run_tactel({"monitor", "--source", "usb:glove", "--network", network_});
  EXPECT_EQ(absent.exit_code, 3) << absent.err;
  EXPECT_THAT(absent.err, HasSubstr("connect it"));
}

/// The program in a shell, for its redirections.
ChildResult in_shell(const std::string& arguments) {
  return run_child({"/bin/sh", "-c", std::string(TACTEL_PROGRAM) + " " + arguments});
}

// Each second without a frame has a line of its own where an alarm was asked for: it is as it was, and nobody can tell.
TEST_F(Monitor, ASilentSensorCannotTell) {
  const std::string profile = folder_.write("p.toml",
                                            "[format]\nkind = \"csv\"\nchannels = 2\n[channels]\nnormal = [0, 1]\n"
                                            "[calibration]\ngain = 1\noffset = 0\nnoise = 0.001\n");
  const auto monitor = [&](const std::string& more) {
    return lines_of(run_child({"/bin/sh", "-c",
                               "(echo 1,1; sleep 2.4; echo 1,1) | " + std::string(TACTEL_PROGRAM) +
                                   " monitor --source csv:- --quiet --rest --profile " + profile + more})
                        .out);
  };
  const auto lines = monitor(" --alarm 0.1");
  ASSERT_EQ(lines.size(), 4u);
  for (const std::size_t k : {1u, 2u}) {
    EXPECT_FALSE(lines[k].contains("frame"));
    EXPECT_EQ(lines[k]["alarm"], false);
    EXPECT_EQ(lines[k]["cannot_tell"], true);
    EXPECT_EQ(lines[k]["why"], "silent");
    EXPECT_NEAR(lines[k]["silence"].get<double>(), static_cast<double>(k), 0.3);  // a busy machine
  }
  EXPECT_EQ(monitor("").size(), 2u);
}

TEST_F(Monitor, LinesThatCannotBeWrittenAreAnError) {
  const std::string arguments = "monitor --source '" + simulation + "' --network " + network_;
  for (const char* view : {"", " --view"}) {
    const ChildResult full = in_shell(arguments + view + " > /dev/full");
    EXPECT_EQ(full.exit_code, 2) << full.err;
    EXPECT_THAT(full.err, HasSubstr("standard output"));
    EXPECT_THAT(full.err, HasSubstr("No space left"));
  }
  EXPECT_EQ(in_shell(arguments + " >&-").exit_code, 2);
  EXPECT_EQ(in_shell(arguments + " --seconds 600 > " + (folder_ / "lines").string() + " 2> /dev/full").exit_code, 0)
      << "a full log does not end the monitoring";
  EXPECT_EQ(lines_of(text_of(folder_ / "lines")).size(), 321u);
}

/// Ten seconds of noise at rest (100 Hz, deviation 3 around 2048); from 4 s on channel 3 is 12 higher. `noise`: line of
/// the calibration.
void record_drift(const std::string& path, const std::string& noise_line = "noise = 3\n") {
  const hw::GenericLayout layout{.sync = {0xA5, 0x5A}, .header = 2, .channels = 42};
  std::string normal = "0", shear = "21";
  for (int i = 1; i < 21; ++i) normal += fmt::format(", {}", i), shear += fmt::format(", {}", 21 + i);
  hw::RecordingWriter writer(
      path,
      "[format]\nkind = \"generic\"\nsync = [0xA5, 0x5A]\nchannels = 42\nsample = \"u16\"\n[channels]\nnormal = [" +
          normal + "]\nshear = [" + shear + "]\n[calibration]\noffset = 2048\ngain = 0.001\n" + noise_line);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(2048, 3);
  std::vector<std::uint8_t> bytes(hw::generic_frame_length(layout));
  std::vector<double> samples(42);
  for (int frame = 0; frame < 1000; ++frame) {
    for (double& sample : samples) sample = noise(random);
    if (frame >= 400) samples[3] += 12;
    hw::write_generic_frame(layout, 0, 0, samples, bytes);
    writer.write({.bytes = bytes, .arrival = 0.01 * frame});
  }
  writer.finish();
}

/// At rest a network answers noise with any S. The first frame of a simulation is at rest.
TEST_F(Monitor, NoAlarmAtRest) {
  const auto simulated = lines_of(
      run_tactel({"monitor", "--source", simulation, "--network", network_, "--alarm", "0.01", "--quiet"}).out);
  ASSERT_EQ(simulated.size(), 321u);
  EXPECT_EQ(simulated[0]["contact"], false);
  EXPECT_EQ(simulated[0]["alarm"], false);
  EXPECT_EQ(simulated[300]["contact"], true);

  record_drift(recording_, "");
  const std::vector<std::string> call = {"monitor", "--source", "replay:" + recording_, "--network", network_};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), call.begin(), call.end());
    return run_tactel(more);
  };
  EXPECT_TRUE(is_refused(with({"--alarm", "0.1"}), {"--alarm", "--touch MPa, or with noise in [calibration]"}));
  const ChildResult lines = with({});
  EXPECT_THAT(lines.err, HasSubstr("warning: no threshold of touch"));
  EXPECT_THAT(with({"--quiet"}).err, ::testing::Not(HasSubstr("warning")));
  EXPECT_THAT(with({"--view"}).out, ::testing::Not(HasSubstr("ALARM")));
  const ChildResult touched = with({"--alarm", "0.1", "--touch", "0.03"});
  ASSERT_EQ(touched.exit_code, 0) << touched.err;
  EXPECT_THAT(touched.err, ::testing::Not(HasSubstr("no threshold")));
  for (const nlohmann::json& line : lines_of(touched.out)) EXPECT_EQ(line["alarm"], false) << line;
}

/// Blocks of a second: the shift begins with block 4, which the first frame after block 5 judges.
TEST_F(Monitor, AnOffsetThatMovedIsNamedOnce) {
  record_drift(recording_);
  const std::vector<std::string> call = {"monitor", "--source", "replay:" + recording_, "--network", network_};
  const auto with = [&](std::vector<std::string> more, const std::string& block = "1") {
    std::vector<std::string> all = call;
    all.insert(all.end(), {"--drift", block});
    all.insert(all.end(), more.begin(), more.end());
    return run_tactel(all);
  };
  const ChildResult result = with({"--every", "100000"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto lines = lines_of(result.out);
  ASSERT_EQ(lines.size(), 2u) << "frame 0, and the drift's whatever --every says";
  EXPECT_FALSE(lines[0].contains("drift"));
  EXPECT_NEAR(lines[1]["frame"].get<int>(), 600, 2);
  ASSERT_EQ(lines[1]["drift"].size(), 1u);
  const nlohmann::json& drift = lines[1]["drift"][0];
  EXPECT_EQ(drift["kind"], "offset");
  EXPECT_EQ(drift["channels"], nlohmann::json({3}));
  EXPECT_NEAR(drift["size"].get<double>(), 4, 0.5);
  EXPECT_THAT(drift["text"].get<std::string>(), HasSubstr("channel 3 (normal stress of tactel 3)"));
  EXPECT_THAT(result.err, HasSubstr("warning: the offset moved"));
  EXPECT_THAT(result.err, HasSubstr("\"drifts\": 1"));
  const ChildResult view = with({"--view"});
  EXPECT_THAT(view.out, HasSubstr("offsets moved: tare again; no contact; frame 999"));
  EXPECT_THAT(view.err, HasSubstr("warning: the offset moved"));
  EXPECT_THAT(with({"--quiet"}).err, ::testing::Not(HasSubstr("warning")));
  EXPECT_THAT(with({}, "0").err, HasSubstr("\"drifts\": 0"));
}

/// 150 frames of `sensors` times four tactels with so many axes, as stresses in MPa: presses that drag, noise, rest and
/// NaN. `profile`: what names the channels.
void record_presses(const std::string& path, int sensors, int axes, const std::string& profile) {
  const int places = 4 * sensors, channels = axes * places;
  const hw::GenericLayout layout{
      .sync = {0xA5, 0x5A}, .header = 2, .channels = channels, .sample = hw::SampleType::f32};
  hw::RecordingWriter writer(
      path, fmt::format("[format]\nkind = \"generic\"\nsync = [0xA5, 0x5A]\nchannels = {}\nsample = \"f32\"\n{}"
                        "[calibration]\noffset = 0\ngain = 1\n",
                        channels, profile));
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1e-3);
  std::vector<std::uint8_t> bytes(hw::generic_frame_length(layout));
  std::vector<double> samples(static_cast<std::size_t>(channels));
  for (int frame = 0; frame < 150; ++frame) {
    for (int c = 0; c < channels; ++c) {
      const int tactel = c % places;
      const double press = frame % 50 < 5 ? 0 : 0.4 * std::sin(0.05 * frame + 0.7 * tactel * tactel);
      samples[static_cast<std::size_t>(c)] = press * (c < places ? -1 : 0.01 * (frame % 50)) + noise(random);
    }
    if (frame % 31 == 17) samples.back() = std::nan("");
    hw::write_generic_frame(layout, 0, 0, samples, bytes);
    writer.write({.bytes = bytes, .arrival = 0.01 * frame});
  }
  writer.finish();
}

/// A network with a bound on three frames of four tactels.
nn::Model with_history(const char* topology, int axes) {
  nn::Model model = tactel::tests::bounded_model(topology, nn::ScalingKind::frame);
  model.history = {.frames = 3, .stride = 2, .change = 0.07};
  model.scaling.history = 3, model.scaling.axes = axes;
  model.bound->tactels = 4;
  return model;
}

// A line, and two pads by one launch, without and with features.
TEST_F(Monitor, ADeviceWritesTheLinesOfHostCode) {
  write_onnx(folder_ / "line.onnx", with_history("24-9-3", 2));
  write_onnx(folder_ / "pad.onnx", with_history("36-9-3", 3));
  nn::Model featured = with_history("88-9-3", 3);  // 36 stresses, 3 times 17 sums, the share of the peak
  featured.scaling.features = nn::Features::pad, featured.scaling.columns = 2, featured.scaling.square = true;
  write_onnx(folder_ / "features.onnx", featured);
  record_presses(folder_ / "line.tactel", 1, 2, "[channels]\nnormal = [0, 1, 2, 3]\nshear = [4, 5, 6, 7]\n");
  record_presses(folder_ / "pad.tactel", 2, 3,
                 "[pad]\ntactels = [2, 2, 2, 2]\npitch = 4\n[channels]\nnormal = [0, 1, 2, 3, 4, 5, 6, 7]\n"
                 "shear_x = [8, 9, 10, 11, 12, 13, 14, 15]\nshear_y = [16, 17, 18, 19, 20, 21, 22, 23]\n");
  for (const std::string sensor : {"line", "pad", "features"}) {
    const std::string recording = sensor == "line" ? "line.tactel" : "pad.tactel";
    const auto lines_on = [&](const std::string& device) {
      std::vector<std::string> call = {"monitor",
                                       "--source",
                                       "replay:" + (folder_ / recording).string(),
                                       "--network",
                                       folder_ / (sensor + ".onnx"),
                                       "--touch",
                                       "0.05",
                                       "--alarm",
                                       "0.6",
                                       "--quiet"};
      if (!device.empty()) call.insert(call.end(), {"--device", device});
      const ChildResult result = run_tactel(call);
      EXPECT_EQ(result.exit_code, 0) << result.err;
      std::vector<nlohmann::json> lines = lines_of(result.out);
      for (nlohmann::json& line : lines) line.erase("latency_us");
      EXPECT_THAT(lines_of(result.err).back()["device"].get<std::string>(),
                  HasSubstr(device.empty() ? "host code" : device));
      return lines;
    };
    const std::vector<nlohmann::json> host = lines_on("");
    ASSERT_EQ(host.size(), 150u);
    const auto lines_with = [&](const char* key, const nlohmann::json& value) {
      return std::ranges::count_if(host, [&](const nlohmann::json& line) { return line[key] == value; });
    };
    EXPECT_GT(lines_with("contact", false), 10);
    EXPECT_GT(lines_with("alarm", true), 10);
    if (sensor != "features") {  // of which that bound tells nothing
      EXPECT_GT(lines_with("unlike", true), 10);
      EXPECT_GT(lines_with("alarm", false), 10);
    }
    EXPECT_EQ(host[17]["slip_index"].is_null(), sensor == "line") << "NaN is in the second pad alone";
    EXPECT_EQ(host[16].contains("pads"), sensor != "line");
    for (const std::string device : {"basic", "pthread"}) {
      if (device == "pthread" && sensor != "pad") continue;
      const std::vector<nlohmann::json> kernel = lines_on(device);
      ASSERT_EQ(kernel.size(), host.size());
      for (std::size_t i = 0; i < host.size(); ++i) EXPECT_EQ(kernel[i], host[i]) << sensor << " on " << device;
    }
  }
}

// The kernels are compiled before the sensor is opened.
TEST_F(Monitor, LosesNoFrameOnItsFirstRun) {
  for (const std::vector<std::string>& device : {std::vector<std::string>{}, {"--device", "basic"}}) {
    const OwnCache empty;
    const ChildResult result = run_tactel(
        {"monitor", "--source", "simulate:" + scene + "?rate=1000", "--network", network_, "--seconds", "2"}, device);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto summary = lines_of(result.err).back();
    EXPECT_GT(summary["frames"], 1500);
    EXPECT_EQ(summary["late"], 0);
    EXPECT_EQ(summary["lost"], 0);
    EXPECT_EQ(lines_of(result.out).size(), summary["frames"]);
  }
}

using MonitorOptions = Monitor;
TEST_F(MonitorOptions, TimesThatAreNoneAreRefused) {
  for (const char* option : {"--seconds", "--late"})
    for (const char* value : {"nan", "inf", "0", "-1", "soon"})
      EXPECT_EQ(run_tactel({"monitor", "--source", simulation, "--network", network_, option, value}).exit_code, 2)
          << option << " " << value;
}

}  // namespace tactel::host::monitor_command_test
