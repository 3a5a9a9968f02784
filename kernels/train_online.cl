/* Pattern-by-pattern training by the generalized delta rule with momentum (Rumelhart, Hinton and Williams 1986, eq. 16). One work-item
   trains one network; the lanes of its vectors are neurons. Many networks (topology x seed x noise) are many work-items: each stops by itself,
   and one network's weights and steps fit the first-level cache, where those of LANES networks side by side would not.

   The rule, for a layer with inputs x(t) and deltas d(t):  S(t+1) = m S(t) + eta d(t) x(t)',  W(t+1) = W(t) + S(t+1).

   First layer. Its inputs do not depend on the weights, so BLOCK patterns are taken together and the weights are read and written once for all of
   them. With a_k = 1 + m + ... + m^(k-1) and W, S at the block's start, the rule gives by induction
     W(t) = W + m a_t S + eta sum_{s<t} a_{t-s} d(s) x(s)',
     S(t) = m^t S + eta sum_{s<t} m^(t-1-s) d(s) x(s)';
   hence W(t) x(t) = [W x(t) + m a_t S x(t)] + sum_{s<t} a_{t-s} (x(s).x(t)) eta d(s): a product before the block, a few dots inside it,
   and one update after it. The same numbers as pattern by pattern, up to rounding.

   Second hidden layer. Its step for pattern t - 1 is made in the same pass that takes it forward for pattern t. As there is one output, its
   deltas are g = f' w_out times one number, so its backward pass does not wait for the output.

   Built with -D REAL, LANES, INPUTS, HIDDEN1, HIDDEN2 (0: one hidden layer). */
// defines: INPUTS=42 HIDDEN1=42 HIDDEN2=21
#include "shared/activation.h"
#include "shared/group.h"
#include "shared/lane_sums.h"
#include "shared/online_report.h"
#include "shared/philox.h"

#define BLOCK 8
#define PAIRS (BLOCK * (BLOCK - 1) / 2)
#define LAST (HIDDEN2 ? HIDDEN2 : HIDDEN1)   /* width of the last hidden layer */
#define ROW VECTORS_OF(INPUTS + 1)           /* vectors in a padded row of inputs: inputs, 1 for the bias, zeros */
#define V1 VECTORS_OF(HIDDEN1)
#define V2 VECTORS_OF(HIDDEN2)
#define VL VECTORS_OF(LAST)
#define TOGETHER 3                           /* vectors of neurons that the first layer's products take together */
#define ORDER_STREAM 2                       /* nn::RandomStream::order */

typedef struct {
  vreal w, s; /* weight and last step */
} Weight;

/* A network's weights in memory: Weight [INPUTS + 1][V1], [HIDDEN1 + 1][V2], [VL], [1]; lanes are the neurons of the layer, the bias
   comes last (of the last layer: the bias alone, in every lane). Neurons that only fill a vector have zero weights and stay so. */
#define LAYER1 ((INPUTS + 1) * V1)
#define LAYER2 (HIDDEN2 ? (HIDDEN1 + 1) * V2 : 0)
#define NETWORK_WEIGHTS (LAYER1 + LAYER2 + VL + 1)

typedef struct {
  global Weight *layer1, *layer2, *layer3;
  global const real *x[BLOCK];   /* rows of inputs that the block shows */
  real target[BLOCK];
  vreal dots[VECTORS_OF(PAIRS)]; /* x(s).x(t), s < t < BLOCK, at t (t - 1) / 2 + s */
  vreal u[BLOCK][V1];            /* first the product of the block's weights with x(t), then eta d(t) */
  Weight out[VL], out_bias;
#if HIDDEN2
  vreal d2[V2];                  /* eta d of the last pattern, its step still to be made */
  vreal o1[V1 + 1];              /* and the layer's inputs then; 1 after neuron HIDDEN1 - 1 */
  real m2, moving;               /* momentum and 1 while a step is to be made, 1 and 0 when there is none */
#endif
  real sse, largest;
} Network;

typedef struct {
  real rate, momentum;
  real a[BLOCK + 1];     /* a_k */
  real power[BLOCK + 1]; /* m^k */
} Rule;

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

/* Dots of every pair of rows in the block. */
INLINE void multiply_rows(Network *net) {
  vreal product[VECTORS_OF(PAIRS) * LANES];
  EACH(t, BLOCK) {
    EACH(s, t) {
      vreal p = LOAD(net->x[s]) * LOAD(net->x[t]);
      UNROLL for (int v = 1; v < ROW; ++v) p = fma(LOAD(net->x[s] + v * LANES), LOAD(net->x[t] + v * LANES), p);
      product[t * (t - 1) / 2 + s] = p;
    }
  }
  UNROLL for (int pair = PAIRS; pair < VECTORS_OF(PAIRS) * LANES; ++pair) product[pair] = 0;
  EACH(v, VECTORS_OF(PAIRS)) { net->dots[v] = lane_sums(product + v * LANES); }
}

