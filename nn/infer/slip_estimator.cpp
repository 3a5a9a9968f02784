// SPDX-License-Identifier: Apache-2.0
#include <tactel/infer.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cfenv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

#include "fem/numbers/value_error.h"
#include "nn/features.h"
#include "nn/infer/built_in.h"
#include "nn/infer/friction_reading.h"
#include "nn/infer/layers.h"
#include "nn/infer/loaded_network.h"
#include "nn/infer/sensor_frames.h"

namespace tactel {

Error::~Error() = default;

InputError::InputError(std::string place, std::string problem, std::string fix)
    : Error(place + ": " + problem + "; " + fix),
      place(std::move(place)),
      problem(std::move(problem)),
      fix(std::move(fix)) {}
InputError::~InputError() = default;

const char* version() noexcept { return TACTEL_VERSION; }

const char* name(AnswerStatus status) noexcept {
  constexpr std::array names{"ok", "no stress", "not finite", "overflow", "wrong size"};
  const auto place = static_cast<std::size_t>(status);
  return place < names.size() ? names[place] : "unknown";
}

namespace {

/// While it lives, this thread rounds to nearest and traps nothing, whatever the host program has set: equal bits. With
/// `flush` it also takes denormal numbers for zero, as the kernels do, and no frame takes 100 times as long.
class OwnArithmetic {
 public:
#if defined(__x86_64__)
  explicit OwnArithmetic(bool flush) noexcept : before_(__builtin_ia32_stmxcsr()) {
    __builtin_ia32_ldmxcsr(flush ? 0x9fc0 : 0x1f80);
  }
  ~OwnArithmetic() { __builtin_ia32_ldmxcsr(before_); }
#elif defined(__aarch64__)
  explicit OwnArithmetic(bool flush) noexcept {
    asm volatile("mrs %0, fpcr" : "=r"(before_));
    asm volatile("msr fpcr, %0" : : "r"(std::uint64_t{flush} << 24));
  }
  ~OwnArithmetic() { asm volatile("msr fpcr, %0" : : "r"(before_)); }
#else
  explicit OwnArithmetic(bool) noexcept { std::fegetenv(&before_), std::fesetenv(FE_DFL_ENV); }
  ~OwnArithmetic() { std::fesetenv(&before_); }
#endif
  OwnArithmetic(const OwnArithmetic&) = delete;
  OwnArithmetic& operator=(const OwnArithmetic&) = delete;

