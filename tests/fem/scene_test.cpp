// SPDX-License-Identifier: Apache-2.0
#include "fem/scenes/scene.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "expect_error.h"

namespace tactel::fem::scene_test {

using testing::ElementsAre;
constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();

LoadStep depth(double normal, double tangential = 0) { return {false, false, normal, tangential}; }
LoadStep force(double normal, double tangential = 0) { return {true, false, normal, tangential}; }

TEST(LoadPath, DepthThenEqualTangentialSteps) {
  const Load load{.indentation = {0.5}, .indentation_steps = 4, .tangential_step = 0.25, .tangential_steps = 2};
  const LoadPath path = load_path(load);
  EXPECT_THAT(path.steps,
              ElementsAre(depth(0.125), depth(0.25), depth(0.375), depth(0.5), depth(0.5, 0.25), depth(0.5, 0.5)));
  EXPECT_EQ(path.indentation_steps, 4);
  EXPECT_FALSE(path.until_sliding);
}

TEST(LoadPath, SeveralTargetsUnloadFromTheLastOne) {
  const Load load{.indentation = {0.5, 0.25}, .indentation_steps = 2};
  EXPECT_THAT(load_path(load).steps, ElementsAre(depth(0.25), depth(0.5), depth(0.375), depth(0.25)));
}

TEST(LoadPath, TargetsAreMetExactly) {
  Load load{.indentation = {0.15, 0.07}};
  load.indentation_steps = 7;  // 0.15 / 7 * 7 is not 0.15 in binary
  const LoadPath path = load_path(load);
  EXPECT_EQ(path.steps[6].normal, 0.15);
  EXPECT_EQ(path.steps[13].normal, 0.07);
}

TEST(LoadPath, ExplicitPositionsWithReversal) {
  const LoadPath path = load_path({.normal_force = {2}, .tangential = {0, 0.1, -0.05}});
  EXPECT_THAT(path.steps, ElementsAre(force(2), force(2, 0), force(2, 0.1), force(2, -0.05)));
  EXPECT_EQ(path.indentation_steps, 1);
}

TEST(LoadPath, ForceWinsOverTheDefaultDepth) {
  EXPECT_THAT(load_path({.normal_force = {2}, .indentation_steps = 2}).steps, ElementsAre(force(1), force(2)));
}

TEST(LoadPath, ForceAtAnAngleGrowsBothTogether) {
  const LoadPath path = load_path({.normal_force = {1, 4}, .indentation_steps = 2, .angle = -45});
  ASSERT_EQ(path.steps.size(), 4u);
  EXPECT_EQ(path.indentation_steps, 4);
  const double normal[] = {0.5, 1, 2.5, 4};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_TRUE(path.steps[k].normal_is_force && path.steps[k].tangential_is_force);
    EXPECT_EQ(path.steps[k].normal, normal[k]);
    EXPECT_DOUBLE_EQ(path.steps[k].tangential, -normal[k]);  // tan 45 = 1 to rounding
  }
}

TEST(LoadPath, UntilSlidingStopsAtTheMost) {
  const LoadPath path = load_path({.tangential_step = -0.05});
  EXPECT_TRUE(path.until_sliding);
  ASSERT_EQ(path.steps.size(), 1u + most_tangential_steps);
  EXPECT_EQ(path.steps[1], depth(0.15, -0.05));
  EXPECT_EQ(path.steps.back(), depth(0.15, -0.05 * most_tangential_steps));
}

/// What a scene says when `change` was made to a good one.
template <class Change>
void rejects(Change change, const char* key, const char* value, const char* allowed) {
  Scene scene;
  change(scene);
  expect_value_error([&] { scene.validate(); }, key, value, allowed);
}

TEST(Scene, DefaultsAreValid) { EXPECT_NO_THROW(Scene{}.validate()); }

TEST(Scene, ChecksItsParts) {
  rejects([](Scene& s) { s.sensor.poisson = 0.5; }, "sensor.poisson", "0.5", "");
  rejects([](Scene& s) { s.indenter.shape = Parabola{0}; }, "indenter.radius", "0", "");
  for (double bad : {-0.1, nan})
    rejects([&](Scene& s) { s.friction = bad; }, "contact.friction", "", "not below 0, or \"bonded\"");
}

