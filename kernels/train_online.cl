// SPDX-License-Identifier: Apache-2.0
/* Pattern-by-pattern training by the generalized delta rule with momentum (Rumelhart, Hinton and Williams 1986, eq.
   16). One work-item trains a group of NETWORKS networks of one topology: LANES / NETWORKS neurons of each share a
   vector, lane = neuron NETWORKS + network. Each network has its own weights, set, order and end. Every sum over lanes
   is taken in the same LANES parts. The bits of a network therefore depend neither on its neighbours nor on NETWORKS.

   The rule, for a layer with inputs x(t) and deltas d(t):  S(t+1) = m S(t) + eta d(t) x(t)',  W(t+1) = W(t) + S(t+1).

   First layer. Its inputs do not depend on the weights. BLOCK patterns are therefore taken together, with one read and
   one write of the weights. With a_k = 1 + m + ... + m^(k-1) and W, S at the block's start, the rule gives by induction
     W(t) = W + m a_t S + eta sum_{s<t} a_{t-s} d(s) x(s)',
     S(t) = m^t S + eta sum_{s<t} m^(t-1-s) d(s) x(s)';
   hence W(t) x(t) = [W x(t) + m a_t S x(t)] + sum_{s<t} a_{t-s} (x(s).x(t)) eta d(s): a product before the block, a few
   dots inside it, and one update after it. The numbers equal those of pattern by pattern, up to rounding.

   Second hidden layer. One pass makes its step for pattern t - 1 and evaluates it for pattern t. With a single output,
   its deltas are g = f' w_out times one number. Its backward pass therefore does not wait for the output.

   Built with -D REAL, LANES, INPUTS, HIDDEN1, HIDDEN2 (0: one hidden layer), NETWORKS (a power of two, at most
   LANES). */
// defines: INPUTS=42 HIDDEN1=42 HIDDEN2=21 NETWORKS=1
#include "shared/activation.h"
#include "shared/group.h"
#include "shared/lane_sums.h"
#include "shared/network_work.h"
#include "shared/online_cycle.h"
#include "shared/transpose.h"

#define BLOCK 8 /* patterns that the first layer takes together */
#define PAIRS (BLOCK * (BLOCK - 1) / 2)
#define NEURONS (LANES / NETWORKS) /* of each network in a vector */
#define NEURON_VECTORS(n) (((n) + NEURONS - 1) / NEURONS)
#define ROW VECTORS_OF(INPUTS + 1) /* vectors in a padded row of inputs: inputs, 1 for the bias, zeros */
#define V1 NEURON_VECTORS(HIDDEN1)
#define V2 NEURON_VECTORS(HIDDEN2)
#define VL NEURON_VECTORS(LAST)

typedef struct {
  vreal w, s; /* weight and last step */
} Weight;

/* A group's weights: Weight [V1][INPUTS + 1], [HIDDEN1 + 1][V2], [VL], [1]. The bias comes last (of the last layer: the
   bias alone, in every lane). Neurons that only fill a vector have zero weights and stay so. */
#define LAYER1 ((INPUTS + 1) * V1)
#define LAYER2 (HIDDEN2 ? (HIDDEN1 + 1) * V2 : 0)
#define GROUP_WEIGHTS (LAYER1 + LAYER2 + VL + 1)

typedef struct {
  global Weight *layer1, *layer2, *layer3;
  vreal x[BLOCK * ROW *
          NETWORKS]; /* [pattern][input][network], inputs that the block shows; zeros behind the block's end */
  vreal target[BLOCK];
  vreal dots[NEURON_VECTORS(PAIRS)]; /* x(s).x(t), s < t < BLOCK, [t (t - 1) / 2 + s][network] */
  vreal u[BLOCK][V1];                /* first the product of the block's weights with x(t), then eta d(t) */
  Weight out[VL], out_bias;
#if HIDDEN2
  vreal d2[V2];     /* eta d of the last pattern, its step still to be made */
  vreal o1[V1 + 1]; /* and the layer's inputs then, [neuron][network]; 1 after neuron HIDDEN1 - 1 */
  int pending;      /* a step is to be made */
#endif
  vreal sse, largest;
} Group;

