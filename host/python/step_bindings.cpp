// SPDX-License-Identifier: Apache-2.0
#include <tactel/pad_step.h>

#include "host/python/bindings.h"

namespace tactel::python {

using namespace pybind11::literals;

namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Numbers of an array [count, columns], of [columns] where it is one row for all.
template <class Array>
auto rows_of(const Array& array, std::size_t count, std::size_t columns, const char* name) {
  using Number = typename Array::value_type;
  const auto size = static_cast<std::size_t>(array.size());
  std::vector<Number> all(array.data(), array.data() + size);
  if (array.ndim() == 1 && size == columns && count > 1)
    for (std::size_t c = 1; c < count; ++c) all.insert(all.end(), array.data(), array.data() + size);
  const bool turned = array.ndim() == 2 && static_cast<std::size_t>(array.shape(1)) != columns;
  if (all.size() != count * columns || array.ndim() > 2 || turned)
    throw InputError(name, "an array of " + std::to_string(size) + " numbers",
                     "must be [" + std::to_string(count) + ", " + std::to_string(columns) + "]");
  return all;
}

/// A number for x and y, or one for each; none: by the pad.
template <class Number>
using GivenXY = std::optional<std::variant<Number, std::array<Number, 2>>>;

template <class Number>
AlongXY<Number> along_xy(const GivenXY<Number>& given) {
  if (!given) return {};
  if (const auto* both = std::get_if<Number>(&*given)) return *both;
  const auto& [x, y] = std::get<std::array<Number, 2>>(*given);
  return {x, y};
}

/// The stepper of Python, with the number of its steps: answers know which one they are of.
class Stepper {
 public:
  explicit Stepper(PadStepper steps) : steps_(std::move(steps)) {}
  PadStepper& steps() {
    turn_.check();
    return steps_;
  }
  /// compute(steps) without Python's lock.
  template <class Compute>
  auto compute(const Compute& compute) {
    return turn_.without_lock([&] { return compute(steps_); });
  }

  std::size_t made = 0;

 private:
  PadStepper steps_;
  Turn turn_{"PadStepper"};
};

struct Answer {
  py::object owner;  ///< Stepper
  std::size_t step;
  StepAnswer of;

  Stepper& stepper() const { return owner.cast<Stepper&>(); }
};

template <class Number>
auto member(std::vector<Number> StepAnswer::*numbers, py::ssize_t columns) {
  return [numbers, columns](const py::object& self) {
    const auto& all = self.cast<const Answer&>().of.*numbers;
    std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(all.size()) / columns};
    if (columns > 1) shape.push_back(columns);
    return view(all, shape, self);
  };
}

/// The stepper of an answer that is its last.
Stepper& stepper_of(const Answer& answer, const char* name) {
  Stepper& stepper = answer.stepper();
  if (answer.step != stepper.made)
    throw InputError(name, "those of step " + std::to_string(answer.step),
                     "must be read before the next step, or copied");
  return stepper;
}

/// Frames in the device's memory, of which the stepper alone writes.
py::array_t<float> memory_of_frames(const py::object& self) {
  const Answer& answer = self.cast<const Answer&>();
  Stepper& stepper = stepper_of(answer, "frames");
  const std::span<const float> frames = stepper.compute([](PadStepper& steps) { return steps.frames(); });
  const auto count = static_cast<py::ssize_t>(stepper.steps().count());
  return py::array_t<float>({count, static_cast<py::ssize_t>(frames.size()) / count}, frames.data(), answer.owner);
}

py::array_t<float> frames_of_answer(const py::object& self) {
  py::array_t<float> frames = memory_of_frames(self);
  frames.attr("setflags")("write"_a = false);
  return frames;
}

/// Displacements of markers, in the same memory.
py::array_t<float> markers_of_answer(const py::object& self) {
  const Answer& answer = self.cast<const Answer&>();
  Stepper& stepper = stepper_of(answer, "markers");
  const std::span<const float> all = stepper.compute([](PadStepper& steps) { return steps.markers(); });
  const auto count = static_cast<py::ssize_t>(stepper.steps().count());
  py::array_t<float> array({count, static_cast<py::ssize_t>(all.size()) / (3 * count), py::ssize_t{3}}, all.data(),
                           answer.owner);
  array.attr("setflags")("write"_a = false);
  return array;
}

/// Where the camera sees them, a copy.
py::array_t<float> pixels_of_answer(const Answer& answer) {
  Stepper& stepper = stepper_of(answer, "pixels");
  const std::vector<float> all = stepper.compute([](PadStepper& steps) { return steps.pixels(); });
  const auto count = static_cast<py::ssize_t>(stepper.steps().count());
  return py::array_t<float>({count, static_cast<py::ssize_t>(all.size()) / (2 * count), py::ssize_t{2}}, all.data());
}

