#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sixty pads with free sides beside finite elements of another program (rubber_block.py): what `solve` makes and says of S, P, Q and
of stress at the base.

Proportions from cubes to plates, nu 0 to 0.4999; faces over all, over an edge, over a corner; balls, cylinders, twist. Rows of a table:
errors made / said. P and sigma_z without the strain that
both leave out. Base stress over the largest of its kind on the path, tactels inside and the outermost; these are 0.065 of a length off
the sides.

Usage: studies/sixty_pads.py [--build build] [--pads 0:60] [--seed 60] [--kinds corner ...] [--cache FOLDER] [--accuracy E]. Half a
minute a pad.
Debian: python3-scipy, python3-numba."""
import json
import pathlib
import tempfile

import numpy as np
import rubber_block as rubber
import study

KINDS = ("all", "all", "edge", "corner", "all, turned", "ball", "ball, edge", "ball, corner", "cylinder", "edge, twist")
NU = (0, 0.3, 0.45, 0.49, 0.499, 0.4999)
SEED = 60


def pad(k, seed=SEED):
    """Pad k: lengths over H = 1."""
    draw = np.random.default_rng((seed, k))
    kind = KINDS[k % len(KINDS)]
    length = float(np.exp(draw.uniform(0, np.log(10))))
    width = float(max(1, length * draw.uniform(0.4, 1)))
    nu, mu = NU[(k + k // len(KINDS)) % len(NU)], float(np.exp(draw.uniform(np.log(0.2), np.log(1.2))))
    x, y, twist, shape, depth = 0.0, 0.0, 0.0, {"shape": "box", "half_widths": [99, 99]}, 0.02
    way = [1.0, 0.0]
    if kind.startswith("edge"):
        covered = draw.uniform(0.3, 0.8) * length
        shape["half_widths"], x = [0.6 * covered, 99], length / 2 - 0.4 * covered
        way = [0.0, 1.0] if draw.uniform() < 0.5 else [1.0, 0.0]
    if kind == "corner":
        covered = draw.uniform(0.4, 0.8, 2) * [length, width]
        shape["half_widths"] = list(0.6 * covered)
        x, y = length / 2 - 0.4 * covered[0], width / 2 - 0.4 * covered[1]
        way = [0.7, 0.7]
    if kind.startswith("ball"):
        reach = draw.uniform(0.25, 0.45) * min(1.5, width)
        depth = draw.uniform(0.02, 0.08)
        shape = {"shape": "sphere", "radius": reach**2 / depth}
        x = length / 2 - (reach * draw.uniform(0, 1) if kind != "ball" else length / 2 * draw.uniform(0.5, 1))
        y = width / 2 - reach * draw.uniform(0, 1) if kind == "ball, corner" else 0.0
    if kind == "cylinder":
        reach, depth = draw.uniform(0.25, 0.45) * min(1.5, length), draw.uniform(0.02, 0.08)
        shape, x = {"shape": "cylinder", "radius": reach**2 / depth, "half_length": 99}, draw.uniform(0, 0.45) * length
    if kind in ("all, turned", "edge, twist", "ball, corner"):
        twist, way = 1.0, [0.3, 0.3] if kind != "edge, twist" else [0.0, 0.0]
    return dict(name=f"{seed}_{k}", kind=kind, length=length, width=width, nu=nu, mu=mu, x=float(x), y=float(y), depth=depth, way=way,
                twist=twist, **shape)


def heights(p, x, y):
    """Of the indenter at places about its axis; none beyond a sharp edge."""
    if p["shape"] == "box":
        outside = (abs(x) > p["half_widths"][0] + 1e-9) | (abs(y) > p["half_widths"][1] + 1e-9)
        return np.where(outside, np.inf, 0)
    r2 = x**2 + (y**2 if p["shape"] == "sphere" else 0)
    return p["radius"] - np.sqrt(np.maximum(p["radius"]**2 - r2, 0))


def tactels(p):
    places = [(i - 1.5) * 0.29 for i in range(4)]
    return np.array([(a * p["length"], b * p["width"]) for b in places for a in places])


def along(half, at, p, axis, count):
    """Edges of the quarter's bricks along an axis: fine at the sides and where the contact ends; `count` across the contact of a ball."""
    if p["shape"] == "box":
        edge = abs(at - p["half_widths"][axis])
        return rubber.graded(half, [edge], count + 2) if edge < half else rubber.graded(half, [], count)
    if p["shape"] == "cylinder" and axis == 1:
        return rubber.graded(half, [], count)
    reach = np.sqrt(p["radius"] * p["depth"])
    if p["shape"] == "sphere":
        slope = 0.3 if p["kind"] == "ball" else 0.5  # no tactel may lie below
        return across_ball(half, max(0, at - 1.05 * reach), at + 1.05 * reach, 2.1 * reach / count, slope)
    reach *= 1.15
    zone = (max(0, abs(at) - reach) if abs(at) > reach else 0.0, min(half, abs(at) + reach))
    return rubber.graded(half, [zone], count)


