// SPDX-License-Identifier: Apache-2.0
#include "fem/scenes/indenter.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "expect_error.h"
#include "fem/scenes/measured_profile.h"

namespace tactel::fem::indenter_test {

constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();

/// Height at distance r on either side of an indenter that stands at x = 0.5; they must agree for even shapes.
double at(const Shape& shape, double r) {
  const Indenter indenter{shape, 0.5};
  EXPECT_EQ(profile_height(indenter, 0.5 + r), profile_height(indenter, 0.5 - r)) << shape_name(shape);
  return profile_height(indenter, 0.5 + r);
}

// Distances are sums with 0.5 in binary, so that r is exact: quarters and halves.

TEST(IndenterShape, Flat) {
  EXPECT_EQ(at(Flat{}, 1e6), 0);
  EXPECT_EQ(at(Flat{2.0}, 2), 0);
  EXPECT_EQ(at(Flat{2.0}, 2.25), infinity);
}

TEST(IndenterShape, EdgesReachTheNodeThatStandsOnThem) {
  // 0.3 is not 0.1 + 0.2 in binary, nor is 0.7 - 0.1 0.6: the node still touches. A micrometre further it does not.
  EXPECT_EQ(profile_height({Flat{0.3}, 0.1 + 0.2}, 0.6), 0);
  EXPECT_EQ(profile_height({Flat{0.6}, 0.1}, 0.7), 0);
  EXPECT_EQ(profile_height({Flat{0.6}, 0.1}, 0.701), infinity);
  EXPECT_DOUBLE_EQ(profile_height({Cylinder{0.6}, 0.1}, 0.7), 0.6);
  EXPECT_EQ(profile_height({Cylinder{0.6}, 0.1}, 0.701), infinity);
  EXPECT_DOUBLE_EQ(profile_height({Profile{{-0.6, 0, 0.6}, {1, 0, 1}, 0, ""}, 0.1}, 0.7), 1);
  EXPECT_EQ(profile_height({Profile{{-0.6, 0, 0.6}, {1, 0, 1}, 0, ""}, 0.1}, 0.701), infinity);
}

TEST(IndenterShape, Wedge) {
  EXPECT_DOUBLE_EQ(at(Wedge{90}, 1.5), 1.5);            // tan 45 = 1
  EXPECT_DOUBLE_EQ(at(Wedge{120}, 3), std::sqrt(3.0));  // tan 60 = sqrt 3
  EXPECT_DOUBLE_EQ(at(Wedge{60}, 1), std::sqrt(3.0));   // tan 30 = 1/sqrt 3
}

TEST(IndenterShape, ParabolaAndCylinder) {
  EXPECT_DOUBLE_EQ(at(Parabola{10}, 2), 0.2);
  EXPECT_DOUBLE_EQ(at(Cylinder{5}, 3), 1);  // 3-4-5
  EXPECT_DOUBLE_EQ(at(Cylinder{5}, 5), 5);
  EXPECT_EQ(at(Cylinder{5}, 5.25), infinity);
  // Near the bottom a cylinder is its parabola, r^2/2R (1 + r^2/4R^2): no cancellation.
  EXPECT_NEAR(at(Cylinder{1024}, 0.25) / at(Parabola{1024}, 0.25), 1 + 0.0625 / 4 / 1024 / 1024, 1e-15);
}

TEST(IndenterShape, ExponentialTrapezoidRoundedFlat) {
  EXPECT_DOUBLE_EQ(at(Exponential{0.1, 0.5}, 2), 0.1 * (std::numbers::e - 1));
  EXPECT_EQ(at(Exponential{0.1, 0.5}, 0), 0);
  EXPECT_EQ(at(Trapezoid{2, 0.75}, 2), 0);
  EXPECT_DOUBLE_EQ(at(Trapezoid{2, 0.75}, 4), 1.5);
  EXPECT_EQ(at(RoundedFlat{2, 10}, 2), 0);
  EXPECT_DOUBLE_EQ(at(RoundedFlat{2, 10}, 4), 0.2);
}

TEST(IndenterShape, Taylor) {
  EXPECT_EQ(at(Taylor{{}, 1, {}}, 7), 0);
  EXPECT_DOUBLE_EQ(at(Taylor{{1, 3}, 1, {}}, 2), 10);  // 2 + 8
  EXPECT_DOUBLE_EQ(at(Taylor{{1, 3}, 2, {}}, 4), 20);  // 2 (2 + 8)
  EXPECT_DOUBLE_EQ(at(Taylor{{1, 2, 3, 4, 5}, 1, {}}, 1), 5);
  EXPECT_DOUBLE_EQ(at(Taylor{{1, 3}, 2, 0.25}, 4), 2.5);  // 0.25 (2 + 8)
}

TEST(IndenterShape, MeasuredProfile) {
  // Lowest point 0.2 at x = 1: heights count from there, x from the indenter's position.
  const Indenter indenter{Profile{{-1, 1, 2, 4}, {1.2, 0.2, 0.4, 2.4}, 0, ""}, 10};
  EXPECT_DOUBLE_EQ(profile_height(indenter, 9), 1);
  EXPECT_DOUBLE_EQ(profile_height(indenter, 10), 0.5);
  EXPECT_DOUBLE_EQ(profile_height(indenter, 11), 0);
  EXPECT_NEAR(profile_height(indenter, 11.5), 0.1, 1e-15);
  EXPECT_DOUBLE_EQ(profile_height(indenter, 13), 1.2);
  EXPECT_EQ(profile_height(indenter, 8.9), infinity);
  EXPECT_EQ(profile_height(indenter, 14.1), infinity);
}

TEST(IndenterShape, ManyPlacesAsOne) {
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(9, -2, 2);
  for (const Shape& shape : {Shape{Parabola{3}}, Shape{Flat{1.0}}, Shape{Profile{{-1, 0, 1}, {1, 0, 1}, 0, ""}}}) {
    const Eigen::VectorXd heights = profile_heights({shape, 0.25}, x);
    for (int i = 0; i < 9; ++i) EXPECT_EQ(heights[i], profile_height({shape, 0.25}, x[i]));
  }
}

TEST(IndenterShape, LowestPart) {
  const auto lowest = [](const Shape& shape) {
    const Interval part = lowest_part({shape, 3});
    return std::pair(part.left, part.right);
  };
  EXPECT_EQ(lowest(Flat{}), std::pair(-infinity, infinity));
  EXPECT_EQ(lowest(Flat{2.0}), std::pair(1.0, 5.0));
  EXPECT_EQ(lowest(Parabola{}), std::pair(3.0, 3.0));
  EXPECT_EQ(lowest(Trapezoid{1, 1}), std::pair(2.0, 4.0));
  EXPECT_EQ(lowest(RoundedFlat{1, 1}), std::pair(2.0, 4.0));
  EXPECT_EQ(lowest(Taylor{{}, 1, {}}), std::pair(-infinity, infinity));
  EXPECT_EQ(lowest(Taylor{{2}, 1, {}}), std::pair(3.0, 3.0));
  EXPECT_EQ(lowest(Profile{{-2, 0, 1, 2}, {1, 0, 0, 4}, 0, ""}), std::pair(3.0, 4.0));
}

TEST(MeasuredProfile, SmallDentsAreLiftedToTheHull) {
  // A parabola's points with one raised by 0.03: convex within smooth = 0.03, and the chord replaces it.
  const Profile dented{{-2, -1, 0, 1, 2}, {4, 1 + 2, 0, 1, 4}, 1.0, ""};
  const auto found = non_convexities(dented);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].x, -1);
  EXPECT_DOUBLE_EQ(found[0].height, 1);  // the chord from (-2, 4) to (0, 0) passes at 2
  EXPECT_NO_THROW(validate(dented));
  EXPECT_DOUBLE_EQ(profile_height({dented, 0}, -1), 2);
  EXPECT_DOUBLE_EQ(profile_height({dented, 0}, 1), 1);
}

