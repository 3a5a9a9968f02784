// SPDX-License-Identifier: Apache-2.0

// tactel.h: the functions of tactel/infer.h for C.
#include <tactel.h>
#include <tactel/infer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <iterator>
#include <limits>
#include <new>
#include <string>

struct tactel_estimator {
  tactel::SlipEstimator estimator;
};

struct tactel_history {
  tactel::SlipHistory history;
};

struct tactel_alarm {
  tactel::Alarm alarm;
};

namespace {

using tactel::Alarm;
using tactel::AnswerStatus;

static_assert(sizeof(tactel_answer) == sizeof(tactel::Answer) && sizeof(tactel_answer) == 32);
static_assert(TACTEL_OK == int(AnswerStatus::ok) && TACTEL_NO_STRESS == int(AnswerStatus::no_stress));
static_assert(TACTEL_NOT_FINITE == int(AnswerStatus::not_finite) && TACTEL_OVERFLOW == int(AnswerStatus::overflow));
static_assert(TACTEL_LEFT == int(tactel::AlarmSignal::left) && TACTEL_NO_ANSWER == int(tactel::CannotTell::no_answer));
static_assert(TACTEL_WRONG_SIZE == int(AnswerStatus::wrong_size));

thread_local const char* last_error = "";
thread_local std::string load_error;  ///< text of last_error where it is no literal

/// The answer to a call with NULL. Takes no memory.
tactel_answer refused(const char* error) noexcept {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  last_error = error;
  return {none, none, TACTEL_WRONG_SIZE, {none, none}, 0, 0, {0}};
}

tactel_answer c_answer(const tactel::Answer& answer) noexcept {
  tactel_answer same;
  std::memcpy(&same, &answer, sizeof same);
  return same;
}

/// What `make` returns; NULL where it throws, with the reason in last_error.
template <class Make>
auto made(const char* out_of_memory, const Make& make) noexcept -> decltype(make()) {
  last_error = "";
  try {
    return make();
  } catch (const std::bad_alloc&) {
    last_error = out_of_memory;
  } catch (const std::exception& error) {
    load_error = error.what();
    last_error = load_error.c_str();
  }
  return nullptr;
}

template <class Make>
tactel_alarm* new_alarm(const tactel_alarm_options* options, const Make& make) noexcept {
  const tactel_alarm_options given = options != nullptr ? *options : tactel_alarm_defaults();
  return made("tactel_alarm_create: out of memory; free some", [&] {
    tactel::AlarmOptions rules{.at = given.at, .widest = given.widest};
    rules.hold = given.hold, rules.ignore_unlike = given.ignore_unlike != 0, rules.rest = given.rest != 0;
    if (!(given.touch < 0)) rules.touch = given.touch;
    if (given.signal < TACTEL_SLIP || given.signal > TACTEL_LEFT)
      throw tactel::InputError("signal", std::to_string(given.signal),
                               "must be TACTEL_SLIP, TACTEL_MOVED or TACTEL_LEFT");
    rules.signal = static_cast<tactel::AlarmSignal>(given.signal);
    if (given.rate != 0) rules.rate = given.rate;
    if (given.aspect != 0) rules.aspect = given.aspect;
    rules.columns = given.columns, rules.slide = given.slide;
    std::ranges::copy(given.covariance, rules.held.covariance.begin());
    rules.held.at = given.held_at;
    return make(rules);
  });
}

}  // namespace

tactel_estimator* tactel_load(const char* path) {
  last_error = "tactel_load: no path; give the name of a network file";
  if (path == nullptr) return nullptr;
  return made("tactel_load: out of memory; free some",
              [&] { return new tactel_estimator{tactel::SlipEstimator::load(path)}; });
}

void tactel_free(tactel_estimator* estimator) { delete estimator; }

size_t tactel_inputs(const tactel_estimator* estimator) {
  if (estimator != nullptr) return estimator->estimator.inputs();
  last_error = "tactel_inputs: no estimator; give one of tactel_load";
  return 0;
}

tactel_answer tactel_estimate(const tactel_estimator* estimator, const float* frame, size_t count) {
  if (estimator == nullptr) return refused("tactel_estimate: no estimator; give one of tactel_load");
  if (frame == nullptr) return refused("tactel_estimate: no frame; give tactel_inputs() numbers");
  return c_answer(estimator->estimator.estimate({frame, count}));
}

