// SPDX-License-Identifier: Apache-2.0

// tactel.h: the functions of tactel/infer.h for C.
#include <tactel.h>
#include <tactel/infer.h>

#include <algorithm>
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

namespace {

using tactel::AnswerStatus;

static_assert(sizeof(tactel_answer) == sizeof(tactel::Answer) && sizeof(tactel_answer) == 32);
static_assert(TACTEL_OK == int(AnswerStatus::ok) && TACTEL_NO_STRESS == int(AnswerStatus::no_stress));
static_assert(TACTEL_NOT_FINITE == int(AnswerStatus::not_finite) && TACTEL_OVERFLOW == int(AnswerStatus::overflow));
static_assert(TACTEL_WRONG_SIZE == int(AnswerStatus::wrong_size));

thread_local std::string last_error;

tactel_answer c_answer(const tactel::Answer& answer) noexcept {
  tactel_answer same;
  std::memcpy(&same, &answer, sizeof same);
  return same;
}

}  // namespace

tactel_estimator* tactel_load(const char* path) {
  last_error.clear();
  try {
    if (path != nullptr) return new tactel_estimator{tactel::SlipEstimator::load(path)};
    last_error = "tactel_load: no path; give the name of a network file";
  } catch (const std::bad_alloc&) {
    last_error = "tactel_load: out of memory; free some";
  } catch (const std::exception& error) {
    last_error = error.what();
  }
  return nullptr;
}

void tactel_free(tactel_estimator* estimator) { delete estimator; }

size_t tactel_inputs(const tactel_estimator* estimator) { return estimator->estimator.inputs(); }

tactel_answer tactel_estimate(const tactel_estimator* estimator, const float* frame, size_t count) {
  return c_answer(estimator->estimator.estimate({frame, count}));
}

void tactel_estimate_all(const tactel_estimator* estimator, const float* frames, size_t answers, tactel_answer* out) {
  const size_t inputs = estimator->estimator.inputs();
  tactel::Answer some[16];
  for (size_t i = 0; i < answers; i += std::size(some)) {
    const size_t count = std::min(std::size(some), answers - i);
    estimator->estimator.estimate({frames + i * inputs, count * inputs}, {some, count});
    std::transform(some, some + count, out + i, c_answer);
  }
}

tactel_history* tactel_history_create(const tactel_estimator* estimator) {
  last_error.clear();
  try {
    return new tactel_history{tactel::SlipHistory(estimator->estimator)};
  } catch (const std::exception&) {
    last_error = "tactel_history_create: out of memory; free some";
  }
  return nullptr;
}

void tactel_history_free(tactel_history* history) { delete history; }

tactel_answer tactel_history_estimate(tactel_history* history, const float* frame, size_t count) {
  return c_answer(history->history.estimate({frame, count}));
}

void tactel_history_clear(tactel_history* history) { history->history.clear(); }

const char* tactel_error(void) { return last_error.c_str(); }

const char* tactel_status_name(uint32_t status) { return tactel::name(static_cast<AnswerStatus>(status)); }

const char* tactel_version(void) { return tactel::version(); }
