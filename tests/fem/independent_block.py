#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An independent program for the condensed block, held against fem/.

It assembles no elements. On a rectangular grid the bilinear space is a product of two one-dimensional spaces, so that
the stiffness of the whole block is a sum of Kronecker products of one-dimensional matrices:

    integral u,x v,x = K_x (x) M_y,   integral u,y v,y = M_x (x) K_y,   integral u,x v,y = B_x (x) B_y^T

with K, M and B[i,j] = integral N_i' N_j of the linear hat functions. Mean dilatation (Hughes 1980) replaces the
dilatation u,x + v,y by its mean over each cell. On a cell the part of u,x that is not constant is linear in y and the
part of v,y linear in x; they are orthogonal, so that kappa (K_x (x) D_y) for u and kappa (D_x (x) K_y) for v is
taken off, D = M less the mass of cell means.

The stress by `element` is worked out from finite differences: a bilinear displacement's gradient, sampled at the
Gauss points of a cell and extrapolated bilinearly, is the gradient at the corner itself (q4); mean dilatation replaces
u,x + v,y in it by its value at the cell's centre.

usage: independent_block.py DUMP_PROGRAM
"""

import subprocess
import sys

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg


def line_matrices(x):
    """Stiffness, mass, B and deviation D of linear elements between the points x, all [n, n] sparse."""
    n, h = len(x), np.diff(x)
    matrices = [sparse.lil_matrix((n, n)) for _ in range(4)]
    for e in range(n - 1):
        cells = (
            np.array([[1, -1], [-1, 1]]) / h[e],
            h[e] / 6 * np.array([[2, 1], [1, 2]]),
            np.array([[-1, -1], [1, 1]]) / 2,
            h[e] / 12 * np.array([[1, -1], [-1, 1]]),
        )
        for matrix, cell in zip(matrices, cells):
            matrix[e : e + 2, e : e + 2] += cell
    return [m.tocsc() for m in matrices]


def grid(s):
    """Places of columns, [columns], and of rows, [rows], mm."""
    x = np.linspace(-s["length"] / 2, s["length"] / 2, s["columns"])
    n = s["rows"] - 1
    heights = np.ones(1) if n == 1 else np.geomspace(s["grading"], 1.0, n)
    y = np.concatenate([[0.0], np.cumsum(heights)]) * s["thickness"] / heights.sum()
    return x, y


def stiffness(s, x, y):
    """[2 nodes, 2 nodes]; all x displacements first, nodes row by row from the base (Kronecker order y, x). E = 1."""
    nu = s["poisson"]
    shear, bulk = 1 / (2 * (1 + nu)), 1 / (3 * (1 - 2 * nu))
    along, across = bulk + 4 * shear / 3, bulk - 2 * shear / 3
    kx, mx, bx, dx = line_matrices(x)
    ky, my, by, dy = line_matrices(y)
    kron = sparse.kron
    xx, yy = kron(my, kx), kron(ky, mx)
    xy = kron(by.T, bx)  # integral N_i,x N_j,y
    uu, vv = along * xx + shear * yy, along * yy + shear * xx
    if s["element"] == "bbar":
        uu, vv = uu - bulk * kron(dy, kx), vv - bulk * kron(ky, dx)
    uv = across * xy + shear * xy.T
    return sparse.bmat([[uu, uv], [uv.T, vv]]).tocsc()


def interpolation(nodes, places):
    """[places, nodes]: linear interpolation."""
    matrix = np.zeros((len(places), len(nodes)))
    for t, p in enumerate(places):
        e = min(int(np.searchsorted(nodes, p, side="right")) - 1, len(nodes) - 2)
        part = (p - nodes[e]) / (nodes[e + 1] - nodes[e])
        matrix[t, e : e + 2] = 1 - part, part
    return matrix


def base_stress_by_element(s, x, y, u, v):
    """sigma_y and tau_xy at the base nodes, each [columns, loads], from the two lowest rows of displacements."""
    nu = s["poisson"]
    shear, bulk = 1 / (2 * (1 + nu)), 1 / (3 * (1 - 2 * nu))
    columns, w, h = len(x), np.diff(x)[:, None], y[1] - y[0]
    (u0, u1), (v0, v1) = ((f[:columns], f[columns : 2 * columns]) for f in (u, v))
    sigma, tau, cells = np.zeros_like(u0), np.zeros_like(u0), np.zeros((columns, 1))
    left, right = slice(0, columns - 1), slice(1, columns)
    for corner in (left, right):
        ux = (u0[right] - u0[left]) / w
        uy, vy = (u1[corner] - u0[corner]) / h, (v1[corner] - v0[corner]) / h
        vx = (v0[right] - v0[left]) / w
        dilatation = ux + vy
        if s["element"] == "bbar":
            dilatation = (u0[right] - u0[left] + u1[right] - u1[left]) / (2 * w) + (
                v1[left] - v0[left] + v1[right] - v0[right]
            ) / (2 * h)
        # sigma_y = kappa dilatation + 2 G (deviator of the local strain)
        sigma[corner] += bulk * dilatation + 2 * shear * (vy - (ux + vy) / 3)
        tau[corner] += shear * (uy + vx)
        cells[corner] += 1
    return sigma / cells, tau / cells


def condense(s):
    """C, T and tactel stress in the order of fem/mesh/condensation.h."""
    x, y = grid(s)
    columns, nodes = s["columns"], s["columns"] * s["rows"]
    k = stiffness(s, x, y)
    base = np.concatenate([np.arange(columns), nodes + np.arange(columns)])
    surface = np.concatenate([nodes - columns + np.arange(columns), 2 * nodes - columns + np.arange(columns)])
    free = np.setdiff1d(np.arange(2 * nodes), base)
    load = np.zeros((2 * nodes, 2 * columns))
    load[surface, np.arange(2 * columns)] = 1
    solution = np.zeros_like(load)
    solution[free] = scipy.sparse.linalg.splu(k[free][:, free]).solve(load[free])
    force = -(k[base] @ solution)
    order = np.arange(2 * columns).reshape(2, columns).T.ravel()  # x, y of node 0, of node 1, ...
    to_tactels = interpolation(x, np.linspace(x[0], x[-1], s["tactels"]))
    if s["stress"] == "reaction":
        recovery = to_tactels @ np.linalg.inv(line_matrices(x)[1].toarray())
        stress = np.vstack([recovery @ force[columns:], recovery @ force[:columns]])
    else:
        sigma, tau = base_stress_by_element(s, x, y, solution[:nodes], solution[nodes:])
        stress = np.vstack([to_tactels @ sigma, to_tactels @ tau])
    return solution[surface][order][:, order], force[order][:, order], stress[:, order]


def ours(program, s):
    names = "element stress poisson columns rows grading length thickness tactels".split()
    raw = subprocess.run([program] + [str(s[name]) for name in names], check=True, stdout=subprocess.PIPE).stdout
    values, n = np.frombuffer(raw), 2 * s["columns"]
    assert values.size == 2 * n * n + 2 * s["tactels"] * n, "the dump has another size"
    return np.split(values, [n * n, 2 * n * n])


def main():
    program, worst = sys.argv[1], 0.0
    mesh_b = dict(columns=41, rows=11, grading=4.0, length=20.0, thickness=1.5, tactels=21)
    mesh_a = dict(mesh_b, columns=123, rows=33)
    odd = dict(columns=8, rows=2, grading=3.0, length=5.5, thickness=2.0, tactels=11)
    cases = [(mesh_b, nu) for nu in (0.0, 0.3, 0.45, 0.49, 0.4999)] + [(mesh_a, 0.45), (odd, 0.4)]
    for mesh, nu in cases:
        for element in ("q4", "bbar"):
            for stress in ("reaction", "element"):
                s = dict(mesh, poisson=nu, element=element, stress=stress)
                errors = [
                    np.abs(mine.ravel() - theirs).max() / np.abs(mine).max()
                    for mine, theirs in zip(condense(s), ours(program, s))
                ]
                # Either side rounds its volumetric stiffness: 1e-16 times about 1 / (1/2 - nu) and some tens of terms.
                allowed = 5e-14 / (0.5 - nu)
                good = max(errors) < allowed
                worst = max(worst, max(errors) / allowed)
                print(
                    f"{element:5} {stress:9} nu {nu:<7} {s['columns']:3} x {s['rows']:<3} C %.1e  T %.1e  stress %.1e  "
                    "allowed %.1e  %s" % (*errors, allowed, "" if good else "TOO FAR")
                )
    return 0 if worst < 1 else 1


if __name__ == "__main__":
    sys.exit(main())
