// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/python/bindings.h"

namespace tactel::python {

/// Takes what a call gives by this name, where it does. Throws TypeError for another type.
template <class M>
void take(const py::dict& words, const std::string& name, M& value) {
  if (!words.contains(name)) return;
  py::detail::make_caster<M> caster;
  if (!caster.load(words[name.c_str()], true)) throw py::type_error("incompatible function arguments: " + name);
  value = py::detail::cast_op<M>(std::move(caster));
}

/// The options of a solve or a sweep that are among these words.
template <class Options>
Options options_of(const py::dict& words) {
  Options options;
  take(words, "accuracy", options.accuracy);
  take(words, "rung", options.rung);
  take(words, "precision", options.precision);
  take(words, "device", options.device);
  take(words, "tolerance", options.tolerance);
  return options;
}

}  // namespace tactel::python