/* u(t) = W x(t) + m a_t S x(t) for `vectors` vectors of neurons from `first` on. */
INLINE void multiply_layer1_some(const int vectors, int first, Network *net, const Rule *rule) {
  vreal sum[BLOCK][TOGETHER];
  global const Weight *layer1 = net->layer1 + first;
  global const real *x[BLOCK];
  EACH(t, BLOCK) { x[t] = net->x[t]; }
  EACH(t, BLOCK) { EACH(v, vectors) { sum[t][v] = 0; } }
  for (int k = 0; k <= INPUTS; ++k) {
    vreal s[TOGETHER];
    EACH(v, vectors) { s[v] = layer1[k * V1 + v].s; }
    EACH(t, BLOCK) { EACH(v, vectors) { sum[t][v] = fma(s[v], ALL_LANES(x[t][k]), sum[t][v]); } }
  }
  EACH(t, BLOCK) { EACH(v, vectors) { sum[t][v] *= ALL_LANES(rule->momentum * rule->a[t]); } }
  for (int k = 0; k <= INPUTS; ++k) {
    vreal w[TOGETHER];
    EACH(v, vectors) { w[v] = layer1[k * V1 + v].w; }
    EACH(t, BLOCK) { EACH(v, vectors) { sum[t][v] = fma(w[v], ALL_LANES(x[t][k]), sum[t][v]); } }
  }
  EACH(t, BLOCK) { EACH(v, vectors) { net->u[t][first + v] = sum[t][v]; } }
}

INLINE void multiply_layer1(Network *net, const Rule *rule) {
  for (int v = 0; v + TOGETHER <= V1; v += TOGETHER) multiply_layer1_some(TOGETHER, v, net, rule);
  if (V1 % TOGETHER) multiply_layer1_some(V1 % TOGETHER, V1 - V1 % TOGETHER, net, rule);
}

/* The first layer's weights and steps after the block's `count` patterns. */
INLINE void update_layer1(Network *net, const Rule *rule, int count) {
  const real old_step = rule->momentum * rule->a[count], decay = rule->power[count];
  global Weight *layer1 = net->layer1;
  global const real *x[BLOCK];
  EACH(t, BLOCK) { x[t] = net->x[t]; }
  for (int v = 0; v < V1; ++v) {
    vreal to_w[BLOCK], to_s[BLOCK];
    EACH(t, BLOCK) {
      to_w[t] = t < count ? net->u[t][v] * rule->a[count - t] : ALL_LANES(0);
      to_s[t] = t < count ? net->u[t][v] * rule->power[count - 1 - t] : ALL_LANES(0);
    }
    for (int k = 0; k <= INPUTS; ++k) {
      global Weight *weight = layer1 + k * V1 + v;
      vreal w = fma(ALL_LANES(old_step), weight->s, weight->w), s = weight->s * decay;
      EACH(t, BLOCK) {
        const vreal input = ALL_LANES(x[t][k]);
        w = fma(to_w[t], input, w);
        s = fma(to_s[t], input, s);
      }
      weight->w = w;
      weight->s = s;
    }
  }
}

#if HIDDEN2
/* A step of the second layer that is due: what it needs. */
typedef struct {
  vreal d[V2];
  const real *o; /* [HIDDEN1 + 1] */
  real momentum, moving;
} Step;

/* Makes the step for input k, and adds what the new weight does to z. */
INLINE void step_input(global Weight *weight, const Step *step, int k, real o, vreal *z) {
  EACH(v, V2) {
    const vreal s = fma(step->d[v], ALL_LANES(step->o[k]), weight[k * V2 + v].s * step->momentum);
    const vreal w = fma(ALL_LANES(step->moving), s, weight[k * V2 + v].w);
    weight[k * V2 + v].s = s;
    weight[k * V2 + v].w = w;
    z[v] = fma(w, ALL_LANES(o), z[v]);
  }
}

/* The due step, and z = W o; o: [HIDDEN1 + 1], the last 1. */
INLINE void step_layer2(Network *net, const real *o, vreal *z) {
  global Weight *weight = net->layer2;
  Step step = {.o = (const real *)net->o1, .momentum = net->m2, .moving = net->moving};
  vreal sum[V2];
  EACH(v, V2) {
    step.d[v] = net->d2[v];
    sum[v] = 0;
  }
  for (int k = 0; k <= HIDDEN1; ++k) step_input(weight, &step, k, o[k], sum);
  EACH(v, V2) { z[v] = sum[v]; }
}