Answer answer_of(py::object self) {
  auto& stepper = self.cast<Stepper&>();
  return {std::move(self), ++stepper.made, stepper.steps().answer()};
}

std::vector<PadIndenter> indenters_of(const std::variant<PadIndenter, PadShape, std::vector<PadIndenter>>& given) {
  if (const auto* one = std::get_if<PadIndenter>(&given)) return {*one};
  if (const auto* shape = std::get_if<PadShape>(&given)) return {PadIndenter{*shape}};
  return std::get<std::vector<PadIndenter>>(given);
}

void set_gaps(Stepper& self, const Floats& gaps, const std::optional<Floats>& cover) {
  const std::size_t count = self.steps().count(), cells = self.steps().cell_x().size();
  const std::vector<float> all = rows_of(gaps, count, cells, "gaps");
  self.steps().set_gaps(all, cover ? rows_of(*cover, count, cells, "cover") : std::vector<float>());
}

/// Sets gaps where they are given, by Python's function, which keeps them for copies.
void put_gaps(const py::object& self, const std::optional<Floats>& gaps, const std::optional<Floats>& cover) {
  if (cover && !gaps) throw InputError("cover", "an array", "must be given with gaps");
  if (gaps) self.attr("_gaps")(*gaps, cover);
}

Answer move(const py::object& self, const std::optional<Doubles>& pose, const std::optional<Floats>& gaps,
            const std::optional<Floats>& cover, const std::optional<Doubles>& motion, bool travel) {
  auto& stepper = self.cast<Stepper&>();
  const std::size_t count = stepper.steps().count();
  if (pose.has_value() == gaps.has_value())
    throw InputError("move", pose ? "a pose and gaps" : "neither pose nor gaps",
                     "must have a pose of the shapes, or gaps with a motion");
  if (pose) {
    const std::vector<double> to = rows_of(*pose, count, 4, "pose");
    stepper.compute([&](PadStepper& steps) { steps.move(to, travel); });
  } else {
    put_gaps(self, gaps, cover);
    const std::vector<double> by = motion ? rows_of(*motion, count, 3, "motion") : std::vector<double>(3 * count);
    stepper.compute([&](PadStepper& steps) { steps.move_by(by); });
  }
  return answer_of(self);
}

using Mask = py::array_t<bool, py::array::c_style | py::array::forcecast>;

/// A mask [count]; none: empty.
std::vector<std::uint8_t> mask_of(const std::optional<Mask>& mask, std::size_t count) {
  if (!mask) return {};
  if (static_cast<std::size_t>(mask->size()) != count)
    throw InputError("mask", std::to_string(mask->size()) + " numbers", "must be " + std::to_string(count));
  return {mask->data(), mask->data() + mask->size()};
}

Answer press(const py::object& self, const Doubles& wrench, const std::optional<Mask>& mask,
             const std::optional<Floats>& gaps, const std::optional<Floats>& cover) {
  auto& stepper = self.cast<Stepper&>();
  const std::size_t count = stepper.steps().count();
  put_gaps(self, gaps, cover);
  const std::vector<double> to = rows_of(wrench, count, 4, "wrench");
  const std::vector<std::uint8_t> which = mask_of(mask, count);
  stepper.compute([&](PadStepper& steps) { steps.press(to, which); });
  return answer_of(self);
}

py::array_t<double> state_of(Stepper& self, const std::vector<std::size_t>& contacts) {
  const std::vector<double> all = self.steps().state(contacts);
  const auto size = static_cast<py::ssize_t>(self.steps().state_size());
  py::array_t<double> array({static_cast<py::ssize_t>(all.size()) / size, size});
  std::ranges::copy(all, array.mutable_data());
  return array;
}

