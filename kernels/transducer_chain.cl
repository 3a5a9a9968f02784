// SPDX-License-Identifier: Apache-2.0
/* Readings of transducers from their stresses, for many contacts; twin: nn/transducer_chain.*. For each channel, over
   the load steps k = 0, 1, ... of a contact:
     s_k = the stress at the tactel's shifted place, linear between tactels, and a share of its neighbours' stresses;
           0 where it is dead
     x_k = (1 + gain_spread g) (s_k - lag h_k),    h_k = lag_decay h_{k-1} + lag_pass (s_k - s_{k-1}): arrives late
     y_k = decay y_{k-1} + pass (x_k - x_{k-1})    the charge amplifier: tau y' + y = tau x', exactly where x is linear
                                                   between steps of h: decay = exp(-h / tau), pass = (1 - decay) tau / h
     reading_k = cut off and rounded (y_k + offset_spread o + noise n_k)
   with normal numbers g, o, n_k from Philox counters {item, item's upper half, stream, which}:
     g, o     item: the instance, stream 7, which: the channel; words 0, 1
     n_k      item: the contact, stream 6, which: k / 4 channels + channel; words 0, 1 for k mod 4 = 0, 1, else 2, 3
     spreads  item: the instance, stream 10, which 0; words 0 (gains), 1 (offsets), 2 (noise), 3 (tau): evenly between
              the least and the most; which 1, word 0: the bits, least + word times their count over 2^32
     faults   item: the instance, stream 11, which: the channel; word 0: dead, words 2, 3: the share of neighbours
              and which: channels + the tactel; words 0, 1: the shift of its place
   (Box and Muller 1958: the pair's cosine comes first), and the instance is the contact itself, or word 0 of
   {contact, stream 8, 0} times `instances` over 2^32.

   One work-item takes LANES channels of one contact. Built with -D REAL, LANES. */
#include "shared/chain_settings.h"
#include "shared/group.h"
#include "shared/lanes.h"
#include "shared/philox.h"
#include "shared/random_streams.h"
#include "shared/unroll.h"

#if LANES == 1
#define TO_REAL JOIN(convert_, REAL)
#else
#define TO_REAL JOIN(convert_, JOIN(REAL, LANES))
#endif

typedef struct {
  vreal first, second;
} NormalPair;

/* In (0, 1): 23 bits and a half, without rounding. */
INLINE vreal unit_number(vuint word) { return (TO_REAL(word >> 9) + ALL_LANES(0.5f)) * ALL_LANES(0x1p-23f); }

INLINE NormalPair normal_pair(vuint a, vuint b) {
  const vreal radius = sqrt(ALL_LANES(-2) * log(unit_number(a))), half_turns = ALL_LANES(2) * unit_number(b);
  const NormalPair pair = {radius * cospi(half_turns), radius * sinpi(half_turns)};
  return pair;
}

INLINE ulong instance_of(const ChainSettings *chain, ulong contact) {
  if (chain->instances == 0) return contact;
  const RandomWords drawn = words_of_item(chain->instance_seed, INSTANCE_STREAM, contact, (vuint)(0));
  return mul_hi(((const uint *)&drawn.word[0])[0], chain->instances);
}

/* A sensor's own spread, by a word. */
INLINE vreal spread_of(const float *ends, vuint word) {
  return ALL_LANES(ends[0]) + ALL_LANES(ends[1] - ends[0]) * unit_number(word);
}

/* What a sensor has of its own: its charge amplifier and its converter. */
typedef struct {
  vreal decay, pass, quantum;
  float low, high;
} Electronics;

INLINE Electronics electronics_of(const ChainSettings *chain, ulong instance, vuint tau_word) {
  Electronics own = {ALL_LANES(chain->decay), ALL_LANES(chain->pass), ALL_LANES(chain->quantum), chain->low,
                     chain->high};
  if (chain->time_constant[0] < chain->time_constant[1]) {
    const vreal ratio = ALL_LANES(chain->step_time) / spread_of(chain->time_constant, tau_word);
    own.decay = exp(-ratio);
    own.pass = -expm1(-ratio) / ratio;
  }
  if (chain->bits[0] < chain->bits[1]) {
    const RandomWords drawn = words_of_item(chain->instance_seed, SPREAD_STREAM, instance, (vuint)(1));
    const uint count = chain->bits[1] - chain->bits[0] + 1;
    const int bits = chain->bits[0] + (int)mul_hi(((const uint *)&drawn.word[0])[0], count);
    own.low = -ldexp(1.0f, bits - 1);
    own.high = -own.low - 1;
    own.quantum = ALL_LANES(ldexp(chain->range, 1 - bits));
  }
  return own;
}

/* Shares of the stresses of a tactel and of its neighbours in what a transducer feels. */
typedef struct {
  vreal left, own, right;
} Shares;

INLINE Shares shares_of(const ChainSettings *chain, ulong instance, vuint channel, uint channels) {
  const uint tactels = channels / 2;
  const RandomWords fault = words_of_item(chain->instance_seed, FAULT_STREAM, instance, channel);
  const RandomWords place =
      words_of_item(chain->instance_seed, FAULT_STREAM, instance, (vuint)(channels) + channel % (vuint)(tactels));
  const vreal share = ALL_LANES(chain->crosstalk) * fabs(normal_pair(fault.word[2], fault.word[3]).first);
  const vreal shift = ALL_LANES(chain->shift_spread) * normal_pair(place.word[0], place.word[1]).first;
  const vreal alive = unit_number(fault.word[0]);
  Shares shares;
  for (uint lane = 0; lane < LANES; ++lane) {
    const uint tactel = ((const uint *)&channel)[lane] % tactels;
    const real left = tactel > 0, right = tactel + 1 < tactels, feels = ((const real *)&alive)[lane] >= chain->dead;
    const real d = fmin(fmax(((const real *)&shift)[lane], -left), right), c = ((const real *)&share)[lane];
    ((real *)&shares.left)[lane] = feels * left * (fmax(-d, (real)0) + c);
    ((real *)&shares.own)[lane] = feels * (1 - fabs(d));
    ((real *)&shares.right)[lane] = feels * right * (fmax(d, (real)0) + c);
  }
  return shares;
}

