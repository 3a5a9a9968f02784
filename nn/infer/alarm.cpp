// SPDX-License-Identifier: Apache-2.0
#include <tactel/infer.h>

#include <algorithm>
#include <cmath>

#include "nn/infer/grip_score.h"
#include "nn/infer/rest_reference.h"
#include "nn/infer/sensor_frames.h"
#include "nn/network.h"

namespace tactel {
namespace {

constexpr float usual_at = 0.8f;      // of S
constexpr float release = 0.05f;      // of S, below `at`
constexpr double usual_touch = 1e-3;  // MPa, without a network
constexpr std::size_t most_axes = 3;  // of a tactel
constexpr double most_friction = 1e3, most_rate = 1e6;
constexpr float full_index = 0.6f;  // of a slide: from here on `left` counts in full
constexpr float least_share = 0.1f, most_share = 2;
constexpr float largest_share = 0.35f;  // of the scores of several pads

[[noreturn]] void refuse(const char* place, double value, const char* fix) {
  throw InputError(place, std::to_string(value), fix);
}

/// touch: MPa.
void check(const AlarmOptions& options, double touch, bool has_bound) {
  const bool never = options.at == std::numeric_limits<float>::infinity();
  const bool moved = options.signal == AlarmSignal::moved, left = options.signal == AlarmSignal::left;
  if (left && !(options.at > 0)) refuse("at", options.at, "must be above 0 of left, whose alarm is 1");
  if (moved && !(never || (options.at > 0 && options.at < infer::most_moved)))
    refuse("at", options.at, "must be above 0 and below 0.5: 1.2 times the largest `moved` of a hold");
  if (!moved && !left && !(never || (options.at >= 0 && options.at <= 1))) refuse("at", options.at, "must be 0 to 1");
  if (!(touch >= 0 && std::isfinite(touch))) refuse("touch", touch, "must be 0 or above, MPa");
  if (options.rest && touch == 0)
    refuse("touch", touch, "must be above 0 with a rest, which ends where nothing touches, MPa");
  if (options.hold < 1) refuse("hold", options.hold, "must be 1 frame or more");
  if (!(options.widest >= 0)) refuse("widest", options.widest, "must be 0 or above");
  if (std::isfinite(options.widest) && !has_bound)
    refuse("widest", options.widest, "leave it out for a network without a bound: it has no interval");
  if (!(options.rate > 0 && options.rate <= most_rate)) refuse("rate", options.rate, "must be above 0, at most 1e6 Hz");
  if (!(options.slide >= 0 && options.slide <= most_friction))
    refuse("slide", options.slide, "must be 0, not known, or Q / P of a slide, at most 1000");
}

infer::PadShape checked_shape(std::size_t tactels, std::size_t axes, const AlarmOptions& options) {
  const infer::PadShape shape{tactels, axes, options.columns, options.aspect};
  if (shape.columns > 0 && tactels % shape.columns != 0)
    throw InputError("columns", std::to_string(shape.columns), "must divide the tactels, " + std::to_string(tactels));
  if (!(shape.aspect > 0 && std::isfinite(shape.aspect))) refuse("aspect", shape.aspect, "must be above 0");
  const HeldGrip& held = options.held;
  if (!(held.at >= 0 && std::isfinite(held.at))) refuse("held.at", held.at, "must be 0, no hold, or above");
  const std::size_t n = infer::PadMoments(shape).count();
  if (held.at > 0 && infer::whitening(held.covariance, n).empty())
    throw InputError("held.covariance", "not positive definite", "give that of tactel tare --hold");
  return shape;
}

bool estimates_slide(const SlipEstimator& network) {
  const std::string target = network.metadata("target");
  return !target.empty() && nn::is_slide(nn::parse_target(target));
}

/// Returns the rules with their threshold, with a rest where one is needed, and with a threshold of touch.
AlarmOptions checked(const SlipEstimator& network, AlarmOptions options) {
  options.touch = options.touch.value_or(network.smallest_peak());
  options.rest |= network.needs_rest() || options.signal != AlarmSignal::slip;
  const std::string target = network.metadata("target");
  if (!network.metadata("inputs").empty())
    throw InputError("network", "of markers", "give one of stresses, by which an alarm goes");
  const bool left = options.signal == AlarmSignal::left, own = options.at == AlarmOptions().at && !left;
  if (left && options.at == AlarmOptions().at) options.at = 1;
  if (own && estimates_slide(network) && network.alarm_at() == 0)
    throw InputError("at", "missing, and not in the network's file",
                     "give 1.2 times the largest answer in a hold that holds (tactel tare --hold --network)");
  if (own) options.at = network.alarm_at() > 0 ? network.alarm_at() : usual_at;
  check(options, *options.touch, network.has_bound());
  const bool never = options.at == std::numeric_limits<float>::infinity();
  if (!never && options.signal == AlarmSignal::slip && !target.empty() && !estimates_slide(network))
    throw InputError("network", "estimates " + target,
                     std::string("give one of S, ") + nn::slide_names + ": the alarm is for slip");
  return options;
}

AlarmOptions checked(std::size_t tactels, std::size_t axes, AlarmOptions options) {
  if (options.signal == AlarmSignal::slip)
    throw InputError("signal", "slip", "must be left or moved without a network");
  if (tactels == 0) throw InputError("tactels", "0", "must be 1 or more");
  if (axes == 0 || axes > most_axes) throw InputError("axes", std::to_string(axes), "must be 1, 2 or 3");
  options.touch = options.touch.value_or(usual_touch);
  options.rest = true;
  if (options.at == AlarmOptions().at) options.at = options.signal == AlarmSignal::left ? 1 : usual_at;
  check(options, *options.touch, false);
  return options;
}

/// Takes the index of a slide into `left`.
void take_index(AlarmAnswer& given) noexcept {
  if (std::isnan(given.index)) return;
  const float share = given.index / full_index, clipped = std::clamp(share, least_share, most_share);
  given.left = std::isnan(given.left) ? share : given.left * clipped * clipped * clipped;
}

}  // namespace

void join(std::span<AlarmAnswer> pads) noexcept {
  const float none = std::nanf("");
  float most = none, least = none, of_hold = none, index = none;
  for (const AlarmAnswer& pad : pads) {
    most = std::fmax(most, pad.score), least = std::fmin(least, pad.score);
    of_hold = std::fmax(of_hold, pad.of_hold), index = std::fmin(index, pad.index);
  }
  for (AlarmAnswer& pad : pads) {
    pad.score = largest_share * most + (1 - largest_share) * least, pad.of_hold = of_hold, pad.index = index;
    pad.left = std::fmax(pad.score, of_hold);
  }
}

const char* name(CannotTell why) noexcept {
  constexpr const char* names[] = {"",        "not a number", "frozen",        "wrong sign",
                                   "no rest", "unlike",       "wide interval", "no answer"};
  const auto k = static_cast<std::size_t>(why);
  return k < std::size(names) ? names[k] : "unknown";
}

struct Alarm::State {
  State(const AlarmOptions& rules, std::size_t tactels_, std::size_t axes)
      : options(rules), touch(*rules.touch), inputs(tactels_ * axes), tactels(tactels_), health(inputs, tactels) {
    if (by_left())
      score.emplace(checked_shape(tactels, axes, rules), rules, touch);
    else if (options.rest)
      rest.emplace(inputs, tactels, touch);
  }
  State(const SlipEstimator& network, const AlarmOptions& rules)
      : State(rules, network.tactels(), SlipHistory(network).inputs() / network.tactels()) {
    history.emplace(network, touch);
  }
  bool by_moved() const noexcept { return options.signal == AlarmSignal::moved; }
  bool by_left() const noexcept { return options.signal == AlarmSignal::left; }
  bool by_slip() const noexcept { return options.signal == AlarmSignal::slip; }
  /// Whether the alarm judges changes since the rest.
  bool by_changes() const noexcept { return !by_slip() || needs_rest; }
  bool seeks_rest(const AlarmAnswer& given) const noexcept {
    if (by_left()) return std::isnan(given.left);
    return by_changes() && given.rest == false && given.answer.status != AnswerStatus::not_finite;
  }
  bool nothing(const AlarmAnswer& given) const noexcept {
    return given.contact == false || (given.released && given.rest == false) ||
           (!by_changes() && given.answer.status == AnswerStatus::no_stress);
  }
  float end() const noexcept {
    const bool by_share = !by_slip() || of_slid;
    return by_share ? options.at / static_cast<float>(infer::hold_margin) : options.at - release;
  }
  float number_of(const AlarmAnswer& given) const noexcept {
    if (nothing(given) || seeks_rest(given)) return 0;
    if (by_left()) return given.left;
    return by_moved() ? given.moved : has_bound ? given.answer.slip_upper : given.answer.slip_index;
  }
  bool touches(std::span<const float> frame, AnswerStatus status) const noexcept {
    const auto normals = frame.first(tactels);
    if (by_left() && std::ranges::any_of(normals, [](float s) { return std::isfinite(s); }))
      return std::ranges::any_of(normals, [&](float s) { return std::abs(s) >= touch; });
    // NaN touches.
    return status == AnswerStatus::not_finite ||
           !std::ranges::all_of(normals, [&](float s) { return std::abs(s) < touch; });
  }

