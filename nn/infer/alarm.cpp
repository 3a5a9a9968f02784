// SPDX-License-Identifier: Apache-2.0
#include <tactel/infer.h>

#include <algorithm>
#include <cmath>

#include "nn/infer/rest_reference.h"
#include "nn/network.h"

namespace tactel {
namespace {

constexpr float usual_at = 0.8f;      // of S
constexpr float release = 0.05f;      // of S, below `at`
constexpr std::size_t most_axes = 3;  // of a tactel
constexpr double most_friction = 1e3;

[[noreturn]] void refuse(const char* place, double value, const char* fix) {
  throw InputError(place, std::to_string(value), fix);
}

/// touch: MPa.
void check(const AlarmOptions& options, double touch, bool has_bound) {
  const bool never = options.at == std::numeric_limits<float>::infinity();
  const bool moved = options.signal == AlarmSignal::moved;
  if (moved && !(never || (options.at > 0 && options.at < infer::most_moved)))
    refuse("at", options.at, "must be above 0 and below 0.5: 1.2 times the largest `moved` of a hold");
  if (!moved && !(never || (options.at >= 0 && options.at <= 1))) refuse("at", options.at, "must be 0 to 1");
  if (!(touch >= 0 && std::isfinite(touch))) refuse("touch", touch, "must be 0 or above, MPa");
  if (options.rest && touch == 0)
    refuse("touch", touch, "must be above 0 with a rest, which ends where nothing touches, MPa");
  if (options.hold < 1) refuse("hold", options.hold, "must be 1 frame or more");
  if (!(options.widest >= 0)) refuse("widest", options.widest, "must be 0 or above");
  if (std::isfinite(options.widest) && !has_bound)
    refuse("widest", options.widest, "leave it out for a network without a bound: it has no interval");
}

bool estimates_slide(const SlipEstimator& network) {
  const std::string target = network.metadata("target");
  return target == nn::name(nn::Target::slid) || target == nn::name(nn::Target::slip_path);
}

/// Returns the rules with their threshold, with a rest where one is needed, and with a threshold of touch.
AlarmOptions checked(const SlipEstimator& network, AlarmOptions options) {
  options.touch = options.touch.value_or(network.smallest_peak());
  options.rest |= network.needs_rest() || options.signal == AlarmSignal::moved;
  const std::string target = network.metadata("target");
  const bool own = options.at == AlarmOptions().at;
  if (own && estimates_slide(network) && network.alarm_at() == 0)
    throw InputError("at", "missing, and not in the network's file",
                     "give 1.2 times the largest answer in a hold that holds (tactel tare --hold --network)");
  if (own) options.at = network.alarm_at() > 0 ? network.alarm_at() : usual_at;
  check(options, *options.touch, network.has_bound());
  const bool never = options.at == std::numeric_limits<float>::infinity();
  if (!never && options.signal == AlarmSignal::slip && !target.empty() && !estimates_slide(network))
    throw InputError("network", "estimates " + target, "give one of S, slid or slip_path: the alarm is for slip");
  return options;
}

AlarmOptions checked(std::size_t tactels, std::size_t axes, AlarmOptions options) {
  if (options.signal != AlarmSignal::moved) throw InputError("signal", "slip", "must be moved without a network");
  if (tactels == 0) throw InputError("tactels", "0", "must be 1 or more");
  if (axes == 0 || axes > most_axes) throw InputError("axes", std::to_string(axes), "must be 1, 2 or 3");
  options.touch = options.touch.value_or(0);
  options.rest = true;
  if (options.at == AlarmOptions().at) options.at = usual_at;
  check(options, *options.touch, false);
  return options;
}

}  // namespace

struct Alarm::State {
  State(const AlarmOptions& rules, std::size_t numbers, std::size_t normals)
      : options(rules), touch(*rules.touch), inputs(numbers), tactels(normals) {
    if (options.rest) rest.emplace(inputs, tactels, touch);
  }
  State(const SlipEstimator& network, const AlarmOptions& rules)
      : options(rules),
        touch(*rules.touch),
        history(std::in_place, network, touch),
        inputs(history->inputs()),
        tactels(network.tactels()) {
    if (options.rest) rest.emplace(inputs, tactels, touch);
  }
  bool by_moved() const noexcept { return options.signal == AlarmSignal::moved; }
  /// Whether the alarm judges changes since the rest.
  bool by_changes() const noexcept { return by_moved() || needs_rest; }
  bool seeks_rest(const AlarmAnswer& given) const noexcept {
    return by_changes() && given.rest == false && given.answer.status != AnswerStatus::not_finite;
  }
  bool nothing(const AlarmAnswer& given) const noexcept {
    return given.contact == false || (!by_changes() && given.answer.status == AnswerStatus::no_stress);
  }
  float end() const noexcept {
    const bool by_share = by_moved() || of_slid;
    return by_share ? options.at / static_cast<float>(infer::hold_margin) : options.at - release;
  }
  float number_of(const AlarmAnswer& given) const noexcept {
    if (nothing(given) || seeks_rest(given)) return 0;
    return by_moved() ? given.moved : has_bound ? given.answer.slip_upper : given.answer.slip_index;
  }

