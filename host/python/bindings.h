// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <tactel/pad.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <thread>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "fem/scenes/shape_numbers.h"

namespace tactel::python {

namespace py = pybind11;

void bind_errors(py::module_& module);
void bind_scenes(py::module_& module);
void bind_pads(py::module_& module);
void bind_convergence(py::module_& module);
void bind_pad_paths(py::module_& module);
void bind_solve(py::module_& module);
void bind_sweeps(py::module_& module);
void bind_networks(py::module_& module);
void bind_sources(py::module_& module);
void bind_steps(py::module_& module);

/// The class Scene of Python: of a line where its sensor is a Sensor, of a pad where it is a Pad.
struct AnyScene {
  std::variant<Scene, PadScene> of;
};

/// Returns a press on a pad. Throws InputError where it drags.
PadLoad on_pad(const Load& load);

/// The letters of a type of Python.
template <std::size_t n>
struct Letters {
  constexpr Letters(const char (&text)[n]) { std::ranges::copy(text, all); }  // NOLINT: a text is meant
  char all[n] = {};
};

/// A value whose type signatures, and so the stub, write in these letters: pybind11's own say less.
template <class Value, Letters letters>
struct Typed {
  Value value = {};
  operator Value() const { return value; }  // NOLINT: stands for its value
};

using Precision = Typed<std::string, "Literal['', 'fp32', 'fp64']">;
using OptionalDict = Typed<py::object, "dict[str, Any] | None">;

/// A file's name, of a str or an os.PathLike.
struct FileName : std::string {};

/// One number or several.
using Targets = std::variant<double, std::vector<double>>;

inline std::vector<double> list_of(Targets targets) {
  if (const double* one = std::get_if<double>(&targets)) return {*one};
  return std::get<std::vector<double>>(std::move(targets));
}

/// Binds a class of values whose fields have the names of its constructor's arguments.
template <class Value>
py::class_<Value> value_class(py::module_& module, const char* name, const char* doc,
                              std::initializer_list<const char*> fields) {
  py::class_<Value> bound(module, name, doc);
  py::list names;
  for (const char* field : fields) names.append(field);
  bound.attr("_fields") = py::tuple(names);
  return bound;
}

/// Adds the fields that the table of a struct has (fem/scenes/shape_numbers.h).
template <class T>
void add_fields(py::class_<T>& bound) {
  fem::each_number<T>([&](const auto& number) { bound.def_readonly(number.key, number.member, number.meaning); });
}

/// Binds a struct whose fields, units and defaults its table has.
template <class T>
py::class_<T> numbers_class(py::module_& module, const char* name, const char* doc) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    constexpr auto& all = fem::numbers<T>;
    std::string fields;
    const auto describe = [&](const std::string& key, const std::string& meaning) {
      if (!meaning.empty()) fields += (fields.empty() ? "" : "; ") + key + ": " + meaning;
    };
    (describe(std::get<i>(all).key, std::get<i>(all).meaning), ...);
    auto bound = value_class<T>(module, name, doc, {std::get<i>(all).key...});
    bound.def(py::init([](typename std::tuple_element_t<i, std::remove_cvref_t<decltype(all)>>::Value... values) {
                T made;
                ((made.*std::get<i>(fem::numbers<T>).member = std::move(values)), ...);
                return made;
              }),
              (py::arg(std::get<i>(all).key) = T{}.*std::get<i>(all).member)..., (fields + ".").c_str());
    add_fields(bound);
    return bound;
  }
  (std::make_index_sequence<std::tuple_size_v<std::remove_cvref_t<decltype(fem::numbers<T>)>>>{});
}

/// Binds every shape of a variant that has a table.
template <class... S>
void bind_shapes(py::module_& module, std::type_identity<std::variant<S...>>,
                 const std::array<fem::ShapeName, sizeof...(S)>& names) {
  const auto bind = [&module]<class T>(std::type_identity<T>, const fem::ShapeName& name) {
    if constexpr (!std::is_same_v<T, Profile> && !std::is_same_v<T, HeightMap>)
      numbers_class<T>(module, name.python, name.meaning);
  };
  std::size_t k = 0;
  (bind(std::type_identity<S>{}, names[k++]), ...);
}