def across_ball(half, first, last, size, slope):
    """Edges of bricks of `size` from first to last, wider beyond by `slope`, finer at a side that is near."""
    x = np.linspace(0, half, 4001)
    widest = np.minimum(1.2, size + slope * np.maximum(0, np.maximum(first - x, x - last)))
    density = 1 / np.minimum(widest, max(0.04, 0.3 * (half - last)) + 0.3 * (half - x))
    total = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2) * (x[1] - x[0])])
    return np.interp(np.linspace(0, total[-1], int(np.ceil(total[-1])) + 1), total, x)


def condensed(p, count):
    even = p["y"] == 0 and p["twist"] == 0 and p["way"][1] == 0
    x, y = along(p["length"] / 2, p["x"], p, 0, count), along(p["width"] / 2, p["y"], p, 1, count)
    levels = rubber.levels(1, count >= 7)
    if p["kind"].startswith(("edge", "corner")):  # the pressure is singular at an edge of the indenter
        levels = np.concatenate([levels[:-3], [0.645, 0.84, 0.94, 1]])
    block = rubber.Block(x, y, levels, p["nu"], tactels(p))
    block.condense([(1, 1), (-1, 1)] if even else [(1, 1), (-1, 1), (1, -1), (-1, -1)])
    xx, yy, quarter, signs = block.surface(even)
    h = heights(p, xx - p["x"], yy - p["y"])
    near = np.flatnonzero(h < 1.15 * p["depth"])
    compliance, stress = block.whole(quarter[near], signs[near])
    return compliance, stress, np.stack([xx[near] - p["x"], yy[near] - p["y"]], 1), h[near], 2 if even else 1


def drags(p, contact):
    """Two: to half of what slides, about, and beyond."""
    compliance, _, places, h, whole = contact
    press = rubber.slide(*contact[:4], 0.0, p["depth"], [], 1, 1, whole)[0]
    touch = np.flatnonzero(h < 0.8 * p["depth"])
    axis = 0 if p["way"][0] >= p["way"][1] else 1
    own = compliance[np.ix_(3 * touch + axis, 3 * touch + axis)] + 1e-9 * np.eye(len(touch))
    reach = p["mu"] * press["P"] / (np.linalg.solve(own, np.ones(len(touch))).sum() * whole)
    radius = np.sqrt((places[touch]**2).sum(1).mean()) if p["shape"] != "box" else np.sqrt(p["length"] * p["width"] / 6)
    return [[*(float(f"{share * reach * w:.4g}") for w in p["way"]),
             float(f"{np.degrees(share * reach / radius * p['twist']):.4g}")] for share in (0.5, 1.2)]


def judged(p, count, cache):
    """The judge's answers on bricks of that count, and the drags; kept in a file."""
    path = cache / f"{p['name']}_{count}.json"
    if path.is_file():
        return json.loads(path.read_text())
    contact = condensed(p, count)
    first = cache / f"{p['name']}_drags.json"
    if not first.is_file():
        first.write_text(json.dumps(drags(p, contact)))
    moves = json.loads(first.read_text())
    turned = [[x, y, np.radians(twist)] for x, y, twist in moves]
    runs = [rubber.slide(*contact[:4], p["mu"], p["depth"], turned, presses, parts, contact[4]) for presses, parts in ((3, 2), (6, 4))]
    steps = []
    for coarse, fine in zip(*runs):  # increments converge at the first order
        step = {name: (2 * np.asarray(fine[name]) - np.asarray(coarse[name])).tolist() for name in ("P", "Q", "M", "stress")}
        steps.append({**step, "S": min(1, 2 * fine["S"] - coarse["S"]), "sweeps": fine["sweeps"]})
    path.write_text(json.dumps(dict(drags=moves, steps=steps)))
    return json.loads(path.read_text())


def scene(p, moves):
    shape = "".join(f"{key} = {json.dumps(p[key])}\n" for key in ("half_widths", "radius", "half_length") if key in p)
    return (f'[sensor]\nkind = "pad"\ntactels = [4, 4]\npitch = [{0.29 * p["length"]}, {0.29 * p["width"]}]\nthickness = 1\nyoung = 1.0\n'
            f'poisson = {p["nu"]}\nlength = {p["length"]}\nwidth = {p["width"]}\n[indenter]\nshape = "{p["shape"]}"\n{shape}'
            f'position = [{p["x"]}, {p["y"]}]\n[contact]\nfriction = {p["mu"]}\n[load]\nindentation = {p["depth"]}\n'
            f'tangential = {[m[:2] for m in moves]}\ntwist = {[m[2] for m in moves]}\n')


