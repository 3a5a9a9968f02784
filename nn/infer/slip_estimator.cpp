// SPDX-License-Identifier: Apache-2.0
#include <tactel/infer.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "nn/infer/bound.h"
#include "nn/infer/layers.h"
#include "nn/infer/network_file.h"

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
  switch (status) {
    case AnswerStatus::ok:
      return "ok";
    case AnswerStatus::no_stress:
      return "no stress";
    case AnswerStatus::not_finite:
      return "not finite";
    case AnswerStatus::overflow:
      return "overflow";
    case AnswerStatus::wrong_size:
      return "wrong size";
  }
  return "unknown";
}

struct SlipEstimator::Network {
  mutable std::atomic<std::size_t> owners = 1;
  std::vector<infer::HiddenLayer> hidden;
  std::vector<float> output;  ///< [outputs, inputs of the last layer + 1], the bias last
  int last = 0;               ///< inputs of the last layer
  std::optional<infer::FileBound> bound;
  int inputs = 0;
  int normals = 0;  ///< normal stresses of the newest frame
  nn::InputHistory history;
  bool by_frame = false;
  float factor = 0;
  std::map<std::string, std::string, std::less<>> metadata;
};

namespace {

/// While it lives, this thread's arithmetic takes denormal numbers for zero, as the kernels do: equal bits, and no
/// frame that takes 100 times as long.
class FlushDenormals {
 public:
#if defined(__x86_64__)
  FlushDenormals() noexcept : before_(__builtin_ia32_stmxcsr()) { __builtin_ia32_ldmxcsr(before_ | 0x8040); }
  ~FlushDenormals() { __builtin_ia32_ldmxcsr(before_); }
#elif defined(__aarch64__)
  FlushDenormals() noexcept {
    asm volatile("mrs %0, fpcr" : "=r"(before_));
    asm volatile("msr fpcr, %0" : : "r"(before_ | (std::uint64_t{1} << 24)));
  }
  ~FlushDenormals() { asm volatile("msr fpcr, %0" : : "r"(before_)); }
#else
  FlushDenormals() noexcept {}
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
#if defined(__x86_64__)
  unsigned before_;
#elif defined(__aarch64__)
  std::uint64_t before_ = 0;
#endif
};

using infer::Activations;
using Network = SlipEstimator::Network;

// As nn/input_scaling.h.
constexpr float smallest_stress = 1e-12f, large_stress = 0x1p126f, large_scale = 0x1p-8f;

/// Scales a frame as nn/input_scaling.cpp does. A frame that is not finite, or carries no stress, becomes zeros.
AnswerStatus scale_frame(const Network& network, const float* frame, float* scaled) noexcept {
  const int inputs = network.inputs;
  std::fill_n(scaled, inputs, 0.0f);
  if (!std::all_of(frame, frame + inputs, [](float x) { return std::isfinite(x); })) return AnswerStatus::not_finite;
  float factor = network.factor, scale = 1;
  if (network.by_frame) {
    float largest = 0;
    for (int k = 0; k < network.normals; ++k) largest = std::max(largest, std::abs(frame[k]));
    if (largest < smallest_stress) return AnswerStatus::no_stress;
    if (largest > large_stress) scale = large_scale;
    factor = 1.0f / (largest * scale);
  }
  for (int k = 0; k < inputs; ++k) scaled[k] = frame[k] * scale * factor;
  return AnswerStatus::ok;
}

Answer answer_of(AnswerStatus status, float slip_index) noexcept {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  const bool valid = status == AnswerStatus::ok || status == AnswerStatus::no_stress;
  return {valid ? slip_index : none, none, status, {none, none}, 0, {}};
}

/// The answer of a network with a bound: x are the inputs of its last layer.
Answer bounded_answer(const Network& network, AnswerStatus status, const infer::FrameClass& frame,
                      const float* x) noexcept {
  const auto head = [&](int h) {
    return infer::output_neuron(network.output.data() + h * (network.last + 1), network.last, x) + 0.5f;
  };
  const float median = head(0);
  const infer::Quantiles q{median, median + head(1), median - head(2)};
  if (std::isnan((q.median + q.upper) + q.lower) && status == AnswerStatus::ok) status = AnswerStatus::overflow;
  Answer answer = answer_of(status, median);
  if (!std::isnan(answer.slip_index)) infer::add_bound(*network.bound, frame, q, answer);
  answer.unlike = frame.unlike;
  return answer;
}

Answer evaluate(const Network& network, const float* frame) noexcept {
  const FlushDenormals flush;
  Activations a, b;  // the widest layer fits
  float *x = a.values, *o = b.values;
  AnswerStatus status = scale_frame(network, frame, x);
  infer::FrameClass seen;
  if (network.bound) seen = infer::classify(*network.bound, x);
  for (const infer::HiddenLayer& layer : network.hidden) {
    infer::hidden_outputs(layer, x, o);
    std::swap(x, o);
  }
  if (network.bound) return bounded_answer(network, status, seen, x);
  const float output = infer::output_neuron(network.output.data(), network.last, x);
  if (std::isnan(output) && status == AnswerStatus::ok) status = AnswerStatus::overflow;
  return answer_of(status, output + 0.5f);
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

SlipEstimator SlipEstimator::parse(std::span<const std::byte> bytes, const std::string& place) {
  infer::NetworkFile file =
      infer::read_network_file({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, place);
  auto network = std::make_unique<Network>();
  network->inputs = file.layers.front().inputs;
  network->history = file.history;
  network->normals = network->inputs / (2 * file.history.frames);
  network->by_frame = file.by_frame;
  network->factor = file.factor;
  network->metadata = std::move(file.metadata);
  for (std::size_t l = 0; l + 1 < file.layers.size(); ++l)
    network->hidden.push_back(infer::hidden_layer(file.layers[l]));
  network->bound = std::move(file.bound);
  if (network->bound)
    network->bound->whitening = infer::tiled(network->bound->whitening, network->bound->centre.size());
  const infer::FileLayer& last = file.layers.back();
  network->last = last.inputs;
  for (int h = 0; h < last.outputs; ++h) {
    const auto row = last.weights.begin() + static_cast<std::ptrdiff_t>(h) * last.inputs;
    network->output.insert(network->output.end(), row, row + last.inputs);
    network->output.push_back(last.bias[static_cast<std::size_t>(h)]);
  }
  return SlipEstimator(network.release());
}

SlipEstimator SlipEstimator::load(const std::string& path) {
  const std::string bytes = infer::read_network_bytes(path);
  return parse(std::as_bytes(std::span(bytes)), path);
}

std::size_t SlipEstimator::inputs() const noexcept { return static_cast<std::size_t>(network_->inputs); }

Answer SlipEstimator::estimate(std::span<const float> frame) const noexcept {
  if (frame.size() != inputs()) return answer_of(AnswerStatus::wrong_size, 0);
  return evaluate(*network_, frame.data());
}

std::size_t SlipEstimator::estimate(std::span<const float> frames, std::span<Answer> answers) const noexcept {
  const std::size_t width = inputs();
  if (frames.size() / width != answers.size() || frames.size() % width != 0) return 0;
  for (std::size_t i = 0; i < answers.size(); ++i) answers[i] = evaluate(*network_, frames.data() + i * width);
  return answers.size();
}

std::size_t SlipEstimator::frames() const noexcept { return static_cast<std::size_t>(network_->history.frames); }

struct SlipHistory::State {
  explicit State(const SlipEstimator& network)
      : network(network), history(network.inputs() / network.frames(), network.network_->history) {}
  SlipEstimator network;
  nn::FrameHistory history;
  Activations input;
};

SlipHistory::SlipHistory(const SlipEstimator& network) : state_(new State(network)) {}
SlipHistory::~SlipHistory() { delete state_; }

std::size_t SlipHistory::inputs() const noexcept { return state_->history.width(); }

Answer SlipHistory::estimate(std::span<const float> frame) noexcept {
  if (frame.size() != inputs()) return answer_of(AnswerStatus::wrong_size, 0);
  state_->history.push(frame.data());
  state_->history.write(state_->input.values);
  return state_->network.estimate({state_->input.values, state_->history.inputs()});
}

void SlipHistory::clear() noexcept { state_->history.clear(); }

std::string SlipEstimator::topology() const { return metadata("topology"); }

std::string SlipEstimator::metadata(std::string_view key) const {
  const auto found = network_->metadata.find(key);
  return found == network_->metadata.end() ? std::string() : found->second;
}

}  // namespace tactel