/// Returns the numbers of a vector as an array [shape] without a copy. `owner` holds the vector, and lives as long as
/// the array.
template <class Number>
py::array_t<Number> view(const std::vector<Number>& numbers, const std::vector<py::ssize_t>& shape, py::handle owner) {
  return py::array_t<Number>(shape, numbers.data(), owner);
}

/// Getter of a vector that is a member of a bound class, as an array [size] without a copy.
template <class Owner, class Number>
auto column(std::vector<Number> Owner::*numbers) {
  return [numbers](const py::object& self) {
    const auto& all = self.cast<const Owner&>().*numbers;
    return view(all, {static_cast<py::ssize_t>(all.size())}, self);
  };
}

/// A computation without the interpreter lock, in the thread that makes it. Ctrl-C ends it soon, and so does an
/// exception of its progress function: run() raises it.
class Computation {
 public:
  /// `progress`: a Python function (done, all), or None.
  explicit Computation(py::object progress = py::none()) : progress_(std::move(progress)) {}
  /// Calls compute(ProgressFunction), or compute().
  template <class Compute>
  auto run(const Compute& compute) {
    const auto unlocked = [&] {
      const py::gil_scoped_release released;
      const CancelScope scope([](void* self) { return static_cast<Computation*>(self)->is_cancelled(); }, this);
      const auto progress = [this](std::uint64_t done, std::uint64_t all) { return goes_on(done, all); };
      if constexpr (std::is_invocable_v<Compute>)
        return compute();
      else
        return compute(ProgressFunction(progress));
    };
    try {
      if constexpr (std::is_void_v<decltype(unlocked())>) {
        unlocked();
        raise_seen();
      } else {
        auto made = unlocked();
        raise_seen();
        return made;
      }
    } catch (const Cancelled&) {
      raise_seen();
      throw;
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// Raises what a signal or the progress function raised, also at the very end.
  static void raise_seen() {
    if (PyErr_Occurred() != nullptr) throw py::error_already_set();
  }
  bool is_cancelled();
  bool goes_on(std::uint64_t done, std::uint64_t all);

  py::object progress_;
  std::thread::id own_ = std::this_thread::get_id();
  Clock::time_point looked_ = Clock::now();  ///< for a signal
  std::atomic<bool> cancelled_ = false;
};

/// The same without progress.
template <class Compute>
auto without_lock(const Compute& compute) {
  return Computation().run(compute);
}

/// Who may use an object that one thread uses at a time. Needs Python's lock.
class Turn {
 public:
  explicit Turn(const char* name) : name_(name) {}
  /// Throws InputError while another thread computes with the object.
  void check() const {
    if (taken_) throw InputError(name_, "a call while another thread is in one", "must wait for it, or make another");
  }
  template <class Compute>
  auto without_lock(const Compute& compute) {
    check();
    taken_ = true;
    const struct Given {
      bool& taken;
      ~Given() { taken = false; }
    } given{taken_};
    return python::without_lock(compute);
  }

 private:
  const char* name_;
  bool taken_ = false;
};

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

template <class Value, tactel::python::Letters letters>
struct pybind11::detail::type_caster<tactel::python::Typed<Value, letters>> {
  using Typed = tactel::python::Typed<Value, letters>;
  PYBIND11_TYPE_CASTER(Typed, const_name(letters.all));
  bool load(handle source, bool convert) {
    make_caster<Value> caster;
    if (!caster.load(source, convert)) return false;
    value.value = cast_op<Value>(std::move(caster));
    return true;
  }
  static handle cast(Typed typed, return_value_policy policy, handle parent) {
    return make_caster<Value>::cast(std::move(typed.value), policy, parent);
  }
};

template <>
struct pybind11::detail::type_caster<tactel::python::FileName> {
  PYBIND11_TYPE_CASTER(tactel::python::FileName, const_name("str | os.PathLike[str]"));
  bool load(handle source, bool convert) {
    const object name = reinterpret_steal<object>(PyOS_FSPath(source.ptr()));
    PyErr_Clear();
    make_caster<std::string> text;
    if (!name || !text.load(name, convert)) return false;
    value.assign(cast_op<std::string&>(text));
    return true;
  }
};
