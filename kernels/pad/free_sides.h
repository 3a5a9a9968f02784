// SPDX-License-Identifier: Apache-2.0
/* The influence of all pairs of a scene's cells on a pad with free sides, C = C_layer + (C_block - C_endless)
   (fem/pad/side_kernel.h), and sums over rows of it. A scene is a work-item; WIDE numbers of a row make a vector. Sums
   have SUMMANDS parts whatever WIDE is, so that their bits are the same. Device only. */
#ifndef TACTEL_PAD_FREE_SIDES_H
#define TACTEL_PAD_FREE_SIDES_H
#include "pad/cells.h"

#if WIDE == 1
typedef REAL wide;
#define LOAD_WIDE(p) (*(p))
#define STORE_WIDE(v, p) (*(p) = (v))
#else
typedef JOIN(REAL, WIDE) wide;
#define LOAD_WIDE(p) JOIN(vload, WIDE)(0, p)
#define STORE_WIDE(v, p) JOIN(vstore, WIDE)(v, 0, p)
#endif

#define PARTS (SUMMANDS / WIDE)

/* Numbers of a scene's table: rows of all cells, [COUNT][PAIR_PLANES][COUNT]; of the ring around them z alone,
   [4 (CELLS + 1)][3][COUNT]. Then room to make it in, which is no private memory, for a GPU would set that aside for
   each of its threads: the layer by the offset, [PAIR_PLANES][SPAN][SPAN]; shares of nodes in cells, [COUNT][16]; and
   what the nodes do at a place, [nodes][PAD_BLOCK]. */
enum { PLANE_ZN = 0, PLANE_ZX, PLANE_ZY, PLANE_XX, PLANE_XY, PLANE_XN, PLANE_YX, PLANE_YY, PLANE_YN };
#define PAIR_PLANES PAIRS_PLANES
#define RING_AT PAIRS_RING_AT(CELLS)
#define LAYER_AT PAIRS_LAYER_AT(CELLS)
#define SHARES_AT PAIRS_SHARES_AT(CELLS)
#define ROW_AT PAIRS_ROW_AT(CELLS)
#define PAIR_NUMBERS PAIRS_NUMBERS(CELLS)

/* The sum of 16 numbers: halves are added until one is left. */
INLINE real sum_of(wide *parts) {
#if WIDE < 16
  for (int left = PARTS / 2; left > 0; left /= 2)
    for (int i = 0; i < left; ++i) parts[i] += parts[i + left];
#endif
#if WIDE == 1
  return parts[0];
#else
#if WIDE == 16
  const JOIN(REAL, 8) eight = parts[0].lo + parts[0].hi;
#elif WIDE == 8
  const wide eight = parts[0];
#endif
#if WIDE >= 8
  const JOIN(REAL, 4) four = eight.lo + eight.hi;
#elif WIDE == 4
  const wide four = parts[0];
#endif
#if WIDE >= 4
  const JOIN(REAL, 2) two = four.lo + four.hi;
#else
  const wide two = parts[0];
#endif
  return two.x + two.y;
#endif
}

/* What is the same for the scenes of a launch: the side part between nodes of the block, [node][node][PAD_BLOCK]
   numbers of PLANE_..., in the block's frame; and the block's nodes and sides over H. */
typedef struct {
  global const real *between;
  int nodes_x, nodes_y;
  real side_x, side_y;
} SidePart;

/* Cubic weights at a place: of the nodes from `first`. */
static inline int cubic_at(real at, int count, real *weight) {
  const int first = (int)clamp(floor(at) - 1, (real)0, (real)(count - 4));
  for (int k = 0; k < 4; ++k) {
    weight[k] = 1;
    for (int l = 0; l < 4; ++l)
      if (l != k) weight[k] *= (at - (real)(first + l)) / (real)(k - l);
  }
  return first;
}

typedef struct {
  int x, y; /* of the first node */
  real share[16];
} NodeShares;

static void shares_at(const SidePart *part, global const real *in, real x, real y, NodeShares *to) {
  const real block_x = in[PAD_COSINE] * x - in[PAD_SINE] * y + in[PAD_BLOCK_X],
             block_y = in[PAD_SINE] * x + in[PAD_COSINE] * y + in[PAD_BLOCK_Y];
  const real at_x =
                 (clamp(block_x / part->side_x, (real)-0.5, (real)0.5) + (real)0.5) * (real)part->nodes_x - (real)0.5,
             at_y =
                 (clamp(block_y / part->side_y, (real)-0.5, (real)0.5) + (real)0.5) * (real)part->nodes_y - (real)0.5;
  real wx[4], wy[4];
  to->x = cubic_at(at_x, part->nodes_x, wx);
  to->y = cubic_at(at_y, part->nodes_y, wy);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) to->share[4 * i + j] = wx[i] * wy[j];
}

