// SPDX-License-Identifier: Apache-2.0
#include <tactel/live.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "host/python/bindings.h"
#include "host/training/train_options.h"

namespace tactel::python {
namespace {

using namespace pybind11::literals;
using Frames = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Answers to frames [inputs] or [n, inputs]; `write` receives the answers in order.
void estimate(const SlipEstimator& network, const Frames& frames, std::vector<Answer>& answers) {
  const auto inputs = static_cast<py::ssize_t>(network.inputs());
  if (frames.ndim() < 1 || frames.shape(frames.ndim() - 1) != inputs)
    throw InputError("frames", "an array of another shape", "[..., " + std::to_string(inputs) + "]");
  answers.resize(static_cast<std::size_t>(frames.size() / inputs));
  const std::span<const float> numbers(frames.data(), static_cast<std::size_t>(frames.size()));
  const py::gil_scoped_release released;
  network.estimate(numbers, answers);
}

std::vector<py::ssize_t> leading_shape(const Frames& frames) {
  return {frames.shape(), frames.shape() + frames.ndim() - 1};
}

py::object call(const SlipEstimator& network, const Frames& frames) {
  std::vector<Answer> answers;
  estimate(network, frames, answers);
  if (frames.ndim() == 1) return py::float_(answers.front().slip_index);
  py::array_t<float> s(leading_shape(frames));
  std::ranges::transform(answers, s.mutable_data(), &Answer::slip_index);
  return s;
}

py::array_t<std::uint32_t> statuses(const SlipEstimator& network, const Frames& frames) {
  std::vector<Answer> answers;
  estimate(network, frames, answers);
  py::array_t<std::uint32_t> all(leading_shape(frames));
  std::ranges::transform(answers, all.mutable_data(),
                         [](const Answer& a) { return static_cast<std::uint32_t>(a.status); });
  return all;
}

/// Numbers of the answers in order, in the shape of the frames without their last axis, and `more` behind it.
template <class Number, class Take>
py::array_t<Number> taken(const SlipEstimator& network, const Frames& frames, std::vector<py::ssize_t> more,
                          const Take& take) {
  std::vector<Answer> answers;
  estimate(network, frames, answers);
  std::vector<py::ssize_t> shape = leading_shape(frames);
  shape.insert(shape.end(), more.begin(), more.end());
  py::array_t<Number> all(shape);
  Number* to = all.mutable_data();
  for (const Answer& answer : answers) take(answer, to);
  return all;
}

/// A number as float. One beyond its range would become infinity, which means "never".
float narrow(const char* name, double value) {
  const auto narrowed = static_cast<float>(value);
  if (std::isfinite(value) && !std::isfinite(narrowed))
    throw InputError(name, std::to_string(value), "must be a number of single precision, or infinity");
  return narrowed;
}

/// The numbers of one frame.
std::span<const float> numbers_of(const char* name, const Frames& frame, std::size_t inputs) {
  if (frame.ndim() != 1 || static_cast<std::size_t>(frame.size()) != inputs)
    throw InputError(name, "an array of another shape", "[" + std::to_string(inputs) + "]");
  return {frame.data(), inputs};
}

std::vector<Answer> next_answers(LiveEstimator& estimator, const Frames& frames) {
  const std::span<const float> numbers = numbers_of("frames", frames, estimator.inputs());
  std::vector<Answer> answers(estimator.sensors());
  const py::gil_scoped_release released;
  estimator.estimate(numbers, answers);
  return answers;
}

/// The class Alarm of Python: a device may answer its frames.
struct OwnAlarm {
  Alarm alarm;
  std::unique_ptr<LiveEstimator> estimator{};  ///< on a device; none: host code