 private:
#if defined(__x86_64__)
  unsigned before_;
#elif defined(__aarch64__)
  std::uint64_t before_ = 0;
#else
  std::fenv_t before_;
#endif
};

using infer::Activations;
using Network = SlipEstimator::Network;

/// By the numbers' bits and without a branch, so that compilers use vectors.
bool all_finite(const float* numbers, int count) noexcept {
  constexpr std::uint32_t exponent = 0x7f800000;
  std::uint32_t found = 0;
  for (int k = 0; k < count; ++k) found |= (std::bit_cast<std::uint32_t>(numbers[k]) & exponent) == exponent;
  return found == 0;
}

/// scale_frame by the set or the frame, of finite stresses.
AnswerStatus scale_stresses(const Network& network, const float* frame, float* scaled) noexcept {
  const int inputs = network.inputs;
  float factor = network.factor, scale = 1, largest = 0;
  if (network.scaling.kind == nn::ScalingKind::frame) {
    for (int k = 0; k < network.normals; ++k) largest = std::max(largest, std::abs(frame[k]));
    if (largest < nn::InputScaling::smallest_stress) return AnswerStatus::no_stress;
    if (largest > nn::InputScaling::large_stress) scale = nn::InputScaling::large_scale;
    factor = 1.0f / (largest * scale);
  }
  const int count = network.scaling.width(inputs) * network.scaling.history;
  for (int k = 0; k < count; ++k) scaled[k] = frame[k] * scale * factor;
  if (network.scaling.features != nn::Features::frame) nn::add_features(network.scaling, inputs, largest, scaled);
  return AnswerStatus::ok;
}

/// Scales a frame as nn/input_scaling.cpp does. A frame that is not finite, or carries no stress, becomes zeros.
AnswerStatus scale_frame(const Network& network, const float* frame, float* scaled) noexcept {
  const nn::InputScaling& scaling = network.scaling;
  const int inputs = network.inputs;
  std::fill_n(scaled, scaling.inputs(inputs), 0.0f);
  if (!all_finite(frame, inputs)) return AnswerStatus::not_finite;
  AnswerStatus status = AnswerStatus::no_stress;
  if (scaling.kind != nn::ScalingKind::rest)
    status = scale_stresses(network, frame, scaled);
  else if (nn::take_differences_to_rest(scaling, inputs, frame, scaled))
    status = AnswerStatus::ok;
  if (scaling.friction && status == AnswerStatus::ok)
    nn::tell_friction(frame[inputs - 2], frame[inputs - 1], scaled + scaling.inputs(inputs) - 2);
  return status;
}

Answer answer_of(AnswerStatus status, float slip_index) noexcept {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  const bool valid = status == AnswerStatus::ok || status == AnswerStatus::no_stress;
  return {valid ? slip_index : none, none, status, {none, none}, 0, 0, {}};
}

Answer plain_answer(AnswerStatus status, float output) noexcept {
  if (std::isnan(output) && status == AnswerStatus::ok) status = AnswerStatus::overflow;
  return answer_of(status, output + 0.5f);
}

/// The answer of a network with a bound from the outputs of its heads.
Answer bounded_answer(const Network& network, AnswerStatus status, const infer::FrameClass& frame, float middle,
                      float above, float below) noexcept {
  const float median = middle + 0.5f;
  const nn::Quantiles<float> q{median, median + (above + 0.5f), median - (below + 0.5f)};
  if (std::isnan((q.median + q.upper) + q.lower) && status == AnswerStatus::ok) status = AnswerStatus::overflow;
  Answer answer = answer_of(status, median);
  const nn::BoundAnswer bound = network.bound->answer(frame.touching, q, frame.distance);
  answer.unlike = bound.unlike;
  if (std::isnan(answer.slip_index)) return answer;
  answer.slip_upper = bound.upper;
  std::copy_n(bound.interval, 2, answer.slip_interval);
  return answer;
}

/// Evaluates 1 to most_frames frames, [frames, inputs].
void evaluate(const Network& network, int frames, const float* frame, Answer* answers) noexcept {
  const OwnArithmetic arithmetic(true);
  Activations a, b;  // the widest layer fits
  Activations *x = &a, *next = &b;
  AnswerStatus status[infer::most_frames];
  infer::FrameClass seen[infer::most_frames];
  for (int f = 0; f < frames; ++f) {
    status[f] = scale_frame(network, frame + f * network.inputs, x->values[f]);
    if (network.bound) seen[f] = infer::classify(*network.bound, x->values[f]);
  }
  for (int f = frames; f < infer::most_frames && frames > 1; ++f)
    std::fill_n(x->values[f], network.scaling.inputs(network.inputs), 0.0f);
  for (const infer::HiddenLayer& layer : network.hidden) {
    infer::hidden_outputs(layer, frames, *x, *next);
    std::swap(x, next);
  }
  float o[nn::Topology::heads][infer::most_frames];
  for (int h = 0; h < (network.bound ? nn::Topology::heads : 1); ++h)
    infer::output_neuron(network.output.data() + h * (network.last + 1), network.last, frames, *x, o[h]);
  for (int f = 0; f < frames; ++f) {
    answers[f] = network.bound ? bounded_answer(network, status[f], seen[f], o[0][f], o[1][f], o[2][f])
                               : plain_answer(status[f], o[0][f]);
    answers[f].beyond_learnt = network.learnt.beyond(frame + f * network.inputs, network.normals);
  }
}

/// Returns the bytes of a file. Throws InputError where it cannot be read.
std::string bytes_of(const std::string& path) {
  const auto fail = [&](const std::string& reason) -> InputError {
    return {path, "cannot be read (" + reason + ")", "a network that tactel wrote (ONNX, at most 4 MiB)"};
  };
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw fail(std::strerror(ENOENT));
  if (error) throw fail(error.message());
  if (!std::filesystem::is_regular_file(status)) throw fail("no regular file");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw fail(std::strerror(errno));
  std::string bytes(infer::most_network_bytes + 1, '\0');
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file.get()));
  if (std::ferror(file.get())) throw fail(std::strerror(errno));
  return bytes;
}

}  // namespace

SlipEstimator::~SlipEstimator() {
  if (network_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) delete network_;
}
SlipEstimator::SlipEstimator(const SlipEstimator& other) noexcept : network_(other.network_) {
  network_->owners.fetch_add(1, std::memory_order_relaxed);
}
SlipEstimator& SlipEstimator::operator=(const SlipEstimator& other) noexcept {
  SlipEstimator copy(other);
  std::swap(network_, copy.network_);
  return *this;
}

