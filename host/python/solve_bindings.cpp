// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "host/python/path_arrays.h"

namespace tactel::python {
namespace {

using namespace pybind11::literals;

/// Both stresses of the tactels.
struct Tactels {
  py::array_t<double> normal, shear;
};

py::dict to_dict(const ExpectedError& error) {
  return py::dict("S"_a = error.S, "P"_a = error.P, "Q"_a = error.Q, "sigma_y"_a = error.sigma_y,
                  "tau_xy"_a = error.tau_xy, "finer"_a = error.finer);
}

/// Stress at the tactels of all scenes, [scenes, steps, tactels].
py::array_t<double> stress_of(const py::object& self, std::vector<double> Paths::*stress) {
  const auto& all = self.cast<const Paths&>();
  std::vector<py::ssize_t> shape;
  for (const std::size_t n : {all.scenes, all.steps, all.tactels}) shape.push_back(static_cast<py::ssize_t>(n));
  return view(all.*stress, shape, self);
}

void bind_path(py::module_& m) {
  py::class_<Tactels>(m, "Tactels", "Stress at the tactels; arrays without copies where they come from solve_many.")
      .def_readonly("normal", &Tactels::normal, "[..., tactels] MPa; sigma_y < 0 is compression")
      .def_readonly("shear", &Tactels::shear, "[..., tactels] MPa; tau_xy > 0 where the rubber is dragged toward +x");
  py::class_<Path> path(m, "Path",
                        "The answer to a scene: one entry for each load increment, those of the indentation first. "
                        "P, Q are those of the indenter on the rubber.");
  bind_solved(path, "Path");
  path.def_property_readonly(
          "tactels",
          [](const Path& path) {
            const auto stress = [&](auto member) {
              return of_steps(
                  path, [member](const Step& step) -> const auto& { return step.*member; });
            };
            return Tactels{stress(&Step::sigma_y), stress(&Step::tau_xy)};
          },
          "normal and shear stress, [steps, tactels] MPa")
      .def_property_readonly(
          "frames",
          [](const Path& path) {
            return frames_of(path, {&Step::sigma_y, &Step::tau_xy}, path.tactel_x.size());
          },
          "[steps, 2 tactels] MPa, fp32, as networks take them: normal stresses, then shear")
      .def_property_readonly("surface_x", column(&Path::surface_x), "[surface] mm")
      .def_property_readonly("tactel_x", column(&Path::tactel_x), "[tactels] mm")
      .def_readonly("sliding", &Path::sliding, "the last step slides as a whole")
      .def_readonly("model_reason", &Path::model_reason)
      .def_property_readonly(
          "error",
          [](const Path& path) -> OptionalDict { return {path.error ? py::object(to_dict(*path.error)) : py::none()}; },
          "expected error: S absolutely, P, Q and stresses of their largest; None without an estimate");
}

void bind_paths(py::module_& m) {
  py::class_<Paths> paths(
      m, "Paths",
      "Answers of many scenes. Arrays are views without copies; entries beyond a scene's own steps are NaN.");
  bind_many_solved(paths);
  paths.def_property_readonly("sliding", column(&Paths::sliding), "[scenes] 1: the last step slides as a whole")
      .def_property_readonly(
          "tactels",
          [](const py::object& self) {
            return Tactels{stress_of(self, &Paths::sigma_y), stress_of(self, &Paths::tau_xy)};
          },
          "normal and shear stress, [scenes, steps, tactels] MPa")
      .def_property_readonly(
          "frames",
          [](const Paths& all) {
            return frames_of(all, {&Paths::sigma_y, &Paths::tau_xy}, all.tactels);
          },
          "[scenes, steps, 2 tactels] MPa, fp32 copy, as networks take them: normal stresses, then shear")
      .def("__repr__", [](const Paths& all) {
        return "<tactel.Paths: " + std::to_string(all.scenes) + " scenes, " + std::to_string(all.steps) + " steps, " +
               std::to_string(all.tactels) + " tactels>";
      });
}

/// Copies of scenes that are all of one kind.
template <class Kind>
std::vector<Kind> copies_of(const std::vector<const AnyScene*>& scenes) {
  std::vector<Kind> copies;
  copies.reserve(scenes.size());
  for (const AnyScene* scene : scenes) {
    const Kind* copied = std::get_if<Kind>(&scene->of);
    if (copied == nullptr)
      throw InputError("scenes[" + std::to_string(copies.size()) + "]", "its sensor is of the other kind",
                       "must be all Sensor or all Pad, as that of scenes[0]");
    copies.push_back(*copied);
  }
  return copies;
}

/// Binds solve for scenes of a kind. All are solved alike; its types are those of the scene, of its solvers and of the
/// answer.
template <Letters scene_type, Letters solvers, Letters answer>
void bind_solve_of(py::module_& m, const char* doc) {
  m.def(
      "solve",
      [](Typed<const AnyScene*, scene_type> scene, std::optional<double> accuracy, std::string rung,
         Typed<std::string, solvers> solver, Precision precision, std::string device, std::optional<double> tolerance,
         bool estimate_error) {
        SolveOptions options{.accuracy = accuracy, .rung = std::move(rung), .solver = solver, .precision = precision};
        options.device = std::move(device), options.tolerance = tolerance;
        options.estimate_error = estimate_error;
        return Typed<std::variant<Path, PadPath>, answer>{without_lock([&] {
          return std::visit([&](const auto& kind) { return std::variant<Path, PadPath>(solve(kind, options)); },
                            scene.value->of);
        })};
      },
      py::arg("scene").none(false), py::kw_only(), "accuracy"_a = py::none(), "rung"_a = "", "solver"_a = "batched",
      "precision"_a = "", "device"_a = "", "tolerance"_a = py::none(), "estimate_error"_a = false, doc);
}

}  // namespace

void bind_convergence(py::module_& m) {
  py::class_<ConvergedNumber>(m, "ConvergedNumber", "A number of a step on ever smaller cells, continued to size 0.")
      .def_readonly("name", &ConvergedNumber::name)
      .def_readonly("unit", &ConvergedNumber::unit)
      .def_readonly("answer", &ConvergedNumber::answer, "of the path")
      .def_readonly("limit", &ConvergedNumber::limit, "on cells of size 0")
      .def_readonly("uncertainty", &ConvergedNumber::uncertainty, "of the limit")
      .def_readonly("order", &ConvergedNumber::order, "of convergence; 0: the values scatter, and limit is the last")
      .def_readonly("values", &ConvergedNumber::values, "[rungs]")
      .def("__repr__", [](const ConvergedNumber& n) {
        return py::str("<tactel.ConvergedNumber: {} {:.6g} {}, limit {:.6g} +- {:.2g}>")
            .format(n.name, n.answer, n.unit, n.limit, n.uncertainty);
      });
  py::class_<Convergence>(m, "Convergence", "A step of a path beside exact contact on ever smaller cells.")
      .def_readonly("step", &Convergence::step)
      .def_readonly("h", &Convergence::h, "[rungs] mm, size of cells, the largest first")
      .def_readonly("numbers", &Convergence::numbers, "none where fewer than four rungs were solved");
}

void bind_solve(py::module_& m) {
  bind_path(m);
  bind_paths(m);
  bind_solve_of<"_LineScene", "Literal['batched', 'full-mesh', 'reference']", "Path">(
      m,
      "Solves one contact. Returns a Path, of a pad's scene a PadPath.\n\naccuracy: largest error in S; the planner "
      "chooses the rung. rung: \"patch-12\", \"mesh-81\", \"paper\", \"reference\", ...; of a pad \"pad-8\" to "
      "\"pad-24\", \"reference\".\nsolver: \"batched\" or \"reference\"; of a pad \"batched\" or \"twin\". precision: "
      "\"fp32\" or \"fp64\".\nestimate_error: also solve a finer model, for Path.error; PadPath.error is always there. "
      "\nRaises InputError, HardwareError.");
  bind_solve_of<"_PadScene", "Literal['batched', 'twin']", "PadPath">(m, "");
  bind_solve_of<"Scene", "str", "Any">(m, "");
  m.def(
      "_solve_many",
      [](const std::vector<const AnyScene*>& scenes, const py::dict& words, py::object progress) {
        const auto options = options_of<SolveOptions>(words);
        return Computation(std::move(progress)).run([&](const ProgressFunction& p) -> std::variant<Paths, PadPaths> {
          if (!scenes.empty() && std::holds_alternative<PadScene>(scenes.front()->of))
            return solve_many(copies_of<PadScene>(scenes), options, p);
          return solve_many(copies_of<Scene>(scenes), options, p);
        });
      },
      "scenes"_a, "words"_a, "progress"_a);
}

}  // namespace tactel::python