typedef struct {
  real rate, momentum;
  real a[BLOCK + 1];     /* a_k */
  real power[BLOCK + 1]; /* m^k */
} Rule;

/* Numbers that are one for each network, in the lanes of all its neurons. p: [NETWORKS]. */
INLINE vreal each_network(const real *p) {
#if NETWORKS == LANES
  return *(const vreal *)p;
#elif NETWORKS == 1
  return ALL_LANES(*p);
#else
  const JOIN(REAL, NETWORKS) n = *(const JOIN(REAL, NETWORKS) *)p;
#if NEURONS == 2
  return (vreal)(n, n);
#elif NEURONS == 4
  return (vreal)(n, n, n, n);
#else
  return (vreal)(n, n, n, n, n, n, n, n);
#endif
#endif
}

INLINE void make_rule(Rule *rule, real rate, real momentum) {
  rule->rate = rate;
  rule->momentum = momentum;
  rule->a[0] = 0;
  rule->power[0] = 1;
  for (int k = 1; k <= BLOCK; ++k) {
    rule->a[k] = fma(rule->a[k - 1], momentum, (real)1);
    rule->power[k] = rule->power[k - 1] * momentum;
  }
}

/* Sums over a network's neurons or inputs of a b, [vectors]; what is left to add are the pieces of the vector. In LANES
   parts, number i mod LANES in part i, then halves of the parts first: so that a network's bits do not depend on
   NETWORKS. */
INLINE vreal parts_of_dot(const int vectors, const vreal *a, const vreal *b) {
  vreal part[NETWORKS];
  EACH(i, NETWORKS) { part[i] = i < vectors ? a[i] * b[i] : ALL_LANES(0); }
  UNROLL for (int v = NETWORKS; v < vectors; ++v) part[v % NETWORKS] = fma(a[v], b[v], part[v % NETWORKS]);
  UNROLL for (int rest = NETWORKS / 2; rest > 0; rest /= 2) {
    EACH(i, rest) { part[i] += part[i + rest]; }
  }
  return part[0];
}

/* Rows of NETWORKS networks, [ROW] vectors each, become x, [input][network]. */
INLINE void interleave_rows(global const real *const *rows, vreal *x) {
  EACH(v, ROW) {
    vreal a[NETWORKS];
    EACH(n, NETWORKS) { a[n] = LOAD(rows[n] + v * LANES); }
#if NETWORKS > 1
    UNROLL for (int count = NETWORKS; count > 1; count /= 2) {
      vreal b[NETWORKS];
      interleave(NETWORKS, a, b);
      EACH(n, NETWORKS) { a[n] = b[n]; }
    }
#endif
    EACH(n, NETWORKS) { x[v * NETWORKS + n] = a[n]; }
  }
}

/* Dots of every pair of rows in the block. */
INLINE void multiply_rows(Group *g) {
  vreal product[NEURON_VECTORS(PAIRS) * NEURONS];
  ROLLED for (int t = 1; t < BLOCK; ++t) {
    ROLLED for (int s = 0; s < t; ++s) {
      product[t * (t - 1) / 2 + s] =
          parts_of_dot(NEURON_VECTORS(INPUTS + 1), g->x + s * (ROW * NETWORKS), g->x + t * (ROW * NETWORKS));
    }
  }
  for (int pair = PAIRS; pair < NEURON_VECTORS(PAIRS) * NEURONS; ++pair) product[pair] = 0;
  ROLLED for (int v = 0; v < NEURON_VECTORS(PAIRS); ++v) g->dots[v] = piece_sums(NETWORKS, product + v * NEURONS);
}

/* u(t) = W x(t) + m a_t S x(t) for the neurons in vectors v and, where `two`, v + 1: an input that is loaded serves
   both. Their weights lie in rows. */
