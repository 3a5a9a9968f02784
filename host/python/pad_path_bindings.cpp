// SPDX-License-Identifier: Apache-2.0
#include "host/python/path_arrays.h"

namespace tactel::python {
namespace {

using namespace pybind11::literals;

/// The stresses of the tactels of a pad.
struct PadTactels {
  py::array_t<double> normal, shear_x, shear_y;
};

/// [steps, tactels along y, along x]
py::array_t<double> tactel_grid(const PadPath& path, std::vector<double> PadStep::*stress) {
  return of_steps(path, stress).reshape({path.steps.size(), path.tactel_y.size(), path.tactel_x.size()});
}

py::array_t<float> frames_of_pad(const PadPath& path) {
  const auto axes = static_cast<std::size_t>(path.axes);
  py::array_t<float> frames({path.steps.size(), axes * path.tactel_x.size() * path.tactel_y.size()});
  float* to = frames.mutable_data();
  for (const PadStep& step : path.steps)
    for (const std::vector<double>* stress : {&step.sigma_z, &step.tau_x, &step.tau_y})
      if (stress == &step.sigma_z || axes == 3)
        to = std::ranges::transform(*stress, to, [](double s) { return static_cast<float>(s); }).out;
  return frames;
}

py::array_t<float> frames_of_pads(const PadPaths& all) {
  const auto axes = static_cast<std::size_t>(all.axes);
  const std::size_t tactels = all.tactels[0] * all.tactels[1];
  py::array_t<float> frames({all.scenes, all.steps, axes * tactels});
  float* to = frames.mutable_data();
  for (std::size_t row = 0; row < all.scenes * all.steps; ++row)
    for (const std::vector<double>* stress : {&all.sigma_z, &all.tau_x, &all.tau_y})
      for (std::size_t i = 0; i < tactels && (stress == &all.sigma_z || axes == 3); ++i)
        *to++ = static_cast<float>((*stress)[row * tactels + i]);
  return frames;
}

/// [scenes, steps, ...], the last axes as many as a step has numbers.
template <class Number>
auto pad_grid(std::vector<Number> PadPaths::*numbers, const std::vector<py::ssize_t>& of_a_step = {}) {
  return [numbers, of_a_step](const py::object& self) {
    const auto& all = self.cast<const PadPaths&>();
    std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(all.scenes), static_cast<py::ssize_t>(all.steps)};
    shape.insert(shape.end(), of_a_step.begin(), of_a_step.end());
    return view(all.*numbers, shape, self);
  };
}

PadTactels tactels_of(const py::object& self) {
  const auto& all = self.cast<const PadPaths&>();
  const auto stress = [&](std::vector<double> PadPaths::*numbers) {
    return pad_grid(numbers,
                    {static_cast<py::ssize_t>(all.tactels[1]), static_cast<py::ssize_t>(all.tactels[0])})(self);
  };
  return {stress(&PadPaths::sigma_z), stress(&PadPaths::tau_x), stress(&PadPaths::tau_y)};
}

void bind_pad_path(py::module_& m) {
  py::class_<PadTactels>(m, "PadTactels",
                         "Stress at the tactels of a pad: row y, column x; without copies where it comes from "
                         "solve_many.")
      .def_readonly("normal", &PadTactels::normal, "[..., tactels along y, along x] MPa; sigma_z < 0 is compression")
      .def_readonly("shear_x", &PadTactels::shear_x,
                    "[..., tactels along y, along x] MPa; tau_x > 0 where the rubber is dragged toward +x")
      .def_readonly("shear_y", &PadTactels::shear_y, "[..., tactels along y, along x] MPa; tau_y alike");
  py::class_<PadPath> path(
      m, "PadPath", "The answer to a scene on a pad: one entry for each load increment, those of the pressing first.");
  bind_pictures(path);
  path.def("__len__", [](const PadPath& path) { return path.steps.size(); })
      .def_property_readonly("slip_index", steps_property<PadPath, &PadStep::slip_index>(),
                             "[steps] S, 1 where the forces Q and the torque M can grow no more; NaN where mu P = 0")
      .def_property_readonly("force_ratio", steps_property<PadPath, &PadStep::force_ratio>(),
                             "[steps] |Q| / (mu P); NaN where mu P = 0")
      .def_property_readonly("P", steps_property<PadPath, &PadStep::P>(), "[steps] N, of the indenter on the rubber")
      .def_property_readonly("Q", steps_property<PadPath, &PadStep::Q>(),
                             "[steps, 2] N along x, y; > 0 drags the rubber toward +x, +y")
      .def_property_readonly("M", steps_property<PadPath, &PadStep::M>(), "[steps] N mm about the indenter's axis")
      .def_property_readonly("indentation", steps_property<PadPath, &PadStep::indentation>(), "[steps] mm")
      .def_property_readonly("tangential", steps_property<PadPath, &PadStep::tangential>(), "[steps, 2] mm along x, y")
      .def_property_readonly("twist", steps_property<PadPath, &PadStep::twist>(), "[steps] degrees")
      .def_property_readonly("stick_fraction", steps_property<PadPath, &PadStep::stick_fraction>(),
                             "[steps] cells that stick over those that touch")
      .def_property_readonly("slip_distance", steps_property<PadPath, &PadStep::slip_distance>(), "[steps] mm")
      .def_property_readonly("converged", steps_property<PadPath, &PadStep::converged>(), "[steps] bool")
      .def_property_readonly("iterations", steps_property<PadPath, &PadStep::iterations>(), "[steps] sweeps")
      .def_property_readonly(
          "residual",
          [](const PadPath& path) {
            py::array_t<double> all(static_cast<py::ssize_t>(path.steps.size()));
            std::ranges::transform(path.steps, all.mutable_data(), [](const PadStep& step) {
              const PadResidual& r = step.residual;
              return std::max({r.penetration, r.complementarity, r.cone, r.drift, r.angle});
            });
            return all;
          },
          "[steps] largest relative residual of the contact laws")
      .def_property_readonly(
          "tactels",
          [](const PadPath& path) {
            return PadTactels{tactel_grid(path, &PadStep::sigma_z), tactel_grid(path, &PadStep::tau_x),
                              tactel_grid(path, &PadStep::tau_y)};
          },
          "stresses, [steps, tactels along y, along x] MPa: row y, column x")
      .def_property_readonly("frames", &frames_of_pad,
                             "[steps, axes tactels] MPa, fp32, as networks take them: all sigma_z, then tau_x, then "
                             "tau_y, tactels with x fastest")
      .def_property_readonly("normal_force", steps_property<PadPath, &PadStep::normal_force>(),
                             "[steps, cells] N; >= 0 presses")
      .def_property_readonly("tangential_force", steps_property<PadPath, &PadStep::tangential_force>(),
                             "[steps, cells, 2] N along x, y")
      .def_property_readonly("status", steps_property<PadPath, &PadStep::status>(),
                             "[steps, cells] 0 open, 1 stick, 2 slip")
      .def_property_readonly("cell_x", column(&PadPath::cell_x), "[cells] mm: their middles on the pad")
      .def_property_readonly("cell_y", column(&PadPath::cell_y), "[cells] mm")
      .def_readonly("cell_width", &PadPath::cell_width, "mm along x and y of the turned shape")
      .def_property_readonly("tactel_x", column(&PadPath::tactel_x), "[tactels along x] mm")
      .def_property_readonly("tactel_y", column(&PadPath::tactel_y), "[tactels along y] mm")
      .def_readonly("fell_back", &PadPath::fell_back, "the exact fallback answered")
      .def_readonly("rung", &PadPath::rung)
      .def_readonly("model", &PadPath::model)
      .def_readonly("precision", &PadPath::precision)
      .def_readonly("device", &PadPath::device)
      .def_property_readonly(
          "error",
          [](const PadPath& path) -> OptionalDict {
            if (!path.error) return {py::none()};
            const PadError& e = *path.error;
            return {py::dict("S"_a = e.S, "P"_a = e.P, "Q"_a = e.Q, "M"_a = e.M, "sigma"_a = e.sigma, "tau"_a = e.tau,
                             "largest"_a = e.largest, "scenes"_a = e.scenes, "outside"_a = e.outside,
                             "from"_a = e.from)};
          },
          "errors to expect of S, and of P, Q, M, sigma and tau over the largest: 95 % of scenes stay below them; "
          "\"from\" names the second solution of the scene, \"outside\" what was not measured; None where nothing is "
          "touched")
      .def_readonly("warnings", &PadPath::warnings)
      .def("__repr__", [](const PadPath& path) {
        return "<tactel.PadPath: " + std::to_string(path.steps.size()) + " steps, " + path.model + ">";
      });
}

}  // namespace

