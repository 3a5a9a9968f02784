// SPDX-License-Identifier: Apache-2.0
#include <tactel/live.h>

#include "host/python/bindings.h"

namespace tactel::python {
namespace {

using namespace pybind11::literals;

/// A frame whose stresses are its own.
struct OwnFrame {
  std::vector<float> stress;
  std::uint64_t number;
  std::optional<double> device_time;
  double arrival;
};

OwnFrame own(const Frame& frame) {
  return {{frame.stress.begin(), frame.stress.end()}, frame.number, frame.device_time, frame.arrival};
}

/// A source that may be closed.
class Source {
 public:
  Source(const std::string& name, const std::string& profile, const std::string& calibration)
      : source_(FrameSource::open(name, profile, calibration)) {}
  FrameSource& open() {
    if (!source_) throw InputError("sensor", "closed", "a source that is open");
    return *source_;
  }
  void close() { source_.reset(); }
  /// Waits in pieces, so that Ctrl-C is taken.
  OwnFrame next() {
    Frame frame;
    while (!wait(frame, 0.1))
      if (open().finished()) throw py::stop_iteration();
    return own(frame);
  }
  std::optional<OwnFrame> read(double seconds) {
    Frame frame;
    for (double left = seconds; !wait(frame, std::min(left, 0.1)); left -= 0.1)
      if (left <= 0.1 || open().finished()) return std::nullopt;
    return own(frame);
  }

 private:
  bool wait(Frame& frame, double seconds) {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    FrameSource& source = open();
    const py::gil_scoped_release released;
    return source.wait(frame, seconds);
  }
  std::optional<FrameSource> source_;
};

Source& itself(Source& source) { return source; }

Typed<py::dict, "dict[str, int]"> counts_of(Source& source) {
  const FrameCounts counts = source.open().counts();
  return {py::dict("frames"_a = counts.frames, "lost"_a = counts.lost, "bad"_a = counts.bad,
                   "resynchronised"_a = counts.resynchronised, "overruns"_a = counts.overruns,
                   "stalls"_a = counts.stalls, "errors"_a = counts.errors, "reconnects"_a = counts.reconnects)};
}

}  // namespace

void bind_sources(py::module_& m) {
  py::class_<OwnFrame>(m, "Frame", "A frame of a sensor. Networks take it as it is.")
      .def_property_readonly("stress", column(&OwnFrame::stress),
                             "[2 tactels] MPa, fp32: normal stresses (compression < 0), then shear")
      .def("__array__",
           [](const py::object& self, const py::args&, const py::kwargs&) { return column(&OwnFrame::stress)(self); })
      .def_readonly("number", &OwnFrame::number, "from 0, in the order of decoding")
      .def_readonly("device_time", &OwnFrame::device_time, "s by the device's clock; None without one")
      .def_readonly("arrival", &OwnFrame::arrival, "s since the source was opened");
  py::class_<Source>(m, "Stream", "Frames of a sensor: iterate over it, in a with statement.")
      .def("__enter__", &itself, py::return_value_policy::reference)
      .def("__exit__", [](Source& source, const py::args&) { source.close(); })
      .def("__iter__", &itself, py::return_value_policy::reference)
      .def("__next__", &Source::next)
      .def("read", &Source::read, "seconds"_a = 0.0,
           "Returns the next frame, waiting up to `seconds`; None where none came.")
      .def(
          "fileno", [](Source& source) { return source.open().fd(); },
          "Returns the descriptor that is readable where frames wait, for select and asyncio.")
      .def("close", &Source::close)
      .def_property_readonly("finished", [](Source& source) { return source.open().finished(); })
      .def_property_readonly(
          "inputs", [](Source& source) { return source.open().inputs(); }, "2 tactels")
      .def_property_readonly("tactels", [](Source& source) { return source.open().tactels(); })
      .def_property_readonly("note", [](Source& source) { return source.open().note(); })
      .def_property_readonly("counts", &counts_of,
                             "frames, lost, bad, resynchronised, overruns, stalls, errors, reconnects");
  m.def("_read_profile", [](const std::string& name) {
    const DeviceProfile read = read_profile(name);
    return py::dict("text"_a = read.text, "channel"_a = read.channel, "offset"_a = read.offset, "gain"_a = read.gain,
                    "noise"_a = read.noise, "pads"_a = read.pads);
  });
  m.def(
      "open_sensor",
      [](const std::string& source, const FileName& profile, const FileName& calibration) {
        return std::make_unique<Source>(source, profile, calibration);
      },
      "source"_a, "profile"_a = "", "calibration"_a = "",
      "Opens \"usb:glove\", \"usb:VID:PID\" with a profile, \"csv:FILE\" with a profile, \"replay:FILE\" or "
      "\"simulate:SCENE.toml?rate=100\". "
      "Raises InputError, "
      "HardwareError.");
}

}  // namespace tactel::python