INLINE void multiply_vectors(const int two, Group *g, const Rule *rule, int v) {
  const real *x = (const real *)g->x;
  global const Weight *weight = g->layer1 + v * (INPUTS + 1), *next = weight + two * (INPUTS + 1);
  vreal a[BLOCK], b[BLOCK];
  EACH(t, BLOCK) { a[t] = b[t] = 0; }
  ROLLED for (int k = 0; k <= INPUTS; ++k) {
    UNROLL for (int t = 1; t < BLOCK; ++t) {
      const vreal input = each_network(x + t * (ROW * NETWORKS * LANES) + k * NETWORKS);
      a[t] = fma(weight[k].s, input, a[t]);
      if (two) b[t] = fma(next[k].s, input, b[t]);
    }
  }
  EACH(t, BLOCK) {
    const vreal factor = ALL_LANES(rule->momentum * rule->a[t]);
    a[t] *= factor;
    b[t] *= factor;
  }
  ROLLED for (int k = 0; k <= INPUTS; ++k) {
    EACH(t, BLOCK) {
      const vreal input = each_network(x + t * (ROW * NETWORKS * LANES) + k * NETWORKS);
      a[t] = fma(weight[k].w, input, a[t]);
      if (two) b[t] = fma(next[k].w, input, b[t]);
    }
  }
  EACH(t, BLOCK) {
    g->u[t][v] = a[t];
    if (two) g->u[t][v + 1] = b[t];
  }
}

INLINE void multiply_layer1(Group *g, const Rule *rule) {
  ROLLED for (int v = 0; v + 2 <= V1; v += 2) multiply_vectors(1, g, rule, v);
  if (V1 % 2) multiply_vectors(0, g, rule, V1 - 1);
}

/* The first layer's weights and steps after the block's `count` patterns. */
INLINE void update_layer1(Group *g, const Rule *rule, int count) {
  const vreal old_step = ALL_LANES(rule->momentum * rule->a[count]), decay = ALL_LANES(rule->power[count]);
  const real *x = (const real *)g->x;
  ROLLED for (int v = 0; v < V1; ++v) {
    global Weight *weight = g->layer1 + v * (INPUTS + 1);
    vreal to_w[BLOCK], to_s[BLOCK];
    EACH(t, BLOCK) {
      to_w[t] = t < count ? g->u[t][v] * rule->a[count - t] : ALL_LANES(0);
      to_s[t] = t < count ? g->u[t][v] * rule->power[count - 1 - t] : ALL_LANES(0);
    }
    ROLLED for (int k = 0; k <= INPUTS; ++k) {
      vreal w = fma(old_step, weight[k].s, weight[k].w), s = weight[k].s * decay;
      EACH(t, BLOCK) {
        const vreal input = each_network(x + t * (ROW * NETWORKS * LANES) + k * NETWORKS);
        w = fma(to_w[t], input, w);
        s = fma(to_s[t], input, s);
      }
      weight[k].w = w;
      weight[k].s = s;
    }
  }
}

#if HIDDEN2
/* The pending step, where there is one, then z = W o; o: [HIDDEN1 + 1][NETWORKS], the last 1. The weight's new value is
   a plain sum: adders are idle here, and multipliers are not. */
INLINE void step_layer2_pending(const int pending, Group *g, real momentum, const real *o, vreal *z) {
  global Weight *weight = g->layer2;
  const real *o_before = (const real *)g->o1;
  vreal d[V2], sum[V2];
  EACH(v, V2) {
    d[v] = g->d2[v];
    sum[v] = 0;
  }
  ROLLED for (int k = 0; k <= HIDDEN1; ++k, weight += V2) {
    const vreal before = each_network(o_before + k * NETWORKS), now = each_network(o + k * NETWORKS);
    EACH(v, V2) {
      vreal w = weight[v].w;
      if (pending) {
        const vreal s = fma(d[v], before, weight[v].s * momentum);
        w += s;
        weight[v].s = s;
        weight[v].w = w;
      }
      sum[v] = fma(w, now, sum[v]);
    }
  }
  EACH(v, V2) { z[v] = sum[v]; }
}