  AlarmAnswer next(const Frames& frame, std::optional<Answer> answer) {
    const std::span<const float> numbers = numbers_of("frame", frame, alarm.inputs());
    if (!answer && !estimator) return alarm.next(numbers);
    if (!answer) answer = next_answers(*estimator, frame).front();
    return alarm.judge(alarm.answer(numbers, *answer));
  }
  void friction(double mu, double spread) {
    alarm.friction(mu, spread);
    if (estimator) estimator->friction(static_cast<float>(mu), static_cast<float>(spread));
  }
  float slides() { return estimator ? estimator->slides(0) : alarm.slides(); }
  void rest() {
    alarm.rest();
    if (estimator) estimator->rest();
  }
  void clear() {
    alarm.clear();
    if (estimator) estimator->clear();
  }
};

using AnyNetwork = std::optional<std::variant<const Network*, const SlipEstimator*>>;

std::unique_ptr<OwnAlarm> alarm_of(const AnyNetwork& network, std::optional<double> at, std::optional<double> touch,
                                   std::optional<double> widest, int hold, bool ignore_unlike,
                                   const std::string& device, bool rest, std::optional<std::string> signal,
                                   std::optional<std::size_t> tactels, std::size_t axes, double rate,
                                   std::size_t columns, double aspect, const std::vector<float>& covariance,
                                   double held_at, double slide) {
  AlarmOptions options{.touch = touch, .hold = hold, .ignore_unlike = ignore_unlike, .rest = rest};
  if (at) options.at = narrow("at", *at);
  if (widest) options.widest = narrow("widest", *widest);
  const std::map<std::string, AlarmSignal> signals{
      {"slip", AlarmSignal::slip}, {"moved", AlarmSignal::moved}, {"left", AlarmSignal::left}};
  const std::string judged = signal.value_or(network ? "slip" : at ? "moved" : "left");
  if (!signals.contains(judged)) throw InputError("signal", judged, "slip, moved or left");
  options.signal = signals.at(judged);
  options.rate = rate, options.columns = columns, options.aspect = aspect;
  options.held.at = narrow("held_at", held_at), options.slide = narrow("slide", slide);
  if (covariance.size() > options.held.covariance.size())
    throw InputError("covariance", std::to_string(covariance.size()) + " numbers", "at most 36, as [hold] has them");
  std::ranges::copy(covariance, options.held.covariance.begin());
  if (network.has_value() == tactels.has_value())
    throw InputError("network", network ? "given with tactels" : "none", "give it, or tactels and axes of a frame");
  if (!network && !device.empty()) throw InputError("device", device, "leave it out without a network");
  if (!network) return std::unique_ptr<OwnAlarm>(new OwnAlarm{Alarm(*tactels, axes, options)});
  const Network* const* trained = std::get_if<const Network*>(&*network);
  if (!trained && !device.empty())
    throw InputError("network", "a SlipEstimator on a device", "give a Network: Network.load(path)");
  std::unique_ptr<OwnAlarm> made(
      new OwnAlarm{Alarm(trained ? (*trained)->estimator() : *std::get<const SlipEstimator*>(*network), options)});
  if (!device.empty())
    made->estimator =
        without_lock([&] { return std::make_unique<LiveEstimator>(std::vector{**trained}, device, touch); });
  return made;
}

/// Binds the fields of an Answer, which `answer_of` takes from an object.
template <class Said, class Take>
void bind_answer(py::class_<Said>& bound, const Take& answer_of) {
  const auto field = [&](const char* name, auto read, const char* doc) {
    bound.def_property_readonly(
        name, [=](const Said& said) { return read(answer_of(said)); }, doc);
  };
  field(
      "slip_index", [](const Answer& a) { return a.slip_index; }, "S; NaN without contact or answer");
  field(
      "slip_upper", [](const Answer& a) { return a.slip_upper; }, "upper bound of S; NaN without a bound");
  field(
      "slip_interval", [](const Answer& a) { return std::pair(a.slip_interval[0], a.slip_interval[1]); },
      "interval of S; NaN without a bound");
  field(
      "unlike", [](const Answer& a) { return a.unlike != 0; }, "unlike all that was learnt");
  field(
      "beyond_learnt", [](const Answer& a) { return a.beyond_learnt != 0; },
      "a normal stress is above 10 times the largest that was learnt: are they MPa?");
  field(
      "status", [](const Answer& a) { return name(a.status); },
      "\"ok\", \"no stress\", \"not finite\" or \"overflow\"");
}

std::string text_of(const AlarmAnswer& said) {
  const auto text = [](const py::object& value) { return py::str(value).cast<std::string>(); };
  const auto number = [&](float value) { return text(py::str("{:.4g}").format(value)); };
  const auto boolean = [](bool value) { return value ? "True" : "False"; };
  const Answer& answer = said.answer;
  std::string all = "AlarmAnswer(slip_index=" + number(answer.slip_index);
  if (!std::isnan(answer.slip_interval[1]))
    all += ", slip_upper=" + number(answer.slip_upper) + ", slip_interval=(" + number(answer.slip_interval[0]) + ", " +
           number(answer.slip_interval[1]) + "), unlike=" + boolean(answer.unlike != 0);
  all += std::string(", contact=") + (said.contact ? boolean(*said.contact) : "None");
  if (said.rest) all += std::string(", rest=") + boolean(*said.rest) + ", moved=" + number(said.moved);
  if (!std::isnan(said.left)) all += ", left=" + number(said.left);
  all += std::string(", on=") + boolean(said.on) + ", cannot_tell=" + boolean(said.cannot_tell);
  if (answer.status != AnswerStatus::ok) all += std::string(", status='") + name(answer.status) + "'";
  return all + ")";
}

/// A value for all hidden layers, or one for each.
template <class Value>
using OneOrEach = std::variant<Value, std::vector<Value>>;

template <class Value>
Value of_layer(const OneOrEach<Value>& values, std::size_t layer, const char* name) {
  if (const Value* const one = std::get_if<Value>(&values)) return *one;
  const auto& each = std::get<std::vector<Value>>(values);
  if (layer >= each.size())
    throw InputError(name, std::to_string(each.size()) + " values", "one for each hidden layer");
  return each[layer];
}

Network from_arrays(const std::vector<Frames>& weights, const std::vector<Frames>& biases,
                    const OneOrEach<std::string>& activation, const OneOrEach<double>& slope, std::string scaling,
                    double largest_stress, int axes, std::string history, std::optional<double> history_change,
                    std::string name, std::string target) {
  if (weights.size() != biases.size())
    throw InputError("biases", std::to_string(biases.size()) + " arrays", "one for each of weights");
  std::vector<DenseLayer> layers;
  for (std::size_t l = 0; l < weights.size(); ++l) {
    const Frames &w = weights[l], &b = biases[l];
    if (w.ndim() != 2) throw InputError("weights", std::to_string(w.ndim()) + " axes", "arrays [out, in]");
    layers.push_back({static_cast<std::size_t>(w.shape(1)),
                      static_cast<std::size_t>(w.shape(0)),
                      {w.data(), w.data() + w.size()},
                      {b.data(), b.data() + b.size()},
                      l + 1 < weights.size() ? of_layer(activation, l, "activation") : "sigmoid",
                      l + 1 < weights.size() ? of_layer(slope, l, "slope") : 0});
  }
  return Network::from_layers(layers, {std::move(scaling), largest_stress, axes, std::move(history), history_change,
                                       std::move(name), std::move(target)});
}

/// The options of a training that are among these words.
TrainOptions train_options_of(const py::dict& words) {
  TrainOptions options;
  host::each(host::train_options, [&]<class Owner, class M>(const host::Option<Owner, M>& option) {
    if constexpr (std::is_same_v<Owner, TrainOptions>) take(words, option.key(), options.*option.member);
  });
  return options;
}

}  // namespace

void bind_networks(py::module_& m) {
  py::class_<Errors>(m, "Errors", "Errors |S of a network - S of a set|.")
      .def_readonly("mean", &Errors::mean)
      .def_readonly("largest", &Errors::largest)
      .def_readonly("deviation", &Errors::deviation)
      .def_readonly("rows", &Errors::rows)
      .def("__repr__", [](const Errors& e) {
        return "<tactel.Errors: mean " + std::to_string(e.mean) + ", largest " + std::to_string(e.largest) + " on " +
               std::to_string(e.rows) + " rows>";
      });
  py::class_<SlipEstimator>(m, "SlipEstimator",
                            "A loaded network: frames to S. It never changes: threads may share it.")
      .def_static(
          "load", [](const FileName& path) { return SlipEstimator::load(path); }, "path"_a,
          "Loads a network file (ONNX) that tactel wrote.")
      .def("__call__", &call, "frames"_a,
           "Returns S of a frame [2 tactels], or of frames [..., 2 tactels] as fp32. MPa, normal stresses (compression "
           "< 0) "
           "first, then shear. NaN where there is no answer.")
      .def("status", &statuses, "frames"_a,
           "Returns the status of each answer: 0 ok, 1 no stress, 2 not finite, 3 overflow.")
      .def(
          "upper",
          [](const SlipEstimator& network, const Frames& frames) {
            return taken<float>(network, frames, {}, [](const Answer& a, float*& to) { *to++ = a.slip_upper; });
          },
          "frames"_a, "Returns the upper bound of S of each frame; NaN of a network without a bound.")
      .def(
          "interval",
          [](const SlipEstimator& network, const Frames& frames) {
            return taken<float>(network, frames, {2}, [](const Answer& a, float*& to) {
              *to++ = a.slip_interval[0];
              *to++ = a.slip_interval[1];
            });
          },
          "frames"_a, "Returns the interval of S of each frame [..., 2]; NaN of a network without a bound.")
      .def(
          "unlike",
          [](const SlipEstimator& network, const Frames& frames) {
            return taken<bool>(network, frames, {}, [](const Answer& a, bool*& to) { *to++ = a.unlike != 0; });
          },
          "frames"_a, "Returns where a frame is unlike those of the learning set: its bound says nothing.")
      .def("metadata", &SlipEstimator::metadata, "key"_a, "Returns an entry of the file; empty where there is none.")
      .def_property_readonly("inputs", &SlipEstimator::inputs, "numbers of a frame: 2 tactels")
      .def_property_readonly("topology", &SlipEstimator::topology, "\"42-42-21-1\"")
      .def("__repr__",
           [](const SlipEstimator& network) { return "<tactel.SlipEstimator " + network.topology() + ">"; });
  py::class_<Network>(m, "Network", "A trained network with its origin.")
      .def_static(
          "load", [](const FileName& path) { return Network::load(path); }, "path"_a,
          "Loads a network file (ONNX) that tactel wrote.")
      .def_static(
          "from_arrays", &from_arrays, "weights"_a, "biases"_a, "activation"_a = "sigmoid", py::kw_only(),
          "slope"_a = 0.01, "scaling"_a = "set", "largest_stress"_a = 1.0, "axes"_a = 2, "history"_a = "",
          "history_change"_a = py::none(), "name"_a = "own", "target"_a = "slip_index",
          "Returns a network that another program trained: weights [out, in] and biases [out] of one or two "
          "hidden layers with this activation (sigmoid, tanh, relu or leaky-relu; one for all or a list) and slope, "
          "and of one output through "
          "a sigmoid, which is the target. axes: stresses of a tactel, of a pad 3 or 1. scaling: set, frame or rest.")
      .def(
          "__call__", [](const Network& network, const Frames& frames) { return call(network.estimator(), frames); },
          "frames"_a, "Returns S of a frame [2 tactels], or of frames [..., 2 tactels] as fp32; see SlipEstimator.")
      .def(
          "to_onnx", [](const Network& network, const FileName& path) { network.to_onnx(path); }, "path"_a,
          "Writes the network file.")
      .def_property_readonly("estimator", &Network::estimator)
      .def_property_readonly("topology", &Network::topology)
      .def_property_readonly("seed", &Network::seed)
      .def_property_readonly("noise", &Network::noise)
      .def_property_readonly("cycles", &Network::cycles)
      .def_property_readonly("learning_errors", &Network::learning_errors)
      .def(
          "errors",
          [](const Network& network, const Set& set) {
            const py::gil_scoped_release released;
            return errors(network.estimator(), set);
          },
          "set"_a, "Returns the errors |S - S of the set| on a set.")
      .def(py::pickle([](const Network& network) { return py::bytes(network.onnx()); },
                      [](const py::bytes& bytes) { return Network::parse(std::string_view(bytes)); }))
      .def("__repr__", [](const Network& network) {
        return "<tactel.Network " + network.topology() + ", seed " + std::to_string(network.seed()) + ">";
      });
  py::class_<Answer> answer(m, "Answer", "The answer to a frame.");
  bind_answer(answer, [](const Answer& a) { return a; });
  py::class_<AlarmAnswer> alarm_answer(m, "AlarmAnswer", "What an Alarm says about a frame.");
  bind_answer(alarm_answer, [](const AlarmAnswer& said) { return said.answer; });
  alarm_answer
      .def_readonly("contact", &AlarmAnswer::contact, "whether something touches; None without a threshold of touch")
      .def_readonly("acted_on", &AlarmAnswer::acted_on, "number that the alarm judges")
      .def_readonly("on", &AlarmAnswer::on, "the alarm")
      .def_readonly("cannot_tell", &AlarmAnswer::cannot_tell, "the alarm cannot tell, by `why`")
      .def_property_readonly(
          "why", [](const AlarmAnswer& said) { return name(said.why); },
          "\"not a number\", \"frozen\", \"wrong sign\", \"no rest\", \"unlike\", \"wide interval\" or \"no answer\"; "
          "\"\" "
          "where it can tell")
      .def_readonly("left", &AlarmAnswer::left,
                    "of signal left: how far the stresses have left their rest, 1 at the alarm; NaN without contact or "
                    "rest")
      .def_readonly("calm", &AlarmAnswer::calm, "of signal left: tremor of the newest third of a second, over P; NaN")
      .def_readonly("index", &AlarmAnswer::index, "of signal left: Q / P with its torque over that of a slide; NaN")
      .def_readonly("released", &AlarmAnswer::released, "of signal left: the hand opens, or has opened")
      .def_readonly("rest", &AlarmAnswer::rest, "whether a rest of this grip is known; None where it is not asked for")
      .def_readonly("moved", &AlarmAnswer::moved,
                    "change of the stresses since rest: the norm of the differences of all, over the sum of the normal "
                    "stresses at rest; NaN without contact or rest")
      .def("__repr__", &text_of);
  py::class_<OwnAlarm>(m, "Alarm", "The alarm of `tactel monitor`: frames of one sensor in turn, by its rules.",
                       py::dynamic_attr())
      .def(
          py::init(&alarm_of), "network"_a = py::none(), py::kw_only(), "at"_a = py::none(), "touch"_a = py::none(),
          "widest"_a = py::none(), "hold"_a = 1, "ignore_unlike"_a = false, "device"_a = "", "rest"_a = false,
          "signal"_a = py::none(), "tactels"_a = py::none(), "axes"_a = 3, "rate"_a = 60.0, "columns"_a = 0,
          "aspect"_a = 1.0, "covariance"_a = std::vector<float>(), "held_at"_a = 0.0, "slide"_a = 0.0,
          "network: a Network or SlipEstimator. at: upper bound of S (S itself without a bound) at which the alarm "
          "begins, 0.8 where not given; it ends below at - 0.05. touch: MPa; a frame whose normal stresses all stay "
          "below is no contact; "
          "None: the smallest peak that the network learnt. widest: no alarm begins at a wider interval of S. hold: "
          "it begins at the last of so many frames in a row that ask for it. ignore_unlike: a frame unlike all that "
          "was learnt asks for the alarm by its S alone. device: one of devices() that answers the frames, by "
          "\"gpu\", \"cpu\", index or a part of its name; \"\": host code, with the same bits. rest: answers have "
          "`rest` "
          "and `moved`. signal: \"slip\", or \"left\" or \"moved\", which need no network, but tactels and axes of a "
          "frame; \"left\" is 1 at the alarm, and stands where neither network nor `at` is given; \"moved\" has an "
          "`at` "
          "such as 1.2 times the largest `moved` of a hold; both end below at / 1.2. Of left: rate, Hz; columns, "
          "tactels "
          "along x, 0: as many as along y; aspect, pitch along y over that along x; covariance and held_at (its at) of "
          "[hold], slide of [slide] in a calibration file of `tactel tare`.")
      .def("next", &OwnAlarm::next, "frame"_a, "answer"_a = py::none(),
           "Takes the sensor's next frame [inputs] MPa, normal stresses of all tactels first, then shear. answer: that "
           "of a LiveEstimator, in place of its own.")
      .def("slides", &OwnAlarm::slides,
           "Call it where the object is known to slide in the newest frame: reads mu from it, or of left Q / P, tells "
           "it "
           "from the next frame on, and returns it; nan where there is none.")
      .def(
          "rate", [](OwnAlarm& own, double hz) { own.alarm.rate(hz); }, "hz"_a,
          "Says that frames come at another rate.")
      .def("friction", &OwnAlarm::friction, "mu"_a, "spread"_a = 0.1,
           "Tells a network of train(friction=True) mu and its relative standard deviation; 0: mu is not known.")
      .def("rest", &OwnAlarm::rest,
           "Seeks rest anew from the next frame on, after a change of the grip; ends an alarm that needs the rest.")
      .def("clear", &OwnAlarm::clear, "Ends the alarm and forgets all frames.")
      .def_property_readonly(
          "inputs", [](const OwnAlarm& own) { return own.alarm.inputs(); }, "numbers of a frame");
  py::class_<LiveEstimator>(m, "LiveEstimator",
                            "Answers to the frames of several sensors, the pads of a hand, on a device.")
      .def(py::init<const std::vector<Network>&, const std::string&>(), py::call_guard<py::gil_scoped_release>(),
           "networks"_a, "device"_a = "",
           "networks: that of each sensor; the same one several times shares its work. device: one of devices(), by "
           "\"gpu\", \"cpu\", index or a part of its name: one launch for all sensors whose networks have one topology "
           "and scaling; \"\": host code, with the same bits, quicker for a sensor or two.")
      .def("next", &next_answers, "frames"_a, "Takes the next frame of every sensor, [inputs] MPa, sensor by sensor.")
      .def("clear", &LiveEstimator::clear, "Forgets all frames.")
      .def_property_readonly("inputs", &LiveEstimator::inputs, "numbers of one frame of every sensor")
      .def_property_readonly("sensors", &LiveEstimator::sensors)
      .def_property_readonly("device", &LiveEstimator::device, "name; empty: host code");
  py::class_<DeviceInfo>(m, "DeviceInfo", "An OpenCL device, as `tactel devices` lists it.")
      .def_readonly("index", &DeviceInfo::index)
      .def_readonly("name", &DeviceInfo::name)
      .def_readonly("platform", &DeviceInfo::platform)
      .def_readonly("type", &DeviceInfo::type, "\"cpu\", \"gpu\" or \"other\"")
      .def_readonly("compute_units", &DeviceInfo::compute_units)
      .def_readonly("memory", &DeviceInfo::memory, "bytes")
      .def_readonly("fp64", &DeviceInfo::fp64, "double precision in kernels")
      .def_readonly("is_default", &DeviceInfo::is_default, "computes where no device is named")
      .def("__repr__", [](const DeviceInfo& info) {
        return "<tactel.DeviceInfo " + std::to_string(info.index) + ": " + info.name + ", " + info.type + ">";
      });
  m.def("devices", &devices, py::call_guard<py::gil_scoped_release>(),
        "Returns the OpenCL devices; where there is none an empty list.");
  m.def(
      "_train",
      [](const Set& set, const Set* validation, std::string device, const py::dict& words, py::object progress) {
        TrainOptions options = train_options_of(words);
        options.validation = validation, options.device = std::move(device);
        return Computation(std::move(progress)).run([&](const ProgressFunction& p) { return train(set, options, p); });
      },
      "set"_a, "validation"_a, "device"_a, "words"_a, "progress"_a);
}

}  // namespace tactel::python
