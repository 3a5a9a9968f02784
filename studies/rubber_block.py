# SPDX-License-Identifier: Apache-2.0
"""A block of rubber that is bonded to a rigid base, its sides free, and an indenter on it with Coulomb's friction: finite elements
that share nothing with the program.

Bricks of 27 nodes with a pressure of their own, linear in x, y, z: they do not lock near nu = 1/2. A quarter of the block under each
parity; its levels are eliminated from the base upwards, which leaves the compliance of the surface's nodes and what they do to the base.
Contact is a law of each surface node, solved by Gauss-Seidel. E = 1. Debian: python3-scipy; python3-numba makes contact fast."""
import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular

try:
    from numba import njit
except ImportError:
    njit = lambda **_: lambda function: function  # noqa: E731

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(3)


def quadratics(t):
    """Values and slopes of the quadratics through -1, 0, 1."""
    return np.array([t * (t - 1) / 2, 1 - t * t, t * (t + 1) / 2]), np.array([t - 0.5, -2 * t, t + 0.5])


def gradients(size, x, y, z):
    """Derivatives of the 27 shape functions, [3][27], nodes [z][y][x]."""
    (vx, sx), (vy, sy), (vz, sz) = (quadratics(t) for t in (x, y, z))
    return np.stack([np.einsum("k,j,i->kji", vz, vy, 2 / size[0] * sx).ravel(),
                     np.einsum("k,j,i->kji", vz, 2 / size[1] * sy, vx).ravel(),
                     np.einsum("k,j,i->kji", 2 / size[2] * sz, vy, vx).ravel()])


def strains(slopes):
    """Strains xx, xy, xz, yx, ... by displacements, [...][9][81], unknowns [27 nodes][3]."""
    all_strains = np.zeros((*slopes.shape[:-2], 3, 3, 27, 3))
    for a in range(3):
        for b in range(3):
            all_strains[..., a, b, :, a] += slopes[..., b, :] / 2
            all_strains[..., a, b, :, b] += slopes[..., a, :] / 2
    return all_strains.reshape(*slopes.shape[:-2], 9, 81)


GRID = np.array(list(np.ndindex(3, 3, 3)))
CUBE = np.array([gradients(2 * np.ones(3), *POINTS[p]) for p in GRID])  # of the cube [-1, 1]^3
LINEAR = np.concatenate([np.ones((27, 1)), POINTS[GRID]], 1)


def brick(size, nu):
    """Stiffness [81][81] and coefficients 1, x, y, z of the pressure [4][81]."""
    shear, bulk, weights = 0.5 / (1 + nu), 1 / (3 * (1 - 2 * nu)), WEIGHTS[GRID].prod(1) * np.prod(size) / 8
    deviator = strains(CUBE * (2 / size)[:, None])
    volume = deviator[:, [0, 4, 8]].sum(1)
    deviator[:, [0, 4, 8]] -= volume[:, None] / 3
    weighted = (deviator * np.sqrt(2 * shear * weights)[:, None, None]).reshape(-1, 81)
    moments, masses = (LINEAR * weights[:, None]).T @ volume, (LINEAR * weights[:, None]).T @ LINEAR
    pressure = bulk * np.linalg.solve(masses, moments)
    return weighted.T @ weighted + moments.T @ pressure, pressure


def base_rows(size, nu, pressure, x, y):
    """sigma_z, tau_x, tau_y on a brick's lower face by its displacements, [3][81]."""
    shear, slopes = 0.5 / (1 + nu), gradients(size, x, y, -1)
    rows = np.zeros((3, 27, 3))
    rows[0, :, 2] = 2 * shear * slopes[2]
    rows[0] -= 2 * shear / 3 * slopes.T
    for a in (0, 1):
        rows[1 + a, :, a], rows[1 + a, :, 2] = shear * slopes[2], shear * slopes[a]
    rows = rows.reshape(3, 81)
    rows[0] += np.array([1, x, y, -1]) @ pressure
    return rows


