// SPDX-License-Identifier: Apache-2.0
/* The patch of each lane: where frictionless contact presses, and elements over it. Device only. */
#ifndef TACTEL_PATCH_SEARCH_H
#define TACTEL_PATCH_SEARCH_H
#include "patch/layer.h"
#include "patch/profile.h"

#define N ELEMENTS
#define SEARCH_ELEMENTS 12
#define SEARCH_ROUNDS 3
#define SEARCH_SWEEPS 200
#define SEARCH_TOLERANCE ((real)1e-3)
#define SEARCH_DEPTHS 20                /* trials of the depth that gives a force */
#define SEARCH_FORCE_ERROR ((real)0.02) /* of the force */
#define BISECTIONS (REAL_IS_DOUBLE ? 60 : 30)
#define MARGIN ((real)0.06)
#define EDGE_PART ((real)0.15)

typedef struct {
  vreal origin, element; /* of the patch, mm */
  vreal sweeps;
} Patch;

/* One sweep of frictionless contact on the search's elements; a: its scaled row, [0] for the element itself. */
static inline vint search_sweep(const vreal *a, const vreal *b, vreal *n, vint active) {
  vreal change = 0, largest = 0;
  EACH(i, SEARCH_ELEMENTS) {
    vreal even = b[i], odd = 0;
    EACH(k, SEARCH_ELEMENTS / 2) {
      const int j = (i + 2 * k) % SEARCH_ELEMENTS, j1 = (i + 2 * k + 1) % SEARCH_ELEMENTS;
      even = fma(a[i > j ? i - j : j - i], n[j], even);
      odd = fma(a[i > j1 ? i - j1 : j1 - i], n[j1], odd);
    }
    const vreal old = n[i], now = PICK(active, LARGER(even + odd, ALL_LANES(0)), old);
    n[i] = now;
    change = LARGER(change, fabs(now - old));
    largest = LARGER(largest, now);
    ROW_BARRIER;
  }
  return active & (change > SEARCH_TOLERANCE * largest);
}

static inline void search_iterate(const vreal *a, const vreal *b, vreal *n, vint active, int most_sweeps,
                                  vreal *sweeps) {
  for (int k = 0; k < most_sweeps && ANY(active); ++k) {
    *sweeps += PICK(active, ALL_LANES(1), ALL_LANES(0));
    active = search_sweep(a, b, n, active);
  }
}

typedef struct {
  vreal a[SEARCH_ELEMENTS], h[SEARCH_ELEMENTS], b[SEARCH_ELEMENTS], n[SEARCH_ELEMENTS];
  vreal wy; /* 1 / C_yy[0] */
} SearchContact;

/* Frictionless contact on elements of this width from `left` on, with no forces yet. */
static inline void start_round(const Layer *layer, const Profile *profile, vreal left, vreal width, SearchContact *s) {
  const vreal over_h = width / layer->thickness, per = 1 / over_h, log_width = natural_log(over_h);
  vreal c[SEARCH_ELEMENTS], last = 0;
  for (int k = 0; k < SEARCH_ELEMENTS; ++k) {
    vreal r[3];
    smooth_integrals(layer, width * ((real)k + (real)0.5), r);
    c[k] = even_part(log_width, k, r[0], k == 0 ? -r[0] : last, per);
    last = r[0];
  }
  s->wy = 1 / (layer->cy * c[0]);
  const vreal scale = -1 / c[0];
  for (int k = 0; k < SEARCH_ELEMENTS; ++k) {
    s->a[k] = k == 0 ? ALL_LANES(0) : scale * c[k];
    s->h[k] = profile_height(profile, fma(width, ALL_LANES((real)k + (real)0.5), left));
    s->n[k] = 0;
  }
}

/* The pressed extent of a round becomes [*left, *right]; *from and *to become the next window. Where nothing presses
   the extent is the window. */
static inline void next_window(const Profile *profile, const SearchContact *s, vreal width, vreal *from, vreal *to,
                               vreal *left, vreal *right) {
  vreal first = FAR, end = 0;
  for (int k = 0; k < SEARCH_ELEMENTS; ++k) {
    const vint pressed = s->n[k] > 0;
    first = PICK(pressed & (first >= FAR), ALL_LANES(k), first);
    end = PICK(pressed, ALL_LANES(k + 1), end);
  }
  const vint any = end > 0;
  const vreal l = PICK(any, fma(width, first, *from), *from), r = PICK(any, fma(width, end, *from), *to);
  const vreal part = (real)0.25 * (r - l), elements = (real)1.5 * width;
  const vreal next_from = l - PICK(first > 0, elements, part);
  const vreal next_to = r + PICK(end < SEARCH_ELEMENTS, elements, part);
  *left = l;
  *right = r;
  *from = LARGER(next_from, profile->left);
  *to = SMALLER(next_to, profile->right);
}