  AlarmOptions options;
  double touch;  ///< MPa
  std::optional<SlipHistory> history{};
  std::optional<infer::RestReference> rest{};
  std::optional<infer::GripScore> score{};  ///< of AlarmSignal::left, in place of `rest`
  std::size_t inputs, tactels;
  infer::FrameHealth health;
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
    : state_(new State(checked(tactels, axes, options), tactels, axes)) {}
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
  const bool whole = given.answer.status != AnswerStatus::wrong_size && frame.size() == inputs();
  if (whole) given.why = state_->health.next(frame);
  if (state_->touch > 0 && whole) {
    given.contact = state_->touches(frame, given.answer.status);
    if (!*given.contact) given.answer.slip_index = given.answer.slip_upper = std::nanf("");
  }
  if (state_->rest && whole) {
    given.moved = state_->rest->next(frame, *given.contact);
    given.rest = state_->rest->found();
    if (state_->needs_rest && !*given.rest) given.answer.slip_index = given.answer.slip_upper = std::nanf("");
  }
  if (state_->score && whole) {
    const infer::GripReading said = state_->score->next(frame, *given.contact);
    given.rest = said.rest, given.released = said.released, given.moved = said.moved;
    given.calm = said.calm, given.score = said.score, given.of_hold = said.of_hold, given.index = said.index;
    given.left = std::fmax(said.score, said.of_hold);
  }
  given.acted_on = state_->number_of(given);
  return given;
}

// A frame without an answer neither asks for the alarm nor ends it, nor the row of those that ask.
AlarmAnswer Alarm::judge(AlarmAnswer given) noexcept {
  const AlarmOptions& rules = state_->options;
  const bool by_slip = state_->by_slip();
  if (state_->by_left()) take_index(given);
  given.acted_on = state_->number_of(given);
  const bool none = std::isnan(given.acted_on), nothing = state_->nothing(given);
  const bool unlike = given.answer.unlike != 0 && !none && !nothing && by_slip;
  const float width = state_->has_bound && by_slip ? given.answer.slip_interval[1] - given.answer.slip_interval[0] : 0;
  const bool near = given.acted_on >= rules.at && !given.released, wide = near && !(width <= rules.widest);
  if (unlike && !rules.ignore_unlike ? rules.at <= 1 : near && !wide) {
    state_->asking = std::min(state_->asking + 1, rules.hold);
    if (state_->asking == rules.hold) state_->on = true;
  } else if (!none) {
    state_->asking = 0;
    if (given.acted_on < state_->end()) state_->on = false;
  }
  given.on = state_->on;
  const bool touches = given.contact == true && !nothing;
  if (!touches && given.why != CannotTell::not_a_number) given.why = CannotTell::none;
  if (given.why == CannotTell::none)
    given.why = unlike                                  ? CannotTell::unlike
                : wide && !given.on                     ? CannotTell::wide
                : !nothing && state_->seeks_rest(given) ? CannotTell::no_rest
                : none                                  ? CannotTell::no_answer
                                                        : CannotTell::none;
  given.cannot_tell = given.why != CannotTell::none;
  return given;
}

void Alarm::friction(double mu, double spread) {
  if (!state_->takes_friction)
    throw InputError("friction", std::to_string(mu), "leave it out: the network does not take friction");
  if (!(mu >= 0 && mu <= most_friction)) refuse("friction", mu, "must be 0, not known, or above, at most 1000");
  if (!(spread >= 0 && spread <= most_friction)) refuse("spread", spread, "must be 0 or above, at most 1000");
  state_->history->friction(static_cast<float>(mu), static_cast<float>(spread));
}

float Alarm::slides() noexcept {
  const float mu = state_->history ? state_->history->slides() : std::nanf("");
  return state_->score ? state_->score->slides() : mu;
}

void Alarm::rate(double hz) noexcept {
  if (state_->score && hz > 0 && hz <= most_rate) state_->score->rate(hz);
}

void Alarm::rest() noexcept {
  if (state_->history) state_->history->rest();
  if (state_->rest) state_->rest->forget();
  if (state_->score) state_->score->forget();
  if (state_->by_changes()) state_->on = false, state_->asking = 0;
}

void Alarm::clear() noexcept {
  if (state_->history) state_->history->clear();
  if (state_->rest) state_->rest->forget();
  if (state_->score) state_->score->clear();
  state_->on = false, state_->asking = 0;
}

}  // namespace tactel
