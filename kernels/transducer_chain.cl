// SPDX-License-Identifier: Apache-2.0
/* Readings of transducers from their stresses, for many contacts; twin: nn/transducer_chain.*. For each channel, over the load steps k = 0, 1, ... of a contact:
     x_k = (1 + gain_spread g) stress_k
     y_k = decay y_{k-1} + pass (x_k - x_{k-1})        the charge amplifier: tau y' + y = tau x', exactly where x is linear between
                                                       steps of h: decay = exp(-h / tau), pass = (1 - decay) tau / h
     reading_k = cut off and rounded (y_k + offset_spread o + noise n_k)
   with normal numbers g, o, n_k from Philox counters {item, item's upper half, stream, which}:
     g, o   item: the instance, stream 7, which: the channel; words 0, 1
     n_k    item: the contact, stream 6, which: k / 4 channels + channel; words 0, 1 for k mod 4 = 0, 1, words 2, 3 for 2, 3
   (Box and Muller 1958: the pair's cosine comes first), and the instance is the contact itself, or word 0 of {contact, stream 8, 0}
   times `instances` over 2^32.

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

/* NaN stays NaN. */
INLINE vreal cut_off(vreal x, float low, float high) {
  const vreal from_below = PICK(x < ALL_LANES(low), ALL_LANES(low), x);
  return PICK(from_below > ALL_LANES(high), ALL_LANES(high), from_below);
}

/* Group g: vector g % vectors of the channels of contact g / vectors.
   contact:   [contacts] its number in the sweep
   first_row: [contacts + 1] rows first_row[c] ... first_row[c + 1] - 1 are the load steps of contact c
   signal:    [rows][vectors * LANES] MPa, stress, becomes readings; places beyond `channels` only fill a vector */
kernel void transducer_chain(uint first_group, global const ulong *contact, global const uint *first_row, global real *signal, uint vectors,
                             uint channels, ChainSettings chain) {
  TAKE_GROUP(group);
  const size_t c = group / vectors;
  const uint vector = (uint)(group % vectors), row = first_row[c], steps = first_row[c + 1] - row;
  vuint channel;
  for (uint lane = 0; lane < LANES; ++lane) ((uint *)&channel)[lane] = vector * LANES + lane;
  vreal gain = 1, offset = 0;
  if (chain.gain_spread > 0 || chain.offset_spread > 0) {
    const RandomWords drawn = words_of_item(chain.instance_seed, GAIN_STREAM, instance_of(&chain, contact[c]), channel);
    const NormalPair spread = normal_pair(drawn.word[0], drawn.word[1]);
    gain += ALL_LANES(chain.gain_spread) * spread.first;
    offset = ALL_LANES(chain.offset_spread) * spread.second;
  }
  const vreal per_quantum = ALL_LANES(chain.quantum > 0 ? 1 / chain.quantum : 0);
  NormalPair noise[2];
  vreal x_before = 0, y_before = 0;
  global real *at = signal + ((size_t)row * vectors + vector) * LANES;
  for (uint k = 0; k < steps; ++k, at += (size_t)vectors * LANES) {
    const vreal x = gain * LOAD(at);
    vreal y = x;
    if (chain.high_pass) y = fma(ALL_LANES(chain.decay), y_before, ALL_LANES(chain.pass) * (x - x_before));
    x_before = x;
    y_before = y;
    y += offset;
    if (chain.noise > 0) {
      if (k % 4 == 0) {
        const RandomWords words = words_of_item(chain.reading_seed, READING_STREAM, contact[c], (vuint)(k / 4 * channels) + channel);
        noise[0] = normal_pair(words.word[0], words.word[1]);
        noise[1] = normal_pair(words.word[2], words.word[3]);
      }
      const NormalPair two = noise[k % 4 / 2];
      y = fma(ALL_LANES(chain.noise), k % 2 ? two.second : two.first, y);
    }
    if (chain.quantum > 0) y = rint(y * per_quantum);
    y = cut_off(y, chain.low, chain.high);
    if (chain.quantum > 0) y *= ALL_LANES(chain.quantum);
    STORE(y, at);
  }
}