void bind_step_answer(py::module_& m) {
  py::class_<Answer>(m, "StepAnswer", "What a step of a PadStepper says. Arrays are views without copies.")
      .def_property_readonly(
          "frames", &frames_of_answer,
          "[count, 3 tactels] MPa, fp32, as networks take them: all sigma_z, then tau_x, then tau_y; "
          "memory of the device where that is the host's, valid until the next step; read-only")
      .def_property_readonly("markers", &markers_of_answer,
                             "[count, markers, 3] mm along x, y, z, fp32: displacements of the stepper's markers; "
                             "memory as of frames; read-only")
      .def_property_readonly("pixels", &pixels_of_answer,
                             "[count, markers, 2] where the stepper's camera sees them, a copy")
      .def(
          "__dlpack__",
          [](const py::object& self, const py::kwargs& options) {
            return memory_of_frames(self).attr("__dlpack__")(**options);
          },
          "Shares the frames: torch.from_dlpack(answer). NumPy 1 exports no array that is read-only.")
      .def("__dlpack_device__",
           [](const py::object& self) { return memory_of_frames(self).attr("__dlpack_device__")(); })
      .def_property_readonly("force", member(&StepAnswer::force, 4),
                             "[count, 4] P, Qx, Qy (N), M (N mm) of the object on the rubber, in the axes of the pad")
      .def_property_readonly("pose", member(&StepAnswer::pose, 4),
                             "[count, 4] depth, x, y (mm), twist (degrees) since the contact was reset")
      .def_property_readonly("slip_index", member(&StepAnswer::slip_index, 1), "[count] S; 0 where mu P = 0")
      .def_property_readonly("stick_fraction", member(&StepAnswer::stick_fraction, 1),
                             "[count] cells that stick over those that touch")
      .def_property_readonly("flags", member(&StepAnswer::flags, 1),
                             "[count] sums of OPEN, SLIDES, UNMET, EDGE, INVALID, DEEP, REACH of PadStepper")
      .def_property_readonly("residual", member(&StepAnswer::residual, 1), "[count] largest residual of the laws")
      .def_property_readonly("solves", member(&StepAnswer::solves, 1), "[count] poses that were solved")
      .def_property_readonly("sweeps", member(&StepAnswer::sweeps, 1), "[count] sweeps of all of them");
}

}  // namespace