def made_and_said(p, judge, coarse, answer):
    """Errors of an answer as fem/pad/pad_reference.cpp has them, with `base` of the tactels inside and outermost; what the answer says of
    them; what the judge differs from itself on coarser bricks, 0 without them."""
    steps = answer["steps"][-3:]
    ours = [dict(P=s["P"], Q=s["Q"], M=s["M"], S=s["slip_index"] or 0,
                 stress=np.stack([s["sigma_z"], s["tau_x"], s["tau_y"]], -1).reshape(16, 3)) for s in steps]
    size = max(np.max(np.ptp([answer["cell_x"], answer["cell_y"]], axis=1)) / 2, 1e-9)

    def off(a, b):
        error, largest = dict(P=0.0, S=0.0, Q=0.0, M=0.0), dict(P=0.0, t=0.0)
        base = np.zeros((2, 2))  # [sigma, tau][inside, outermost]
        top, out = np.zeros(2), np.maximum(abs(np.arange(16) % 4 - 1.5), abs(np.arange(16) // 4 - 1.5)) > 1
        for one, two in zip(a, b):
            error["P"], largest["P"] = max(error["P"], abs(one["P"] - two["P"])), max(largest["P"], two["P"])
            error["S"] = max(error["S"], abs(one["S"] - two["S"]))
            error["Q"] = max(error["Q"], np.hypot(*np.subtract(one["Q"], two["Q"])))
            error["M"] = max(error["M"], abs(one["M"] - two["M"]) / size)
            largest["t"] = max(largest["t"], np.hypot(*two["Q"]), abs(two["M"]) / size)
            stress, right = np.asarray(one["stress"]), np.asarray(two["stress"])
            for n, c in enumerate((slice(0, 1), slice(1, 3))):
                top[n] = max(top[n], abs(right[:, c]).max())
                for m, which in enumerate((~out, out)):
                    base[n, m] = max(base[n, m], abs(stress - right)[which, c].max())
        error["P"] /= largest["P"]
        error["Q"], error["M"] = error["Q"] / largest["t"], error["M"] / largest["t"]
        base /= top[:, None]
        return {**error, "sigma": base[0].max(), "tau": base[1].max(), "base": base}

    made, own, e = off(ours, judge["steps"]), off((coarse or judge)["steps"], judge["steps"]), answer["discretisation_error"]
    said = dict(S=e["slip_index"], P=e["P"] - e["strain"], Q=e["Q"], M=e["M"], sigma=e["sigma_z"] - e["strain"], tau=e["tau"])
    return made, said, own


def main():
    parser = study.options(__doc__)
    parser.add_argument("--pads", default="0:60")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--kinds", nargs="+", default=KINDS, help=f"of {KINDS}")
    parser.add_argument("--cache", type=pathlib.Path)
    parser.add_argument("--bricks", type=int, nargs="+", default=[7], help="along a half side; others to judge the judge by")
    parser.add_argument("--accuracy", type=float)
    options = parser.parse_args()
    run, names, all_pads = study.Program(options.build), ("S", "P", "Q", "M", "sigma", "tau"), []
    print(study.head("pad", "kind", "L W /H", "nu", "mu", "rung", *(f"{n} made/said" for n in names), "base in", "out", "judge S P base"))
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        cache = options.cache or folder
        cache.mkdir(exist_ok=True)
        for k in range(*map(int, options.pads.split(":"))):
            p = pad(k, options.seed)
            if p["kind"] not in options.kinds:
                continue
            try:
                judge, coarse = ([judged(p, n, cache) for n in options.bricks] + [None])[:2]
            except RuntimeError as error:
                print(f"| {k} | {p['kind']} | left out: {error} |")
                continue
            (folder / "pad.toml").write_text(scene(p, judge["drags"]))
            run("solve", folder / "pad.toml", "--json", folder / "pad.json", *(["--accuracy", options.accuracy] if options.accuracy else []))
            answer = json.loads((folder / "pad.json").read_text())
            made, said, own = made_and_said(p, judge, coarse, answer)
            all_pads.append((k, {n: (made[n], said[n]) for n in names}, made["base"]))
            print(study.row(k, p["kind"], f"{p['length']:.2f} {p['width']:.2f}", p["nu"], f"{p['mu']:.2f}", answer["rung"],
                            *(f"{made[n]:.4f} / {said[n]:.4f}" + "!" * int(made[n] > said[n]) for n in names),
                            *("{:.3f} {:.3f}".format(*made["base"][:, m]) for m in (0, 1)),
                            f"{own['S']:.4f} {own['P']:.4f} {own['base'].max():.3f}"), flush=True)
    for n in names:
        made, said = np.array([pad[1][n] for pad in all_pads]).T
        print(f"{n}: held by {np.mean(made <= said):.0%} of {len(made)}, worst {np.max(made / said):.2f}; made median {np.median(made):.4f}, 95 % {np.quantile(made, 0.95):.4f}; said median "
              f"{np.median(said):.4f}, largest {said.max():.4f}")


if __name__ == "__main__":
    main()
