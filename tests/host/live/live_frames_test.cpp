// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_frames.h"

#include <gmock/gmock.h>

#include <limits>

#include "host/live/open_source.h"
#include "host/support/errors.h"
#include "hw/frame_source.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::live_frames_test {

using ::testing::ElementsAre;

TEST(FrameQueue, DropsTheOldestWhenFull) {
  FrameQueue queue(3, 2);
  for (std::uint64_t i = 0; i < 5; ++i) {
    const auto inputs = queue.push({.number = i});
    inputs[0] = static_cast<float>(i), inputs[1] = -1.0f;
  }
  EXPECT_EQ(queue.size(), 3u);
  EXPECT_EQ(queue.dropped(), 2u);
  EXPECT_EQ(queue.frame(0).number, 2u);
  EXPECT_THAT(queue.inputs(2), ElementsAre(4.0f, -1.0f));
  queue.pop();
  EXPECT_EQ(queue.frame(0).number, 3u);
  EXPECT_EQ(queue.dropped(), 2u) << "what was answered is not dropped";
}

TEST(LatencyHistogram, QuantilesWithinOnePercent) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), 0);
  for (int i = 1; i <= 1000; ++i) histogram.add(i);
  EXPECT_NEAR(histogram.quantile(0.5), 500, 5.1);  // a bucket is 1 % wide
  EXPECT_NEAR(histogram.quantile(0.99), 990, 10);
  EXPECT_EQ(histogram.largest(), 1000);
  EXPECT_EQ(histogram.quantile(1.0), 1000);
  histogram.add(1e12);
  EXPECT_EQ(histogram.largest(), 1e12);
}

TEST(LatencyHistogram, WhatIsNotFiniteIsLeftOut) {
  LatencyHistogram histogram;
  for (const double none :
       {std::nan(""), std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()})
    histogram.add(none);
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.largest(), 0);
  histogram.add(-5);  // an arrival in the future of a clock that was set back
  EXPECT_EQ(histogram.count(), 1u);
}

std::string profile_text(const std::string& format, const std::string& rest) {
  return "[device]\nname = \"board\"\nvendor = 0x1209\nproduct = 0x0001\n[format]\n" + format + "\n" + rest;
}
const std::string six_channels = "kind = \"csv\"\nchannels = 6";
const std::string two_channels = "kind = \"generic\"\nsync = [0xA5, 0x5A]\nchannels = 2";

TEST(SensorProfile, ReadsWhatTheFileSays) {
  const SensorProfile profile = parse_profile(
      profile_text(two_channels, "[channels]\nnormal = [1]\nshear = [0]\n[calibration]\noffset = [1, 2]\ngain = 0.5\n"),
      "p.toml");
  EXPECT_EQ(profile.name, "board");
  EXPECT_EQ(profile.usb.vendor, 0x1209);
  EXPECT_EQ(profile.format()->channels(), 2u);
  EXPECT_THAT(profile.map.normal, ElementsAre(1));
  EXPECT_THAT(profile.map.calibration.offset, ElementsAre(1, 2));
  EXPECT_THAT(profile.map.calibration.gain, ElementsAre(0.5, 0.5));
}

TEST(SensorProfile, TheBuiltInGlove) {
  const SensorProfile glove = built_in_profile("glove");
  EXPECT_EQ(glove.usb.vendor, 0x04D8);
  EXPECT_EQ(glove.usb.product, 0x000A);
  EXPECT_EQ(glove.usb.transport, hw::Transport::cdc_acm);
  EXPECT_EQ(glove.map.tactels(), 64u);
  EXPECT_THROW(built_in_profile("mitten"), ConfigError);
}

// x, y, z of each tactel, row by row; the frame has all z, all x, all y. Readings are the channel's number.
TEST(SensorProfile, TheBuiltInPads) {
  for (const auto& [name, ny] : {std::pair{"uskin-4x4", 4}, {"uskin-4x6", 6}}) {
    const SensorProfile pad = read_profile(name);
    ASSERT_EQ(pad.pads.size(), 1u);
    EXPECT_THAT(pad.pads[0].tactels, ElementsAre(4, ny));
    EXPECT_THAT(pad.pads[0].pitch, ElementsAre(4.7, 4.7));
    const auto tactels = 4 * static_cast<std::size_t>(ny);
    std::vector<double> readings(pad.format()->channels());
    ASSERT_EQ(readings.size(), 3 * tactels);
    for (std::size_t i = 0; i < readings.size(); ++i) readings[i] = static_cast<double>(i);
    std::vector<float> frame(pad.map.places());
    pad.map.apply(readings, frame);
    for (std::size_t i = 0; i < tactels; ++i) {
      EXPECT_LT(frame[i], 0) << "a pressed tactel counts upwards";
      EXPECT_FLOAT_EQ(frame[i] / frame[0], static_cast<float>(3 * i + 2) / 2) << "z of " << i;
      EXPECT_FLOAT_EQ(frame[tactels + i] / frame[0], -static_cast<float>(3 * i) / 2) << "x of " << i;
      EXPECT_FLOAT_EQ(frame[2 * tactels + i] / frame[0], -static_cast<float>(3 * i + 1) / 2) << "y of " << i;
    }
  }
}