void bind_steps(py::module_& m) {
  bind_step_answer(m);
  py::class_<Stepper> stepper(m, "PadStepper",
                              "Contacts with one pad inside a simulator: each call takes all of them a step on.",
                              py::dynamic_attr());
  stepper
      .def(py::init([](const Pad& pad, std::size_t count, const Doubles& friction, const GivenXY<int>& cells,
                       const GivenXY<double>& cell, double tolerance, double force_tolerance, int most_solves,
                       Precision precision, const std::string& device, double object_young, double object_poisson,
                       std::optional<Markers> markers, std::optional<Camera> camera, double dt) {
             StepOptions options;
             options.cells = along_xy(cells), options.cell = along_xy(cell), options.tolerance = tolerance;
             options.force_tolerance = force_tolerance, options.most_solves = most_solves;
             options.precision = precision, options.device = device;
             options.object_young = object_young, options.object_poisson = object_poisson;
             options.markers = std::move(markers), options.camera = camera, options.dt = dt;
             const std::vector<double> mu(friction.data(), friction.data() + friction.size());
             Stepper made(without_lock([&] { return PadStepper(pad, count, mu, options); }));
             if (friction.ndim() > 1) (void)rows_of(friction, count, made.steps().cell_x().size(), "friction");
             return made;
           }),
           "pad"_a, "count"_a, "friction"_a, py::kw_only(), "cells"_a = py::none(), "cell"_a = py::none(),
           "tolerance"_a = 1e-3, "force_tolerance"_a = 2e-3, "most_solves"_a = 16, "precision"_a = "", "device"_a = "",
           "object_young"_a = 0.0, "object_poisson"_a = 0.45, "markers"_a = py::none(), "camera"_a = py::none(),
           "dt"_a = 0.0,
           "friction: as of set_friction; cells: of the grid about the pad's middle, 4 to 24, along both sides or "
           "[x, y]; cell: mm, one side or [x, y]; tolerance: of the sweeps; force_tolerance: of a wrench, over P; "
           "most_solves: poses that a step by wrench may solve. By default cells cover a pad whose sides are free, "
           "about 256 of them, and are 16 x 16 of 0.5 mm on another. The grid lies within a pad whose sides are free. "
           "object_young: MPa, of soft objects, 0 for rigid ones; object_poisson: of soft ones; markers, camera: "
           "answers "
           "have the displacements of these markers, and the pixels where the camera sees them; dt: seconds of each "
           "step, of a pad that relaxes.")
      .def("__len__", [](Stepper& self) { return self.steps().count(); })
      .def_property_readonly("tactels", [](Stepper& self) { return self.steps().tactels(); })
      .def_property_readonly(
          "cell_x", [](Stepper& self) { return py::array_t<double>(py::cast(self.steps().cell_x())); },
          "[cells] mm on the pad, y fastest")
      .def_property_readonly(
          "cell_y", [](Stepper& self) { return py::array_t<double>(py::cast(self.steps().cell_y())); }, "[cells] mm")
      .def_property_readonly("device", [](Stepper& self) { return self.steps().device(); })
      .def_property_readonly(
          "dt", [](Stepper& self) { return self.steps().options().dt; }, "s, of each step")
      .def(
          "set_dt", [](Stepper& self, double dt) { self.steps().set_dt(dt); }, "dt"_a,
          "Sets the seconds that each step takes from now on.")
      .def(
          "set_friction",
          [](Stepper& self, const Doubles& friction) {
            PadStepper& steps = self.steps();
            if (friction.ndim() > 1)
              return steps.set_friction(rows_of(friction, steps.count(), steps.cell_x().size(), "friction"));
            steps.set_friction(std::vector<double>(friction.data(), friction.data() + friction.size()));
          },
          "friction"_a, "friction: [count], one number, or [count, cells], from the next step on.")
      .def(
          "shapes",
          [](Stepper& self, const std::variant<PadIndenter, PadShape, std::vector<PadIndenter>>& shapes,
             const std::optional<Doubles>& places) {
            self.steps().set_shapes(indenters_of(shapes));
            if (places) self.steps().set_places(rows_of(*places, self.steps().count(), 3, "places"));
          },
          "shapes"_a, "places"_a = py::none(),
          "shapes: a shape or PadIndenter for all contacts, or a PadIndenter for each; places: [count, 3] x, y (mm), "
          "yaw "
          "(degrees) on the pad, else those of the indenters.")
      .def(
          "places",
          [](Stepper& self, const Doubles& places) {
            self.steps().set_places(rows_of(places, self.steps().count(), 3, "places"));
          },
          "places"_a,
          "Places of the shapes from the next step on: [count, 3] x, y (mm), yaw (degrees). Heights move, "
          "friction does not feel it.")
      .def("_gaps", &set_gaps, "gaps"_a, "cover"_a = py::none())
      .def("move", &move, "pose"_a = py::none(), py::kw_only(), "gaps"_a = py::none(), "cover"_a = py::none(),
           "motion"_a = py::none(), "travel"_a = true,
           "Steps by motion. pose: [count, 4] depth, x, y (mm), twist (degrees) since the contact was reset, with "
           "travel the shapes go along. Or gaps: [count, cells] mm, < 0 overlaps, cover: [count, cells] 0 to 1, and "
           "motion: [count, 3] x, y (mm), twist (degrees) since the last step.")
      .def("press", &press, "wrench"_a, py::kw_only(), "mask"_a = py::none(), "gaps"_a = py::none(),
           "cover"_a = py::none(),
           "Steps by wrench, and finds the pose. wrench: [count, 4] P, Qx, Qy (N), M (N mm); P <= 0: open; mask: "
           "[count] "
           "where it is false, a contact stays as it is, with its last answer; gaps, cover as of move.")
      .def(
          "reset",
          [](Stepper& self, const std::optional<Mask>& mask) {
            if (!mask) return self.steps().reset();
            self.steps().reset(mask_of(mask, self.steps().count()));
          },
          "mask"_a = py::none(), "Contacts as if nothing had touched: where mask [count] is true, or all.")
      .def("state", &state_of, "contacts"_a = std::vector<std::size_t>{},
           "Returns the state of these contacts, or of all, [contacts, numbers]; fp32 numbers are kept exactly.")
      .def(
          "set_state",
          [](Stepper& self, const Doubles& state, const std::vector<std::size_t>& contacts) {
            self.steps().set_state(std::span(state.data(), static_cast<std::size_t>(state.size())), contacts);
          },
          "state"_a, "contacts"_a = std::vector<std::size_t>{},
          "Sets the state of these contacts, or of all: steps then have the bits that they had from where it was "
          "taken.")
      .def(
          "tractions",
          [](Stepper& self) {
            const std::vector<double> all = self.steps().tractions();
            const auto count = static_cast<py::ssize_t>(self.steps().count());
            py::array_t<double> array({count, py::ssize_t{3}, static_cast<py::ssize_t>(all.size()) / count / 3});
            std::ranges::copy(all, array.mutable_data());
            return array;
          },
          "Returns pressures and tractions on the cells, [count, 3, cells] MPa: n, t_x, t_y.");
  stepper.attr("OPEN") = int(step_open), stepper.attr("SLIDES") = int(step_slides);
  stepper.attr("UNMET") = int(step_unmet), stepper.attr("EDGE") = int(step_edge);
  stepper.attr("INVALID") = int(step_invalid), stepper.attr("DEEP") = int(step_deep);
  stepper.attr("REACH") = int(step_reach);
}

}  // namespace tactel::python