/* (W' g) of `count` neurons of the first layer, in the lanes of one vector; zero in lanes that only fill it. weight: of the first one. */
INLINE vreal back_vector(const int count, global const Weight *weight, const vreal *g) {
  vreal row[LANES];
  EACH(i, LANES) {
    row[i] = 0;
    if (i < count) EACH(v, V2) { row[i] = fma(weight[i * V2 + v].w, g[v], row[i]); }
  }
  return lane_sums(row);
}

/* back = W' g, [V1]. */
INLINE void back_layer2(const Network *net, const vreal *g, vreal *back) {
  for (int b = 0; b < HIDDEN1 / LANES; ++b) back[b] = back_vector(LANES, net->layer2 + b * LANES * V2, g);
  if (HIDDEN1 % LANES) back[V1 - 1] = back_vector(HIDDEN1 % LANES, net->layer2 + (HIDDEN1 - HIDDEN1 % LANES) * V2, g);
}
#endif

/* Outputs of the first layer for pattern t of the block. */
INLINE void forward_layer1(const Network *net, const Rule *rule, int t, vreal *f) {
  const real *dots = (const real *)net->dots + t * (t - 1) / 2;
  EACH(v, V1) { f[v] = net->u[t][v]; }
  for (int s = 0; s < t; ++s) {
    const vreal factor = ALL_LANES(dots[s] * rule->a[t - s]);
    EACH(v, V1) { f[v] = fma(factor, net->u[s][v], f[v]); }
  }
  EACH(v, V1) { f[v] = activation(f[v]); }
}

/* The output neuron for inputs f [VL]: its error is noted, its step made; returns eta delta, in every lane. */
INLINE vreal learn_output(Network *net, const Rule *rule, const vreal *f, real target) {
  vreal z = f[0] * net->out[0].w;
  UNROLL for (int v = 1; v < VL; ++v) z = fma(f[v], net->out[v].w, z);
  const vreal output = activation(ALL_LANES(lane_sum(z)) + net->out_bias.w);
  const vreal error = ALL_LANES(target) - output;
  const vreal step = error * activation_slope(output) * rule->rate;
  const real e = ((const real *)&error)[0];
  net->sse = fma(e, e, net->sse);
  net->largest = fmax(net->largest, fabs(e));
  EACH(v, VL) {
    net->out[v].s = fma(step, f[v], net->out[v].s * rule->momentum);
    net->out[v].w += net->out[v].s;
  }
  net->out_bias.s = fma(ALL_LANES(rule->momentum), net->out_bias.s, step);
  net->out_bias.w += net->out_bias.s;
  return step;
}

/* Shows pattern t of the block and learns from it; leaves eta d(t) in u(t). */
INLINE void learn_pattern(Network *net, const Rule *rule, int t) {
  vreal f1[V1];
  forward_layer1(net, rule, t, f1);
#if HIDDEN2
  vreal o[V1 + 1], f2[V2], g[V2], back[V1];
  EACH(v, V1) { o[v] = f1[v]; }
  ((real *)o)[HIDDEN1] = 1;
  step_layer2(net, (const real *)o, f2);
  EACH(v, V2) {
    f2[v] = activation(f2[v]);
    g[v] = activation_slope(f2[v]) * net->out[v].w;
  }
  back_layer2(net, g, back);
  const vreal step = learn_output(net, rule, f2, net->target[t]);
  EACH(v, V1 + 1) { net->o1[v] = o[v]; }
  EACH(v, V2) { net->d2[v] = step * g[v]; }
  EACH(v, V1) { net->u[t][v] = step * activation_slope(f1[v]) * back[v]; }
  net->m2 = rule->momentum;
  net->moving = 1;
#else
  vreal g[V1];
  EACH(v, V1) { g[v] = activation_slope(f1[v]) * net->out[v].w; }
  const vreal step = learn_output(net, rule, f1, net->target[t]);
  EACH(v, V1) { net->u[t][v] = step * g[v]; }
#endif
}

/* Fisher and Yates' shuffle of the rows for one cycle, as nn/presentation_order.h describes it. */
INLINE void shuffle(global uint *order, uint rows, ulong seed, uint cycle) {
  for (uint row = 0; row < rows; ++row) order[row] = row;
  vuint index;
  for (uint lane = 0; lane < LANES; ++lane) ((uint *)&index)[lane] = lane;
  for (uint first = 0; first + 1 < rows; first += 4 * LANES) {
    const RandomWords words = random_words(seed, ORDER_STREAM, index, cycle);
    index += (vuint)(LANES);
    const uint end = min(first + 4 * LANES, rows - 1);
    for (uint step = first; step < end; ++step) {
      const uint word = ((const uint *)&words.word[step % 4])[(step - first) / 4];
      const uint i = rows - 1 - step, j = mul_hi(word, i + 1);
      const uint row = order[i];
      order[i] = order[j];
      order[j] = row;
    }
  }
}