TEST(MeasuredProfile, NamesDentsWithSizeAndPlace) {
  const Profile dented{{-2, -1, 0, 1, 2}, {4, 3, 0, 1, 4}, 0.5, ""};
  expect_value_error([&] { validate(dented); }, "indenter.y", "[4, 3, 0", "1 mm at x = -1; smooth = 1 (mm) or more");
  Profile file = dented;
  file.file = "finger.csv";
  expect_value_error([&] { validate(file); }, "indenter.file", "finger.csv", "convex");
  // A concave profile: all inner points above the chord.
  expect_value_error(
      [] {
        validate(Profile{{-2, -1, 0, 1, 2}, {0, 3, 4, 3, 0}, 0, ""});
      },
      "indenter.y", "", "by 4 mm at x = 0, 3 mm at x = -1, 3 mm at x = 1;");
}

TEST(MeasuredProfile, ANumberForAMissingPointAndOtherUnitsAreNoHeights) {
  expect_value_error(
      [] {
        validate(Profile{{-2, -1, 0, 1, 2}, {4, 1, -9999, 1, 4}, 0, "tip.csv"});
      },
      "indenter.file", "10003 mm of heights over 4 mm", "at most ten times as high as wide");
  expect_value_error([] { validate(Profile{{-2, 0, 2}, {40.1, 0, 40}, 0, ""}); }, "indenter.y", "40.1", "in mm");
  EXPECT_NO_THROW(validate(Profile{{-2, 0, 2}, {40, 0, 40}, 0, ""}));
  expect_value_error(
      [] {
        validate(Profile{{-2, 0, 2}, {0, 1, 0}, 0, ""});
      },
      "indenter.y", "[0, 1, 0]", "upside down?");
}

