// SPDX-License-Identifier: Apache-2.0
#include <utility>
#include <variant>

#include "host/python/bindings.h"

namespace tactel::python {
namespace {

using namespace pybind11::literals;

template <class Indenter, class... Shapes>
std::variant<Indenter, Shapes...> with_shapes(const std::variant<Shapes...>&);
/// An indenter, or its shape alone in the middle of the array.
using AnyIndenter = decltype(with_shapes<Indenter>(Shape{}));
using AnyPadIndenter = decltype(with_shapes<PadIndenter>(PadShape{}));
using AnyPadLoad = std::variant<PadLoad, Load>;

template <class Indenter, class Any>
Indenter indenter_of(Any any) {
  return std::visit(
      [](auto& given) {
        if constexpr (std::is_same_v<std::decay_t<decltype(given)>, Indenter>)
          return std::move(given);
        else
          return Indenter{.shape = std::move(given)};
      },
      any);
}

/// Returns the classes of a variant: "Indenter, Flat, Wedge or Profile".
template <class... Kinds>
std::string classes_of(const std::variant<Kinds...>&) {
  std::string names;
  std::size_t left = sizeof...(Kinds);
  const auto add = [&](const py::handle& kind) {
    --left;
    names += kind.attr("__name__").cast<std::string>() + (left > 1 ? ", " : left == 1 ? " or " : "");
  };
  (add(py::type::of<Kinds>()), ...);
  return names;
}

/// Returns a field that a constructor was given, or its usual value. Throws InputError for one of another kind; kind():
/// what it must be.
template <class Field, class Kind>
Field field_of(const py::object& given, Field usual, const char* name, const Kind& kind) {
  if (given.is_none()) return usual;
  try {
    return given.cast<Field>();
  } catch (const py::cast_error&) {
    throw InputError(name, py::type::of(given).attr("__name__").cast<std::string>(), kind());
  }
}

AnyScene scene_of(const std::variant<Sensor, Pad>& sensor, const py::object& indenter, double friction,
                  const py::object& load, std::string title, std::optional<Markers> markers,
                  std::optional<Camera> camera, std::optional<FrictionMap> friction_map) {
  if (const Pad* pad = std::get_if<Pad>(&sensor)) {
    auto shape = field_of<AnyPadIndenter>(indenter, PadIndenter{}, "indenter", [] {
      return "must be a " + classes_of(AnyPadIndenter{}) + ", as the sensor is a Pad";
    });
    auto path = field_of<AnyPadLoad>(load, PadLoad{}, "load", [] { return "must be a PadLoad, or Press or Force"; });
    const Load* press = std::get_if<Load>(&path);
    return {PadScene{std::move(title), *pad, indenter_of<PadIndenter>(std::move(shape)), friction,
                     press ? on_pad(*press) : std::get<PadLoad>(std::move(path)), std::move(markers), camera,
                     std::move(friction_map)}};
  }
  if (markers || camera || friction_map)
    throw InputError(markers  ? "markers"
                     : camera ? "camera"
                              : "friction_map",
                     "of a line", "must be None, as the sensor is no Pad");
  auto shape = field_of<AnyIndenter>(indenter, Indenter{}, "indenter", [] {
    return "must be an " + classes_of(AnyIndenter{}) + ", as the sensor is no Pad";
  });
  auto path =
      field_of<Load>(load, Load{}, "load", [] { return "must be a Load, of drags along x, as the sensor is no Pad"; });
  return {Scene{std::move(title), std::get<Sensor>(sensor), indenter_of<Indenter>(std::move(shape)), friction,
                std::move(path)}};
}

/// Getter of a member that scenes of both kinds have, a copy.
template <class Get>
auto scene_field(const Get& get) {
  return [get](const AnyScene& scene) { return std::visit([&](const auto& kind) { return get(kind); }, scene.of); };
}

/// The same of an optional one that pads alone have.
template <class Member>
auto of_pad(std::optional<Member> PadScene::*member) {
  return [member](const AnyScene& scene) {
    const auto* pad = std::get_if<PadScene>(&scene.of);
    return pad ? pad->*member : std::nullopt;
  };
}

void bind_line_shapes(py::module_& m) {
  bind_shapes(m, std::type_identity<Shape>{}, fem::line_shapes);
  value_class<Profile>(m, "Profile", fem::line_shapes.back().meaning, {"x", "y", "smooth"})
      .def(py::init([](std::vector<double> x, std::vector<double> y, double smooth) {
             return Profile{std::move(x), std::move(y), smooth};
           }),
           "x"_a, "y"_a, "smooth"_a = 0.0,
           "x, y: [points] mm, x increasing; smooth: mm, the deepest dent that is filled.")
      .def_static(
          "sampled",
          [](const Typed<py::function, "Callable[[float], float]">& height, double left, double right, int points) {
            return sampled([&](double x) { return height.value(x).cast<double>(); }, left, right, points);
          },
          "height"_a, "left"_a, "right"_a, "points"_a = 401,
          "Samples a function of x (mm), which returns a height in mm, at equally spaced points from left to right.")
      .def_readonly("x", &Profile::x, "mm")
      .def_readonly("y", &Profile::y, "mm")
      .def_readonly("smooth", &Profile::smooth, "mm");
}

void bind_sensor(py::module_& m) {
  py::enum_<Element>(m, "Element", "Finite elements of a mesh.")
      .value("bbar", Element::bbar)
      .value("q4", Element::q4)
      .value("q4i", Element::q4i)
      .value("q8", Element::q8);
  py::enum_<StressRecovery>(m, "StressRecovery", "Recovery of the stress at the base of a mesh.")
      .value("reaction", StressRecovery::reaction)
      .value("element", StressRecovery::element);
  value_class<Mesh>(m, "Mesh", "Mesh of the rubber layer.", {"columns", "rows", "grading", "element", "stress"})
      .def(py::init([](int columns, int rows, double grading, Element element, StressRecovery stress) {
             return Mesh{columns, rows, grading, element, stress};
           }),
           "columns"_a = 41, "rows"_a = 11, "grading"_a = 4.0, "element"_a = Element::bbar,
           "stress"_a = StressRecovery::reaction, "columns, rows: nodes; grading: bottom over top row height.")
      .def_readonly("columns", &Mesh::columns, "nodes along x")
      .def_readonly("rows", &Mesh::rows, "nodes through the thickness")
      .def_readonly("grading", &Mesh::grading, "bottom row height over top row height")
      .def_readonly("element", &Mesh::element)
      .def_readonly("stress", &Mesh::stress);
  value_class<Sensor>(
      m, "Sensor", "The rubber layer and its tactels.",
      {"length", "thickness", "young", "poisson", "tactels", "tactel_span", "tactel_width", "mesh", "layers"})
      .def(py::init([](double length, double thickness, double young, double poisson, int tactels,
                       std::optional<double> tactel_span, double tactel_width, std::optional<Mesh> mesh,
                       std::vector<RubberLayer> layers) {
             return with_layers(Sensor{length, thickness, young, poisson, tactels, tactel_span, tactel_width, mesh,
                                       std::move(layers)});
           }),
           "length"_a = 20.0, "thickness"_a = 1.5, "young"_a = 2.0, "poisson"_a = 0.45, "tactels"_a = 21,
           "tactel_span"_a = py::none(), "tactel_width"_a = 0.0, "mesh"_a = py::none(),
           "layers"_a = std::vector<RubberLayer>(),
           "length, thickness, tactel_span, tactel_width: mm; young: MPa; mesh: None for contact on the scene's own "
           "patch; layers: from the base up, in place of thickness, young and poisson.")
      .def_readonly("length", &Sensor::length, "mm")
      .def_readonly("thickness", &Sensor::thickness, "mm")
      .def_readonly("young", &Sensor::young, "MPa")
      .def_readonly("poisson", &Sensor::poisson)
      .def_readonly("tactels", &Sensor::tactels)
      .def_readonly("tactel_span", &Sensor::tactel_span, "mm; None: all that fits")
      .def_readonly("tactel_width", &Sensor::tactel_width, "mm; 0: points")
      .def_readonly("mesh", &Sensor::mesh, "None: contact on the scene's own patch")
      .def_readonly("layers", &Sensor::layers, "from the base up; []: one, of thickness, young and poisson");
}

void bind_load(py::module_& m) {
  numbers_class<Load>(m, "Load", "The path of the indenter: a depth or normal force, then a drag. See Press and Force.")
      .def("drag", &Load::drag, "step"_a, "steps"_a, "Returns this load with `steps` equal drags of `step` mm.")
      .def(
          "drag",
          [](const Load& load, std::array<double, 2> step, int steps, double twist) {
            return on_pad(load).drag(step, steps, twist);
          },
          "step"_a, "steps"_a, "twist"_a = 0.0,
          "Of a pad: returns the PadLoad with `steps` equal drags of `step` (x, y) mm, each with a twist of `twist` "
          "degrees.")
      .def("drag_until_sliding", &Load::drag_until_sliding, "step"_a,
           "Returns this load with drags of `step` mm until the whole contact slides.")
      .def("drag_to", &Load::drag_to, "positions"_a, "Returns this load with drags to these positions, mm.")
      .def(
          "drag_to",
          [](const Load& load, const std::vector<std::array<double, 2>>& positions, const std::vector<double>& twist) {
            return on_pad(load).drag_to(positions, twist);
          },
          "positions"_a, "twist"_a = std::vector<double>{},
          "Of a pad: returns the PadLoad with drags to these positions (x, y) mm, and to these twists, degrees.")
      .def(
          "turn", [](const Load& load, double twist, int steps) { return on_pad(load).turn(twist, steps); }, "twist"_a,
          "steps"_a, "Of a pad: returns the PadLoad with `steps` twists of `twist` degrees in place.");
  m.def(
      "Press",
      [](Targets indentation, int steps) {
        Load load;
        load.indentation = list_of(std::move(indentation));
        load.indentation_steps = steps;
        return load;
      },
      "indentation"_a, "steps"_a = 1,
      "Returns the load that presses to a depth, or to several in turn (mm), each in equal steps.");
  m.def(
      "Force",
      [](Targets normal_force, std::optional<double> angle, int steps) {
        Load load;
        load.indentation.clear();
        load.normal_force = list_of(std::move(normal_force));
        load.indentation_steps = steps;
        load.angle = angle;
        return load;
      },
      "normal_force"_a, "angle"_a = py::none(), "steps"_a = 1,
      "Returns the load of a normal force, or of several in turn (N/mm, on a pad N); with an angle (degrees) P and Q = "
      "P "
      "tan(angle) grow together.");
}

/// The constructor of a scene. Its types are of __new__, whose answer knows the kind of the scene.
void bind_scene_of(py::class_<AnyScene>& scene) {
  py::options signatures;
  signatures.disable_function_signatures();
  scene.def(
      py::init(&scene_of), "sensor"_a = Sensor{}, "indenter"_a = py::none(), "friction"_a = 0.5, "load"_a = py::none(),
      "title"_a = "", "markers"_a = py::none(), "camera"_a = py::none(), "friction_map"_a = py::none(),
      "__new__(cls, sensor: Sensor = ..., indenter: Indenter | Shape | None = None, friction: float = 0.5, "
      "load: Load | None = None, title: str = '') -> _LineScene\n"
      "__new__(cls, sensor: Pad, indenter: PadIndenter | PadShape | None = None, friction: float = 0.5, "
      "load: PadLoad | Load | None = None, title: str = '', markers: Markers | None = None, camera: Camera | "
      "None = None, friction_map: FrictionMap | None = None) -> _PadScene\n\n"
      "sensor: a Sensor or Pad; indenter: an Indenter, of a Pad a PadIndenter, or a shape in the middle, None: "
      "Parabola(), Sphere(); friction: mu, or bonded on a line; load: Press or Force with drags, None: Load(), "
      "PadLoad(); markers, camera: of a pad, whose displacements and pixels the answer has; friction_map: of a pad, in "
      "place of friction. Raises InputError for "
      "what belongs to the other kind.");
}

}  // namespace

void bind_scenes(py::module_& m) {
  bind_line_shapes(m);
  bind_sensor(m);
  bind_load(m);
  m.attr("bonded") = bonded;
  value_class<Indenter>(m, "Indenter", "A shape at a position.", {"shape", "position"})
      .def(py::init([](Shape shape, double position) {
             return Indenter{std::move(shape), position};
           }),
           "shape"_a, "position"_a = 0.0, "position: mm along the array, 0 in its middle.")
      .def_readonly("shape", &Indenter::shape)
      .def_readonly("position", &Indenter::position, "mm along the array");
  py::class_<AnyScene> scene =
      value_class<AnyScene>(m, "Scene", "One contact: on a pad where the sensor is a Pad, else on a line.",
                            {"sensor", "indenter", "friction", "load", "title", "markers", "camera", "friction_map"});
  bind_scene_of(scene);
  scene
      .def(
          "validate", [](const AnyScene& scene) { std::visit([](const auto& kind) { validate(kind); }, scene.of); },
          "Raises InputError for the first value that the model rejects.")
      .def(
          "toml",
          [](const AnyScene& scene) { return std::visit([](const auto& kind) { return toml(kind); }, scene.of); },
          "Returns its scene file, with every default filled in; read_scene() reads it.")
      .def_property_readonly("sensor", scene_field([](const auto& scene) { return py::cast(scene.sensor); }))
      .def_property_readonly("indenter", scene_field([](const auto& scene) { return py::cast(scene.indenter); }))
      .def_property_readonly("friction", scene_field([](const auto& scene) { return scene.friction; }),
                             "mu; infinite: bonded")
      .def_property_readonly("load", scene_field([](const auto& scene) { return py::cast(scene.load); }))
      .def_property_readonly("title", scene_field([](const auto& scene) { return scene.title; }))
      .def_property_readonly("markers", of_pad(&PadScene::markers), "of a pad; None: none")
      .def_property_readonly("camera", of_pad(&PadScene::camera), "of a pad's markers; None: none")
      .def_property_readonly("friction_map", of_pad(&PadScene::friction_map), "of a pad; None: one mu");
  m.def(
      "read_scene", [](const FileName& path) { return py::cast(AnyScene{read_any_scene(path)}); }, "path"_a,
      "Reads a scene file (TOML) of a line or a pad. Raises InputError with file, line, key and range.");
  m.def(
      "heights",
      [](AnyIndenter indenter, const std::vector<double>& x) {
        const std::vector<double> y = heights(indenter_of<Indenter>(std::move(indenter)), x);
        return py::array_t<double>(static_cast<py::ssize_t>(y.size()), y.data());
      },
      "indenter"_a, "x"_a,
      "Returns heights [mm] above the lowest point at places x [mm]; infinite where there is no indenter.");
}

}  // namespace tactel::python