void tactel_estimate_all(const tactel_estimator* estimator, const float* frames, size_t answers, tactel_answer* out) {
  if (answers == 0) return;
  if (estimator == nullptr || frames == nullptr || out == nullptr) {
    const tactel_answer none = refused("tactel_estimate_all: no estimator, frames or answers; give all three");
    if (out != nullptr) std::fill_n(out, answers, none);
    return;
  }
  const size_t inputs = estimator->estimator.inputs();
  tactel::Answer some[16];
  for (size_t i = 0; i < answers; i += std::size(some)) {
    const size_t count = std::min(std::size(some), answers - i);
    estimator->estimator.estimate({frames + i * inputs, count * inputs}, {some, count});
    std::transform(some, some + count, out + i, c_answer);
  }
}

tactel_history* tactel_history_create(const tactel_estimator* estimator) {
  last_error = "";
  try {
    if (estimator != nullptr) return new tactel_history{tactel::SlipHistory(estimator->estimator)};
    last_error = "tactel_history_create: no estimator; give one of tactel_load";
  } catch (const std::exception&) {
    last_error = "tactel_history_create: out of memory; free some";
  }
  return nullptr;
}

void tactel_history_free(tactel_history* history) { delete history; }

tactel_answer tactel_history_estimate(tactel_history* history, const float* frame, size_t count) {
  if (history == nullptr) return refused("tactel_history_estimate: no history; give one of tactel_history_create");
  if (frame == nullptr) return refused("tactel_history_estimate: no frame; give the numbers of one");
  return c_answer(history->history.estimate({frame, count}));
}

void tactel_history_clear(tactel_history* history) {
  if (history != nullptr) history->history.clear();
}

tactel_alarm_options tactel_alarm_defaults(void) {
  const tactel::AlarmOptions rules;
  return {rules.at,
          -1,
          rules.widest,
          rules.hold,
          rules.ignore_unlike,
          rules.rest,
          TACTEL_SLIP,
          rules.rate,
          0,
          rules.aspect,
          {},
          0,
          0};
}

tactel_alarm* tactel_alarm_create(const tactel_estimator* estimator, const tactel_alarm_options* options) {
  last_error = "tactel_alarm_create: no estimator; give one of tactel_load";
  if (estimator == nullptr) return nullptr;
  return new_alarm(options, [&](const auto& rules) { return new tactel_alarm{Alarm(estimator->estimator, rules)}; });
}

tactel_alarm* tactel_alarm_create_moved(size_t tactels, size_t axes, const tactel_alarm_options* options) {
  tactel_alarm_options left = tactel_alarm_defaults();
  left.signal = TACTEL_LEFT;
  return new_alarm(options != nullptr ? options : &left,
                   [&](const auto& rules) { return new tactel_alarm{Alarm(tactels, axes, rules)}; });
}

void tactel_alarm_free(tactel_alarm* alarm) { delete alarm; }

tactel_alarm_answer tactel_alarm_next(tactel_alarm* alarm, const float* frame, size_t count) {
  if (alarm == nullptr || frame == nullptr)
    return {refused("tactel_alarm_next: no alarm or frame; give both"),
            -1,
            NAN,
            0,
            1,
            -1,
            NAN,
            TACTEL_NO_ANSWER,
            NAN,
            NAN,
            NAN,
            0};
  const tactel::AlarmAnswer answer = alarm->alarm.next({frame, count});
  return {c_answer(answer.answer),
          answer.contact ? int{*answer.contact} : -1,
          answer.acted_on,
          answer.on,
          answer.cannot_tell,
          answer.rest ? int{*answer.rest} : -1,
          answer.moved,
          static_cast<int>(answer.why),
          answer.left,
          answer.calm,
          answer.index,
          answer.released};
}

int tactel_alarm_friction(tactel_alarm* alarm, double mu, double spread) {
  last_error = "tactel_alarm_friction: no alarm; give one of tactel_alarm_create";
  if (alarm == nullptr) return 0;
  const auto told = made("tactel_alarm_friction: out of memory; free some", [&] {
    alarm->alarm.friction(mu, spread);
    return alarm;
  });
  return told != nullptr;
}

float tactel_alarm_slides(tactel_alarm* alarm) { return alarm != nullptr ? alarm->alarm.slides() : NAN; }

void tactel_alarm_rate(tactel_alarm* alarm, double hz) {
  if (alarm != nullptr) alarm->alarm.rate(hz);
}

void tactel_alarm_rest(tactel_alarm* alarm) {
  if (alarm != nullptr) alarm->alarm.rest();
}

void tactel_alarm_clear(tactel_alarm* alarm) {
  if (alarm != nullptr) alarm->alarm.clear();
}

const char* tactel_error(void) { return last_error; }

const char* tactel_status_name(uint32_t status) { return tactel::name(static_cast<AnswerStatus>(status)); }

const char* tactel_cannot_tell_name(int why) { return tactel::name(static_cast<tactel::CannotTell>(why)); }

const char* tactel_version(void) { return tactel::version(); }