/* The stresses of LANES channels from `first` on, each `beside` places further, within the row; 0 where its share is
   0. */
INLINE vreal beside(global const real *row, uint first, int by, uint channels, vreal share) {
  vreal x;
  for (uint lane = 0; lane < LANES; ++lane)
    ((real *)&x)[lane] =
        ((const real *)&share)[lane] != 0 ? row[clamp((int)(first + lane) + by, 0, (int)channels - 1)] : 0;
  return x;
}

/* NaN stays NaN. */
INLINE vreal cut_off(vreal x, float low, float high) {
  const vreal from_below = PICK(x < ALL_LANES(low), ALL_LANES(low), x);
  return PICK(from_below > ALL_LANES(high), ALL_LANES(high), from_below);
}

/* Group g: vector g % vectors of the channels of contact g / vectors.
   contact:   [contacts] its number in the sweep
   first_row: [contacts + 1] rows first_row[c] ... first_row[c + 1] - 1 are the load steps of contact c
   largest:   [contacts] MPa, the largest |stress|
   stress:    [rows][vectors * LANES] MPa; places beyond `channels` only fill a vector. May be `signal` where no
   neighbours count. signal:    [rows][vectors * LANES] MPa, becomes readings */
kernel void transducer_chain(uint first_group, global const ulong *contact, global const uint *first_row,
                             global const float *largest, global const real *stress, global real *signal, uint vectors,
                             uint channels, ChainSettings chain) {
  TAKE_GROUP(group);
  const size_t c = group / vectors;
  const uint vector = (uint)(group % vectors), row = first_row[c], steps = first_row[c + 1] - row;
  vuint channel;
  for (uint lane = 0; lane < LANES; ++lane) ((uint *)&channel)[lane] = vector * LANES + lane;
  const ulong instance = instance_of(&chain, contact[c]);
  vreal gain = 1, offset = 0, deviation = 0;
  const RandomWords own = words_of_item(chain.instance_seed, SPREAD_STREAM, instance, (vuint)(0));
  if (chain.gain_spread[1] > 0 || chain.offset_spread[1] > 0) {
    const RandomWords drawn = words_of_item(chain.instance_seed, GAIN_STREAM, instance, channel);
    const NormalPair spread = normal_pair(drawn.word[0], drawn.word[1]);
    gain += spread_of(chain.gain_spread, own.word[0]) * spread.first;
    offset = spread_of(chain.offset_spread, own.word[1]) * spread.second;
  }
  const bool noisy = chain.noise[1] > 0 || chain.noise_of_largest > 0;
  if (noisy) deviation = spread_of(chain.noise, own.word[2]) + ALL_LANES(chain.noise_of_largest * largest[c]);
  const bool neighbours = chain.shift_spread > 0 || chain.crosstalk > 0, faults = neighbours || chain.dead > 0;
  Shares shares = {0, 1, 0};
  if (faults) shares = shares_of(&chain, instance, channel, channels);
  const Electronics electronics = electronics_of(&chain, instance, own.word[3]);
  const bool converts = chain.quantum > 0;
  const vreal per_quantum = converts ? ALL_LANES(1) / electronics.quantum : ALL_LANES(0);
  NormalPair noise[2];
  vreal x_before = 0, y_before = 0, s_before = 0, late = 0;
  global real *at = signal + ((size_t)row * vectors + vector) * LANES;
  for (uint k = 0; k < steps; ++k, at += (size_t)vectors * LANES) {
    global const real *row_of_stress = stress + (size_t)(row + k) * vectors * LANES;
    vreal s = LOAD(row_of_stress + vector * LANES);
    if (faults) s = PICK(shares.own > ALL_LANES(0), shares.own * s, ALL_LANES(0));
    if (neighbours) {
      s = fma(shares.left, beside(row_of_stress, vector * LANES, -1, channels, shares.left), s);
      s = fma(shares.right, beside(row_of_stress, vector * LANES, 1, channels, shares.right), s);
    }
    if (chain.lag > 0) {
      late = fma(ALL_LANES(chain.lag_decay), late, ALL_LANES(chain.lag_pass) * (s - s_before));
      s_before = s;
      s -= ALL_LANES(chain.lag) * late;
    }
    const vreal x = gain * s;
    vreal y = x;
    if (chain.high_pass) y = fma(electronics.decay, y_before, electronics.pass * (x - x_before));
    x_before = x;
    y_before = y;
    y += offset;
    if (noisy) {
      if (k % 4 == 0) {
        const RandomWords words =
            words_of_item(chain.reading_seed, READING_STREAM, contact[c], (vuint)(k / 4 * channels) + channel);
        noise[0] = normal_pair(words.word[0], words.word[1]);
        noise[1] = normal_pair(words.word[2], words.word[3]);
      }
      const NormalPair two = noise[k % 4 / 2];
      y = fma(deviation, k % 2 ? two.second : two.first, y);
    }
    if (converts) y = rint(y * per_quantum);
    y = cut_off(y, electronics.low, electronics.high);
    if (converts) y *= electronics.quantum;
    STORE(y, at);
  }
}
