#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Judges contacts solved elsewhere: assembles the block anew, condenses it densely, solves the contact by block Gauss-Seidel over the
surface nodes, and compares base nodal forces. It shares no line with the program, only the conventions (mm, N/mm, x along the array,
y up; forces of the rubber on the base).

usage: independent_contact.py CASES.json    exit 0 if every case agrees, 1 if not, 2 without numpy

CASES.json: {"agreement": largest allowed difference over the largest base force, "cases": [{
  "name", "sensor": {length, thickness, young, poisson, columns, rows, grading, element: "q4" | "bbar"},
  "shape": "parabola" | "wedge" | "flat", "size": radius | edge_angle | half_width, "position", "friction",
  "steps": [{"indentation", "tangential", "base_force_x": [...], "base_force_y": [...]}]}]}
"""
import json
import math
import sys

try:
    import numpy as np
except ImportError:
    print("independent_contact.py needs numpy (Debian: python3-numpy)")
    sys.exit(2)


def mesh_lines(sensor):
    """x of the columns; y of the rows, whose heights fall geometrically from bottom to top."""
    x = np.linspace(-sensor["length"] / 2, sensor["length"] / 2, sensor["columns"])
    count = sensor["rows"] - 1
    height = np.array([sensor["grading"] ** (-k / max(1, count - 1)) for k in range(count)])
    y = np.concatenate([[0.0], np.cumsum(height)]) * (sensor["thickness"] / height.sum())
    return x, y


def element_stiffness(width, height, young, nu, mean_dilatation):
    """Rectangle, nodes counter-clockwise from the lower left, 2x2 Gauss points, plane strain."""
    lame = young * nu / ((1 + nu) * (1 - 2 * nu))
    shear = young / (2 * (1 + nu))
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    point = 1 / math.sqrt(3)
    points = [(sx * point, sy * point) for sx in (-1, 1) for sy in (-1, 1)]
    weight = width * height / 4

    def gradients(xi, eta):
        dx = corner[:, 0] * (1 + corner[:, 1] * eta) / 4 * (2 / width)
        dy = corner[:, 1] * (1 + corner[:, 0] * xi) / 4 * (2 / height)
        return dx, dy

    mean = np.zeros(8)  # of the divergence, over the element
    for p in points:
        dx, dy = gradients(*p)
        mean[0::2] += dx / 4
        mean[1::2] += dy / 4
    k = np.zeros((8, 8))
    for p in points:
        dx, dy = gradients(*p)
        divergence = np.zeros(8)
        divergence[0::2], divergence[1::2] = dx, dy
        e = np.zeros((4, 8))  # xx, yy, zz, engineering xy
        e[0, 0::2], e[1, 1::2] = dx, dy
        e[3, 0::2], e[3, 1::2] = dy, dx
        if mean_dilatation:
            for row in range(3):  # a third of the divergence is exchanged in each direct strain, zz included
                e[row] += (mean - divergence) / 3
        d = np.diag([2 * shear, 2 * shear, 2 * shear, shear])
        d[:3, :3] += lame
        k += weight * e.T @ d @ e
    return k


class Block:
    """C: surface displacements from surface forces. T: base forces from surface forces."""

    def __init__(self, sensor):
        x, y = mesh_lines(sensor)
        columns, rows = len(x), len(y)
        size = 2 * columns * rows
        k = np.zeros((size, size))
        for j in range(rows - 1):
            ke = element_stiffness(x[1] - x[0], y[j + 1] - y[j], sensor["young"], sensor["poisson"], sensor["element"] == "bbar")
            for i in range(columns - 1):
                nodes = [j * columns + i, j * columns + i + 1, (j + 1) * columns + i + 1, (j + 1) * columns + i]
                dofs = [2 * n + d for n in nodes for d in (0, 1)]
                k[np.ix_(dofs, dofs)] += ke
        base = np.arange(2 * columns)
        free = np.arange(2 * columns, size)
        surface = np.arange(size - 2 * columns, size)
        load = np.zeros((len(free), 2 * columns))
        load[surface - 2 * columns, np.arange(2 * columns)] = 1
        u = np.linalg.solve(k[np.ix_(free, free)], load)
        u += np.linalg.solve(k[np.ix_(free, free)], load - k[np.ix_(free, free)] @ u)
        self.x = x
        self.compliance = u[surface - 2 * columns]
        self.to_base = -k[np.ix_(base, free)] @ u


def profile(case, x):
    r = np.abs(x - case["position"])
    if case["shape"] == "parabola":
        return r**2 / (2 * case["size"])
    if case["shape"] == "wedge":
        return r / math.tan(math.radians(case["size"] / 2))
    return np.where(r <= case["size"] + 1e-9, 0.0, np.inf)  # flat


def node_forces(c, gap_free, slip_free, mu):
    """Pressure n and friction t of one node, its local compliance c [2, 2], others' forces held: with f = (t, -n),
    gap = gap_free - (c f)_y >= 0, slip = slip_free + (c f)_x."""
    if gap_free >= 0:
        return 0.0, 0.0
    # Stick: (c f)_x = -slip_free, (c f)_y = gap_free.
    t, down = np.linalg.solve(c, [-slip_free, gap_free])
    if -down >= 0 and abs(t) <= mu * -down:
        return -down, t
    for side in (1, -1):  # t = side mu n: (side mu c_yx - c_yy) n = gap_free
        n = gap_free / (side * mu * c[1, 0] - c[1, 1])
        t = side * mu * n
        if n >= 0 and side * (slip_free + c[0, 0] * t - c[0, 1] * n) <= 0:
            return n, t
    return None


def contact(block, case, depth, drag, before, f):
    """Surface forces [2 columns] by Gauss-Seidel, from the guess f; before: u_x - indenter position one step ago."""
    c, height, mu = block.compliance, profile(case, block.x), case["friction"]
    u = c @ f
    for sweep in range(20000):
        change = 0.0
        for i in np.flatnonzero(height < depth + 0.5):
            ix, iy = 2 * i, 2 * i + 1
            local = c[ix : iy + 1, ix : iy + 1]
            others = u[ix : iy + 1] - local @ f[ix : iy + 1]
            forces = node_forces(local, height[i] - depth - others[1], others[0] - drag - before[i], mu)
            if forces is None:
                raise ArithmeticError("a node has no solution")
            step = np.array([forces[1], -forces[0]]) - f[ix : iy + 1]
            if step.any():
                u += c[:, ix : iy + 1] @ step
                f[ix : iy + 1] += step
                change = max(change, np.abs(step).max())
        if change <= 1e-15 * np.abs(f).max():
            break
        if sweep % 20 == 19:
            u = c @ f  # no drift of the running sum
    else:
        raise ArithmeticError("Gauss-Seidel did not settle")
    return f, c @ f


def judge(case, block):
    """Largest difference of a base nodal force over the largest base nodal force, over all steps."""
    f = np.zeros(2 * len(block.x))
    before = np.zeros(len(block.x))
    worst = 0.0
    for step in case["steps"]:
        f, u = contact(block, case, step["indentation"], step["tangential"], before, f)
        before = u[0::2] - step["tangential"]
        base = block.to_base @ f
        theirs = np.ravel(np.column_stack([step["base_force_x"], step["base_force_y"]]))
        worst = max(worst, np.abs(base - theirs).max() / np.abs(base).max())
    return worst


def main():
    with open(sys.argv[1]) as file:
        given = json.load(file)
    blocks, agreed = {}, True
    for case in given["cases"]:
        key = json.dumps(case["sensor"], sort_keys=True)
        if key not in blocks:
            blocks[key] = Block(case["sensor"])
        difference = judge(case, blocks[key])
        agreed &= difference <= given["agreement"]
        print(f"{case['name']}: {difference:.1e}")
    return 0 if agreed else 1


if __name__ == "__main__":
    sys.exit(main())
