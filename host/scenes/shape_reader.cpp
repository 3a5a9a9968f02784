// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/shape_reader.h"

#include <algorithm>

#include "host/scenes/profile_csv.h"
#include "host/scenes/scene_tables.h"
#include "host/scenes/shape_choice.h"

namespace tactel::host {
namespace {

/// Reads one shape's keys; `complete` when nothing may be missing (no preset stands behind it).
struct ShapeKeys {
  TomlTable& in;
  const TomlFile& file;
  bool complete;

  void need(const std::string& key, double& value, const std::string& what) {
    if (!in.read(key, value, what) && complete) in.refuse_missing(key, "given, " + what);
  }
};

constexpr const char* some_mm = "a number of mm above 0";

void read_shape(ShapeKeys& keys, fem::Flat& flat) {
  if (double half = 0; keys.in.read("half_width", half, some_mm)) flat.half_width = half;
}
void read_shape(ShapeKeys& keys, fem::Wedge& wedge) {
  keys.need("edge_angle", wedge.edge_angle, "a number of degrees, the full angle, above 0 and below 180");
}
void read_shape(ShapeKeys& keys, fem::Parabola& parabola) { keys.need("radius", parabola.radius, some_mm); }
void read_shape(ShapeKeys& keys, fem::Cylinder& cylinder) { keys.need("radius", cylinder.radius, some_mm); }
void read_shape(ShapeKeys& keys, fem::Exponential& exponential) {
  keys.need("height", exponential.height, some_mm);
  keys.need("rate", exponential.rate, "a number of 1/mm above 0");
}
void read_shape(ShapeKeys& keys, fem::Trapezoid& trapezoid) {
  keys.need("half_width", trapezoid.half_width, some_mm);
  keys.need("slope", trapezoid.slope, "a number above 0 (mm of height per mm)");
}
void read_shape(ShapeKeys& keys, fem::RoundedFlat& rounded) {
  keys.need("half_width", rounded.half_width, some_mm);
  keys.need("radius", rounded.radius, some_mm);
}
void read_shape(ShapeKeys& keys, fem::Taylor& taylor) {
  const char* powers = "an array of whole numbers, each at least 1, such as [1, 3] ([] is flat)";
  if (!keys.in.read("powers", taylor.powers, powers)) keys.in.refuse_missing("powers", std::string("given, ") + powers);
  keys.in.read("scale", taylor.scale, some_mm);
  if (double height = 0; keys.in.read("height", height, some_mm)) taylor.height = height;
  keys.in.read("coefficients", taylor.coefficients, "an array of numbers not below 0, one for each power");
}
void read_shape(ShapeKeys& keys, fem::Profile& profile) {
  TomlTable& in = keys.in;
  in.read("smooth", profile.smooth, "a number of mm, at least 0");
  std::string name;
  const bool from_file = in.read("file", name, "the name of a CSV file with columns x,y in mm");
  const bool has_x = in.read("x", profile.x, "an array of mm, increasing");
  const bool has_y = in.read("y", profile.y, "an array of mm, as many as x");
  if (from_file && (has_x || has_y)) in.refuse("file", "left out, because the profile's x and y are given too");
  if (!from_file && !has_x)
    in.refuse_missing("x", "given, an array of mm, increasing (or file, a CSV file with columns x,y)");
  if (!from_file && !has_y) in.refuse_missing("y", "given, an array of mm, as many as x");
  if (!from_file) return;
  const std::filesystem::path path = keys.file.path().parent_path() / name;
  read_profile_csv(path, profile);
  profile.file = path.string();
}

const std::vector<ShapeName<fem::Shape>>& shapes() {
  static const std::vector<ShapeName<fem::Shape>> all = {
      {"flat", {"half_width"}, fem::Flat{}},
      {"wedge", {"edge_angle"}, fem::Wedge{}},
      {"parabola", {"radius"}, fem::Parabola{}},
      {"cylinder", {"radius"}, fem::Cylinder{}},
      {"exponential", {"height", "rate"}, fem::Exponential{}},
      {"trapezoid", {"half_width", "slope"}, fem::Trapezoid{}},
      {"rounded_flat", {"half_width", "radius"}, fem::RoundedFlat{}},
      {"taylor", {"powers", "scale", "height", "coefficients"}, fem::Taylor{}},
      {"profile", {"x", "y", "file", "smooth"}, fem::Profile{}},
  };
  return all;
}

}  // namespace

void read_indenter(const TomlFile& file, fem::Indenter& indenter, bool preset) {
  TomlTable in(file, "indenter");
  OtherKind{{"radii", "half_length", "half_widths", "edge", "angle", "pitch", "yaw", "tilt", "tilt_direction"},
            {"sphere", "paraboloid", "punch", "box", "cone", "heightmap"},
            of_a_pad}
      .refuse(in);
  const std::string usual = fem::shape_name(indenter.shape);
  const auto& chosen =
      choose_shape(in, shapes(), {"shape", "position"},
                   preset ? &*std::ranges::find(shapes(), usual, &ShapeName<fem::Shape>::name) : nullptr);
  const bool known = preset && chosen.name == usual;
  if (!known) indenter.shape = chosen.made;
  ShapeKeys keys{in, file, !known};
  std::visit([&](auto& shape) { read_shape(keys, shape); }, indenter.shape);
  in.read("position", indenter.position, "a number of mm along the array, 0 at its middle");
  in.finish();
}

}  // namespace tactel::host
