// SPDX-License-Identifier: Apache-2.0
#include <tactel/infer.h>

#include <algorithm>
#include <cmath>

namespace tactel {
namespace {

constexpr float release = 0.05f;  // of S, below `at`

void check(const SlipEstimator& network, const AlarmOptions& options) {
  const auto refuse = [](const char* place, double value, const char* fix) {
    throw InputError(place, std::to_string(value), fix);
  };
  const bool never = options.at == std::numeric_limits<float>::infinity();
  if (!(never || (options.at >= 0 && options.at <= 1))) refuse("at", options.at, "must be 0 to 1");
  if (!(options.touch >= 0 && std::isfinite(options.touch))) refuse("touch", options.touch, "must be 0 or above, MPa");
  if (!(options.widest >= 0)) refuse("widest", options.widest, "must be 0 or above");
  if (std::isfinite(options.widest) && !network.has_bound())
    refuse("widest", options.widest, "leave it out for a network without a bound: it has no interval");
  const std::string target = network.metadata("target");
  if (!never && !target.empty())
    throw InputError("network", "estimates " + target, "give one of S: the alarm is for S");
}

}  // namespace

struct Alarm::State {
  float number_of(const AlarmAnswer& given) const noexcept {
    if (given.answer.status == AnswerStatus::no_stress || given.contact == false) return 0;
    return has_bound ? given.answer.slip_upper : given.answer.slip_index;
  }

  AlarmOptions options;
  SlipHistory history;
  std::size_t tactels;
  bool has_bound, on = false;
};

Alarm::Alarm(const SlipEstimator& network, const AlarmOptions& options)
    : state_((check(network, options),
              new State{options, SlipHistory(network), network.tactels(), network.has_bound()})) {}
Alarm::~Alarm() { delete state_; }

std::size_t Alarm::inputs() const noexcept { return state_->history.inputs(); }

AlarmAnswer Alarm::answer(std::span<const float> frame) noexcept {
  return answer(frame, state_->history.estimate(frame));
}

AlarmAnswer Alarm::answer(std::span<const float> frame, const Answer& estimated) noexcept {
  AlarmAnswer given{.answer = estimated};
  const double touch = state_->options.touch;
  if (touch > 0 && given.answer.status != AnswerStatus::wrong_size) {
    // NaN touches.
    given.contact = given.answer.status == AnswerStatus::not_finite ||
                    !std::ranges::all_of(frame.first(state_->tactels), [&](float s) { return std::abs(s) < touch; });
    if (!*given.contact) given.answer.slip_index = given.answer.slip_upper = std::nanf("");
  }
  given.acted_on = state_->number_of(given);
  return given;
}

AlarmAnswer Alarm::judge(AlarmAnswer given) noexcept {
  const auto& [at, touch, widest] = state_->options;
  const float width = state_->has_bound ? given.answer.slip_interval[1] - given.answer.slip_interval[0] : 0;
  given.acted_on = state_->number_of(given);
  if (given.acted_on >= at && width <= widest) state_->on = true;
  if (given.acted_on < at - release) state_->on = false;
  given.on = state_->on;
  given.cannot_tell = !given.on && given.acted_on >= at;
  return given;
}

void Alarm::clear() noexcept {
  state_->history.clear();
  state_->on = false;
}

}  // namespace tactel