/* Elements over the contact [left, right]. */
static inline void lay_patch(const Layer *layer, const vreal *in, const Profile *profile, vreal left, vreal right,
                             Patch *patch) {
  const vreal part = ALL_LANES(EDGE_PART), none = ALL_LANES(0);
  const vreal edge_left = PICK((left <= profile->left) & (in[PATCH_LEFT_EDGE] > 0), part, none);
  const vreal edge_right = PICK((right >= profile->right) & (in[PATCH_RIGHT_EDGE] > 0), part, none);
  const vreal l = LARGER(left, profile->left), r = SMALLER(right, profile->right);
  const vreal element = (r - l) / ((real)N - (edge_left + edge_right));
  const vreal end = (real)0.5 * layer->length, sensor_left = -end - in[PATCH_POSITION],
              sensor_right = end - in[PATCH_POSITION];
  const vreal from = LARGER(fma(-edge_left, element, l), SMALLER(sensor_left, l));
  const vreal to = SMALLER(fma(edge_right, element, r), LARGER(sensor_right, r));
  patch->origin = from;
  patch->element = (to - from) / N;
}

/* Rounds of frictionless contact at this depth from the window [from, to] on. Returns the force of the last; [*left,
   *right]: what presses. */
OUTLINE vreal search_at(const Layer *layer, const Profile *profile, vreal depth, vreal from, vreal to, vint searching,
                        vreal *left, vreal *right, vreal *sweeps) {
  vreal p = 0;
  *left = from;
  *right = to;
  for (int round = 0; round < SEARCH_ROUNDS; ++round) {
    SearchContact s;
    const vreal width = (to - from) / SEARCH_ELEMENTS;
    start_round(layer, profile, from, width, &s);
    for (int k = 0; k < SEARCH_ELEMENTS; ++k) s.b[k] = (depth - s.h[k]) * s.wy;
    search_iterate(s.a, s.b, s.n, searching, SEARCH_SWEEPS, sweeps);
    p = 0;
    for (int k = 0; k < SEARCH_ELEMENTS; ++k) p += s.n[k];
    next_window(profile, &s, width, &from, &to, left, right);
  }
  return p;
}

#if FORCE_CONTROL
/* The farthest place between `inside`, where the profile is below `depth`, and `outside`. */
static inline vreal last_below(const Profile *profile, vreal depth, vreal inside, vreal outside) {
  const vint all = profile_height(profile, outside) <= depth;
  vreal low = inside, high = outside;
  for (int k = 0; k < BISECTIONS; ++k) {
    const vreal middle = (real)0.5 * (low + high);
    const vint below = profile_height(profile, middle) <= depth;
    low = PICK(below, middle, low);
    high = PICK(below, high, middle);
  }
  return PICK(all, outside, low);
}

/* The extent that the largest force presses without friction: searches at depths from secants in the logarithms of
   depth and force. */
static inline void search_force(const Layer *layer, const Profile *profile, const vreal *in, vint searching,
                                vreal *left, vreal *right, vreal *sweeps) {
  const vreal wanted = in[PATCH_MOST];
  vreal depth = (real)0.3 * wanted, depth_last = depth, p = 0, p_last = 0, power = 1;
  searching &= wanted > 0;
  for (int trial = 0; trial < SEARCH_DEPTHS && ANY(searching); ++trial) {
    if (trial > 0) {
      const vint learns = (depth != depth_last) & (p > 0) & (p_last > 0);
      const vreal ratio = PICK(learns, p / p_last, ALL_LANES(2)), way = PICK(learns, depth / depth_last, ALL_LANES(2));
      const vreal slope = SMALLER(LARGER(natural_log(ratio) / natural_log(way), ALL_LANES((real)0.5)), ALL_LANES(4));
      if (trial > 1) power = PICK(learns, slope, power);
      const vreal step = natural_exp(natural_log(PICK(p > 0, wanted / p, ALL_LANES(1))) / power);
      const vreal factor = PICK(p > 0, SMALLER(LARGER(step, ALL_LANES((real)0.1)), ALL_LANES(10)), ALL_LANES(10));
      depth_last = depth;
      p_last = p;
      depth = PICK(searching, depth * factor, depth);
    }
    vreal trial_left, trial_right;
    const vreal from = last_below(profile, depth, in[PATCH_LOWEST_LEFT], profile->left);
    const vreal to = last_below(profile, depth, in[PATCH_LOWEST_RIGHT], profile->right);
    const vint touches = to > from;
    const vreal window_from = PICK(touches, from, profile->left), window_to = PICK(touches, to, profile->right);
    const vreal found = search_at(layer, profile, depth, window_from, window_to, searching & touches, &trial_left,
                                  &trial_right, sweeps);
    p = PICK(searching, found, p);
    *left = PICK(searching & touches, trial_left, *left);
    *right = PICK(searching & touches, trial_right, *right);
    searching &= NOT(fabs(p - wanted) <= SEARCH_FORCE_ERROR * wanted);
  }
}
#endif

/* The patch of each lane, from the search or as it is given. */
static inline void find_patch(const Layer *layer, const Profile *profile, const vreal *in, vint valid, Patch *patch) {
  const vint given = in[PATCH_GIVEN] > 0;
  vreal left = in[PATCH_FROM], right = in[PATCH_TO];
  patch->sweeps = 0;
#if FORCE_CONTROL
  search_force(layer, profile, in, valid & NOT(given), &left, &right, &patch->sweeps);
#else
  search_at(layer, profile, in[PATCH_MOST], in[PATCH_FROM], in[PATCH_TO], valid & NOT(given), &left, &right,
            &patch->sweeps);
#endif
  const vreal margin = MARGIN * (right - left);
  lay_patch(layer, in, profile, PICK(given, in[PATCH_FROM], left - margin), PICK(given, in[PATCH_TO], right + margin),
            patch);
}

#endif
