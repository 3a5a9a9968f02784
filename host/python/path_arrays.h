// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <string_view>
#include <tuple>

#include "host/answers/quantities.h"
#include "host/python/bindings.h"

// The quantities of the steps of an answer, host/answers/quantities.h, as arrays.

namespace tactel::python {

template <class Value>
concept List = requires(const Value& value) {
  value.size();
};

/// The number in an array of a value that is no list.
template <class Value>
struct NumberOf {
  using type = Value;
};
template <>
struct NumberOf<NodeStatus> {
  using type = std::uint8_t;
};
template <List Value>
struct NumberOf<Value> : NumberOf<typename Value::value_type> {};
template <class Value>
requires requires(const Value& value) { host::residuals(value); }
struct NumberOf<Value> {
  using type = double;  // the largest
};

/// Appends the extents of a value: none of a number.
template <class Value>
void add_extents(const Value& value, std::vector<py::ssize_t>& shape) {
  if constexpr (List<Value>) {
    shape.push_back(static_cast<py::ssize_t>(value.size()));
    add_extents(typename Value::value_type{}, shape);
  }
}

/// Writes the numbers of a value, and returns the place behind them.
template <class Value, class Number>
Number* put_numbers(const Value& value, Number* to) {
  if constexpr (List<Value>) {
    for (const auto& part : value) to = put_numbers(part, to);
  } else if constexpr (requires { host::residuals(value); }) {
    *to = 0;
    host::each(host::residuals(value), [&](const auto& law) { *to = std::max(*to, law.value); });
    ++to;
  } else {
    *to++ = static_cast<Number>(value);
  }
  return to;
}

/// One value of every step of a path, [steps] and the extents of the value. `member(step)` returns it.
template <class Path, class Member>
auto of_steps(const Path& path, const Member& member) {
  using Step = typename decltype(path.steps)::value_type;
  using Value = std::remove_cvref_t<decltype(member(std::declval<const Step&>()))>;
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(path.steps.size())};
  const Step none{};
  add_extents(member(path.steps.empty() ? none : path.steps.front()), shape);
  py::array_t<typename NumberOf<Value>::type> all(shape);
  auto* to = all.mutable_data();
  for (const Step& step : path.steps) to = put_numbers(member(step), to);
  return all;
}

/// Text of an attribute: "[steps, 2] N along x, y".
template <class Value>
std::string doc_of(const host::Quantity<Value>& quantity, const char* axes) {
  const std::string extent = quantity.extent;
  return std::string("[") + axes + (extent.empty() ? "" : ", ") + extent + "] " + quantity.unit + quantity.meaning;
}

/// Calls visit.operator()<i>(quantity) for the quantities of a table but for the stresses of tactels.
template <class Table, class Visit>
void each_numbered(const Table& table, const Visit& visit) {
  const auto one = [&]<std::size_t i>() {
    if (std::string_view(std::get<i>(table).extent) != "tactels") visit.template operator()<i>(std::get<i>(table));
  };
  [&]<std::size_t... i>(std::index_sequence<i...>) { (one.template operator()<i>(), ...); }
  (std::make_index_sequence<std::tuple_size_v<Table>>());
}

/// Binds the quantities of the steps of a path.
template <class Path>
void bind_steps(py::class_<Path>& path) {
  using Step = typename decltype(Path::steps)::value_type;
  const Step any{};
  each_numbered(host::quantities<false>(any), [&]<std::size_t i>(const auto& quantity) {
    path.def_property_readonly(
        quantity.key,
        [](const Path& self) {
          return of_steps(
              self, [](const Step& step) -> const auto& { return std::get<i>(host::quantities<false>(step)).value; });
        },
        doc_of(quantity, "steps").c_str());
  });
}

/// Binds those of the steps of many scenes, as views.
template <class Paths>
void bind_many_steps(py::class_<Paths>& paths) {
  const Paths any{};
  each_numbered(host::quantities<true>(any), [&]<std::size_t i>(const auto& quantity) {
    const bool pairs = quantity.extent == std::string_view("2");
    paths.def_property_readonly(
        quantity.key,
        [pairs](const py::object& self) {
          const auto& all = self.cast<const Paths&>();
          std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(all.scenes), static_cast<py::ssize_t>(all.steps)};
          if (pairs) shape.push_back(2);
          return view(std::get<i>(host::quantities<true>(all)).value, shape, self);
        },
        doc_of(quantity, "scenes, steps").c_str());
  });
}

