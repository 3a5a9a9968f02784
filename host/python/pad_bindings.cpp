// SPDX-License-Identifier: Apache-2.0
#include "host/python/bindings.h"

namespace tactel::python {

using namespace pybind11::literals;

namespace {

using Pair = std::array<double, 2>;
using Grid = py::array_t<double, py::array::c_style | py::array::forcecast>;

HeightMap map_of(const Grid& heights, double pitch) {
  if (heights.ndim() != 2)
    throw InputError("heights", "an array of " + std::to_string(heights.ndim()) + " axes",
                     "must have two, [rows along y, columns along x]");
  return {pitch, static_cast<std::size_t>(heights.shape(1)), {heights.data(), heights.data() + heights.size()}};
}

py::array_t<double> heights_of(const py::object& self) {
  const auto& map = self.cast<const HeightMap&>();
  const auto rows = static_cast<py::ssize_t>(map.columns > 0 ? map.heights.size() / map.columns : 0);
  py::array_t<double> array = view(map.heights, {rows, static_cast<py::ssize_t>(map.columns)}, self);
  array.attr("setflags")("write"_a = false);  // values never change
  return array;
}

void bind_pad_shapes(py::module_& m) {
  bind_shapes(m, std::type_identity<PadShape>{}, fem::pad_shapes);
  value_class<HeightMap>(m, "HeightMap", fem::pad_shapes.back().meaning, {"heights", "pitch"})
      .def(py::init(&map_of), "heights"_a, "pitch"_a = 0.1,
           "heights: [rows along y, columns along x] mm, the middle on the axis, the lowest counts as 0; pitch: mm.")
      .def_property_readonly("heights", &heights_of, "[rows along y, columns along x] mm, read only")
      .def_readonly("pitch", &HeightMap::pitch, "mm, from point to point");
}

void bind_pad_sensor(py::module_& m) {
  numbers_class<RubberLayer>(m, "RubberLayer", "One of the layers that the rubber of a sensor is made of.");
  py::enum_<Sides>(m, "Sides", "Sides of a pad.").value("free", Sides::free).value("held", Sides::held);
  auto pad = value_class<Pad>(m, "Pad", "A layer of rubber with tactels along x and y.",
                              {"tactels", "pitch", "tactel_size", "axes", "thickness", "young", "poisson", "length",
                               "width", "sides", "curvature_radius", "layers", "relaxation"});
  add_fields(pad);
  pad.def_readonly("layers", &Pad::layers, "from the base up; []: one, of thickness, young and poisson");
  pad.def_readonly("relaxation", &Pad::relaxation, "(share of E, s) of each term; []: elastic");
  pad.def(py::init([](std::array<int, 2> tactels, std::variant<double, Pair> pitch, double tactel_size,
                      Typed<int, "Literal[1, 3]"> axes, double thickness, double young, double poisson,
                      std::optional<double> length, std::optional<double> width, Sides sides,
                      std::optional<double> curvature_radius, std::vector<RubberLayer> layers,
                      std::vector<Pair> relaxation) {
            const double* both = std::get_if<double>(&pitch);
            return with_layers({tactels, both ? Pair{*both, *both} : std::get<Pair>(pitch), tactel_size, axes,
                                thickness, young, poisson, length, width, sides, curvature_radius, std::move(layers),
                                std::move(relaxation)});
          }),
          "tactels"_a = std::array{4, 4}, "pitch"_a = 4.7, "tactel_size"_a = 0.0, "axes"_a = 3, "thickness"_a = 2.0,
          "young"_a = 2.0, "poisson"_a = 0.45, "length"_a = py::none(), "width"_a = py::none(), "sides"_a = Sides::free,
          "curvature_radius"_a = py::none(), "layers"_a = std::vector<RubberLayer>(),
          "relaxation"_a = std::vector<Pair>(),
          "tactels: (along x, along y); pitch: mm, one number or (x, y); tactel_size: mm, 0 for points; axes: 3, or 1 "
          "for normal stress alone; thickness: mm; young: MPa; length, width: mm of rubber, None where not known; "
          "sides: of "
          "a pad whose length and width are given, free, or held as if the rubber went on; curvature_radius: mm, of "
          "the skin, None where it is flat; layers: from the base up, in place of "
          "thickness, young and poisson; relaxation: (share, s) of each term of E that relaxes, for PadStepper.");
  value_class<PadIndenter>(m, "PadIndenter", "A shape on a pad: its place, and how it is turned.",
                           {"shape", "position", "yaw", "tilt", "tilt_direction", "young", "poisson"})
      .def(py::init([](PadShape shape, Pair position, double yaw, double tilt, double tilt_direction,
                       std::optional<double> young, double poisson) {
             return PadIndenter{std::move(shape), position, yaw, tilt, tilt_direction, young, poisson};
           }),
           "shape"_a, "position"_a = Pair{0, 0}, "yaw"_a = 0.0, "tilt"_a = 0.0, "tilt_direction"_a = 0.0,
           "young"_a = py::none(), "poisson"_a = 0.45,
           "position: (x, y) mm, (0, 0) in the pad's middle; yaw: degrees about z; tilt: degrees, of Punch and Box, "
           "whose "
           "bottom rises along tilt_direction (degrees from x of the turned shape); young: MPa, None for a rigid "
           "object; poisson: of a soft one.")
      .def_readonly("shape", &PadIndenter::shape)
      .def_readonly("position", &PadIndenter::position, "mm, (x, y)")
      .def_readonly("yaw", &PadIndenter::yaw, "degrees")
      .def_readonly("tilt", &PadIndenter::tilt, "degrees")
      .def_readonly("tilt_direction", &PadIndenter::tilt_direction, "degrees")
      .def_readonly("young", &PadIndenter::young, "MPa; None: rigid")
      .def_readonly("poisson", &PadIndenter::poisson);
}

void bind_markers(py::module_& m) {
  auto markers = value_class<Markers>(m, "Markers", "Marks within the rubber of a pad, which move with it.",
                                      {"counts", "pitch", "depth", "places"});
  add_fields(markers);
  markers.def_readonly("places", &Markers::places, "mm, (x, y) of each; []: on a grid of counts and pitch");
  markers.def(
      py::init([](std::array<int, 2> counts, std::variant<double, Pair> pitch, double depth, std::vector<Pair> places) {
        const double* both = std::get_if<double>(&pitch);
        return Markers{counts, both ? Pair{*both, *both} : std::get<Pair>(pitch), depth, std::move(places)};
      }),
      "counts"_a = std::array{9, 7}, "pitch"_a = 1.0, "depth"_a = 0.25, "places"_a = std::vector<Pair>(),
      "counts: (along x, along y) about the pad's middle; pitch: mm, one number or (x, y); depth: mm below the "
      "surface; places: mm, (x, y) of each, in place of counts and pitch.");
  numbers_class<Camera>(m, "Camera", "A pinhole camera below the middle of a pad, which looks up at its markers.");
  value_class<FrictionMap>(m, "FrictionMap", "mu over the skin of a pad, on a grid about its middle.",
                           {"rows", "pitch"})
      .def(py::init<std::vector<std::vector<double>>, double>(), "rows"_a, "pitch"_a = FrictionMap{}.pitch,
           "rows: mu of the nodes, one row for each y, x and y increasing; pitch: mm, from node to node.")
      .def_readonly("rows", &FrictionMap::rows)
      .def_readonly("pitch", &FrictionMap::pitch, "mm");
}

void bind_pad_load(py::module_& m) {
  numbers_class<PadLoad>(m, "PadLoad",
                         "The path of an indenter on a pad: a depth or normal force, then drags and twists. See Press "
                         "and Force.")
      .def("drag", &PadLoad::drag, "step"_a, "steps"_a, "twist"_a = 0.0,
           "Returns this load with `steps` more drags of `step` (x, y) mm, each with a twist of `twist` degrees.")
      .def("drag_to", &PadLoad::drag_to, "positions"_a, "twist"_a = std::vector<double>{},
           "Returns this load with more drags to these positions (x, y) mm, and to these twists, degrees.")
      .def("turn", &PadLoad::turn, "twist"_a, "steps"_a,
           "Returns this load with `steps` more twists of `twist` degrees in place.");
}

}  // namespace

PadLoad on_pad(const Load& load) {
  if (!load.tangential.empty() || load.tangential_step != 0 || load.tangential_steps || load.angle ||
      !load.moves.empty())
    throw InputError("load", "a drag or an angle of a line",
                     "must be a press with drags by (x, y): "
                     "Press(0.2).drag((0.05, 0.02), steps=3)");
  return {load.indentation, load.normal_force, load.indentation_steps};
}

void bind_pads(py::module_& m) {
  bind_pad_shapes(m);
  bind_pad_sensor(m);
  bind_markers(m);
  bind_pad_load(m);
}

}  // namespace tactel::python
