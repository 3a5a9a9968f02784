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
  const double touch = options.touch.value_or(0);
  if (!(touch >= 0 && std::isfinite(touch))) refuse("touch", touch, "must be 0 or above, MPa");
  if (options.hold < 1) refuse("hold", options.hold, "must be 1 frame or more");
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
  double touch;  ///< MPa
  SlipHistory history;
  std::size_t tactels;
  bool has_bound, on = false;
  int asking = 0;  ///< frames in a row that asked for the alarm
};

Alarm::Alarm(const SlipEstimator& network, const AlarmOptions& options)
    : state_((check(network, options), new State{options, options.touch.value_or(network.smallest_peak()),
                                                 SlipHistory(network), network.tactels(), network.has_bound()})) {}
Alarm::~Alarm() { delete state_; }

std::size_t Alarm::inputs() const noexcept { return state_->history.inputs(); }

AlarmAnswer Alarm::answer(std::span<const float> frame) noexcept {
  return answer(frame, state_->history.estimate(frame));
}

AlarmAnswer Alarm::answer(std::span<const float> frame, const Answer& estimated) noexcept {
  AlarmAnswer given{.answer = estimated};
  const double touch = state_->touch;
  if (touch > 0 && given.answer.status != AnswerStatus::wrong_size) {
    // NaN touches.
    given.contact = given.answer.status == AnswerStatus::not_finite ||
                    !std::ranges::all_of(frame.first(state_->tactels), [&](float s) { return std::abs(s) < touch; });
    if (!*given.contact) given.answer.slip_index = given.answer.slip_upper = std::nanf("");
  }
  given.acted_on = state_->number_of(given);
  return given;
}

// A frame without an answer neither asks for the alarm nor ends it, nor the row of those that ask.
AlarmAnswer Alarm::judge(AlarmAnswer given) noexcept {
  const AlarmOptions& rules = state_->options;
  given.acted_on = state_->number_of(given);
  const bool none = std::isnan(given.acted_on);
  const bool nothing = given.answer.status == AnswerStatus::no_stress || given.contact == false;
  const bool unlike = given.answer.unlike != 0 && !none && !nothing;
  const float width = state_->has_bound ? given.answer.slip_interval[1] - given.answer.slip_interval[0] : 0;
  const bool near = given.acted_on >= rules.at, wide = near && !(width <= rules.widest);
  if (unlike && !rules.ignore_unlike ? rules.at <= 1 : near && !wide) {
    state_->asking = std::min(state_->asking + 1, rules.hold);
    if (state_->asking == rules.hold) state_->on = true;
  } else if (!none) {
    state_->asking = 0;
    if (given.acted_on < rules.at - release) state_->on = false;
  }
  given.on = state_->on;
  given.cannot_tell = none || unlike || (wide && !given.on);
  return given;
}

void Alarm::clear() noexcept {
  state_->history.clear();
  state_->on = false, state_->asking = 0;
}

}  // namespace tactel