INLINE void step_layer2(Group *g, real momentum, const real *o, vreal *z) {
  if (g->pending)
    step_layer2_pending(1, g, momentum, o, z);
  else
    step_layer2_pending(0, g, momentum, o, z);
}

/* (W' g) of `count` neurons of the first layer, in the lanes of one vector; zero in lanes that only fill it. weight: of
   the first one. */
INLINE vreal back_vector(const int count, global const Weight *weight, const vreal *g) {
  vreal row[NEURONS];
  EACH(i, NEURONS) {
    vreal w[V2];
    EACH(v, V2) { w[v] = weight[min(i, count - 1) * V2 + v].w; }
    row[i] = i < count ? parts_of_dot(V2, w, g) : ALL_LANES(0);
  }
  return piece_sums(NETWORKS, row);
}

/* back = W' g, [V1]. */
INLINE void back_layer2(const Group *group, const vreal *g, vreal *back) {
  ROLLED for (int b = 0; b < HIDDEN1 / NEURONS; ++b) back[b] =
      back_vector(NEURONS, group->layer2 + b * NEURONS * V2, g);
  const int rest = HIDDEN1 % NEURONS;
  if (rest) back[V1 - 1] = back_vector(rest, group->layer2 + (HIDDEN1 - rest) * V2, g);
}
#endif

/* Outputs of the first layer for pattern t of the block. */
INLINE void forward_layer1(const Group *g, const Rule *rule, int t, vreal *f) {
  const real *dots = (const real *)g->dots + t * (t - 1) / 2 * NETWORKS;
  EACH(v, V1) { f[v] = g->u[t][v]; }
  ROLLED for (int s = 0; s < t; ++s) {
    const vreal factor = each_network(dots + s * NETWORKS) * rule->a[t - s];
    EACH(v, V1) { f[v] = fma(factor, g->u[s][v], f[v]); }
  }
  EACH(v, V1) { f[v] = activation(f[v]); }
}

/* The output neuron for inputs f [VL]: its error is noted, its step made; returns eta delta. */
INLINE vreal learn_output(Group *g, const Rule *rule, const vreal *f, vreal target) {
  vreal w[VL];
  EACH(v, VL) { w[v] = g->out[v].w; }
  const vreal output = activation(piece_sum(NETWORKS, parts_of_dot(VL, f, w)) + g->out_bias.w);
  const vreal error = target - output;
  const vreal step = error * activation_slope(output) * rule->rate;
  g->sse = fma(error, error, g->sse);
  g->largest = fmax(g->largest, fabs(error));
  EACH(v, VL) {
    g->out[v].s = fma(step, f[v], g->out[v].s * rule->momentum);
    g->out[v].w += g->out[v].s;
  }
  g->out_bias.s = fma(ALL_LANES(rule->momentum), g->out_bias.s, step);
  g->out_bias.w += g->out_bias.s;
  return step;
}

/* Shows pattern t of the block and learns from it; leaves eta d(t) in u(t). */
INLINE void learn_pattern(Group *group, const Rule *rule, int t) {
  vreal f1[V1];
  forward_layer1(group, rule, t, f1);
#if HIDDEN2
  vreal o[V1 + 1], f2[V2], g[V2], back[V1];
  EACH(v, V1) { o[v] = f1[v]; }
  EACH(n, NETWORKS) { ((real *)o)[HIDDEN1 * NETWORKS + n] = 1; }
  step_layer2(group, rule->momentum, (const real *)o, f2);
  EACH(v, V2) {
    f2[v] = activation(f2[v]);
    g[v] = activation_slope(f2[v]) * group->out[v].w;
  }
  back_layer2(group, g, back);
  const vreal step = learn_output(group, rule, f2, group->target[t]);
  EACH(v, V1 + 1) { group->o1[v] = o[v]; }
  EACH(v, V2) { group->d2[v] = step * g[v]; }
  EACH(v, V1) { group->u[t][v] = step * activation_slope(f1[v]) * back[v]; }
  group->pending = 1;
#else
  vreal g[V1];
  EACH(v, V1) { g[v] = activation_slope(f1[v]) * group->out[v].w; }
  const vreal step = learn_output(group, rule, f1, group->target[t]);
  EACH(v, V1) { group->u[t][v] = step * g[v]; }
#endif
}

