// SPDX-License-Identifier: Apache-2.0

// Where a rigid profile lies below the flat surface: closed forms of every shape.
#include "fem/layer/rigid_contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tactel::fem::rigid_contact_test {

constexpr Interval room{-10, 10};
constexpr double depth = 0.2, position = 1.5;  // mm

struct Section {
  Shape shape;
  double half;  // mm, half-width of the section
};

TEST(RigidContact, HalfWidthsOfEveryShape) {
  const Section sections[] = {{Flat{2.0}, 2},
                              {Wedge{120}, depth * std::tan(60 * std::numbers::pi / 180)},
                              {Parabola{10}, std::sqrt(2 * 10 * depth)},
                              {Cylinder{10}, std::sqrt(100 - (10 - depth) * (10 - depth))},
                              {Exponential{0.1, 0.5}, std::log(1 + depth / 0.1) / 0.5},
                              {Trapezoid{2, 0.5}, 2 + depth / 0.5},
                              {RoundedFlat{2, 10}, 2 + std::sqrt(2 * 10 * depth)},
                              {Taylor{{3}, 10.0, 2.0, {}}, 10 * std::cbrt(depth / 2)},
                              {Profile{{-4, 0, 4}, {1, 0, 1}, 0, ""}, 4 * depth}};
  for (const auto& [shape, half] : sections) {
    const Interval contact = rigid_contact({shape, position}, depth, room);
    EXPECT_NEAR(contact.left, position - half, 1e-8) << shape_name(shape);
    EXPECT_NEAR(contact.right, position + half, 1e-8) << shape_name(shape);
  }
}

TEST(RigidContact, EndsWithTheRubberAndWithTheIndenter) {
  const Interval wide = rigid_contact({Flat{}, 0.0}, depth, room);
  EXPECT_EQ(wide.left, -10);
  EXPECT_EQ(wide.right, 10);
  const Interval off = rigid_contact({Flat{3.0}, 9.0}, depth, room);
  EXPECT_EQ(off.left, 6);
  EXPECT_EQ(off.right, 10);
  // A cylinder pressed deeper than it is high ends with its radius; a measured profile with its points.
  const Interval cylinder = rigid_contact({Cylinder{0.1}, 0.0}, 0.5, room);
  EXPECT_EQ(cylinder.left, -0.1);
  EXPECT_EQ(cylinder.right, 0.1);
  const Interval measured = rigid_contact({Profile{{-1, 0, 2}, {0.1, 0, 0.2}, 0, ""}, 1.0}, 0.5, room);
  EXPECT_EQ(measured.left, 0);
  EXPECT_EQ(measured.right, 3);
}

TEST(RigidContact, MeasuredProfileIsItsHull) {
  const Indenter dented{Profile{{-2, -1, 0, 1, 2}, {1, 0, 0.05, 0, 1}, 0.1, ""}, 0.0};
  const Interval contact = rigid_contact(with_hull(dented), 0.5, room);
  EXPECT_NEAR(contact.left, -1.5, 1e-8);
  EXPECT_NEAR(contact.right, 1.5, 1e-8);
}

}  // namespace tactel::fem::rigid_contact_test
