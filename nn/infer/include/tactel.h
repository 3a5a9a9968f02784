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
  uint32_t unlike;        /* 1: the frame is unlike those of the learning set: the network cannot tell */
  uint32_t beyond_learnt; /* 1: a normal stress is above 10 times the largest that was learnt: are they MPa? */
  uint32_t reserved[1];
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

/* The alarm of `tactel monitor`: frames of one sensor in turn. For one thread at a time. */
typedef struct tactel_alarm tactel_alarm;

/* The number that an alarm judges. */
enum tactel_signal {
  TACTEL_SLIP = 0,  /* the upper bound of S, or S */
  TACTEL_MOVED = 1, /* `moved` */
  TACTEL_LEFT = 2   /* `left` */
};

/* Why a frame cannot tell, as tactel::CannotTell of tactel/infer.h. */
enum tactel_cannot_tell {
  TACTEL_CAN_TELL = 0,
  TACTEL_NOT_A_NUMBER = 1,
  TACTEL_FROZEN = 2,
  TACTEL_WRONG_SIGN = 3,
  TACTEL_NO_REST = 4,
  TACTEL_UNLIKE = 5,
  TACTEL_WIDE = 6,
  TACTEL_NO_ANSWER = 7
};

/* Rules of an alarm, as tactel::AlarmOptions of tactel/infer.h. */
typedef struct tactel_alarm_options {
  float at;          /* begins where the upper bound of S (S itself without one) reaches this, and ends 0.05 below; -1:
                        that of the network's file, else 0.8 */
  double touch;      /* MPa: below it a frame is no contact; negative: the smallest peak that the network learnt */
  float widest;      /* no alarm begins at a wider interval of S */
  int hold;          /* it begins at the last of so many frames in a row that ask for it */
  int ignore_unlike; /* 0: a frame that is unlike those learnt asks for the alarm; else its S decides */
  int rest;          /* 1: answers have `rest` and `moved` */
  int signal;        /* what `at` is of, enum tactel_signal; all but TACTEL_SLIP stand for `rest`, too */
  /* of TACTEL_LEFT, whose `at` is 1 where it is -1: */
  double rate;          /* Hz, of the frames; 0: 60 */
  size_t columns;       /* tactels along x, x fastest; 0: as many as along y */
  double aspect;        /* pitch along y over that along x; 0: 1 */
  float covariance[36]; /* of a recorded hold: as [hold] of a calibration file has it */
  float held_at;        /* the same; 0: no hold was recorded */
  float slide;          /* Q / P with its torque of a slide, as [slide] has it; 0: none is known */
} tactel_alarm_options;

/* What an alarm says about a frame. */
typedef struct tactel_alarm_answer {
  tactel_answer answer;    /* its S and upper bound are NaN without contact */
  int contact;             /* 0 or 1; -1 without a threshold of touch */
  float acted_on;          /* number that the alarm judges; 0 without contact */
  int on;                  /* 1: the alarm */
  int cannot_tell;         /* 1: by `why` */
  int rest;                /* 0 or 1: a rest of this grip is known; -1 where it is not asked for */
  float moved;             /* change of the stresses since rest, over the sum of the normal stresses then; NaN: none */
  int why;                 /* enum tactel_cannot_tell */
  float left, calm, index; /* of TACTEL_LEFT, as tactel::AlarmAnswer of tactel/infer.h; NaN: none */
  int released;            /* 1: the hand has opened */
} tactel_alarm_answer;

/* Returns the default rules: at 0.8, the network's own touch, any width, 1 frame, unlike frames ask for it. */
TACTEL_API tactel_alarm_options tactel_alarm_defaults(void);

/* Creates an alarm; the estimator may be freed before it. `options` may be NULL: the default ones. Returns NULL for
   rules out of range and without memory; tactel_error() has the reason. */
TACTEL_API tactel_alarm* tactel_alarm_create(const tactel_estimator* estimator, const tactel_alarm_options* options);

/* The same without a network, by TACTEL_LEFT or TACTEL_MOVED: frames of `tactels` with 1 to 3 axes each. `options` may
   be NULL: TACTEL_LEFT, touch 0.001 MPa. */
TACTEL_API tactel_alarm* tactel_alarm_create_moved(size_t tactels, size_t axes, const tactel_alarm_options* options);

/* Frees an alarm. */
TACTEL_API void tactel_alarm_free(tactel_alarm* alarm);

/* Takes the sensor's next frame: [count] MPa. Allocates nothing and takes no lock. A frame without an answer leaves the
   alarm as it is. */
TACTEL_API tactel_alarm_answer tactel_alarm_next(tactel_alarm* alarm, const float* frame, size_t count);

/* Tells a network that takes friction mu, 0: it is not known, and its relative standard deviation. Returns 0 for
   numbers out of range and a network that does not take friction; tactel_error() says why. */
TACTEL_API int tactel_alarm_friction(tactel_alarm* alarm, double mu, double spread);

/* Where the object is known to slide in the newest frame: reads mu, or of TACTEL_LEFT Q / P, tells it from the next
   frame on, and returns it; NaN where there is none (tactel::Alarm::slides of tactel/infer.h). */
TACTEL_API float tactel_alarm_slides(tactel_alarm* alarm);

/* Says that frames come at another rate, Hz (tactel::Alarm::rate of tactel/infer.h). */
TACTEL_API void tactel_alarm_rate(tactel_alarm* alarm, double hz);

/* Seeks rest anew from the next frame on, after a change of the grip; ends an alarm that needs the rest. */
TACTEL_API void tactel_alarm_rest(tactel_alarm* alarm);

/* Ends the alarm and forgets all frames. */
TACTEL_API void tactel_alarm_clear(tactel_alarm* alarm);

/* Returns the message of the last call that failed in this thread, "place: problem; fix"; "" where none did since
   the last tactel_load or one of the _create functions. The text is valid until the next call of these in this thread.
 */
TACTEL_API const char* tactel_error(void);

/* Returns the name of a status: "ok", "no stress", ... */
TACTEL_API const char* tactel_status_name(uint32_t status);

/* Returns the name of a reason: "not a number", "frozen", ...; "" of TACTEL_CAN_TELL. */
TACTEL_API const char* tactel_cannot_tell_name(int why);

/* Returns the version of the library, "1.0.0-rc1". */
TACTEL_API const char* tactel_version(void);

#ifdef __cplusplus
}
#endif

#endif