/* One cycle over all rows. inputs: [rows + 1][ROW][LANES], the last row zeros. */
INLINE void learn_cycle(Network *net, const Rule *rule, global const real *inputs, global const real *targets,
                        global const uint *order, uint rows) {
  net->sse = net->largest = 0;
  for (uint first = 0; first < rows; first += BLOCK) {
    const int count = (int)min(rows - first, (uint)BLOCK);
    for (int t = 0; t < BLOCK; ++t) {
      const uint row = t < count ? order[first + t] : rows;
      net->x[t] = inputs + (size_t)row * (ROW * LANES);
      net->target[t] = targets[row];
    }
    multiply_rows(net);
    multiply_layer1(net, rule);
    for (int t = 0; t < count; ++t) learn_pattern(net, rule, t);
    update_layer1(net, rule, count);
  }
}

INLINE void open_network(Network *net, global Weight *weights) {
  net->layer1 = weights;
  net->layer2 = weights + LAYER1;
  net->layer3 = weights + LAYER1 + LAYER2;
  EACH(v, VL) { net->out[v] = net->layer3[v]; }
  net->out_bias = net->layer3[VL];
#if HIDDEN2
  EACH(v, V2) { net->d2[v] = 0; }
  EACH(v, V1 + 1) { net->o1[v] = 0; }
  net->m2 = 1;
  net->moving = 0;
#endif
}

/* Everything back to memory, steps that are due included: a later launch goes on to the same bits. */
INLINE void close_network(Network *net) {
#if HIDDEN2
  vreal z[V2];
  step_layer2(net, (const real *)net->o1, z);
#endif
  EACH(v, VL) { net->layer3[v] = net->out[v]; }
  net->layer3[VL] = net->out_bias;
}

/* The stop rules of nn/train_online.cpp. */
INLINE int status_after(const Network *net, uint cycle, uint cycle_limit, real stop_error) {
  if (!isfinite(net->sse)) return ONLINE_NOT_FINITE;
  if (net->largest < stop_error) return ONLINE_LEARNT;
  return cycle >= cycle_limit ? ONLINE_CYCLE_LIMIT : ONLINE_RUNNING;
}

/* Trains network `group` for at most `most_cycles` cycles, or until it stops by itself.
   weights: [networks][NETWORK_WEIGHTS]          changed in place
   reports: [networks]                           changed in place; a network that is not running is left alone
   curve:   [networks][most_cycles][2]           sum of squared errors and largest error of each cycle done here
   order:   [networks][rows]                     scratch
   seeds:   [networks]
   inputs:  [sets][rows + 1][ROW][LANES]         scaled, 1 at place INPUTS, then zeros; row `rows` all zeros
   set_of:  [networks]                           which of the sets it learns
   targets: [rows + 1]                           S - 0.5; the last unused */
kernel void train_online(uint first_group, global Weight *weights, global OnlineReport *reports, global real *curve, global uint *order,
                         global const ulong *seeds, global const real *inputs, global const uint *set_of, global const real *targets,
                         uint rows, uint most_cycles, uint cycle_limit, int permuted, real rate, real momentum, real stop_error) {
  TAKE_GROUP(group);
  OnlineReport report = reports[group];
  if (report.status != ONLINE_RUNNING) return;
  Network net;
  Rule rule;
  make_rule(&rule, rate, momentum);
  open_network(&net, weights + group * NETWORK_WEIGHTS);
  order += group * rows;
  curve += group * most_cycles * 2;
  inputs += (size_t)set_of[group] * (rows + 1) * (ROW * LANES);
  if (!permuted) for (uint row = 0; row < rows; ++row) order[row] = row;
  for (uint done = 0; done < most_cycles && report.status == ONLINE_RUNNING; ++done) {
    if (permuted) shuffle(order, rows, seeds[group], report.cycle);
    learn_cycle(&net, &rule, inputs, targets, order, rows);
    report.status = status_after(&net, ++report.cycle, cycle_limit, stop_error);
    curve[2 * done] = net.sse;
    curve[2 * done + 1] = net.largest;
  }
  close_network(&net);
  report.sse = net.sse;
  report.largest = net.largest;
  reports[group] = report;
}