def graded(length, fine, count, least=0.04, slope=0.3, widest=1.0):
    """`count` edges of bricks or so from 0 to length, fine near the edges `fine` and near the end.

    A pair (a, b) in `fine` is a zone."""
    ends = [p for p in fine if not isinstance(p, tuple)]
    must = sorted({0.0, length, *[p for p in ends if 1e-9 < p < length - 1e-9]})
    x = np.linspace(0, length, 4001)
    size = least + slope * (length - x)
    for p in ends:
        size = np.minimum(size, least + slope * abs(x - p))
    for a, b in (p for p in fine if isinstance(p, tuple)):
        size = np.minimum(size, (b - a) / 4 + slope * np.maximum(0, np.maximum(a - x, x - b)))
    density = 1 / np.minimum(size, widest)
    total = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2) * (x[1] - x[0])])
    edges = [0.0]
    for a, b in zip(must, must[1:]):
        low, high = np.interp([a, b], x, total)
        parts = 1 if (b - a) < 1e-6 else max(1, int(np.ceil(count * (high - low) / total[-1] - 0.4)))
        edges += list(np.interp(low + (high - low) * np.arange(1, parts) / parts, total, x)) + [b]
    return np.array(edges)


def levels(height, finer):
    """Edges of bricks from the base, where stress is wanted, up."""
    sizes = [0.03, 0.055, 0.1, 0.18, 0.28, 0.22, 0.135] if finer else [0.05, 0.1, 0.2, 0.3, 0.22, 0.13]
    return np.concatenate([[0], np.cumsum(sizes)]) * height


def nodes_of(edges):
    return np.sort(np.concatenate([edges, (edges[1:] + edges[:-1]) / 2]))


class Block:
    """A block with edges of bricks x, y of its quarter from the middle to the sides, z from the base; stress at places [n][2]."""

    def __init__(self, x, y, z, nu, places):
        self.edges, self.nu, self.places = (x, y, z), nu, np.asarray(places, float)
        self.x, self.y = nodes_of(x), nodes_of(y)
        self.across, self.count = len(self.x), len(self.x) * len(self.y)  # node iy * across + ix
        self.bricks = {}

    def brick(self, i, j, k):
        size = tuple(round(e[n + 1] - e[n], 12) for e, n in zip(self.edges, (i, j, k)))
        if size not in self.bricks:
            self.bricks[size] = brick(np.array(size), self.nu)
        return np.array(size), *self.bricks[size]

    def unknowns(self, i, j):
        """Of a brick's 27 nodes within the three levels of its layer."""
        plane = ((2 * j + np.arange(3))[:, None] * self.across + 2 * i + np.arange(3)).ravel()
        nodes = (np.arange(3)[:, None] * self.count + plane).ravel()
        return (3 * nodes[:, None] + np.arange(3)).ravel()

    def layer(self, k):
        stiffness = np.zeros((9 * self.count, 9 * self.count))
        for j in range(len(self.edges[1]) - 1):
            for i in range(len(self.edges[0]) - 1):
                at = self.unknowns(i, j)
                stiffness[np.ix_(at, at)] += self.brick(i, j, k)[1]
        return stiffness

    def stress_rows(self):
        """Of places folded to the quarter, [3 places][9 nodes]."""
        rows = np.zeros((3 * len(self.places), 9 * self.count))
        for n, place in enumerate(abs(self.places)):
            at, own = [], []
            for edges, p in zip(self.edges, place):
                i = min(np.searchsorted(edges, p, side="right") - 1, len(edges) - 2)
                at.append(i), own.append(2 * (p - edges[i]) / (edges[i + 1] - edges[i]) - 1)
            size, _, pressure = self.brick(*at, 0)
            rows[3 * n:3 * n + 3, self.unknowns(*at)] = base_rows(size, self.nu, pressure, *own)
        return rows

    def parity(self, component, even_x, even_y):
        """Of a component where u_z is even or odd about x = 0 and y = 0."""
        return even_x * (-1 if component == 0 else 1), even_y * (-1 if component == 1 else 1)

    def free(self, even_x, even_y):
        """Unknowns of a level that a parity does not hold."""
        at_zero = np.zeros((2, self.count), bool)
        at_zero[0, ::self.across] = at_zero[1, :self.across] = True
        held = np.zeros((self.count, 3), bool)
        for c in range(3):
            for axis, sign in enumerate(self.parity(c, even_x, even_y)):
                held[:, c] |= at_zero[axis] & (sign < 0)
        return np.flatnonzero(~held.ravel())

    def condense(self, parities):
        """Compliance of the quarter's surface and rows of stress, of each parity."""
        rows, kept = self.stress_rows(), {}
        for k in range(len(self.edges[2]) - 1):
            whole = self.layer(k)
            for parity in parities:
                free, n = self.free(*parity), 3 * self.count
                below, middle, above = free, free + n, free + 2 * n
                inner = middle if k == 0 else np.concatenate([below, middle])
                inside, to_top = whole[np.ix_(inner, inner)], whole[np.ix_(inner, above)]
                if k == 0:
                    stress, top_stress = rows[:, middle], rows[:, above]
                else:
                    stiffness, stress = kept[parity]
                    inside[:len(free), :len(free)] += stiffness
                    stress, top_stress = np.hstack([stress, np.zeros_like(stress)]), 0
                lower = cholesky(inside, lower=True, overwrite_a=True, check_finite=False)
                to_top, stress = (solve_triangular(lower, part, lower=True, check_finite=False) for part in (to_top, stress.T))
                kept[parity] = (whole[np.ix_(above, above)] - to_top.T @ to_top, top_stress - stress.T @ to_top)
        self.parts = {}
        for parity, (stiffness, stress) in kept.items():
            free = self.free(*parity)
            compliance = np.zeros((3 * self.count, 3 * self.count))
            factor = cho_factor((stiffness + stiffness.T) / 2, lower=True, check_finite=False)
            compliance[np.ix_(free, free)] = cho_solve(factor, np.eye(len(free)), check_finite=False)
            to_base = np.zeros((len(stress), 3 * self.count))
            to_base[:, free] = stress @ compliance[np.ix_(free, free)]
            self.parts[parity] = compliance, to_base
        return self

    def surface(self, mirrored_y):
        """Nodes of the whole surface, of y >= 0 where the load is even about y = 0: x, y, node of the quarter, signs [n][2]."""
        x, y = np.concatenate([-self.x[:0:-1], self.x]), self.y if mirrored_y else np.concatenate([-self.y[:0:-1], self.y])
        xx, yy = (v.ravel() for v in np.meshgrid(x, y, indexing="ij"))
        quarter = np.searchsorted(self.y, abs(yy) - 1e-9) * self.across + np.searchsorted(self.x, abs(xx) - 1e-9)
        return xx, yy, quarter, np.stack([np.where(xx < 0, -1, 1), np.where(yy < 0, -1, 1)], 1)

    def whole(self, quarter, signs):
        """Compliance [3 n][3 n] and stress rows [3 places][3 n] of nodes of the whole surface, by the parities that are there."""
        n, share = len(quarter), 1 / len(self.parts)
        compliance, stress = np.zeros((n, 3, n, 3)), np.zeros((len(self.places), 3, n, 3))
        side = np.where(self.places < 0, -1, 1)
        for parity, (own, rows) in self.parts.items():
            sign = lambda c, s: np.prod([s[:, a] if p < 0 else np.ones(len(s)) for a, p in enumerate(self.parity(c, *parity))], axis=0)
            for b in range(3):
                for a in range(3):
                    part = own[np.ix_(3 * quarter + a, 3 * quarter + b)]
                    compliance[:, a, :, b] += share * sign(a, signs)[:, None] * part * sign(b, signs)
                for row, a in enumerate((2, 0, 1)):
                    stress[:, row, :, b] += share * sign(a, side)[:, None] * rows[row::3][:, 3 * quarter + b] * sign(b, signs)
        return compliance.reshape(3 * n, 3 * n), stress.reshape(-1, 3 * n)


