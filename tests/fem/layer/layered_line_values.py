#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The expected values of layered_line_test.cpp: an endless layer of rubbers upon each other in plane strain, under a line
force of 1 N/mm, in 200 digits. Along a wave e^(iwx) the state (u_x / i, u_y, tau / i, sigma_y) obeys a linear equation
y' = M y through the thickness; M has the double eigenvalues +-w, so that e^(M t) is a cubic in M. Lengths are over the
sum of the layers, E over that of the uppermost.

    /usr/bin/python3 tests/fem/layer/layered_line_values.py
"""
from mpmath import cosh, exp, expm1, eye, log, atan, matrix, mp, mpf, pi, sinh, cos, sin
from mpmath.calculus.quadrature import GaussLegendre

mp.dps = 200


def passed(thickness, young, poisson, w):
    """e^(M t) of one layer."""
    G, nu, t = mpf(young) / (2 * (1 + mpf(poisson))), mpf(poisson), mpf(thickness)
    M = matrix([[0, -w, 1 / G, 0],
                [w * nu / (1 - nu), 0, 0, (1 - 2 * nu) / (2 * G * (1 - nu))],
                [2 * G * w * w / (1 - nu), 0, 0, -w * nu / (1 - nu)],
                [0, 0, w, 0]])
    N = M * M - w * w * eye(4)
    c, s = cosh(w * t), sinh(w * t)
    return c * eye(4) + s / w * M + t * s / (2 * w) * N + (t * c / (2 * w * w) - s / (2 * w**3)) * M * N


def transforms(layers, a):
    """yy, xx, xy, sigma_by_y, tau_by_x, tau_by_y, sigma_by_x of fem/layer/layer_transforms.h."""
    P = eye(4)
    for layer in layers:
        P = passed(*layer, a) * P
    A, B = P[2:4, 2:4], P[0:2, 2:4]  # of the stress at the base: stress and displacement at the surface
    base = A**-1
    u = B * base
    young, nu = mpf(layers[-1][1]), mpf(layers[-1][2])
    c, d = 2 * (1 - nu * nu) / (young * a), (1 + nu) / (young * a)
    return [u[1, 1] / c, u[0, 0] / c, -u[0, 1] / d, base[1, 1], base[0, 0], base[0, 1], -base[1, 0]]


def points(last):
    nodes = GaussLegendre(mp).calc_nodes(3, 100)  # 12 points
    ends = [mpf(0)] + [mpf(2)**k / 2**30 for k in range(29)]
    while ends[-1] < last:
        ends.append(ends[-1] + min(mpf(1), ends[-1] / 2))
    for left, right in zip(ends, ends[1:]):
        for x, weight in nodes:
            yield (left + right) / 2 + (right - left) / 2 * x, (right - left) / 2 * weight


def kernels(layers, places):
    nu = mpf(layers[-1][2])
    cy, cx, jump = 2 * (1 - nu * nu) / pi, (1 + nu) / pi, 1 - 2 * nu
    last = 13 / mpf(layers[-1][0])
    sums = {x: [log(1 + x * x) / 2, log(1 + x * x) / 2, -jump * atan(x), mpf(0), mpf(0), mpf(0), mpf(0)] for x in places}
    for a, weight in points(last):
        yy, xx, xy, sy, tx, ty, sx = transforms(layers, a)
        for x, s in sums.items():
            c, d = cos(a * x), sin(a * x)
            for k, term in enumerate([(yy + expm1(-a)) * c / a, (xx + expm1(-a)) * c / a, (xy + jump * expm1(-a)) * d / a,
                                      sy * c / pi, tx * c / pi, -ty * d / pi, -sx * d / pi]):
                s[k] += weight * term
    for x, (yy, xx, xy, *base) in sums.items():
        print([float(x)] + [mp.nstr(v, 12) for v in (cy * (yy - log(x)), cy * (xx - log(x)), cx * (jump * pi / 2 + xy), *base)])


if __name__ == "__main__":
    places = [mpf(1) / 20, mpf(1) / 2, mpf(2)]
    for layers in ([("0.925", "0.1", "0.48"), ("0.075", "1", "0.48")],
                   [("0.05", "0.1", "0.49"), ("0.5", "2", "0"), ("0.45", "1", "0.4999")],
                   [("1", "1", "0.45")]):
        print(layers)
        kernels(layers, places)