/// Stresses of every step, fp32, as networks take them: [steps, stresses of a tactel times tactels].
template <class Path, class Step>
py::array_t<float> frames_of(const Path& path, std::initializer_list<std::vector<double> Step::*> stresses,
                             std::size_t tactels) {
  py::array_t<float> frames({path.steps.size(), stresses.size() * tactels});
  float* to = frames.mutable_data();
  for (const Step& step : path.steps)
    for (const auto stress : stresses) to = put_numbers(step.*stress, to);
  return frames;
}
/// The same of many scenes, [scenes, steps, ...].
template <class Paths>
py::array_t<float> frames_of(const Paths& all, std::initializer_list<std::vector<double> Paths::*> stresses,
                             std::size_t tactels) {
  py::array_t<float> frames({all.scenes, all.steps, stresses.size() * tactels});
  float* to = frames.mutable_data();
  for (std::size_t row = 0; row < all.scenes * all.steps; ++row)
    for (const auto stress : stresses)
      for (std::size_t i = 0; i < tactels; ++i) *to++ = static_cast<float>((all.*stress)[row * tactels + i]);
  return frames;
}

/// A pandas.DataFrame of the numbers of every step; of pairs a column each, "Q_x" and "Q_y". attrs["units"] has those
/// of the columns.
template <class Path>
py::object to_pandas(const py::object& path) {
  using Step = typename decltype(Path::steps)::value_type;
  py::dict columns, units;
  const Step any{};
  each_numbered(host::quantities<false>(any), [&]<std::size_t>(const auto& quantity) {
    const std::string extent = quantity.extent, key = quantity.key;
    const py::object values = path.attr(key.c_str());
    const auto put = [&](const std::string& name, const py::object& column) {
      columns[name.c_str()] = column, units[name.c_str()] = quantity.unit;
    };
    if (extent.empty()) put(key, values);
    for (const int axis : {0, 1})
      if (extent == "2") put(key + (axis == 0 ? "_x" : "_y"), values[py::make_tuple(py::ellipsis(), axis)]);
  });
  try {
    const py::object frame = py::module_::import("pandas").attr("DataFrame")(columns);
    frame.attr("attrs")["units"] = units;
    return frame;
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_ImportError)) throw;
    throw InputError("pandas", "not installed", "install it: pip install pandas");
  }
}

/// Pages, files and tables of an answer.
template <class Path>
void bind_pictures(py::class_<Path>& path) {
  using namespace pybind11::literals;
  path.def(
          "json", [](const Path& self) { return json(self); }, "Returns the text of `tactel solve --json`.")
      .def("to_pandas", &to_pandas<Path>,
           "Returns a pandas.DataFrame: a row a step; attrs[\"units\"] has the units of its columns.")
      .def(
          "converge",
          [](const Path& self, std::optional<std::size_t> step) {
            return without_lock([&] { return converge(self, step); });
          },
          "step"_a = py::none(),
          "Solves the scene on ever smaller cells, as `tactel solve --converge`, and judges a step, from 0 (None: the "
          "last that sticks and slips). Takes seconds to minutes.");
  path.def(
          "html", [](const Path& self, std::optional<std::size_t> step) { return html(self, step); },
          py::call_guard<py::gil_scoped_release>(), "step"_a = py::none(),
          "Returns the page of `tactel solve --html`, with this step first, from 0 (None: the last that sticks and "
          "slips).")
      .def(
          "to_html",
          [](const Path& self, const FileName& file, std::optional<std::size_t> step) { to_html(self, file, step); },
          py::call_guard<py::gil_scoped_release>(), "file"_a, "step"_a = py::none(), "Writes that page to a file.")
      .def(
          "to_vtu",
          [](const Path& self, const FileName& file, std::optional<std::size_t> step) { to_vtu(self, file, step); },
          py::call_guard<py::gil_scoped_release>(), "file"_a, "step"_a = py::none(),
          "Writes the VTK file of `tactel solve --field` of a step (None: the last), for ParaView. Of a pad a name "
          "that "
          "ends in .vts takes the rubber, in .vtu the cells.");
}

/// Binds all that answers of lines and of pads have alike. `name`: of the class.
template <class Path>
void bind_solved(py::class_<Path>& path, const std::string& name) {
  bind_pictures(path);
  bind_steps(path);
  path.def("__len__", [](const Path& path) { return path.steps.size(); })
      .def_readonly("fell_back", &Path::fell_back, "the exact fallback answered")
      .def_readonly("model", &Path::model)
      .def_readonly("precision", &Path::precision)
      .def_readonly("device", &Path::device)
      .def_readonly("warnings", &Path::warnings)
      .def("__repr__", [name](const Path& path) {
        return "<tactel." + name + ": " + std::to_string(path.steps.size()) + " steps, " + path.model + ">";
      });
}
/// The same of many scenes.
template <class Paths>
void bind_many_solved(py::class_<Paths>& paths) {
  bind_many_steps(paths);
  paths.def("__len__", [](const Paths& all) { return all.scenes; })
      .def_property_readonly("steps_made", column(&Paths::steps_made), "[scenes] load steps of each scene")
      .def_property_readonly("fell_back", column(&Paths::fell_back), "[scenes] 1: the exact fallback answered")
      .def_readonly("rung", &Paths::rung)
      .def_readonly("precision", &Paths::precision)
      .def_readonly("device", &Paths::device)
      .def_readonly("warnings", &Paths::warnings, "of numbers that look as if they had another unit");
}

}  // namespace tactel::python
