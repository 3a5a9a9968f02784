// SPDX-License-Identifier: Apache-2.0
#include "hw/channel_map.h"

#include <gmock/gmock.h>

#include "fem/numbers/value_error.h"
#include "tests/thrown_message.h"

namespace tactel::hw::channel_map_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

ChannelMap three_channels() {
  return {.normal = {2, 0}, .shear = {1, -1}, .calibration = {.offset = {10, 20, 30}, .gain = {0.5, -1, 0.25}}};
}

TEST(ChannelMap, PutsCalibratedChannelsWhereTheyBelong) {
  float frame[4];
  three_channels().apply(std::vector<double>{14, 21, 38}, frame);
  EXPECT_THAT(frame, ElementsAre(2, 2, -1, 0));  // (38-30)/4, (14-10)/2, -(21-20), no channel
}

TEST(ChannelMap, RefusesWhatDoesNotFitTheDevice) {
  EXPECT_NO_THROW(three_channels().validate(3));
  const auto refused = [](auto&& change) {
    ChannelMap map = three_channels();
    change(map);
    EXPECT_THROW(map.validate(3), ValueError);
  };
  refused([](ChannelMap& m) { m.normal[0] = 3; });
  refused([](ChannelMap& m) { m.shear[0] = -2; });
  refused([](ChannelMap& m) { m.shear.pop_back(); });
  refused([](ChannelMap& m) { m.normal.clear(), m.shear.clear(); });
  refused([](ChannelMap& m) { m.calibration.gain.pop_back(); });
  refused([](ChannelMap& m) { m.calibration.noise = {1}; });
  refused([](ChannelMap& m) { m.calibration.noise = {0, -1, 0}; });
  refused([](ChannelMap& m) { m.calibration.offset[1] = std::nan(""); });
}

TEST(ChannelMap, NamesNumbersThatGiveNoStress) {
  const auto message = [](auto&& change) -> std::string {
    ChannelMap map = three_channels();
    map.calibration.noise = {1, 1, 1};
    change(map.calibration);
    return thrown_message<ValueError>([&] { map.validate(3); });
  };
  EXPECT_EQ(message([](Calibration&) {}), "no error");
  for (const double gain : {0.0, 1e300, -1e300, 1e-44})
    EXPECT_THAT(message([=](Calibration& c) { c.gain[2] = gain; }),
                AllOf(HasSubstr("calibration.gain"), HasSubstr("channel 2 (normal stress of tactel 0)")))
        << gain;
  EXPECT_THAT(message([](Calibration& c) { c.noise[1] = 1e308; }),
              AllOf(HasSubstr("calibration.noise = 1e+308"), HasSubstr("channel 1 (shear stress of tactel 0)")));
  EXPECT_THAT(message([](Calibration& c) { c.offset[0] = 1e300; }), HasSubstr("calibration.offset"));
  ChannelMap unused = three_channels();
  unused.shear = {-1, -1}, unused.calibration.gain[1] = 0;
  EXPECT_NO_THROW(unused.validate(3)) << "no tactel has channel 1";
}

// 7 x 0.5 x |-2| of channel 1; channel 2 is of a shear stress.
TEST(ChannelMap, TouchIsSevenDeviationsOfTheNoisiestNormalStress) {
  ChannelMap map{{0, 1, -1}, {2, 2, -1}, {{0, 0, 0}, {1, -2, 1}}};
  EXPECT_EQ(map.touch(), 0) << "the noise is not known";
  map.calibration.noise = {0.1, 0.5, 9};
  map.validate(3);
  EXPECT_DOUBLE_EQ(map.touch(), 7);
}

/// Two tactels that send x, y, z each; z counts upwards under pressure.
ChannelMap pad_of_two() {
  return {.normal = {2, 5},
          .shear = {0, 3},
          .calibration = {.offset = {100, 200, 300, 0, 0, 0}, .gain = {0.5, 2, -0.25, 1, 1, -1}},
          .shear_y = {1, 4}};
}

TEST(ChannelMap, APadHasAllNormalStressesThenShearAlongXThenAlongY) {
  const ChannelMap map = pad_of_two();
  map.validate(6);
  ASSERT_EQ(map.places(), 6u);
  std::vector<float> frame(6);
  map.apply(std::vector<double>{102, 199, 308, 7, 8, 9}, frame);
  EXPECT_THAT(frame, ElementsAre(-2, -9, 1, 7, -2, 8));  // -(308-300)/4, -9; (102-100)/2, 7; 2 (199-200), 8
  EXPECT_EQ(map.channel_text(1), "channel 5 (normal stress of tactel 1)");
  EXPECT_EQ(map.channel_text(2), "channel 0 (shear stress along x of tactel 0)");
  EXPECT_EQ(map.channel_text(5), "channel 4 (shear stress along y of tactel 1)");
}

TEST(ChannelMap, APadOfOneAxisHasNormalStressesAlone) {
  const ChannelMap map{.normal = {1, 0}, .shear = {}, .calibration = {.offset = {0, 1}, .gain = {1, 3}}};
  map.validate(2);
  std::vector<float> frame(map.places());
  map.apply(std::vector<double>{4, 2}, frame);
  EXPECT_THAT(frame, ElementsAre(3, 4));
  EXPECT_EQ(map.channel(2), -1);
}

TEST(ChannelMap, RefusesAPadWhoseAxesDiffer) {
  ChannelMap map = pad_of_two();
  map.shear_y.pop_back();
  EXPECT_THAT(thrown_message<ValueError>([&] { map.validate(6); }), HasSubstr("channels.shear_y"));
  map = pad_of_two();
  map.shear.push_back(1);
  EXPECT_THAT(thrown_message<ValueError>([&] { map.validate(6); }), HasSubstr("channels.shear_x"));
}

/// Each of two pads has the threshold of its own noise.
TEST(ChannelMap, TouchOfSomeTactels) {
  const ChannelMap map{{0, 1, 2}, {}, {{0, 0, 0}, {1, -2, 1}, {1, 1, 3}}};
  EXPECT_EQ(map.touch(0, 1), 7);
  EXPECT_EQ(map.touch(0, 2), 14);
  EXPECT_EQ(map.touch(2, 1), 21);
}

}  // namespace tactel::hw::channel_map_test