/* The layer's influence by the offset from source to place, mirrored: plane [source x less place x + CELLS][y]. */
static void mirror_layer(global const real *quadrant, global real *planes) {
  for (int dx = -CELLS; dx <= CELLS; ++dx)
    for (int dy = -CELLS; dy <= CELLS; ++dy) {
      global const real *c = quadrant + PAD_OWN_INFLUENCE * ((int)abs(dx) * (CELLS + 1) + (int)abs(dy));
      const real sx = dx > 0 ? -1 : 1, sy = dy > 0 ? -1 : 1; /* the place lies at -(dx, dy) from the source */
      global real *to = planes + (dx + CELLS) * SPAN + dy + CELLS;
      to[PLANE_ZN * SPAN * SPAN] = c[PAD_ZZ];
      to[PLANE_XX * SPAN * SPAN] = c[PAD_XX];
      to[PLANE_YY * SPAN * SPAN] = c[PAD_YY];
      to[PLANE_XY * SPAN * SPAN] = to[PLANE_YX * SPAN * SPAN] = sx * sy * c[PAD_XY];
      to[PLANE_ZX * SPAN * SPAN] = to[PLANE_XN * SPAN * SPAN] = sx * c[PAD_XZ];
      to[PLANE_ZY * SPAN * SPAN] = to[PLANE_YN * SPAN * SPAN] = sy * c[PAD_YZ];
    }
}

/* The nodes around all cells. */
typedef struct {
  int x, y, end_x, end_y;
} NodeBox;

/* What each node of the box moves place `of` by, [nodes of the box][PAD_BLOCK]. */
static void node_row(const SidePart *part, const NodeBox *box, const NodeShares *of, global real *row) {
  const int along = box->end_y - box->y, width = PAD_BLOCK * along;
  ROLLED for (int x = box->x; x < box->end_x; ++x) {
    global real *to = row + (x - box->x) * width;
    global const real *from[16];
    for (int k = 0; k < 16; ++k)
      from[k] = part->between + (size_t)PAD_BLOCK * ((size_t)((of->x + k / 4) * part->nodes_y + of->y + k % 4) *
                                                         (part->nodes_x * part->nodes_y) +
                                                     x * part->nodes_y + box->y);
    ROLLED for (int at = 0; at < width; at += WIDE) {
      wide sum = 0;
      EACH(k, 16) { sum = fma((wide)(of->share[k]), LOAD_WIDE(from[k] + at), sum); }
      STORE_WIDE(sum, to + at);
    }
  }
}

/* Adds the side part to a place's row of the table: `planes` of them, from PLANE_ZN. `row` as node_row leaves it;
   first: where the first node of each cell lies in it. */
static void add_side_part(const NodeBox *box, const int *first, global const real *shares, global const real *row,
                          int planes, const real *units, real cosine, real sine, global real *table) {
  const int along = box->end_y - box->y;
  ROLLED for (int block = 0; block < BLOCKS; ++block) {
    real of_source[SUMMANDS * PAD_BLOCK], plane[PAIR_PLANES * SUMMANDS];
    ROLLED for (int l = 0; l < SUMMANDS; ++l) {
      const int i = block * SUMMANDS + l;
      global const real *from = row + PAD_BLOCK * first[i], *share = shares + 16 * i;
      EACH(p, PARTS) {
        wide sum = 0;
        EACH(k, 16) {
          sum = fma((wide)(share[k]), LOAD_WIDE(from + PAD_BLOCK * (k / 4 * along + k % 4) + p * WIDE), sum);
        }
        STORE_WIDE(sum, of_source + l * PAD_BLOCK + p * WIDE);
      }
    }
    for (int k = 0; k < PAIR_PLANES; ++k)
      for (int l = 0; l < SUMMANDS; ++l) plane[k * SUMMANDS + l] = of_source[l * PAD_BLOCK + k];
    /* From the block's frame to that of the cells. */
    EACH(p, PARTS) {
      wide d[PAIR_PLANES], t[PAIR_PLANES];
      EACH(k, PAIR_PLANES) { d[k] = LOAD_WIDE(plane + k * SUMMANDS + p * WIDE); }
      const wide c = (wide)cosine, s = (wide)sine;
      t[PLANE_ZN] = d[PLANE_ZN];
      t[PLANE_ZX] = c * d[PLANE_ZX] + s * d[PLANE_ZY];
      t[PLANE_ZY] = c * d[PLANE_ZY] - s * d[PLANE_ZX];
      t[PLANE_XN] = c * d[PLANE_XN] + s * d[PLANE_YN];
      t[PLANE_YN] = c * d[PLANE_YN] - s * d[PLANE_XN];
      const wide xx = c * d[PLANE_XX] + s * d[PLANE_YX], xy = c * d[PLANE_XY] + s * d[PLANE_YY],
                 yx = c * d[PLANE_YX] - s * d[PLANE_XX], yy = c * d[PLANE_YY] - s * d[PLANE_XY];
      t[PLANE_XX] = c * xx + s * xy;
      t[PLANE_XY] = c * xy - s * xx;
      t[PLANE_YX] = c * yx + s * yy;
      t[PLANE_YY] = c * yy - s * yx;
      global real *to = table + block * SUMMANDS + p * WIDE;
      EACH(k, PAIR_PLANES) {
        if (k < planes) STORE_WIDE(fma((wide)(units[k]), t[k], LOAD_WIDE(to + k * COUNT)), to + k * COUNT);
      }
    }
  }
}

