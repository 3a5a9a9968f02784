// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>

#include "host/python/bindings.h"

// The members of the steps of a Path or PadPath as arrays.

namespace tactel::python {

/// One number of every step of a path, [steps].
template <class Path, class Step, class Number>
py::array_t<Number> of_steps(const Path& path, Number Step::*number) {
  py::array_t<Number> all(static_cast<py::ssize_t>(path.steps.size()));
  std::ranges::transform(path.steps, all.mutable_data(), [&](const Step& step) { return step.*number; });
  return all;
}

/// One array of every step, [steps, n].
template <class Path, class Step>
py::array_t<double> of_steps(const Path& path, std::vector<double> Step::*numbers) {
  const std::size_t columns = path.steps.empty() ? 0 : (path.steps.front().*numbers).size();
  py::array_t<double> all({path.steps.size(), columns});
  double* to = all.mutable_data();
  for (const Step& step : path.steps) to = std::ranges::copy(step.*numbers, to).out;
  return all;
}

/// Two numbers of every step, [steps, 2].
template <class Path, class Step>
py::array_t<double> of_steps(const Path& path, std::array<double, 2> Step::*both) {
  py::array_t<double> all({path.steps.size(), std::size_t{2}});
  double* to = all.mutable_data();
  for (const Step& step : path.steps) to = std::ranges::copy(step.*both, to).out;
  return all;
}

/// Pairs of every step, [steps, n, 2].
template <class Path, class Step>
py::array_t<double> of_steps(const Path& path, std::vector<std::array<double, 2>> Step::*pairs) {
  const std::size_t columns = path.steps.empty() ? 0 : (path.steps.front().*pairs).size();
  py::array_t<double> all({path.steps.size(), columns, std::size_t{2}});
  double* to = all.mutable_data();
  for (const Step& step : path.steps)
    for (const auto& pair : step.*pairs) to = std::ranges::copy(pair, to).out;
  return all;
}

/// Statuses of every step, [steps, n].
template <class Path, class Step>
py::array_t<std::uint8_t> of_steps(const Path& path, std::vector<NodeStatus> Step::*status) {
  const std::size_t columns = path.steps.empty() ? 0 : (path.steps.front().*status).size();
  py::array_t<std::uint8_t> all({path.steps.size(), columns});
  std::uint8_t* to = all.mutable_data();
  for (const Step& step : path.steps)
    to = std::ranges::transform(step.*status, to, [](NodeStatus s) { return static_cast<std::uint8_t>(s); }).out;
  return all;
}

/// Getter of a member of the steps of a path.
template <class Path, auto Member>
auto steps_property() {
  return [](const Path& path) { return of_steps(path, Member); };
}

/// Pages and VTK files of an answer.
template <class Path>
void bind_pictures(py::class_<Path>& path) {
  using namespace pybind11::literals;
  path.def(
          "html", [](const Path& self, std::optional<std::size_t> step) { return html(self, step); },
          "step"_a = py::none(),
          "Returns the page of `tactel solve --html`, with this step first, from 0 (None: the last that sticks and "
          "slips).")
      .def(
          "to_html",
          [](const Path& self, const FileName& file, std::optional<std::size_t> step) { to_html(self, file, step); },
          "file"_a, "step"_a = py::none(), "Writes that page to a file.")
      .def(
          "to_vtu",
          [](const Path& self, const FileName& file, std::optional<std::size_t> step) { to_vtu(self, file, step); },
          "file"_a, "step"_a = py::none(),
          "Writes the VTK file of `tactel solve --field` of a step (None: the last), for ParaView.");
}

}  // namespace tactel::python
