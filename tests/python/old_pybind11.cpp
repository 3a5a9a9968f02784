// SPDX-License-Identifier: Apache-2.0

// A module by pybind11 2.10, which knows no NumPy 2.
#include <pybind11/pybind11.h>

#include "host/python/array_check.h"

PYBIND11_MODULE(old_pybind11, module) {
  module.doc() = "Loads under NumPy 1 alone.";
  tactel::python::check_arrays();
}