/* The layer's part of a place's row. */
static void put_layer(global const real *layer, int ix, int iy, int planes, global real *table) {
  ROLLED for (int k = 0; k < planes; ++k) ROLLED for (int jx = 0; jx < CELLS; ++jx) {
    global const real *from = layer + (k * SPAN + jx - ix + CELLS) * SPAN + CELLS - iy;
    global real *to = table + k * COUNT + jx * CELLS;
    EACH(jy, CELLS / 4) { vstore4(vload4(jy, from), jy, to); }
  }
}

/* Makes a scene's table. `head` [PAD_TABLE_HEAD], then [CELLS + 1][CELLS + 1][PAD_OWN_INFLUENCE] of the layer; soft
   [COUNT]: compliance of its own that a cell has, over H; in, heights: of the scene. */
OUTLINE void make_pairs(const SidePart *part, global const real *head, global const real *soft, global const real *in,
                        global const real *heights, global real *table) {
  const real hx = head[PAD_HX], hy = head[PAD_HY], nn = 1 / (head[PAD_ROOT_ZZ] * head[PAD_ROOT_ZZ]),
             tt = 1 / (head[PAD_ROOT_TT] * head[PAD_ROOT_TT]), nt = 1 / (head[PAD_ROOT_ZZ] * head[PAD_ROOT_TT]);
  real sum = 0;
  for (int r = 0; r < PAD_INPUT_ROWS; ++r) sum = finite_sum(sum, in[r]);
  if (!(sum == 0)) return; /* no scene: walk() says so */
  const real area = hx * hy;
  const real units[PAIR_PLANES] = {area * nn, area * nt, area * nt, area * tt, area * tt,
                                   area * nt, area * tt, area * tt, area * nt};
  const real cosine = in[PAD_COSINE], sine = in[PAD_SINE];
  global real *layer = table + LAYER_AT, *shares = table + SHARES_AT, *row = table + ROW_AT;
  NodeShares at;
  NodeBox box = {part->nodes_x, part->nodes_y, 0, 0};
  int first[COUNT];
#define MIDDLE(i) ((real)(i) - (real)0.5 * (CELLS - 1))
  for (int i = 0; i < COUNT; ++i) {
    shares_at(part, in, in[PAD_X_MIDDLE] + MIDDLE(i / CELLS) * hx, in[PAD_Y_MIDDLE] + MIDDLE(i % CELLS) * hy, &at);
    for (int k = 0; k < 16; ++k) shares[16 * i + k] = at.share[k];
    first[i] = at.x * part->nodes_y + at.y;
    box.x = min(box.x, at.x);
    box.y = min(box.y, at.y);
    box.end_x = max(box.end_x, at.x + 4);
    box.end_y = max(box.end_y, at.y + 4);
  }
  for (int i = 0; i < COUNT; ++i)
    first[i] = (first[i] / part->nodes_y - box.x) * (box.end_y - box.y) + first[i] % part->nodes_y - box.y;
  mirror_layer(head + PAD_TABLE_HEAD, layer);
  ROLLED for (int i = 0; i < COUNT; ++i) {
    global real *to = table + (size_t)PAIR_PLANES * COUNT * i;
    put_layer(layer, i / CELLS, i % CELLS, PAIR_PLANES, to);
    shares_at(part, in, in[PAD_X_MIDDLE] + MIDDLE(i / CELLS) * hx, in[PAD_Y_MIDDLE] + MIDDLE(i % CELLS) * hy, &at);
    node_row(part, &box, &at, row);
    add_side_part(&box, first, shares, row, PAIR_PLANES, units, cosine, sine, to);
    to[PLANE_ZN * COUNT + i] += soft[i] * nn;
    to[PLANE_XX * COUNT + i] += soft[i] * tt;
    to[PLANE_YY * COUNT + i] += soft[i] * tt;
  }
  ROLLED for (int k = 0; k < RING_PLACES; ++k) {
    int ix, iy;
    ring_place(k, &ix, &iy);
    if (heights[(ix + 1) * RING + iy + 1] >= PAD_OPEN) continue;
    global real *to = table + RING_AT + (size_t)3 * COUNT * k;
    shares_at(part, in, in[PAD_X_MIDDLE] + MIDDLE(ix) * hx, in[PAD_Y_MIDDLE] + MIDDLE(iy) * hy, &at);
    put_layer(layer, ix, iy, 3, to);
    node_row(part, &box, &at, row);
    add_side_part(&box, first, shares, row, 3, units, cosine, sine, to);
  }
#undef MIDDLE
}

