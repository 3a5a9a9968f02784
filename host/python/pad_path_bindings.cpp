// SPDX-License-Identifier: Apache-2.0
#include "host/python/path_arrays.h"

namespace tactel::python {
namespace {

using namespace pybind11::literals;

/// The stresses of the tactels of a pad.
struct PadTactels {
  py::array_t<double> normal, shear_x, shear_y;
};

/// Stress at the tactels of a path, [steps, tactels along y, along x].
py::array_t<double> tactel_grid(const PadPath& path, std::vector<double> PadStep::*stress) {
  return of_steps(
             path, [stress](const PadStep& step) -> const auto& { return step.*stress; })
      .reshape({path.steps.size(), path.tactel_y.size(), path.tactel_x.size()});
}
/// The same of many, [scenes, steps, ...].
py::array_t<double> tactel_grids(const py::object& self, std::vector<double> PadPaths::*stress) {
  const auto& all = self.cast<const PadPaths&>();
  std::vector<py::ssize_t> shape;
  for (const std::size_t n : {all.scenes, all.steps, all.tactels[1], all.tactels[0]})
    shape.push_back(static_cast<py::ssize_t>(n));
  return view(all.*stress, shape, self);
}

/// Of all stresses, or of the normal ones where tactels have one axis. `Answer`: PadStep of a path, PadPaths of many.
template <class Answer, class Paths>
py::array_t<float> frames_of_pads(const Paths& all, std::size_t tactels) {
  if (all.axes == 1) return frames_of(all, {&Answer::sigma_z}, tactels);
  return frames_of(all, {&Answer::sigma_z, &Answer::tau_x, &Answer::tau_y}, tactels);
}

void bind_pad_path(py::module_& m) {
  py::class_<PadTactels>(m, "PadTactels",
                         "Stress at the tactels of a pad: row y, column x; without copies where it comes from "
                         "solve_many.")
      .def_readonly("normal", &PadTactels::normal, "[..., tactels along y, along x] MPa; sigma_z < 0 is compression")
      .def_readonly("shear_x", &PadTactels::shear_x,
                    "[..., tactels along y, along x] MPa; tau_x > 0 where the rubber is dragged toward +x")
      .def_readonly("shear_y", &PadTactels::shear_y, "[..., tactels along y, along x] MPa; tau_y alike");
  py::class_<PadPath> path(m, "PadPath",
                           "The answer to a scene on a pad: one entry for each load increment, those of the pressing "
                           "first. P, Q, M are those of the indenter on the rubber.");
  bind_solved(path, "PadPath");
  path.def_property_readonly(
          "tactels",
          [](const PadPath& path) {
            return PadTactels{tactel_grid(path, &PadStep::sigma_z), tactel_grid(path, &PadStep::tau_x),
                              tactel_grid(path, &PadStep::tau_y)};
          },
          "stresses, [steps, tactels along y, along x] MPa: row y, column x")
      .def_property_readonly(
          "frames",
          [](const PadPath& path) {
            return frames_of_pads<PadStep>(path, path.tactel_x.size() * path.tactel_y.size());
          },
          "[steps, axes tactels] MPa, fp32, as networks take them: all sigma_z, then tau_x, then "
          "tau_y, tactels with x fastest")
      .def_property_readonly("cell_x", column(&PadPath::cell_x), "[cells] mm: their middles on the pad")
      .def_property_readonly("cell_y", column(&PadPath::cell_y), "[cells] mm")
      .def_readonly("cell_width", &PadPath::cell_width, "mm along x and y of the turned shape")
      .def_property_readonly("tactel_x", column(&PadPath::tactel_x), "[tactels along x] mm")
      .def_property_readonly("tactel_y", column(&PadPath::tactel_y), "[tactels along y] mm")
      .def_readonly("rung", &PadPath::rung)
      .def_property_readonly(
          "error",
          [](const PadPath& path) -> OptionalDict {
            if (!path.error) return {py::none()};
            const PadError& e = *path.error;
            py::dict all("S"_a = e.S, "P"_a = e.P, "Q"_a = e.Q, "M"_a = e.M, "sigma"_a = e.sigma, "tau"_a = e.tau);
            if (e.markers > 0) all["markers"] = e.markers;
            all["largest"] = e.largest, all["strain"] = e.strain, all["scenes"] = e.scenes;
            all["outside"] = e.outside, all["from"] = e.from;
            return {all};
          },
          "errors to expect of S, and of P, Q, M, sigma, tau, markers over the largest: 95 % of scenes stay below; "
          "\"from\" names the second solution of the scene, \"outside\" what was not measured, \"strain\" what large "
          "strain adds to P and sigma; None where nothing is touched");
}

}  // namespace

void bind_pad_paths(py::module_& m) {
  bind_pad_path(m);
  py::class_<PadPaths> paths(
      m, "PadPaths",
      "Answers of many scenes on pads. Arrays are views without copies; entries beyond a scene's own steps are NaN.");
  bind_many_solved(paths);
  paths
      .def_property_readonly(
          "tactels",
          [](const py::object& self) {
            return PadTactels{tactel_grids(self, &PadPaths::sigma_z), tactel_grids(self, &PadPaths::tau_x),
                              tactel_grids(self, &PadPaths::tau_y)};
          },
          "stresses, [scenes, steps, tactels along y, along x] MPa: row y, column x")
      .def_property_readonly(
          "frames", [](const PadPaths& all) { return frames_of_pads<PadPaths>(all, all.tactels[0] * all.tactels[1]); },
          "[scenes, steps, axes tactels] MPa, fp32 copy, as networks take them: all sigma_z, then "
          "tau_x, then tau_y, tactels with x fastest")
      .def("__repr__", [](const PadPaths& all) {
        return "<tactel.PadPaths: " + std::to_string(all.scenes) + " scenes, " + std::to_string(all.steps) +
               " steps, " + std::to_string(all.tactels[0]) + " x " + std::to_string(all.tactels[1]) + " tactels>";
      });
}

}  // namespace tactel::python