/* Learning sets of the networks of a group: [NETWORKS] each. */
typedef struct {
  global const real *inputs[NETWORKS]; /* [rows + 1][ROW][LANES], the last row zeros */
  global const real *targets;
  global uint *order; /* [NETWORKS][rows] */
  uint rows;
} Lesson;

/* The block of `count` patterns from place `first` on. */
INLINE void show_block(Group *g, const Lesson *lesson, uint first, int count) {
  for (int t = 0; t < BLOCK; ++t) {
    global const real *rows[NETWORKS];
    vreal target;
    EACH(n, NETWORKS) {
      const uint row = t < count ? lesson->order[n * lesson->rows + first + t] : lesson->rows;
      rows[n] = lesson->inputs[n] + (size_t)row * (ROW * LANES);
      ((real *)&target)[n] = lesson->targets[row];
    }
    interleave_rows(rows, g->x + t * (ROW * NETWORKS));
    g->target[t] = each_network((const real *)&target);
  }
}

/* One cycle over all rows. */
INLINE void learn_cycle(Group *g, const Rule *rule, const Lesson *lesson) {
  g->sse = g->largest = 0;
  for (uint first = 0; first < lesson->rows; first += BLOCK) {
    const int count = (int)min(lesson->rows - first, (uint)BLOCK);
    show_block(g, lesson, first, count);
    multiply_rows(g);
    multiply_layer1(g, rule);
    for (int t = 0; t < count; ++t) learn_pattern(g, rule, t);
    update_layer1(g, rule, count);
  }
}

/* Moves weight (neuron, input) of one network between the group's vectors and memory; `place`: the vector. */
INLINE void move_weight(int keep, global Weight *at, int neuron, int n, global real *w, global real *s) {
  global real *lane = (global real *)at + neuron * NETWORKS + n;
  if (keep) {
    *w = lane[0];
    *s = lane[LANES];
  } else {
    lane[0] = *w;
    lane[LANES] = *s;
  }
}

INLINE void move_layer(int keep, global Weight *layer, int to_input, int to_vector, int fan_in, int fan_out, int n,
                       global real *w, global real *s) {
  ROLLED for (int neuron = 0; neuron < fan_out; ++neuron) {
    ROLLED for (int k = 0; k <= fan_in; ++k, ++w, ++s)
        move_weight(keep, layer + k * to_input + neuron / NEURONS * to_vector, neuron % NEURONS, n, w, s);
  }
}

/* All weights of the group's network n: from memory, or (keep) to it. network: weights, then steps. */
INLINE void move_network(int keep, Group *g, int n, global real *network) {
  global real *w = network, *s = network + NETWORK_WEIGHTS;
  move_layer(keep, g->layer1, 1, INPUTS + 1, INPUTS, HIDDEN1, n, w, s);
#if HIDDEN2
  move_layer(keep, g->layer2, V2, 1, HIDDEN1, HIDDEN2, n, w + COUNT1, s + COUNT1);
#endif
  w += COUNT1 + COUNT2;
  s += COUNT1 + COUNT2;
  for (int k = 0; k < LAST; ++k) move_weight(keep, g->layer3 + k / NEURONS, k % NEURONS, n, w + k, s + k);
  for (int neuron = 0; neuron < NEURONS; ++neuron) move_weight(keep, g->layer3 + VL, neuron, n, w + LAST, s + LAST);
}

/* Stores the group's vectors in memory, pending steps included, so that a later launch resumes bit-identically. */
INLINE void settle(Group *g, const Rule *rule) {
#if HIDDEN2
  vreal z[V2];
  step_layer2(g, rule->momentum, (const real *)g->o1, z);
  g->pending = 0;
#endif
  EACH(v, VL) { g->layer3[v] = g->out[v]; }
  g->layer3[VL] = g->out_bias;
}

