// SPDX-License-Identifier: Apache-2.0
/* Readings of transducers from their stresses, for many contacts; twin: nn/transducer_chain.*. For each channel, over
   the load steps k = 0, 1, ... of a contact:
     s_k = the stress at the tactel's shifted place, linear between tactels, and shares of its neighbours' stresses and
           of those of the tactel's other axes; 0 where it is dead
     x_k = (1 + gain_spread g) shear_gain (s_k - sum over both late shares of share h_k)
     h_k = decay h_{k-1} + pass (s_k - s_{k-1})        arrives late
     y_k = decay y_{k-1} + pass (x_k - x_{k-1})        the charge amplifier
     r_k = cut off and rounded (y_k + offset_spread o + drift z (largest normal stress) + noise n_k)
     reading_k = r_k, or reading_{k-1} of all channels with the probability `repeats`
   Both filters solve tau y' + y = tau x' exactly where x is linear between steps of h: decay = exp(-h / tau), pass =
   (1 - decay) tau / h. Normal numbers g, o, z, n_k and the other draws are from Philox counters
   {item, item's upper half, stream, which}:
     g, o     item: the instance, stream 7, which: the channel; words 0, 1
     n_k      item: the contact, stream 6, which: k / 4 channels + channel; words 0, 1 for k mod 4 = 0, 1, else 2, 3
     z        item: the contact, stream 12, which: the channel; words 0, 1
     repeats  item: the contact, stream 12, which: channels + k / 4; word k mod 4, below the probability
     spreads  item: the instance, stream 10: evenly between the least and the most by words 0 to 3 of which 0 (gains,
              offsets, noise, tau), which 2 (mixing, drift, repeats, logarithm of shear_gain), which 3 (share and
              time of both late shares);
              which 1, word 0: the bits, least + word times their count over 2^32
     faults   item: the instance, stream 11, which: the channel; word 0: dead, words 2, 3: the share of neighbours
              and which: channels + the tactel; words 0, 1: the shift of its place, along its row and across
              and which: 2 channels + channel; words 0, 1: the shares of the next axis and of the one after it
   (Box and Muller 1958: the pair's cosine comes first), and the instance is the contact itself, or word 0 of
   {contact, stream 8, 0} times `instances` over 2^32.

   One work-item takes LANES channels of one contact. Built with -D REAL, LANES. */
#include "shared/chain_settings.h"
#include "shared/elementary.h"
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
  const vreal radius = sqrt(ALL_LANES(-2) * natural_log(unit_number(a)));
  vreal sine;
  const vreal cosine = cos_pi(ALL_LANES(2) * unit_number(b), &sine);
  const NormalPair pair = {radius * cosine, radius * sine};
  return pair;
}

INLINE ulong instance_of(const ChainSettings *chain, ulong contact) {
  if (chain->instances == 0) return contact;
  const RandomWords drawn = words_of_item(chain->instance_seed, INSTANCE_STREAM, contact, (vuint)(0));
  return mul_hi(((const uint *)&drawn.word[0])[0], chain->instances);
}

/* A sensor's own spread, by a word. */
INLINE vreal spread_of(const float *ends, vuint word) {
  return fma(ALL_LANES(ends[1] - ends[0]), unit_number(word), ALL_LANES(ends[0]));
}

/* The filter of a sensor with a time constant of its own. */
INLINE void own_filter(const ChainSettings *chain, const float *ends, vuint word, vreal *decay, vreal *pass) {
  if (ends[0] == ends[1]) return;
  const vreal ratio = ALL_LANES(chain->step_time) / spread_of(ends, word);
  const vreal grown = exp_minus_1(ratio);
  *decay = 1 / (1 + grown);
  *pass = grown / (1 + grown) / ratio;
}

/* What a sensor has of its own: its charge amplifier and its converter. */
typedef struct {
  vreal decay, pass, quantum;
  float low, high;
} Electronics;