  AlarmOptions options;
  double touch;  ///< MPa
  std::optional<SlipHistory> history{};
  std::optional<infer::RestReference> rest{};
  std::size_t inputs, tactels;
  bool has_bound = false, needs_rest = false, takes_friction = false, of_slid = false;  ///< of the network
  bool on = false;
  int asking = 0;  ///< frames in a row that asked for the alarm
};

Alarm::Alarm(const SlipEstimator& network, const AlarmOptions& options)
    : state_(new State(network, checked(network, options))) {
  state_->has_bound = network.has_bound(), state_->needs_rest = network.needs_rest();
  state_->takes_friction = network.takes_friction(), state_->of_slid = estimates_slide(network);
}
Alarm::Alarm(std::size_t tactels, std::size_t axes, const AlarmOptions& options)
    : state_(new State(checked(tactels, axes, options), tactels * axes, tactels)) {}
Alarm::~Alarm() { delete state_; }

std::size_t Alarm::inputs() const noexcept { return state_->inputs; }

AlarmAnswer Alarm::answer(std::span<const float> frame) noexcept {
  if (state_->history) return answer(frame, state_->history->estimate(frame));
  const bool finite = std::ranges::all_of(frame, [](float s) { return std::isfinite(s); });
  const AnswerStatus status = frame.size() != inputs() ? AnswerStatus::wrong_size
                              : finite                 ? AnswerStatus::ok
                                                       : AnswerStatus::not_finite;
  const float none = std::nanf("");
  return answer(frame, {none, none, status, {none, none}, 0, 0, {}});
}

AlarmAnswer Alarm::answer(std::span<const float> frame, const Answer& estimated) noexcept {
  AlarmAnswer given{.answer = estimated};
  const double touch = state_->touch;
  const bool whole = given.answer.status != AnswerStatus::wrong_size && frame.size() == inputs();
  if (touch > 0 && whole) {
    // NaN touches.
    given.contact = given.answer.status == AnswerStatus::not_finite ||
                    !std::ranges::all_of(frame.first(state_->tactels), [&](float s) { return std::abs(s) < touch; });
    if (!*given.contact) given.answer.slip_index = given.answer.slip_upper = std::nanf("");
  }
  if (state_->rest && whole) {
    given.moved = state_->rest->next(frame, *given.contact);
    given.rest = state_->rest->found();
    if (state_->needs_rest && !*given.rest) given.answer.slip_index = given.answer.slip_upper = std::nanf("");
  }
  given.acted_on = state_->number_of(given);
  return given;
}

// A frame without an answer neither asks for the alarm nor ends it, nor the row of those that ask.
AlarmAnswer Alarm::judge(AlarmAnswer given) noexcept {
  const AlarmOptions& rules = state_->options;
  const bool by_moved = state_->by_moved();
  given.acted_on = state_->number_of(given);
  const bool none = std::isnan(given.acted_on), nothing = state_->nothing(given);
  const bool unlike = given.answer.unlike != 0 && !none && !nothing && !by_moved;
  const float width =
      state_->has_bound && !by_moved ? given.answer.slip_interval[1] - given.answer.slip_interval[0] : 0;
  const bool near = given.acted_on >= rules.at, wide = near && !(width <= rules.widest);
  if (unlike && !rules.ignore_unlike ? rules.at <= 1 : near && !wide) {
    state_->asking = std::min(state_->asking + 1, rules.hold);
    if (state_->asking == rules.hold) state_->on = true;
  } else if (!none) {
    state_->asking = 0;
    if (given.acted_on < state_->end()) state_->on = false;
  }
  given.on = state_->on;
  given.cannot_tell = none || unlike || (wide && !given.on) || (!nothing && state_->seeks_rest(given));
  return given;
}

void Alarm::friction(double mu, double spread) {
  if (!state_->takes_friction)
    throw InputError("friction", std::to_string(mu), "leave it out: the network does not take friction");
  if (!(mu >= 0 && mu <= most_friction)) refuse("friction", mu, "must be 0, not known, or above, at most 1000");
  if (!(spread >= 0 && spread <= most_friction)) refuse("spread", spread, "must be 0 or above, at most 1000");
  state_->history->friction(static_cast<float>(mu), static_cast<float>(spread));
}

float Alarm::slides() noexcept { return state_->history ? state_->history->slides() : std::nanf(""); }

void Alarm::rest() noexcept {
  if (state_->history) state_->history->rest();
  if (state_->rest) state_->rest->forget();
  if (state_->by_changes()) state_->on = false, state_->asking = 0;
}

void Alarm::clear() noexcept {
  if (state_->history) state_->history->clear();
  if (state_->rest) state_->rest->forget();
  state_->on = false, state_->asking = 0;
}

}  // namespace tactel