INLINE void open_group(Group *g, global Weight *vectors, global const uint *slots, global real *weights) {
  g->layer1 = vectors;
  g->layer2 = vectors + LAYER1;
  g->layer3 = vectors + LAYER1 + LAYER2;
  const Weight none = {0, 0};
  for (int i = 0; i < GROUP_WEIGHTS; ++i) vectors[i] = none;
  for (int n = 0; n < NETWORKS; ++n) {
    if (slots[n] != NO_NETWORK) move_network(0, g, n, weights + (size_t)slots[n] * (2 * NETWORK_WEIGHTS));
  }
  EACH(v, VL) { g->out[v] = g->layer3[v]; }
  g->out_bias = g->layer3[VL];
#if HIDDEN2
  g->pending = 0;
#endif
}

/* Trains the networks of slots [group] for at most `most_cycles` cycles, or until they stop by themselves.
   weights: [networks][weights, steps][NETWORK_WEIGHTS]  changed in place, [layer][out][in + 1]
   reports: [networks]                           changed in place
   curve:   [networks][most_cycles][2]           sum of squared errors and largest error of each cycle done here
   vectors: [groups][GROUP_WEIGHTS]              scratch
   order:   [groups][NETWORKS][rows]             scratch
   slots:   [groups][NETWORKS]                   networks that are running, or NO_NETWORK
   seeds:   [networks]
   inputs:  [sets][rows + 1][ROW][LANES]         scaled, 1 at place INPUTS, then zeros; row `rows` all zeros
   set_of:  [networks]                           which of the sets it learns
   targets: [rows + 1]                           S - 0.5; the last unused */
kernel void train_online(uint first_group, global real *weights, global OnlineReport *reports, global real *curve,
                         global Weight *vectors, global uint *order, global const uint *slots,
                         global const ulong *seeds, global const real *inputs, global const uint *set_of,
                         global const real *targets, uint rows, uint most_cycles, uint cycle_limit, int permuted,
                         real rate, real momentum, real stop_error) {
  TAKE_GROUP(group);
  Group g;
  Rule rule;
  Lesson lesson = {.targets = targets, .order = order + group * NETWORKS * rows, .rows = rows};
  slots += group * NETWORKS;
  make_rule(&rule, rate, momentum);
  open_group(&g, vectors + group * GROUP_WEIGHTS, slots, weights);
  uint running = 0; /* a bit for each network */
  for (int n = 0; n < NETWORKS; ++n) {
    const uint network = slots[n];
    lesson.inputs[n] = inputs + (network == NO_NETWORK ? 0 : (size_t)set_of[network] * (rows + 1) * (ROW * LANES));
    if (network != NO_NETWORK && reports[network].status == ONLINE_RUNNING) running |= 1u << n;
    for (uint row = 0; row < rows; ++row) lesson.order[n * rows + row] = row;
  }
  for (uint done = 0; done < most_cycles && running; ++done) {
    for (int n = 0; permuted && n < NETWORKS; ++n) {
      if (running >> n & 1) shuffle(lesson.order + n * rows, rows, seeds[slots[n]], reports[slots[n]].cycle);
    }
    learn_cycle(&g, &rule, &lesson);
    uint stopping = 0;
    for (int n = 0; n < NETWORKS; ++n) {
      if (!(running >> n & 1)) continue;
      global OnlineReport *report = reports + slots[n];
      const real sse = ((const real *)&g.sse)[n], largest = ((const real *)&g.largest)[n];
      report->sse = sse;
      report->largest = largest;
      report->status = status_after(sse, largest, ++report->cycle, cycle_limit, stop_error);
      global real *point = curve + ((size_t)slots[n] * most_cycles + done) * 2;
      point[0] = sse;
      point[1] = largest;
      if (report->status != ONLINE_RUNNING || done + 1 == most_cycles) stopping |= 1u << n;
    }
    if (stopping) settle(&g, &rule);
    for (int n = 0; n < NETWORKS; ++n) {
      if (stopping >> n & 1) move_network(1, &g, n, weights + (size_t)slots[n] * (2 * NETWORK_WEIGHTS));
    }
    running &= ~stopping;
  }
}