const std::string pad_of_two = "[pad]\ntactels = [2, 1]\npitch = [3, 4]\n[channels]\nnormal = [2, 5]\n";

TEST(SensorProfile, JoinedPadsFollowEachOtherInALine) {
  const std::string format = "[format]\nkind = \"csv\"\nchannels = 6\n";
  const std::string shear = "shear_x = [0, 3]\nshear_y = [1, -1]\n";
  const SensorProfile a =
      parse_profile(format + pad_of_two + shear + "[calibration]\noffset = 7\ngain = 2\nnoise = 1\n", "a.toml");
  const SensorProfile b =
      parse_profile(format + pad_of_two + shear + "[calibration]\noffset = 0\ngain = -1\nnoise = 3\n", "b");
  const SensorProfile both = joined_profile({a, b});
  EXPECT_EQ(both.format()->channels(), 12u);
  EXPECT_THAT(both.map.normal, ElementsAre(2, 5, 8, 11));
  EXPECT_THAT(both.map.shear, ElementsAre(0, 3, 6, 9));
  EXPECT_THAT(both.map.shear_y, ElementsAre(1, -1, 7, -1));
  EXPECT_THAT(both.map.calibration.offset, ElementsAre(7, 7, 7, 7, 7, 7, 0, 0, 0, 0, 0, 0));
  EXPECT_THAT(both.map.calibration.gain, ElementsAre(2, 2, 2, 2, 2, 2, -1, -1, -1, -1, -1, -1));
  EXPECT_THAT(both.map.calibration.noise, ElementsAre(1, 1, 1, 1, 1, 1, 3, 3, 3, 3, 3, 3));
  ASSERT_EQ(both.pads.size(), 2u);
  EXPECT_THAT(both.pads[1].tactels, ElementsAre(2, 1));
  EXPECT_THAT(both.pads[1].pitch, ElementsAre(3, 4));

  const SensorProfile of_one_axis = parse_profile(format + pad_of_two, "c.toml");
  EXPECT_TRUE(of_one_axis.map.shear.empty());
  for (const SensorProfile& other : {of_one_axis, read_profile("uskin-4x4"), built_in_profile("glove")}) {
    EXPECT_THROW(joined_profile({a, other}), ConfigError) << other.name;
    EXPECT_THROW(joined_profile({other, a}), ConfigError) << other.name;
  }
}

TEST(SensorProfile, EveryMistakeNamesItsKey) {
  struct {
    std::string text, key;
  } const mistakes[] = {
      {profile_text(two_channels, "[channels]\nnormal = [2]\n"), "channels.normal"},
      {profile_text(two_channels, "[channels]\nnormal = [0]\nshear = [0, 1]\n"), "channels.shear"},
      {profile_text(two_channels, ""), "channels.normal"},
      {profile_text(two_channels, "[channels]\nnormal = [0]\n[calibration]\ngain = [1, 2, 3]\n"), "calibration.gain"},
      {profile_text("kind = \"generic\"\nsync = [300]\nchannels = 2", ""), "format.sync"},
      {profile_text("kind = \"generic\"\nchannels = 2", "[channels]\nnormal = [0]\n"), "format.sync"},
      {profile_text("kind = \"mitten\"", ""), "format.kind"},
      {profile_text("", ""), "format.kind"},
      {profile_text("kind = \"papillarray\"\nsensors = 9", "[channels]\nnormal = [0]\n"), "format.sensors"},
      {profile_text("kind = \"glove\"\nsync = [1]", "[channels]\nnormal = [0]\n"), "format.sync"},
      {profile_text(two_channels + "\nchecksum = \"md5\"", ""), "format.checksum"},
      {"[device]\nvendor = 70000\n", "device.vendor"},
      {"[device]\nendpoint = 2\n", "device.endpoint"},
      {"[device]\nbaud = 0\n", "device.baud"},
      {profile_text(six_channels, pad_of_two + "shear = [0, 3]\n"), "channels.shear"},
      {profile_text(six_channels, pad_of_two + "shear_x = [0, 3]\n"), "channels.shear_y"},
      {profile_text(six_channels, pad_of_two + "shear_x = [0]\nshear_y = [1, 4]\n"), "channels.shear_x"},
      {profile_text(six_channels, pad_of_two + "shear_x = [0, 3]\nshear_y = [1, 6]\n"), "channels.shear_y"},
      {profile_text(six_channels, "[channels]\nnormal = [0]\nshear_x = [1]\n"), "channels.shear_x"},
      {profile_text(six_channels, "[pad]\ntactels = [2, 2]\n[channels]\nnormal = [0, 1]\n"), "channels.normal"},
      {profile_text(six_channels, "[pad]\ntactels = [2]\n"), "pad.tactels"},
      {profile_text(six_channels, "[pad]\ntactels = [2, 0]\n"), "pad.tactels"},
      {profile_text(six_channels, "[pad]\npitch = 4.7\n"), "pad.tactels"},
      {profile_text(six_channels, "[pad]\ntactels = [2, 1]\npitch = -1\n"), "pad.pitch"},
      {"[devise]\n", "devise"}};
  for (const auto& mistake : mistakes) {
    EXPECT_THAT([&] { parse_profile(mistake.text, "p.toml"); },
                ::testing::Throws<ConfigError>(::testing::Field(&ConfigError::key, mistake.key)))
        << mistake.text;
  }
}

