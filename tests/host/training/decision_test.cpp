// SPDX-License-Identifier: Apache-2.0

// The counting of alarms on drags, by hand, and the coverage of a bound on rows that are counted by hand.
#include "host/training/decision.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/support/errors.h"

namespace tactel::host::decision_test {

/// Drags at 0.8 with a release of 0.05, worked by hand:
///   a  slides at 1.0 mm; alarm at 0.6 mm, S 0.7: detected, lead 0.4 mm of 1.0
///   b  slides at 2.0 mm; alarms at 0.5 mm (S 0.3, false) and, after 0.74 ended it, at 1.5 mm: detected, but falsely
///   c  slides at 1.0 mm; 0.76 does not end the alarm of 0.2 mm (S 0.6): one alarm, lead 0.8
///   d  slides; its values stay below: missed
///   e  never slides; a false alarm at S 0.4
///   f  never slides; NaN fires nothing
std::vector<Drag> worked_drags() {
  return {{.rows = {{0.0, 0.1, 0.2}, {0.6, 0.7, 0.8}, {0.9, 0.9, 0.9}}, .slides = true, .slide_way = 1.0},
          {.rows = {{0.0, 0.1, 0.1}, {0.5, 0.3, 0.9}, {1.0, 0.5, 0.74}, {1.5, 0.8, 0.85}},
           .slides = true,
           .slide_way = 2.0},
          {.rows = {{0.0, 0.1, 0.1}, {0.2, 0.6, 0.81}, {0.4, 0.4, 0.76}, {0.6, 0.4, 0.9}},
           .slides = true,
           .slide_way = 1.0},
          {.rows = {{0.0, 0.1, 0.1}, {0.5, 0.9, 0.79}}, .slides = true, .slide_way = 1.0},
          {.rows = {{0.0, 0.4, 0.95}, {0.1, 0.4, 0.95}}},
          {.rows = {{0.0, 0.9, std::nan("")}}}};
}

TEST(AlarmCounting, FollowsDragsWorkedByHand) {
  const AlarmCount count = count_alarms(worked_drags(), 0.8, {.rate = 100});
  EXPECT_EQ(count.drags, 4u);
  EXPECT_EQ(count.detected, 3u);
  EXPECT_DOUBLE_EQ(count.detection(), 0.75);
  EXPECT_EQ(count.all, 6u);
  EXPECT_EQ(count.false_drags, 2u);   // b, e
  EXPECT_EQ(count.false_alarms, 2u);  // b at 0.5 mm, e at once; not b at 1.5 mm
  EXPECT_EQ(count.rows, 16u);
  EXPECT_DOUBLE_EQ(count.false_a_minute(100), 2 / (16 / 100.0 / 60));
  EXPECT_EQ(count.lead.size(), 2u);
  EXPECT_NEAR(count.lead[0], 0.4, 1e-12);
  EXPECT_NEAR(count.lead[1], 0.8, 1e-12);
  EXPECT_NEAR(count.lead_share[0], 0.4, 1e-12);
  EXPECT_NEAR(count.lead_share[1], 0.8, 1e-12);
}

// Without hysteresis 0.76 ends the alarm of drag c, and 0.9 at S 0.4 begins a false one.
TEST(AlarmCounting, ReleaseDecidesWhatIsOneAlarm) {
  EXPECT_EQ(count_alarms(worked_drags(), 0.8, {.release = 0}).false_alarms, 3u);
}

// Intervals of at most 0.4 begin an alarm. Drag a: at 0.6 mm it is 0.5 wide, at 0.9 mm 0.4: the alarm begins there,
// with a lead of 0.1 mm. Drag b: 0.5 wide at both places: no alarm, and two frames that cannot tell. Drag c: the alarm
// of 0.2 mm is narrow, and a wide frame does not end it. d stays below. e: wide, no false alarm.
TEST(AlarmCounting, AWideIntervalCannotTell) {
  std::vector<Drag> drags = worked_drags();
  drags[0].rows[1].width = 0.5, drags[0].rows[2].width = 0.4;
  drags[1].rows[1].width = drags[1].rows[3].width = 0.5;
  drags[2].rows[3].width = 0.9;
  drags[4].rows[0].width = 0.6, drags[4].rows[1].width = std::nan("");
  const AlarmCount count = count_alarms(drags, 0.8, {.widest = 0.4});
  EXPECT_EQ(count.detected, 2u);  // a, c
  EXPECT_EQ(count.told, 3u);      // and b
  EXPECT_DOUBLE_EQ(count.told_share(), 0.75);
  EXPECT_EQ(count.false_drags, 0u);
  EXPECT_EQ(count.cannot_tell, 5u);
  EXPECT_DOUBLE_EQ(count.cannot_tell_share(), 5.0 / 16);
  EXPECT_NEAR(count.lead[0], 0.1, 1e-12);
  const AlarmCount any = count_alarms(drags, 0.8, {});
  EXPECT_EQ(any.cannot_tell, 0u);
  EXPECT_EQ(any.detected, 3u);
}

// To and fro: 0.2 there, 0.1 back and 0.2 on are 0.5 mm of way; rows without an answer are no rows of the drag, and
// what follows the first sliding row belongs to no drag.
TEST(AlarmCounting, AddsUpTheWay) {
  ContactSet set(SetColumns(2));
  set.frames.resize(12);
  set.contact = {4, 4, 4, 4, 4, 9};
  set.step = {0, 1, 2, 3, 4, 0};
  set.indenter = {2, 2, 2, 2, 2, 1};
  set.contact_nodes = {3, 3, 3, 4, 5, 7};
  set.status = {0, 0, 0, 1, 0, 0};
  set.slip_index = {0, 0.5f, 0.4f, 1, 1, 0.1f};
  const AnsweredRows rows{{}, {0, 1, 3, 4, 5}, 1};
  const std::vector<float> values{0.1f, 0.6f, 0.9f, 0.9f, 0.2f};
  const std::vector<double> positions{0, 0.2, 0.1, 0.3, 0.4, 0};
  const std::vector<Drag> drags = drags_of(set, rows, values, positions);
  ASSERT_EQ(drags.size(), 2u);
  EXPECT_EQ(drags[0].kind, 2);
  EXPECT_EQ(drags[0].touching, 3);
  EXPECT_TRUE(drags[0].slides);
  EXPECT_NEAR(drags[0].slide_way, 0.5, 1e-12);
  ASSERT_EQ(drags[0].rows.size(), 2u);
  EXPECT_NEAR(drags[0].rows[1].way, 0.2, 1e-12);
  EXPECT_EQ(drags[0].rows[1].value, 0.6f);
  EXPECT_FALSE(drags[1].slides);
}

// Rows 0 and 2 stay below 0.1 MPa of normal stress, the second input being shear: they fire nothing and end an alarm.
TEST(AlarmCounting, BelowTheThresholdOfTouchThereIsNoAlarm) {
  ContactSet set(SetColumns(2));
  set.frames = {0.05f, 9, -0.1f, 0, -0.09f, 9, 0.2f, 0};
  set.contact = {0, 0, 0, 0};
  set.step = {0, 1, 2, 3};
  set.indenter = {0, 0, 0, 0}, set.contact_nodes = {1, 1, 1, 1}, set.status = {0, 0, 0, 0};
  set.slip_index = {0, 0, 0, 0};
  const AnsweredRows rows{{}, {0, 1, 2, 3}, 0};
  const std::vector<float> values{0.9f, 0.9f, 0.9f, 0.9f};
  const std::vector<double> positions{0, 0.1, 0.2, 0.3};
  const auto false_alarms = [&](double touch) {
    return count_alarms(drags_of(set, rows, values, positions, touch), 0.8, {}).false_alarms;
  };
  EXPECT_EQ(false_alarms(0), 1u);
  EXPECT_EQ(false_alarms(0.0999), 2u);  // at rows 1 and 3
  EXPECT_EQ(false_alarms(1), 0u);
}

// Contact k of the sweep is drawn again for its positions: 0 at full indentation, then 0.05 and 0.08 mm.
TEST(AlarmCounting, FindsPositionsInTheSweepOfTheSet) {
  ContactSet set(SetColumns(10));
  set.sweep =
      "[sweep]\ncontacts = 3\n[sensor]\ncolumns = 11\nrows = 4\ntactels = 5\n[contact]\nfriction = 0.5\n[indenter]\n"
      "shape = \"parabola\"\nradius = 10\n[load]\nindentation = 0.1\ntangential = [0.05, 0.08]\n";
  set.contact = {0, 0, 0, 2};
  set.step = {0, 1, 2, 1};
  set.slip_index = {0, 0.1f, 0.2f, 0.1f};
  EXPECT_EQ(tangential_positions(set, "s.h5"), (std::vector<double>{0, 0.05, 0.08, 0.05}));
  set.step[3] = 3;
  EXPECT_THROW(tangential_positions(set, "s.h5"), ConfigError);
  set.step[3] = 1, set.contact[3] = std::uint64_t{1} << 40;
  EXPECT_NO_THROW(tangential_positions(set, "s.h5"));  // drawn contacts have no end
}

/// Rows of contact 5 on a pad of two tactels with three axes, out of order in the set: at first touch, after 3 mm along
/// x and 4 mm along y, after half a turn back in place.
ContactSet rows_on_pad() {
  ContactSet set(SetColumns(6, false, true));
  set.axes = 3;
  set.contact = {5, 5, 5}, set.step = {2, 0, 1};
  set.tangential = {3, 4, 0, 0, 3, 4}, set.twist = {-180, 0, 0};
  set.frames = {0.05f, -0.04f, 9, 9, 9, 9, 0.2f, -0.001f, 0, 0, 0, 0, 0.3f, 0.3f, 0, 0, 0, 0};
  set.slip_index = {0.9f, 0, 0.6f}, set.force_ratio = {0.1f, 0, 0.6f};
  set.indenter = {0, 0, 0}, set.contact_nodes = {30, 20, 40}, set.status = {0, 0, 0};
  return set;
}

// The hypotenuse, then pi at a radius of 1 mm.
TEST(AlarmCounting, AddsUpTheWayOnAPad) {
  ContactSet set = rows_on_pad();
  const std::vector<double> ways = tangential_positions(set, "s.h5");
  EXPECT_NEAR(ways[0], 5 + 3.14159265, 1e-6);
  EXPECT_EQ(ways[1], 0);
  EXPECT_EQ(ways[2], 5);
  const AnsweredRows rows{{}, {0, 1, 2}, 0};
  const std::vector<float> values{0.9f, 0.9f, 0.9f};
  const std::vector<Drag> drags = drags_of(set, rows, values, ways, 0.1);
  ASSERT_EQ(drags.size(), 1u);
  EXPECT_NEAR(drags[0].rows[2].way, 8.14159265, 1e-6);
  EXPECT_EQ(drags[0].rows[0].value, 0.9f);
  EXPECT_EQ(drags[0].rows[2].value, 0);  // its normal stresses stay below 0.1 MPa, its shear does not
  set.left_out = {"twist"};
  EXPECT_THROW(tangential_positions(set, "s.h5"), ConfigError);
}

// Of pads the tactels above 5 % of the largest |sigma_z| count, and the share of torque.
TEST(AnsweredRowsOfPads, HaveClasses) {
  ContactSet set = rows_on_pad();
  const nn::FrameSet frames = answered_rows(set, "s.h5").frames;
  EXPECT_EQ(frames.contact_nodes, (std::vector<std::int32_t>{2, 1, 2}));
  EXPECT_EQ(frames.torque, (std::vector<std::uint8_t>{3, 0, 1}));
  set.status = {2, 3, 1};  // over tolerance, few cells, sliding
  EXPECT_EQ(answered_rows(set, "s.h5").row, (std::vector<std::size_t>{1, 2}));
  set.left_out = {"force_ratio"};
  EXPECT_THROW(answered_rows(set, "s.h5"), ConfigError);
}

// Six rows of two kinds; S 1.00001 counts as 1, the unlike row apart.
TEST(BoundReport, CountsByClass) {
  const nn::FrameSet set{.slip_index = nn::Vector<float>{{0.05f, 0.5f, 0.55f, 1.00001f, 0.95f, 0.3f}},
                         .shape_class = {0, 0, 1, 1, 1, 0},
                         .contact_nodes = {1, 2, 4, 40, 3, 2},
                         .torque = {0, 1, 3, 3, 3, 2}};
  const std::vector<nn::BoundAnswer> bounds{{0.1f, {0, 0.1f}, false},   {0.4f, {0.3f, 0.6f}, false},
                                            {0.6f, {0.5f, 0.6f}, true}, {1, {0.9f, 1}, false},
                                            {1, {0.97f, 1}, false},     {NAN, {NAN, NAN}, false}};
  const std::vector<double> errors{0.02, 0.04, 0.01, 0.05, 0.03, NAN};
  const BoundReport report = report_bound(bounds, errors, set);
  EXPECT_EQ(report.all.rows, 5u);
  EXPECT_DOUBLE_EQ(report.all.upper, 0.8);
  EXPECT_DOUBLE_EQ(report.all.interval, 0.8);
  EXPECT_DOUBLE_EQ(report.all.unlike, 0.2);
  EXPECT_NEAR(report.all.width, 0.1, 1e-6);
  EXPECT_EQ(report.alike.rows, 4u);
  EXPECT_DOUBLE_EQ(report.alike.upper, 0.75);
  EXPECT_DOUBLE_EQ(report.by_class.at(0).upper, 0.5);
  EXPECT_DOUBLE_EQ(report.by_class.at(1).upper, 1);
  EXPECT_EQ(report.by_touching.at(3).rows, 2u);
  EXPECT_EQ(report.by_touching.at(17).rows, 1u);
  EXPECT_EQ(report.by_slip.at(9).rows, 2u);
  EXPECT_EQ(report.by_torque.at(3).rows, 3u);
  EXPECT_DOUBLE_EQ(report.by_torque.at(1).upper, 0);
  EXPECT_DOUBLE_EQ(report.by_slip.at(5).upper, 0.5);
  ASSERT_EQ(report.answered.size(), 5u);  // the widest is row 1, and row 5 has no answer
  EXPECT_NEAR(report.answered[0].mean, 0.03, 1e-12);
  EXPECT_NEAR(report.answered[0].most, 0.0496, 1e-12);  // 0.96 of the way from the fourth to the fifth
  EXPECT_NEAR(report.answered[0].width, 0.3, 1e-6);
  EXPECT_DOUBLE_EQ(report.answered[4].share, 0.8);
  EXPECT_NEAR(report.answered[4].mean, 0.0275, 1e-12);
  EXPECT_NEAR(report.answered[4].width, 0.1, 1e-6);
  EXPECT_EQ(touching_name(3), "3 to 4");
  EXPECT_EQ(touching_name(2), "2");
  EXPECT_EQ(touching_name(17), "17 and more");
}

}  // namespace tactel::host::decision_test