/* Displacement along z at place k of the ring, (ix, iy), by the cells listed. Returns whether there is rubber. */
INLINE int displacement_of_ring(const Influence *influence, global const vreal *heights, const Cells *c, int k, int ix,
                                int iy, Lanes *z) {
  if (heights[(ix + 1) * RING + iy + 1] >= PAD_OPEN) return 0; /* the table lacks it */
  global const real *row = influence->table + RING_AT + (size_t)3 * COUNT * k;
  wide sum[PARTS];
  EACH(p, PARTS) { sum[p] = 0; }
  ROLLED for (int b = 0; b < c->blocks; ++b) EACH(p, PARTS) {
    const int j = SUMMANDS * c->block[b] + p * WIDE;
    sum[p] = fma(LOAD_WIDE(row + PLANE_ZN * COUNT + j), LOAD_WIDE((const real *)c->n + j), sum[p]);
    sum[p] = fma(LOAD_WIDE(row + PLANE_ZX * COUNT + j), LOAD_WIDE((const real *)c->tx + j), sum[p]);
    sum[p] = fma(LOAD_WIDE(row + PLANE_ZY * COUNT + j), LOAD_WIDE((const real *)c->ty + j), sum[p]);
  }
  z->v[0] = -sum_of(sum);
  return 1;
}

/* Displacement at a cell by the cells listed. */
INLINE void displacement(const Influence *influence, const Cells *c, int ix, int iy, Lanes *x, Lanes *y, Lanes *z) {
  global const real *row = influence->table + (size_t)PAIR_PLANES * COUNT * (ix * CELLS + iy);
  wide z_sum[PARTS], x_sum[PARTS], y_sum[PARTS];
  wide zn[PARTS], zx[PARTS], zy[PARTS], xx[PARTS], xy[PARTS], xn[PARTS], yx[PARTS], yy[PARTS], yn[PARTS];
  EACH(p, PARTS) { zn[p] = zx[p] = zy[p] = xx[p] = xy[p] = xn[p] = yx[p] = yy[p] = yn[p] = 0; }
  ROLLED for (int b = 0; b < c->blocks; ++b) EACH(p, PARTS) {
    const int j = SUMMANDS * c->block[b] + p * WIDE;
    const wide n = LOAD_WIDE((const real *)c->n + j), tx = LOAD_WIDE((const real *)c->tx + j),
               ty = LOAD_WIDE((const real *)c->ty + j);
    zn[p] = fma(LOAD_WIDE(row + PLANE_ZN * COUNT + j), n, zn[p]);
    zx[p] = fma(LOAD_WIDE(row + PLANE_ZX * COUNT + j), tx, zx[p]);
    zy[p] = fma(LOAD_WIDE(row + PLANE_ZY * COUNT + j), ty, zy[p]);
    xx[p] = fma(LOAD_WIDE(row + PLANE_XX * COUNT + j), tx, xx[p]);
    xy[p] = fma(LOAD_WIDE(row + PLANE_XY * COUNT + j), ty, xy[p]);
    xn[p] = fma(LOAD_WIDE(row + PLANE_XN * COUNT + j), n, xn[p]);
    yx[p] = fma(LOAD_WIDE(row + PLANE_YX * COUNT + j), tx, yx[p]);
    yy[p] = fma(LOAD_WIDE(row + PLANE_YY * COUNT + j), ty, yy[p]);
    yn[p] = fma(LOAD_WIDE(row + PLANE_YN * COUNT + j), n, yn[p]);
  }
  EACH(p, PARTS) {
    x_sum[p] = xx[p] + xy[p] - xn[p];
    y_sum[p] = yx[p] + yy[p] - yn[p];
    z_sum[p] = zn[p] + zx[p] + zy[p];
  }
  x->v[0] = sum_of(x_sum);
  y->v[0] = sum_of(y_sum);
  z->v[0] = -sum_of(z_sum);
}

/* Rows of a sweep are divided by what each cell does to itself. */
INLINE void set_own(const Influence *influence, Cells *c) {
  ROLLED for (int i = 0; i < COUNT; ++i) {
    global const real *own = influence->table + (size_t)PAIR_PLANES * COUNT * i + i;
    c->per_own_n[i].v[0] = 1 / own[PLANE_ZN * COUNT];
    c->per_own_t[i].v[0] = 1 / fmax(own[PLANE_XX * COUNT], own[PLANE_YY * COUNT]);
  }
}

#endif