TEST(MeasuredProfile, DecimalRoundingIsNoDent) {
  Profile line;
  for (int i = 0; i <= 100; ++i) line.x.push_back(i * 0.1), line.y.push_back(i * 0.03);
  EXPECT_NO_THROW(validate(line));
}

TEST(MeasuredProfile, NamesBadPoints) {
  const auto rejects = [](std::vector<double> x, std::vector<double> y, const char* key, const char* value,
                          const char* allowed) {
    expect_value_error([&] { validate(Indenter{Profile{x, y, 0, ""}, 0}); }, key, value, allowed);
  };
  rejects({}, {}, "indenter.x", "[]", "at least two points");
  rejects({1}, {1}, "indenter.x", "[1]", "at least two points");
  rejects({0, 1}, {0}, "indenter.y", "[0]", "as many heights as there are x: 2");
  rejects({0, 1, 1}, {0, 0, 1}, "indenter.x", "1 after 1", "strictly increasing");
  rejects({0, 2, 1}, {0, 0, 1}, "indenter.x", "1 after 2", "strictly increasing");
  rejects({0, nan}, {0, 0}, "indenter.x", "nan", "finite");
  rejects({0, 1}, {0, infinity}, "indenter.y", "inf", "finite");
  expect_value_error([] { validate(Profile{{0, 1}, {0, 0}, -1, ""}); }, "indenter.smooth", "-1", "not below 0");
}

TEST(Indenter, NamesWhatItRejects) {
  const auto rejects = [](const Shape& shape, const char* key, const char* value, const char* allowed) {
    expect_value_error([&] { validate(Indenter{shape, 0}); }, key, value, allowed);
  };
  rejects(Flat{0.0}, "indenter.half_width", "0", "length in mm");
  rejects(Wedge{0}, "indenter.edge_angle", "0", "above 0 and below 180");
  rejects(Wedge{180}, "indenter.edge_angle", "180", "above 0 and below 180");
  rejects(Wedge{nan}, "indenter.edge_angle", "nan", "degrees");
  for (double bad : {0.0, -1.0, nan, infinity}) {
    rejects(Parabola{bad}, "indenter.radius", "", "length in mm");
    rejects(Cylinder{bad}, "indenter.radius", "", "length in mm");
    rejects(RoundedFlat{1, bad}, "indenter.radius", "", "length in mm");
    rejects(Exponential{bad, 1}, "indenter.height", "", "length in mm");
    rejects(Exponential{1, bad}, "indenter.rate", "", "1/mm");
    rejects(Trapezoid{1, bad}, "indenter.slope", "", "slope");
    rejects(Taylor{{1}, bad, {}}, "indenter.scale", "", "length in mm");
    rejects(Taylor{{1}, 1, bad}, "indenter.height", "", "length in mm");
  }
  rejects(Trapezoid{-1, 1}, "indenter.half_width", "-1", "0 or a length");
  rejects(RoundedFlat{-1, 1}, "indenter.half_width", "-1", "0 or a length");
  rejects(Taylor{{1, 0}, 1, {}}, "indenter.powers", "0", "1 to 100");
  expect_value_error([] { validate(Indenter{Parabola{}, nan}); }, "indenter.position", "nan", "position in mm");
}

TEST(Indenter, DefaultsAreValid) {
  for (const Shape& shape : {Shape{Flat{}}, Shape{Wedge{}}, Shape{Parabola{}}, Shape{Cylinder{}}, Shape{Exponential{}},
                             Shape{Trapezoid{}}, Shape{RoundedFlat{}}, Shape{Taylor{}}})
    EXPECT_NO_THROW((validate(Indenter{shape, 0}))) << shape_name(shape);
}

}  // namespace tactel::fem::indenter_test