INLINE Electronics electronics_of(const ChainSettings *chain, ulong instance, vuint tau_word) {
  Electronics own = {ALL_LANES(chain->decay), ALL_LANES(chain->pass), ALL_LANES(chain->quantum), chain->low,
                     chain->high};
  own_filter(chain, chain->time_constant, tau_word, &own.decay, &own.pass);
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

/* How the channels lie: [axes][rows][columns], tactels = rows columns. */
typedef struct {
  uint channels, tactels, columns;
} Layout;

/* Shares of stresses in what a transducer feels: its own; of the neighbours left, right, below, above; of the next axis
   and of the one after it. */
typedef struct {
  vreal own, neighbour[4], axis[2];
} Shares;

INLINE Shares shares_of(const ChainSettings *chain, ulong instance, vuint channel, vreal mixing, Layout at) {
  const RandomWords fault = words_of_item(chain->instance_seed, FAULT_STREAM, instance, channel);
  const RandomWords place =
      words_of_item(chain->instance_seed, FAULT_STREAM, instance, (vuint)(at.channels) + channel % (vuint)(at.tactels));
  RandomWords mixed = place;
  if (chain->mixing[1] > 0)
    mixed = words_of_item(chain->instance_seed, FAULT_STREAM, instance, (vuint)(2 * at.channels) + channel);
  const vreal share = ALL_LANES(chain->crosstalk) * fabs(normal_pair(fault.word[2], fault.word[3]).first);
  const NormalPair shift = normal_pair(place.word[0], place.word[1]), axis = normal_pair(mixed.word[0], mixed.word[1]);
  const vreal alive = unit_number(fault.word[0]), along = ALL_LANES(chain->shift_spread) * shift.first,
              across = ALL_LANES(chain->shift_spread) * shift.second, first = mixing * axis.first,
              second = mixing * axis.second;
  Shares shares;
  for (uint lane = 0; lane < LANES; ++lane) {
    const uint tactel = ((const uint *)&channel)[lane] % at.tactels;
    const real left = tactel % at.columns > 0, right = tactel % at.columns + 1 < at.columns,
               below = tactel >= at.columns, above = tactel + at.columns < at.tactels;
    const real feels = NUMBER(alive, lane) >= chain->dead;
    const real x = fmin(fmax(NUMBER(along, lane), -left), right), rest = 1 - fabs(x), c = NUMBER(share, lane);
    const real y = fmin(fmax(NUMBER(across, lane), -below * rest), above * rest);
    ((real *)&shares.own)[lane] = feels * (rest - fabs(y));
    ((real *)&shares.neighbour[0])[lane] = feels * left * (fmax(-x, (real)0) + c);
    ((real *)&shares.neighbour[1])[lane] = feels * right * (fmax(x, (real)0) + c);
    ((real *)&shares.neighbour[2])[lane] = feels * below * (fmax(-y, (real)0) + c);
    ((real *)&shares.neighbour[3])[lane] = feels * above * (fmax(y, (real)0) + c);
    ((real *)&shares.axis[0])[lane] = feels * NUMBER(first, lane);
    ((real *)&shares.axis[1])[lane] = feels * NUMBER(second, lane);
  }
  return shares;
}

/* The stresses of LANES channels from `first` on, each `by` places further, and around from the last channel to the
   first; 0 where its share is 0. */
INLINE vreal beside(global const real *row, uint first, uint by, uint channels, vreal share) {
  vreal x;
  for (uint lane = 0; lane < LANES; ++lane) {
    const uint there = first + lane + by, around = there < channels ? there : there - channels;
    ((real *)&x)[lane] = NUMBER(share, lane) != 0 ? row[min(around, channels - 1)] : 0;
  }
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
   largest:   [contacts][2] MPa, the largest |stress| and the largest |normal stress|
   stress:    [rows][vectors * LANES] MPa; places beyond `channels` only fill a vector. May be `signal` where no
              other channels count
   signal:    [rows][vectors * LANES] MPa, becomes readings
   The channels are [axes][tactels], tactels in rows of `columns`. */
kernel void transducer_chain(uint first_group, global const ulong *contact, global const uint *first_row,
                             global const float *largest, global const real *stress, global real *signal, uint vectors,
                             uint channels, uint tactels, uint columns, ChainSettings chain) {
  TAKE_GROUP(group);
  const size_t c = group / vectors;
  const uint vector = (uint)(group % vectors), row = first_row[c], steps = first_row[c + 1] - row;
  vuint channel;
  for (uint lane = 0; lane < LANES; ++lane) ((uint *)&channel)[lane] = vector * LANES + lane;
  const ulong instance = instance_of(&chain, contact[c]);
  vreal gain = 1, offset = 0, deviation = 0;
  const RandomWords own = words_of_item(chain.instance_seed, SPREAD_STREAM, instance, (vuint)(0));
  RandomWords skin = own, slow = own;
  const bool of_axes = chain.shear_gain[0] != 0 || chain.shear_gain[1] != 0;
  if (chain.mixing[1] > 0 || chain.drift[1] > 0 || chain.repeats[1] > 0 || of_axes)
    skin = words_of_item(chain.instance_seed, SPREAD_STREAM, instance, (vuint)(2));
  if (chain.late[0].share[1] > 0 || chain.late[1].share[1] > 0)
    slow = words_of_item(chain.instance_seed, SPREAD_STREAM, instance, (vuint)(3));
  if (chain.gain_spread[1] > 0 || chain.offset_spread[1] > 0) {
    const RandomWords drawn = words_of_item(chain.instance_seed, GAIN_STREAM, instance, channel);
    const NormalPair spread = normal_pair(drawn.word[0], drawn.word[1]);
    gain = fma(spread_of(chain.gain_spread, own.word[0]), spread.first, gain);
    offset = spread_of(chain.offset_spread, own.word[1]) * spread.second;
  }
  if (of_axes) {
    const vreal shear = gain * natural_exp(spread_of(chain.shear_gain, skin.word[3]));
    for (uint lane = 0; lane < LANES; ++lane)
      if (vector * LANES + lane >= tactels) ((real *)&gain)[lane] = NUMBER(shear, lane);
  }
  if (chain.drift[1] > 0) {
    const RandomWords drawn = words_of_item(chain.reading_seed, FRAME_STREAM, contact[c], channel);
    const vreal drift = spread_of(chain.drift, skin.word[1]) * ALL_LANES(largest[2 * c + 1]);
    offset = fma(drift, normal_pair(drawn.word[0], drawn.word[1]).first, offset);
  }
  const bool noisy = chain.noise[1] > 0 || chain.noise_of_largest > 0;
  if (noisy) deviation = spread_of(chain.noise, own.word[2]) + ALL_LANES(chain.noise_of_largest * largest[2 * c]);
  const bool neighbours = chain.shift_spread > 0 || chain.crosstalk > 0, mixes = chain.mixing[1] > 0;
  const bool faults = neighbours || mixes || chain.dead > 0;
  const Layout layout = {channels, tactels, columns};
  Shares shares;
  if (faults) shares = shares_of(&chain, instance, channel, spread_of(chain.mixing, skin.word[0]), layout);
  const Electronics electronics = electronics_of(&chain, instance, own.word[3]);
  vreal share[2], decay[2], pass[2], late[2] = {0, 0};
  UNROLL for (int i = 0; i < 2; ++i) {
    share[i] = spread_of(chain.late[i].share, slow.word[2 * i]);
    decay[i] = ALL_LANES(chain.late[i].decay), pass[i] = ALL_LANES(chain.late[i].pass);
    own_filter(&chain, chain.late[i].time, slow.word[2 * i + 1], &decay[i], &pass[i]);
  }
  const bool repeats = chain.repeats[1] > 0, converts = chain.quantum > 0;
  const vreal repeating = spread_of(chain.repeats, skin.word[2]);
  const vreal per_quantum = converts ? ALL_LANES(1) / electronics.quantum : ALL_LANES(0);
  NormalPair noise[2];
  RandomWords chance;
  vreal x_before = 0, y_before = 0, s_before = 0, before = 0;
  global real *at = signal + ((size_t)row * vectors + vector) * LANES;
  for (uint k = 0; k < steps; ++k, at += (size_t)vectors * LANES) {
    global const real *row_of_stress = stress + (size_t)(row + k) * vectors * LANES;
    const uint first = vector * LANES;
    vreal s = LOAD(row_of_stress + first);
    if (faults) s = PICK(shares.own > ALL_LANES(0), shares.own * s, ALL_LANES(0));
    if (neighbours) {
      s = fma(shares.neighbour[0], beside(row_of_stress, first, channels - 1, channels, shares.neighbour[0]), s);
      s = fma(shares.neighbour[1], beside(row_of_stress, first, 1, channels, shares.neighbour[1]), s);
    }
    if (neighbours && columns < tactels) {
      s = fma(shares.neighbour[2], beside(row_of_stress, first, channels - columns, channels, shares.neighbour[2]), s);
      s = fma(shares.neighbour[3], beside(row_of_stress, first, columns, channels, shares.neighbour[3]), s);
    }
    if (mixes)
      for (uint axis = 1; axis * tactels < channels; ++axis)
        s = fma(shares.axis[axis - 1], beside(row_of_stress, first, axis * tactels, channels, shares.axis[axis - 1]),
                s);
    const vreal change = s - s_before;
    s_before = s;
    UNROLL for (int i = 0; i < 2; ++i) {
      if (!(chain.late[i].share[1] > 0)) continue;
      late[i] = fma(decay[i], late[i], pass[i] * change);
      s = fma(-share[i], late[i], s);
    }
    const vreal x = gain * s;
    vreal y = x;
    if (chain.time_constant[1] > 0) y = fma(electronics.decay, y_before, electronics.pass * (x - x_before));
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
    if (repeats) {
      if (k % 4 == 0) chance = words_of_item(chain.reading_seed, FRAME_STREAM, contact[c], (vuint)(channels + k / 4));
      if (k > 0) y = PICK(unit_number(chance.word[k % 4]) < repeating, before, y);
      before = y;
    }
    STORE(y, at);
  }
}