TEST(Scene, ChecksTheNormalLoad) {
  rejects([](Scene& s) { s.load.indentation = {}; }, "load.indentation", "[]", "at least one");
  rejects([](Scene& s) { s.load.indentation = {0.1, -0.1}; }, "load.indentation", "-0.1", "not below 0");
  rejects([](Scene& s) { s.load.indentation = {nan}; }, "load.indentation", "nan", "finite");
  rejects([](Scene& s) { s.load.normal_force = {-1}; }, "load.normal_force", "-1", "not below 0");
  rejects([](Scene& s) { s.load.normal_force = {infinity}; }, "load.normal_force", "inf", "finite");
  for (int bad : {0, -3, 1001})
    rejects([&](Scene& s) { s.load.indentation_steps = bad; }, "load.indentation_steps", "", "1 to 1000");
}

TEST(Scene, ChecksTheTangentialLoad) {
  rejects([](Scene& s) { s.load.tangential = {0.1, nan}; }, "load.tangential", "nan", "finite");
  rejects([](Scene& s) { s.load.tangential_step = infinity; }, "load.tangential_step", "inf", "finite");
  rejects([](Scene& s) { s.load.tangential = {0.1}, s.load.tangential_step = 0.05; }, "load.tangential_step", "0.05",
          "left out");
  rejects([](Scene& s) { s.load.tangential_steps = 3; }, "load.tangential_step", "0", "other than 0");
  rejects([](Scene& s) { s.load.tangential_step = 1, s.load.tangential_steps = -1; }, "load.tangential_steps", "-1",
          "0 to 1000");
  rejects([](Scene& s) { s.load.tangential_step = 1, s.load.tangential_steps = 1001; }, "load.tangential_steps", "1001",
          "0 to 1000");
}

TEST(Scene, AngleStaysWithinTheFrictionAngle) {
  const auto with_angle = [](double angle, double friction) {
    return [=](Scene& s) { s.load.normal_force = {1}, s.load.angle = angle, s.friction = friction; };
  };
  Scene good;
  with_angle(30, std::tan(38 * std::numbers::pi / 180))(good);  // the paper's largest
  EXPECT_NO_THROW(good.validate());
  with_angle(0, 0.1)(good);
  EXPECT_NO_THROW(good.validate());
  rejects(with_angle(46, 1), "load.angle", "46", "-45 < angle < 45 degrees (atan of contact.friction = 1)");
  rejects(with_angle(-46, 1), "load.angle", "-46", "friction angle");
  rejects(with_angle(135, 1), "load.angle", "135", "friction angle");  // its tangent is -1
  rejects(with_angle(90, 1e20), "load.angle", "90", "friction angle");
  rejects(with_angle(nan, 1), "load.angle", "nan", "friction angle");
  rejects(with_angle(0, 0), "load.angle", "0", "leave it out");
  rejects([](Scene& s) { s.load.angle = 10; }, "load.angle", "10", "with load.normal_force");
  rejects([&](Scene& s) { with_angle(10, 1)(s), s.load.tangential_step = 0.1; }, "load.angle", "10", "without");
}

TEST(Scene, TheIndenterMustReachTheSensor) {
  const auto stands = [](const Shape& shape, double position) {
    return [=](Scene& s) { s.indenter = {shape, position}; };
  };
  const auto accepts = [&](const Shape& shape, double position) {
    Scene scene;
    stands(shape, position)(scene);
    EXPECT_NO_THROW(scene.validate()) << shape_name(shape) << " at " << position;
  };
  accepts(Parabola{}, 10);  // on the very edge
  rejects(stands(Parabola{}, 10.01), "indenter.position", "10.01",
          "now at 10.01 to 10.01 mm, over the sensor, from -10 to 10");
  accepts(Flat{}, 500);  // wider than the sensor, wherever it stands
  accepts(Flat{2.0}, 12);
  rejects(stands(Flat{2.0}, 12.1), "indenter.position", "12.1", "over the sensor");
  rejects(stands(Flat{2.0}, -12.1), "indenter.position", "-12.1", "over the sensor");
  accepts(Flat{0.1}, 0.5);
  rejects(stands(Flat{0.1}, 0.25), "indenter.position", "0.25",
          "a surface node under the indenter; the nodes are 0.5 mm apart");
  rejects(stands(Cylinder{0.2}, 0.25), "indenter.position", "0.25", "a surface node under the indenter");
  rejects(stands(Profile{{1, 2, 3}, {1, 0, 1}, 0, ""}, 9), "indenter.position", "9", "now at 11 to 11");
}

}  // namespace tactel::fem::scene_test