@njit(cache=True)
def settle(C, f, u, gap, goal, mu, tolerance, most, undamped=300):
    """Gauss-Seidel, of half steps after `undamped` sweeps, which may go around: forces f and displacements u of nodes below an indenter
    at `gap` above them that carries sticking nodes to `goal` [n][2]. Returns the sweeps."""
    n = len(gap)
    for sweep in range(most):
        worst, top = 0.0, 0.0
        for i in range(n):
            k = 3 * i
            Cx, Cy, cross = C[k, k], C[k + 1, k + 1], C[k, k + 1]
            Ct = (Cx + Cy) / 2 + np.sqrt((Cx - Cy) ** 2 / 4 + cross * cross)
            p = max(0.0, -f[k + 2] - (gap[i] - u[k + 2]) / C[k + 2, k + 2])
            dz = -p - f[k + 2]
            if dz == 0 and p == 0:
                continue
            tx = f[k] + (goal[i, 0] - u[k] - C[k, k + 2] * dz) / Ct
            ty = f[k + 1] + (goal[i, 1] - u[k + 1] - C[k + 1, k + 2] * dz) / Ct
            t = np.sqrt(tx * tx + ty * ty)
            if t > mu * p:
                tx, ty = tx * mu * p / t, ty * mu * p / t
            part = 1.0 if sweep < undamped else 0.5
            dx, dy, dz = part * (tx - f[k]), part * (ty - f[k + 1]), part * dz
            f[k], f[k + 1], f[k + 2] = f[k] + dx, f[k + 1] + dy, f[k + 2] + dz
            for j in range(len(u)):
                u[j] += dx * C[k, j] + dy * C[k + 1, j] + dz * C[k + 2, j]
            worst = max(worst, abs(dx), abs(dy), abs(dz))
            top = max(top, p)
        if worst <= tolerance * top:
            return sweep + 1
    return most


