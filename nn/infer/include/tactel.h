// SPDX-License-Identifier: Apache-2.0
/* Slippage index from tactel stresses, in C: networks that tactel trained, frame to S. Link tactel::infer (CMake) or
   `pkg-config --libs tactel`.
   Every pointer may be NULL. A function that needs another returns NULL, 0 or an answer of TACTEL_WRONG_SIZE; then
   tactel_error() names the argument. */
#ifndef TACTEL_H
#define TACTEL_H

#include <stddef.h>
#include <stdint.h>
#include <tactel/export.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A loaded network. It never changes: threads may share it. */
typedef struct tactel_estimator tactel_estimator;

/* Status of an answer. */
enum tactel_status {
  TACTEL_OK = 0,
  TACTEL_NO_STRESS = 1,  /* no normal stress, and the network scales by frame; the network received zeros */
  TACTEL_NOT_FINITE = 2, /* the frame contains NaN or infinity */
  TACTEL_OVERFLOW = 3,   /* the frame is finite, but a sum inside the network is not */
  TACTEL_WRONG_SIZE = 4  /* the frame has not tactel_inputs() numbers, or an argument is NULL */
};

/* The answer to a frame. Later versions may give a meaning to `reserved`, and change nothing else. */
typedef struct tactel_answer {
  float slip_index;       /* S, 0..1; NaN where the status is not TACTEL_OK or TACTEL_NO_STRESS */
  float slip_upper;       /* upper bound of S, at most 1; NaN where the network has none */
  uint32_t status;        /* enum tactel_status */
  float slip_interval[2]; /* S is within it, lower end first; NaN where the network has no bound */
  uint32_t unlike;        /* 1: the frame is unlike those of the learning set, and the bound says nothing */
  uint32_t reserved[2];
} tactel_answer;

/* Loads a network file (ONNX) that tactel wrote. Returns NULL where that fails; tactel_error() has the reason. */
TACTEL_API tactel_estimator* tactel_load(const char* path);

/* Frees an estimator. */
TACTEL_API void tactel_free(tactel_estimator* estimator);

/* Returns the numbers of an input: a normal and a shear stress for each tactel, in each of its frames. */
TACTEL_API size_t tactel_inputs(const tactel_estimator* estimator);

/* Returns S of one frame: [count] MPa, the normal stresses of all tactels first, then the shear stresses. Allocates
   nothing and takes no lock. */
TACTEL_API tactel_answer tactel_estimate(const tactel_estimator* estimator, const float* frame, size_t count);

/* Estimates frames [answers, tactel_inputs()] one after the other. */
TACTEL_API void tactel_estimate_all(const tactel_estimator* estimator, const float* frames, size_t answers,
                                    tactel_answer* out);

/* The frames of one sensor for a network with history (`tactel train --history`): each is taken in turn, and those kept
   by change of load are the earlier frames of the network's input. For one thread at a time. */
typedef struct tactel_history tactel_history;

/* Creates the history of a sensor; the estimator may be freed before it. Returns NULL without memory; tactel_error()
   has the reason. */
TACTEL_API tactel_history* tactel_history_create(const tactel_estimator* estimator);

/* Frees a history. */
TACTEL_API void tactel_history_free(tactel_history* history);

/* Takes the sensor's next frame: [count] MPa, a normal and a shear stress for each tactel, and returns S. Allocates
   nothing and takes no lock. */
TACTEL_API tactel_answer tactel_history_estimate(tactel_history* history, const float* frame, size_t count);

/* Forgets all frames: the next one begins a contact. */
TACTEL_API void tactel_history_clear(tactel_history* history);

/* Returns the message of the last call that failed in this thread, "place: problem; fix"; "" where none did since
   the last tactel_load or tactel_history_create. The text is valid until the next call of these in this thread. */
TACTEL_API const char* tactel_error(void);

/* Returns the name of a status: "ok", "no stress", ... */
TACTEL_API const char* tactel_status_name(uint32_t status);

/* Returns the version of the library, "1.0.0-rc1". */
TACTEL_API const char* tactel_version(void);

#ifdef __cplusplus
}
#endif

#endif
