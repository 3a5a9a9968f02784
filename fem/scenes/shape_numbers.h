// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/line_scene.h>
#include <tactel/pad_scene.h>

#include <array>
#include <tuple>

// Every number of the parts of scenes that users see, once. Files, draws of sweeps, columns of sets, JSON and Python
// are made of these tables; scene_numbers.h has those of the other parts.

namespace tactel::fem {

/// A number of a struct, or several under one key.
template <class T, class M>
struct Number {
  using Value = M;
  const char *key, *unit;  ///< "radius", "mm"; "1": of none
  M T::*member;
  const char* allowed;         ///< what a file may hold: "a number of mm above 0"
  const char* meaning;         ///< of Python: "mm, radius of the rounding; 0: sharp"
  bool needed = true;          ///< no file may leave it out
  bool drawn = true;           ///< sweeps may draw it
  const char* each = nullptr;  ///< of a pair: what each of both is called: "radius", of radius_x and radius_y
};
// Clang deduces no arguments of an aggregate before its version 17.
template <class T, class M, class... Rest>
Number(const char*, const char*, M T::*, Rest...) -> Number<T, M>;

/// The table of a struct: a tuple of Numbers, in the order of files and JSON. A struct without one does not compile.
template <class T>
struct NoTable;
template <class T>
inline constexpr NoTable<T> numbers;
template <>
inline constexpr std::tuple<> numbers<Profile>{};

/// What a shape is called in files and in Python, and what Python says of it.
struct ShapeName {
  const char *key, *python, *meaning;
};
// In the order of their variants.
inline constexpr std::array line_shapes{
    ShapeName{"flat", "Flat", "0 up to half_width, no indenter beyond."},
    ShapeName{"wedge", "Wedge", "y = r / tan(edge_angle / 2)."},
    ShapeName{"parabola", "Parabola", "y = r^2 / (2 radius); r: distance from the indenter's position."},
    ShapeName{"cylinder", "Cylinder", "A circle; no indenter beyond r = radius."},
    ShapeName{"exponential", "Exponential", "y = height (e^(rate r) - 1)."},
    ShapeName{"trapezoid", "Trapezoid", "0 up to half_width, then slope (r - half_width)."},
    ShapeName{"rounded_flat", "RoundedFlat", "0 up to half_width, then (r - half_width)^2 / (2 radius)."},
    ShapeName{"taylor", "Taylor", "y = height * sum of coefficients (r / scale)^powers."},
    ShapeName{"profile", "Profile", "Points, linear between them; no indenter beyond the ends."}};
inline constexpr std::array pad_shapes{
    ShapeName{"sphere", "Sphere", "A sphere on a pad; no indenter beyond r = radius."},
    ShapeName{"paraboloid", "Paraboloid", "x^2 / (2 radii[0]) + y^2 / (2 radii[1])."},
    ShapeName{"cylinder", "LyingCylinder",
              "A cylinder along y on a pad; no indenter beyond |x| = radius and |y| = half_length."},
    ShapeName{"punch", "Punch", "A round punch: max(0, r - radius)^2 / (2 edge); edge 0: sharp."},
    ShapeName{"box", "Box", "max(0, |x| - half_widths[0])^2 / (2 edge), and the same along y; edge 0: sharp."},
    ShapeName{"cone", "Cone", "r / tan(angle)."},
    ShapeName{"heightmap", "HeightMap", "Heights on a grid, bilinear between them; no indenter beyond."}};

inline constexpr const char *some_mm = "a number of mm above 0", *two_mm = "two numbers of mm above 0, along x and y",
                            *some_edge = "the radius of its rounding in mm, 0 for a sharp edge",
                            *sharp_or_round = "mm, radius of the rounding; 0: sharp",
                            *some_targets = "a number of mm, or an array of successive targets";

// A line.
template <>
inline constexpr auto numbers<Flat> =
    std::tuple{Number{"half_width", "mm", &Flat::half_width, some_mm, "mm; None: wider than the sensor", false}};
template <>
inline constexpr auto numbers<Wedge> =
    std::tuple{Number{"edge_angle", "degrees", &Wedge::edge_angle,
                      "a number of degrees, the full angle, above 0 and below 180", "full angle, degrees"}};
template <>
inline constexpr auto numbers<Parabola> = std::tuple{Number{"radius", "mm", &Parabola::radius, some_mm, "mm"}};
template <>
inline constexpr auto numbers<Cylinder> = std::tuple{Number{"radius", "mm", &Cylinder::radius, some_mm, "mm"}};
template <>
inline constexpr auto numbers<Exponential> =
    std::tuple{Number{"height", "mm", &Exponential::height, some_mm, "mm"},
               Number{"rate", "1/mm", &Exponential::rate, "a number of 1/mm above 0", "1/mm"}};
template <>
inline constexpr auto numbers<Trapezoid> = std::tuple{
    Number{"half_width", "mm", &Trapezoid::half_width, some_mm, "mm"},
    Number{"slope", "1", &Trapezoid::slope, "a number above 0 (mm of height per mm)", "height over distance"}};
template <>
inline constexpr auto numbers<RoundedFlat> =
    std::tuple{Number{"half_width", "mm", &RoundedFlat::half_width, some_mm, "mm"},
               Number{"radius", "mm", &RoundedFlat::radius, some_mm, "mm"}};
template <>
inline constexpr auto numbers<Taylor> = std::tuple{
    Number{"powers", "", &Taylor::powers, "an array of whole numbers, each at least 1, such as [1, 3] ([] is flat)",
           "whole numbers, each at least 1", true, false},
    Number{"scale", "mm", &Taylor::scale, some_mm, "mm", false},
    Number{"height", "mm", &Taylor::height, some_mm, "mm; None: scale", false},
    Number{"coefficients", "1", &Taylor::coefficients, "an array of numbers not below 0, one for each power",
           "one a power; empty: all 1", false}};
template <>
inline constexpr auto numbers<Indenter> =
    std::tuple{Number{"position", "mm", &Indenter::position, "a number of mm along the array, 0 at its middle",
                      "mm along the array", false}};

// A pad.
template <>
inline constexpr auto numbers<Sphere> = std::tuple{Number{"radius", "mm", &Sphere::radius, some_mm, "mm"}};
template <>
inline constexpr auto numbers<Paraboloid> =
    std::tuple{Number{"radii", "mm", &Paraboloid::radii, two_mm, "mm, along x and y", true, true, "radius"}};
template <>
inline constexpr auto numbers<LyingCylinder> =
    std::tuple{Number{"radius", "mm", &LyingCylinder::radius, some_mm, "mm"},
               Number{"half_length", "mm", &LyingCylinder::half_length, some_mm, "mm"}};
template <>
inline constexpr auto numbers<Punch> = std::tuple{Number{"radius", "mm", &Punch::radius, some_mm, "mm"},
                                                  Number{"edge", "mm", &Punch::edge, some_edge, sharp_or_round, false}};
template <>
inline constexpr auto numbers<Box> =
    std::tuple{Number{"half_widths", "mm", &Box::half_widths, two_mm, "mm, along x and y", true, true, "half_width"},
               Number{"edge", "mm", &Box::edge, some_edge, sharp_or_round, false}};
template <>
inline constexpr auto numbers<Cone> =
    std::tuple{Number{"angle", "degrees", &Cone::angle, "degrees between surface and axis, above 0 and below 90",
                      "degrees between surface and axis, above 0 and below 90"}};
template <>
inline constexpr auto numbers<RubberLayer> =
    std::tuple{Number{"thickness", "mm", &RubberLayer::thickness, some_mm, "mm"},
               Number{"young", "MPa", &RubberLayer::young, "a number of MPa above 0", "MPa"},
               Number{"poisson", "1", &RubberLayer::poisson, "a number with 0 <= poisson <= 0.5", "", false}};
template <>
inline constexpr auto numbers<Pad> = std::tuple{
    Number{"tactels", "", &Pad::tactels, "two whole numbers [nx, ny] of tactels along x and y", "along x and y", false,
           false},
    Number{"pitch", "mm", &Pad::pitch, "a number of mm, or two [px, py] along x and y", "mm, along x and y", false,
           false},
    Number{"tactel_size", "mm", &Pad::tactel_size, "the side of a square in mm, 0 for a point",
           "mm: side of a square; 0: points", false, false},
    Number{"axes", "", &Pad::axes, "3, or 1 (normal stress only)", "3, or 1: normal stress alone", false, false},
    Number{"thickness", "mm", &Pad::thickness, some_mm, "mm"},
    Number{"young", "MPa", &Pad::young, "a number of MPa above 0", "MPa", false},
    Number{"poisson", "1", &Pad::poisson, "a number with 0 <= poisson <= 0.5", "", false},
    Number{"length", "mm", &Pad::length, "a number of mm along x", "mm along x; None: not known", false, false},
    Number{"width", "mm", &Pad::width, "a number of mm along y", "mm along y; None: not known", false, false},
    Number{"sides", "", &Pad::sides, "", "of the rubber, where length and width are given", false, false},
    Number{"curvature_radius", "mm", &Pad::curvature_radius, "a number of mm, or left out for a flat skin",
           "mm, of the skin; None: flat", false, false},
    Number{"depth", "mm", &Pad::depth, "a number of mm above the base", "mm of the tactels above the base", false,
           false}};
template <>
inline constexpr auto numbers<Markers> =
    std::tuple{Number{"counts", "", &Markers::counts, "two whole numbers [nx, ny] of markers along x and y",
                      "along x and y", false, false},
               Number{"pitch", "mm", &Markers::pitch, "a number of mm, or two [px, py] along x and y",
                      "mm, along x and y", false, false},
               Number{"depth", "mm", &Markers::depth, "a number of mm below the surface, 0 or more",
                      "mm below the surface", false, false}};
template <>
inline constexpr auto numbers<Camera> =
    std::tuple{Number{"distance", "mm", &Camera::distance, "a number of mm above 0",
                      "mm, from the pinhole to the markers", false, false},
               Number{"pixels_per_mm", "1/mm", &Camera::pixels_per_mm, "a number above 0",
                      "in the plane of the markers", false, false},
               Number{"centre", "pixels", &Camera::centre, "two numbers of pixels, the image of the pad's middle",
                      "pixels: image of the pad's middle", false, false},
               Number{"noise_px", "pixels", &Camera::noise_px, "a number of pixels, 0 or more",
                      "pixels: standard deviation along each axis, in sets", false, false}};
template <>
inline constexpr auto numbers<Load> = std::tuple{
    Number{"indentation", "mm", &Load::indentation, some_targets, "mm: targets"},
    Number{"normal_force", "N/mm", &Load::normal_force, "a number of N/mm, or an array of successive targets",
           "N/mm: targets in place of depths"},
    Number{"indentation_steps", "", &Load::indentation_steps, "a whole number of steps, at least 1", "", false, false},
    Number{"tangential", "mm", &Load::tangential, "", "mm: positions"},
    Number{"tangential_step", "mm", &Load::tangential_step, "", "mm; 0: none"},
    Number{"tangential_steps", "", &Load::tangential_steps, "", "None with a tangential_step: until sliding", false,
           false},
    Number{"angle", "degrees", &Load::angle, "", "degrees; None: no angle"}};

/// The load of a pad, as fem or users have it.
template <class T>
concept LoadOfPad = requires(T load) {
  load.normal_force;
  load.moves[0].twist;
};
template <LoadOfPad T>
inline constexpr auto numbers<T> = [] {
  const auto pressing = std::tuple{
      Number{"indentation", "mm", &T::indentation, some_targets, "mm: targets"},
      Number{"normal_force", "N", &T::normal_force, "a number of N, or an array of successive targets",
             "N: targets in place of depths"},
      Number{"indentation_steps", "", &T::indentation_steps, "a whole number of steps, 1 to 1000", "", false, false}};
  if constexpr (requires { &T::twist; })
    return std::tuple_cat(
        pressing, std::tuple{Number{"tangential", "mm", &T::tangential,
                                    "an array of positions [x, y] in mm, at least one", "mm: positions (x, y)"},
                             Number{"twist", "degrees", &T::twist, "an array of degrees, at least one",
                                    "degrees at these positions; empty: none"},
                             Number{"times", "s", &T::times, "", "s, of each load step of a pad that relaxes"}});
  else
    return pressing;
}();

/// Calls use(number) for every number of a struct.
template <class T, class Use>
constexpr void each_number(const Use& use) {
  std::apply([&](const auto&... number) { (use(number), ...); }, numbers<T>);
}

/// Returns the shape with the height that it has where none is given.
inline Taylor with_height(Taylor shape) {
  shape.height = shape.height.value_or(shape.scale);
  return shape;
}
}  // namespace tactel::fem
