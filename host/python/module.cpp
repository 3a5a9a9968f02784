// SPDX-License-Identifier: Apache-2.0
#include <tactel/error.h>
#include <tactel/infer.h>

#include "host/python/array_check.h"
#include "host/python/bindings.h"

namespace tactel::python {

using namespace pybind11::literals;

// The interpreter's error indicator belongs to this thread: it survives until run().
bool Computation::goes_on(std::uint64_t done, std::uint64_t all) {
  const py::gil_scoped_acquire held;
  looked_ = Clock::now();
  if (cancelled_ || PyErr_CheckSignals() != 0) return !(cancelled_ = true);
  if (progress_.is_none()) return true;
  try {
    progress_(done, all);
    return true;
  } catch (py::error_already_set& error) {
    error.restore();
    return !(cancelled_ = true);
  }
}

// Only this thread may look for signals: others see what it saw.
bool Computation::is_cancelled() {
  constexpr std::chrono::milliseconds between_looks{50};
  if (cancelled_ || std::this_thread::get_id() != own_ || Clock::now() - looked_ < between_looks) return cancelled_;
  const py::gil_scoped_acquire held;
  looked_ = Clock::now();
  return cancelled_ = PyErr_CheckSignals() != 0;
}

void bind_errors(py::module_& module) {
  static py::exception<Error> base(module, "Error", PyExc_RuntimeError);
  // A ValueError and a TypeError too: what Python's own functions raise for a wrong value, and for a wrong argument.
  const py::tuple bases = py::make_tuple(base, py::handle(PyExc_ValueError), py::handle(PyExc_TypeError));
  const py::dict types("place"_a = "str", "problem"_a = "str", "fix"_a = "str");
  const py::dict members("__annotations__"_a = types);
  // Never freed: the interpreter may be gone when the library is unloaded.
  static const py::handle input = PyErr_NewExceptionWithDoc(
      "tactel.InputError",
      "A file, value or call that cannot be used. place: file and line, or key; problem: the value; fix: "
      "what is allowed.",
      bases.ptr(), members.ptr());
  module.attr("InputError") = input;
  static py::exception<HardwareError> hardware(module, "HardwareError", base);
  static py::exception<Cancelled> cancelled(module, "Cancelled", base);
  base.doc() = "Base of the errors of this package.";
  hardware.doc() = "No OpenCL device, a kernel that it cannot compile, or a sensor that cannot be used.";
  cancelled.doc() = "Raised where a progress function cancelled.";
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const InputError& error) {
      const py::object raised = input(error.what());
      raised.attr("place") = error.place;
      raised.attr("problem") = error.problem;
      raised.attr("fix") = error.fix;
      PyErr_SetObject(input.ptr(), raised.ptr());
    } catch (const HardwareError& error) {
      PyErr_SetString(hardware.ptr(), error.what());
    } catch (const Cancelled& error) {
      PyErr_SetString(cancelled.ptr(), error.what());
    } catch (const Error& error) {
      PyErr_SetString(base.ptr(), error.what());
    }
  });
}

}  // namespace tactel::python

PYBIND11_MODULE(_tactel, module) {
  using namespace tactel::python;
  check_arrays();
  module.doc() = "The C++ library tactel::simulate for Python; use the package tactel.";
  module.attr("__version__") = tactel::version();
  bind_errors(module);
  bind_pads(module);
  bind_scenes(module);
  bind_convergence(module);
  bind_pad_paths(module);
  bind_solve(module);
  bind_sweeps(module);
  bind_networks(module);
  bind_sources(module);
  bind_steps(module);
}