TEST(Calibration, AFileReadsBackToTheSameNumbers) {
  const ScratchFolder folder;
  SensorProfile profile = parse_profile(profile_text(two_channels, "[channels]\nnormal = [0]\n"), "p.toml");
  const hw::Calibration calibration{{0.1, 2048.0 / 3}, {1e-9 / 3, -2}, {0, 1e-3 / 7}};
  read_calibration(folder.write("c.toml", calibration_text(calibration)), profile);
  EXPECT_EQ(profile.map.calibration.offset, calibration.offset);
  EXPECT_EQ(profile.map.calibration.gain, calibration.gain);
  EXPECT_EQ(profile.map.calibration.noise, calibration.noise);
}

// Counts with a gain have a zero that is to be measured; stresses, and readings whose offset is told, have theirs.
TEST(Calibration, AGainWithoutAnOffsetHasNoZero) {
  const auto has_zero = [](const std::string& text) {
    return parse_profile(profile_text(two_channels, "[channels]\nnormal = [0]\n" + text), "p.toml")
        .map.calibration.has_zero;
  };
  EXPECT_TRUE(has_zero("") && has_zero("[calibration]\noffset = 0\ngain = 2\n") &&
              has_zero("[calibration]\nnoise = 2\n"));
  EXPECT_FALSE(has_zero("[calibration]\ngain = 2\n"));
  SensorProfile pad = read_profile("uskin-4x4");
  EXPECT_FALSE(pad.map.calibration.has_zero);
  EXPECT_FALSE(joined_profile({pad, pad}).map.calibration.has_zero);
  EXPECT_FALSE(parse_profile(joined_profile({pad, pad}).text, "recording").map.calibration.has_zero);
  const ScratchFolder folder;
  read_calibration(folder.write("gain.toml", "[calibration]\ngain = 1e-5\n"), pad);
  EXPECT_FALSE(pad.map.calibration.has_zero);
  read_calibration(folder.write("rest.toml", "[calibration]\noffset = 40000\n"), pad);
  EXPECT_TRUE(pad.map.calibration.has_zero);
  read_calibration(folder.write("gain.toml", "[calibration]\ngain = 1e-5\n"), pad);
  EXPECT_TRUE(pad.map.calibration.has_zero);
  SensorProfile bare = parse_profile(profile_text(two_channels, "[channels]\nnormal = [0]\n"), "p.toml");
  read_calibration(folder / "gain.toml", bare);
  EXPECT_FALSE(bare.map.calibration.has_zero) << "what were stresses are counts now";
}

TEST(OpenSource, RefusesWhatItDoesNotKnow) {
  for (const char* source :
       {"glove", "usb:", "radio:1", "usb:zzzz:0001", "usb:1209:0001", "simulate:none.toml",
        "simulate:examples/parabola.toml?rat=5", "simulate:examples/parabola.toml?rate=fast",
        "simulate:examples/parabola.toml?rate=0", "simulate:examples/parabola.toml?rate=1e6&repeat=2000000000",
        "usb:glove?serail=3", "usb:glove?serial=", "usb:glove?port"})
    EXPECT_THROW(open_source(source, "", ""), ConfigError) << source;
}

// This machine has no such device, and perhaps no USB at all.
TEST(OpenSource, ADeviceThatIsNotThereSaysWhatToCheck) {
  EXPECT_THAT([] { open_source("usb:glove", "", ""); },
              ::testing::ThrowsMessage<hw::SourceError>(::testing::HasSubstr("lsusb -d 04d8:000a")));
}

}  // namespace tactel::host::live_frames_test