SlipEstimator SlipEstimator::parse(std::span<const std::byte> bytes, const std::string& place) try {
  const OwnArithmetic arithmetic(false);
  infer::NetworkFile file = infer::read_network({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return Network::of(file.model, std::move(file.metadata));
} catch (const ValueError& error) {
  throw InputError(place, error.value, error.allowed);
}

SlipEstimator SlipEstimator::load(const std::string& path) {
  if (const auto end = path.find('\0'); end != std::string::npos)
    throw InputError(path.substr(0, end), "goes on behind a NUL byte", "must be the name of a file");
  if (const std::string_view bytes = infer::built_in_network(path); !bytes.empty())
    return parse(std::as_bytes(std::span(bytes)), path);
  const std::string bytes = bytes_of(path);
  return parse(std::as_bytes(std::span(bytes)), path);
}

std::size_t SlipEstimator::inputs() const noexcept { return static_cast<std::size_t>(network_->inputs); }

Answer SlipEstimator::estimate(std::span<const float> frame) const noexcept {
  if (frame.size() != inputs()) return answer_of(AnswerStatus::wrong_size, 0);
  Answer answer;
  evaluate(*network_, 1, frame.data(), &answer);
  return answer;
}

std::size_t SlipEstimator::estimate(std::span<const float> frames, std::span<Answer> answers) const noexcept {
  const std::size_t width = inputs();
  if (frames.size() / width != answers.size() || frames.size() % width != 0) return 0;
  for (std::size_t i = 0; i < answers.size(); i += infer::most_frames) {
    const std::size_t count = std::min<std::size_t>(infer::most_frames, answers.size() - i);
    evaluate(*network_, static_cast<int>(count), frames.data() + i * width, &answers[i]);
  }
  return answers.size();
}

std::size_t SlipEstimator::frames() const noexcept { return static_cast<std::size_t>(network_->history.frames); }
std::size_t SlipEstimator::tactels() const noexcept { return static_cast<std::size_t>(network_->normals); }
bool SlipEstimator::has_bound() const noexcept { return network_->bound.has_value(); }
float SlipEstimator::smallest_peak() const noexcept { return network_->learnt.smallest_peak; }
bool SlipEstimator::takes_friction() const noexcept { return network_->scaling.friction; }
bool SlipEstimator::needs_rest() const noexcept { return network_->history.rest; }
float SlipEstimator::alarm_at() const noexcept { return network_->learnt.alarm_at; }

struct SlipHistory::State {
  State(const SlipEstimator& network, std::optional<double> touch)
      : network(network),
        frames(network.network_->scaling, network.network_->history, network.network_->learnt, network.network_->inputs,
               touch) {}
  SlipEstimator network;
  infer::SensorFrames frames;
  alignas(64) float input[2 * nn::Topology::widest_layer] = {};  // a rest is as wide as the newest frame, and no input
  infer::FrictionReading friction;
};

SlipHistory::SlipHistory(const SlipEstimator& network) : SlipHistory(network, std::nullopt) {}
SlipHistory::SlipHistory(const SlipEstimator& network, std::optional<double> touch)
    : state_(new State(network, touch)) {}
SlipHistory::~SlipHistory() { delete state_; }

std::size_t SlipHistory::inputs() const noexcept { return state_->frames.width(); }

Answer SlipHistory::estimate(std::span<const float> frame) noexcept {
  if (frame.size() != inputs()) return answer_of(AnswerStatus::wrong_size, 0);
  const OwnArithmetic arithmetic(false);
  state_->frames.push(frame.data());
  state_->frames.write(state_->input);
  return state_->network.estimate({state_->input, state_->network.inputs()});
}

void SlipHistory::friction(float mu, float spread) noexcept {
  state_->frames.friction(mu, spread);
  state_->friction.forget();
}

float SlipHistory::slides() noexcept {
  const SlipEstimator& network = state_->network;
  const float mu = state_->friction.next(network, network.network_->learnt, {state_->input, network.inputs()});
  if (!std::isnan(mu)) state_->frames.friction(mu, infer::FrictionReading::spread);
  return mu;
}

void SlipHistory::rest() noexcept { state_->frames.rest(); }
void SlipHistory::clear() noexcept { state_->frames.clear(); }

std::string SlipEstimator::topology() const { return metadata("topology"); }

std::string SlipEstimator::metadata(std::string_view key) const {
  const auto found = network_->metadata.find(key);
  return found == network_->metadata.end() ? std::string() : found->second;
}

}  // namespace tactel