void bind_pad_paths(py::module_& m) {
  bind_pad_path(m);
  py::class_<PadPaths>(
      m, "PadPaths",
      "Answers of many scenes on pads. Arrays are views without copies; entries beyond a scene's own steps are NaN.")
      .def("__len__", [](const PadPaths& all) { return all.scenes; })
      .def_property_readonly("slip_index", pad_grid(&PadPaths::slip_index), "[scenes, steps] S; NaN where mu P = 0")
      .def_property_readonly("force_ratio", pad_grid(&PadPaths::force_ratio),
                             "[scenes, steps] |Q| / (mu P); NaN where mu P = 0")
      .def_property_readonly("P", pad_grid(&PadPaths::P), "[scenes, steps] N, of the indenter on the rubber")
      .def_property_readonly("Q", pad_grid(&PadPaths::Q, {2}),
                             "[scenes, steps, 2] N along x, y; > 0 drags the rubber toward +x, +y")
      .def_property_readonly("M", pad_grid(&PadPaths::M), "[scenes, steps] N mm about the indenter's axis")
      .def_property_readonly("indentation", pad_grid(&PadPaths::indentation), "[scenes, steps] mm")
      .def_property_readonly("tangential", pad_grid(&PadPaths::tangential, {2}), "[scenes, steps, 2] mm along x, y")
      .def_property_readonly("twist", pad_grid(&PadPaths::twist), "[scenes, steps] degrees")
      .def_property_readonly("stick_fraction", pad_grid(&PadPaths::stick_fraction),
                             "[scenes, steps] cells that stick over those that touch")
      .def_property_readonly("converged", pad_grid(&PadPaths::converged), "[scenes, steps] 1: within its tolerance")
      .def_property_readonly("steps_made", column(&PadPaths::steps_made), "[scenes] load steps of each scene")
      .def_property_readonly("fell_back", column(&PadPaths::fell_back), "[scenes] 1: the exact fallback answered")
      .def_property_readonly("tactels", &tactels_of,
                             "stresses, [scenes, steps, tactels along y, along x] MPa: row y, column x")
      .def_property_readonly("frames", &frames_of_pads,
                             "[scenes, steps, axes tactels] MPa, fp32 copy, as networks take them: all sigma_z, then "
                             "tau_x, then tau_y, tactels with x fastest")
      .def_readonly("rung", &PadPaths::rung)
      .def_readonly("precision", &PadPaths::precision)
      .def_readonly("device", &PadPaths::device)
      .def_readonly("warnings", &PadPaths::warnings, "of numbers that look as if they had another unit")
      .def("__repr__", [](const PadPaths& all) {
        return "<tactel.PadPaths: " + std::to_string(all.scenes) + " scenes, " + std::to_string(all.steps) +
               " steps, " + std::to_string(all.tactels[0]) + " x " + std::to_string(all.tactels[1]) + " tactels>";
      });
}

}  // namespace tactel::python
