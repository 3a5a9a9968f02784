// SPDX-License-Identifier: Apache-2.0
#include <tactel/train.h>

#include <memory>
#include <utility>
#include <variant>

#include "host/python/bindings.h"

namespace tactel::python {
namespace {

using namespace pybind11::literals;

/// Frames and S of a set from arrays; what the set's other columns would hold is unknown, 0.
Set set_of(const py::array_t<float, py::array::c_style | py::array::forcecast>& frames,
           const py::array_t<float, py::array::c_style | py::array::forcecast>& slip_index) {
  if (frames.ndim() != 2 || slip_index.ndim() != 1 || frames.shape(0) != slip_index.shape(0) ||
      frames.shape(1) % 2 != 0)
    throw InputError("Set", "frames and slip_index of these shapes", "[rows, 2 tactels] and [rows]");
  Set set;
  set.inputs = static_cast<std::size_t>(frames.shape(1));
  set.frames.assign(frames.data(), frames.data() + frames.size());
  set.slip_index.assign(slip_index.data(), slip_index.data() + slip_index.size());
  const std::size_t rows = set.slip_index.size();
  for (auto* numbers : {&set.normal_force, &set.tangential_force, &set.friction, &set.stick_fraction, &set.residual})
    numbers->assign(rows, 0.0f);
  set.contact.resize(rows);
  for (std::size_t i = 0; i < rows; ++i) set.contact[i] = i;
  set.step.assign(rows, 0);
  set.indenter.assign(rows, 0);
  set.contact_nodes.assign(rows, 0);
  set.status.assign(rows, 0);
  set.indenter_names = {"unknown"};
  set.contacts = rows;
  return set;
}

/// Getter of a vector of a set, [rows].
template <class Number>
auto list(std::vector<Number> SetArrays::*numbers) {
  return column<Set, Number>(numbers);
}
/// The same: of pads [rows, 2].
auto directed(std::vector<float> SetArrays::*numbers) {
  return [numbers](const py::object& self) {
    const auto& set = self.cast<const Set&>();
    const auto& all = set.*numbers;
    const auto count = static_cast<py::ssize_t>(all.size());
    return set.axes == 2 ? view(all, {count}, self) : view(all, {count / 2, 2}, self);
  };
}

/// Batches of a sweep as an iterator of (frames, slip_index) or of sets.
class Batches {
 public:
  Batches(const Sweep& sweep, std::uint64_t contacts, const SweepOptions& options, std::uint64_t first, bool whole)
      : batches_(sweep, contacts, options, first), whole_(whole) {}
  py::object next() {
    auto rows = std::make_unique<Set>();
    if (!turn_.without_lock([&] { return batches_.next(*rows); })) throw py::stop_iteration();
    const py::object set = py::cast(std::move(rows));
    return whole_ ? set : py::make_tuple(set.attr("frames"), set.attr("slip_index"));
  }