def slip_index(limit, places, Q, M):
    """S: the wrench over the largest along it that friction bears, the dual by reweighted least squares."""
    size = np.hypot(Q[0], Q[1]) + abs(M)
    if limit.sum() == 0 or size < 1e-9 * limit.sum():
        return 0.0
    centre = limit @ places / limit.sum()
    arms = places - centre
    radius = np.sqrt(limit @ (arms**2).sum(1) / limit.sum()) or 1.0
    arms = arms / radius
    wrench = np.array([Q[0], Q[1], (M - centre[0] * Q[1] + centre[1] * Q[0]) / radius])
    twist = wrench / (wrench @ wrench)
    for _ in range(60):
        slip = np.stack([twist[0] - twist[2] * arms[:, 1], twist[1] + twist[2] * arms[:, 0]], 1)
        weight = limit / np.maximum(np.hypot(*slip.T), 1e-9 * np.abs(twist).max())
        K = np.array([[weight.sum(), 0, -weight @ arms[:, 1]], [0, weight.sum(), weight @ arms[:, 0]],
                      [-weight @ arms[:, 1], weight @ arms[:, 0], weight @ (arms**2).sum(1)]])
        twist = np.linalg.solve(K + 1e-12 * np.trace(K) * np.eye(3), wrench)
        twist = twist / (twist @ wrench)
    slip = np.stack([twist[0] - twist[2] * arms[:, 1], twist[1] + twist[2] * arms[:, 0]], 1)
    return min(1.0, 1 / (limit @ np.hypot(*slip.T)))


def slide(C, stress, places, heights, mu, depth, drags, presses, parts, whole=1, tolerance=2e-5, most=2000):
    """Presses in so many increments and drags to each (x, y, twist) in so many parts. Returns P, Q, M, S and stress of the press and of
    each drag. `whole`: 2 for nodes of one half."""
    C = np.ascontiguousarray(C, np.float32)
    f, u, answers, sweeps = np.zeros(len(C)), np.zeros(len(C)), [], 0
    path = [(depth * (k + 1) / presses, np.zeros(3), k + 1 == presses) for k in range(presses)]
    at = np.zeros(3)
    for drag in np.asarray(drags, float):
        path += [(depth, at + (drag - at) * (k + 1) / parts, k + 1 == parts) for k in range(parts)]
        at = drag
    before, moved = np.zeros(3), None
    for down, motion, asked in path:
        u = np.asarray(C @ f.astype(np.float32), float)
        way = motion - before
        goal = u.reshape(-1, 3)[:, :2] + way[:2] + way[2] * np.stack([-places[:, 1], places[:, 0]], 1)
        last, before = f.copy(), motion
        if moved is not None and np.array_equal(moved[1], way):
            f += moved[0]
            n = f.reshape(-1, 3)
            n[:, 2] = np.minimum(n[:, 2], 0)
            t = np.hypot(n[:, 0], n[:, 1])
            n[:, :2] *= np.where(t > -mu * n[:, 2], -mu * n[:, 2] / np.maximum(t, 1e-300), 1)[:, None]
            u = np.asarray(C @ f.astype(np.float32), float)
        swept = settle(C, f, u, heights - down, goal, mu, tolerance, most)
        sweeps += swept
        if swept == most:
            raise RuntimeError("contact does not settle")
        moved = (f - last, way)
        if asked:
            n, force = -f[2::3], f.reshape(-1, 3)
            Q, M = force[:, :2].sum(0) * whole, (places[:, 0] @ force[:, 1] - places[:, 1] @ force[:, 0]) * whole
            if whole == 2:
                Q[1], M = 0, 0
            points = places if whole == 1 else np.concatenate([places, places * [1, -1]])
            answers.append(dict(P=n.sum() * whole, Q=Q, M=M, S=slip_index(mu * np.tile(n, whole), points, Q, M),
                                stress=(stress @ f).reshape(-1, 3), sweeps=sweeps))
    return answers
