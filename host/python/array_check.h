// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pybind11/numpy.h>

#include <string>

namespace tactel::python {

/// Throws ImportError where arrays of this build do not fit the NumPy that is there. pybind11 before 2.12 reads the
/// size of a number from another place than NumPy 2 has it, and makes arrays of stride 0: all numbers are the first.
inline void check_arrays() {
  namespace py = pybind11;
  const py::array_t<double> array(2);
  if (array.strides(0) == sizeof(double)) return;
  throw py::import_error("tactel: its build, by pybind11 " + std::to_string(PYBIND11_VERSION_MAJOR) + "." +
                         std::to_string(PYBIND11_VERSION_MINOR) + ", does not fit NumPy " +
                         py::module_::import("numpy").attr("__version__").cast<std::string>() +
                         "; build it with a newer pybind11 (at least 2.12 for NumPy 2)");
}

}  // namespace tactel::python