 private:
  SweepBatches batches_;
  bool whole_;
  Turn turn_{"batches"};
};

py::tuple inputs_of(const Set& set, const std::variant<int, std::string>& history, std::optional<double> history_change,
                    const std::string& reference, std::string target, bool friction) {
  if (!reference.empty() && reference != "rest") throw InputError("reference", reference, "rest, or leave it out");
  TrainOptions options;
  if (const int* frames = std::get_if<int>(&history))
    options.history = *frames == 1 ? "" : std::to_string(*frames);
  else
    options.history = std::get<std::string>(history);
  options.history_change = history_change;
  options.scaling = reference.empty() ? "set" : "rest";
  options.target = std::move(target), options.friction = friction;
  LearningRows rows;
  {
    const py::gil_scoped_release released;
    rows = learning_rows(set, options);
  }
  const auto count = static_cast<py::ssize_t>(rows.target.size());
  return py::make_tuple(py::array_t<float>({count, static_cast<py::ssize_t>(rows.inputs)}, rows.frames.data()),
                        py::array_t<float>(count, rows.target.data()));
}

/// Views of so many numbers for each marker.
auto of_markers(std::vector<float> Set::*numbers, py::ssize_t each) {
  return [=](const py::object& self) {
    const auto& set = self.cast<const Set&>();
    const auto rows = static_cast<py::ssize_t>(set.rows());
    return view(set.*numbers, {rows, rows ? static_cast<py::ssize_t>((set.*numbers).size()) / rows / each : 0, each},
                self);
  };
}

void bind_set(py::module_& m) {
  py::class_<Set>(m, "Set", "Frames with their answers, one row a load step. Arrays are views without copies.")
      .def(py::init(&set_of), "frames"_a, "slip_index"_a,
           "frames: [rows, 2 tactels] MPa, normal stresses first; slip_index: [rows]. Both are copied.")
      .def("__len__", &Set::rows)
      .def_property_readonly(
          "frames",
          [](const py::object& self) {
            const auto& set = self.cast<const Set&>();
            return view(set.frames, {static_cast<py::ssize_t>(set.rows()), static_cast<py::ssize_t>(set.inputs)}, self);
          },
          "[rows, axes tactels] MPa: normal stresses (compression < 0), then shear")
      .def_property_readonly("markers", of_markers(&Set::markers, 3),
                             "[rows, markers, 3] mm along x, y, z, of pads with markers: their displacements")
      .def_property_readonly("pixels", of_markers(&Set::pixels, 2),
                             "[rows, markers, 2] where the sweep's camera sees them, with its noise")
      .def(
          "inputs", &inputs_of, py::kw_only(), "history"_a = 1, "history_change"_a = py::none(), "reference"_a = "",
          "target"_a = "slip_index", "friction"_a = false,
          "Returns what networks learn from: inputs [rows, numbers] MPa, and targets [rows]. history: frames of a row, "
          "the newest first, or \"K:STRIDE\". reference: \"rest\" puts the rest of the grip behind them. friction: two "
          "more numbers, mu and its spread as told. As of train().")
      .def_readonly("axes", &Set::axes, "stresses of a tactel: 2; of a pad 3, or 1")
      .def_property_readonly("slip_index", list(&Set::slip_index), "[rows] S")
      .def_property_readonly("P", list(&Set::normal_force), "[rows] N/mm, of pads N, of the indenter on the rubber")
      .def_property_readonly("Q", directed(&Set::tangential_force), "[rows] N/mm, of pads [rows, 2] N, as P")
      .def_property_readonly("M", list(&Set::torque), "[rows] N mm, of pads, as P")
      .def_property_readonly("force_ratio", list(&Set::force_ratio), "[rows] |Q| / (mu P), of pads")
      .def_property_readonly("slid", list(&Set::slid),
                             "[rows] slide as a whole since first touch over the elastic limit, of pads")
      .def_property_readonly("slip_path", list(&Set::slip_path),
                             "[rows] the cells' rms slips since first touch, summed, over that limit, of pads")
      .def_property_readonly("net_slip", directed(&Set::net_slip),
                             "[rows, 2] mean slips since first touch, added up, over that limit, of grips with a rate")
      .def_property_readonly("net_turn", list(&Set::net_turn),
                             "[rows] their turn times the contact's rms radius, the same")
      .def_property_readonly("slid_ahead", list(&Set::slid_ahead),
                             "[rows] how far slid grows in the next 0.2 s; NaN where the grip ends before")
      .def_property_readonly("twist", list(&Set::twist), "[rows] degrees, of pads")
      .def_property_readonly("indentation", list(&Set::indentation), "[rows] mm, depth since first touch")
      .def_property_readonly("tangential", directed(&Set::tangential),
                             "[rows] mm, way along x since first touch; of pads [rows, 2]")
      .def_property_readonly("tactel_x", column(&Set::tactel_x), "[tactels] mm; empty where contacts differ in them")
      .def_property_readonly("tactel_y", column(&Set::tactel_y), "[tactels] mm, of pads")
      .def_property_readonly(
          "parameters",
          [](const py::object& self) {
            const auto& set = self.cast<const Set&>();
            const auto names = static_cast<py::ssize_t>(set.parameter_names.size());
            return view(set.parameters, {names ? static_cast<py::ssize_t>(set.parameters.size()) / names : 0, names},
                        self);
          },
          "[contacts, parameter_names] what was drawn; NaN: the contact has no such number")
      .def_readonly("parameter_names", &Set::parameter_names, "keys, such as indenter.radius")
      .def_readonly("parameter_units", &Set::parameter_units)
      .def_property_readonly("friction", list(&Set::friction), "[rows] mu")
      .def_property_readonly("stick_fraction", list(&Set::stick_fraction), "[rows] stuck length over contact length")
      .def_property_readonly("residual", list(&Set::residual), "[rows] largest relative residual")
      .def_property_readonly("contact", list(&Set::contact), "[rows] contact of the sweep")
      .def_property_readonly("step", list(&Set::step), "[rows] load step of the contact")
      .def_property_readonly("indenter", list(&Set::indenter), "[rows] index in indenter_names")
      .def_property_readonly("contact_nodes", list(&Set::contact_nodes), "[rows] surface nodes or elements that touch")
      .def_property_readonly("status", list(&Set::status),
                             "[rows] 0 solved, 1 sliding, 2 over tolerance, 3 few cells touch")
      .def_property_readonly("outside", list(&Set::outside),
                             "[rows] of pads, what the model does not serve: sum of 1 nearer than the thickness H to "
                             "an edge, 2 farther than H from every tactel at a pitch above 2 H, 4 cells longer than H")
      .def_readonly("indenter_names", &Set::indenter_names)
      .def_readonly("contacts", &Set::contacts)
      .def_readonly("fell_back", &Set::fell_back, "contacts that the exact fallback answered")
      .def_readonly("press_rows", &Set::press_rows, "whether the load steps of the pressing are rows, too")
      .def_readonly("unsolved", &Set::unsolved, "contacts that stayed unsolved")
      .def_readonly("without_rows", &Set::without_rows, "contacts without a row")
      .def(
          "save",
          [](const Set& set, const FileName& path) {
            const py::gil_scoped_release released;
            write_set(set, path);
          },
          "path"_a,
          "Writes a set file (HDF5), in place of a file of that name: that of `tactel generate` for the rows of a "
          "whole "
          "sweep. Raises InputError.")
      .def("__repr__", [](const Set& set) {
        return "<tactel.Set: " + std::to_string(set.rows()) + " rows of " + std::to_string(set.inputs / set.axes) +
               " tactels, " + std::to_string(set.contacts) + " contacts>";
      });
  m.def(
      "read_set",
      [](const FileName& path) {
        const py::gil_scoped_release released;
        return std::make_unique<Set>(read_set(path));
      },
      "path"_a, "Reads a set file (HDF5). Raises InputError for one that cannot be read or is damaged.");
}

}  // namespace

void bind_sweeps(py::module_& m) {
  bind_set(m);
  py::class_<Batches>(m, "_Batches")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &Batches::next);
  py::class_<Sweep>(m, "Sweep",
                    "The contacts of a sweep file: contact k is a function of the file, its seed and k alone.")
      .def(py::init([](const FileName& path, std::optional<std::uint64_t> seed, std::optional<int> tactels,
                       std::optional<double> thickness) {
             return Sweep(path, seed, {.tactels = tactels, .thickness = thickness});
           }),
           "path"_a, "seed"_a = py::none(), "tactels"_a = py::none(), "thickness"_a = py::none(),
           "Reads a sweep file (TOML). seed, tactels and thickness (mm) take the place of the file's.")
      .def(
          "_of_quantiles",
          [](const Sweep& sweep, const py::array_t<double, py::array::c_style | py::array::forcecast>& quantiles) {
            return sweep.of_quantiles({quantiles.data(), static_cast<std::size_t>(quantiles.size())});
          },
          "quantiles"_a)
      .def("_numbers", &Sweep::numbers)
      .def_property_readonly("_text", &Sweep::text)
      .def("__len__", &Sweep::contacts)
      .def_property_readonly("contacts", &Sweep::contacts)
      .def_property_readonly("endless", &Sweep::endless, "contacts beyond `contacts` exist")
      .def_property_readonly("seed", &Sweep::seed)
      .def_property_readonly("tactels", &Sweep::tactels)
      .def_property_readonly("axes", &Sweep::axes, "stresses of a tactel: 2; of a pad 3, or 1")
      .def_property_readonly("indenter_names", &Sweep::indenter_names)
      .def_property_readonly("warnings", &Sweep::warnings, "of numbers that look as if they had another unit")
      .def(
          "scene",
          [](const Sweep& sweep, std::uint64_t k) {
            return py::cast(sweep.pads() ? AnyScene{sweep.pad_scene(k)} : AnyScene{sweep.scene(k)});
          },
          "k"_a, "Returns contact k as a Scene.")
      .def(
          "_generate",
          [](const Sweep& sweep, std::optional<std::uint64_t> contacts, const py::dict& words, py::object progress) {
            const auto options = options_of<SweepOptions>(words);
            return Computation(std::move(progress)).run([&](const ProgressFunction& p) {
              return std::make_unique<Set>(sweep.generate(contacts, options, p));
            });
          },
          "contacts"_a, "words"_a, "progress"_a)
      .def(
          "_batches",
          [](const Sweep& sweep, std::uint64_t contacts, std::uint64_t first, bool whole, const py::dict& words,
             bool transducer) {
            auto options = options_of<SweepOptions>(words);
            options.transducer = transducer;
            return std::make_unique<Batches>(sweep, contacts, options, first, whole);
          },
          "contacts"_a, "first"_a, "whole"_a, "words"_a, "transducer"_a = true);
}

}  // namespace tactel::python
