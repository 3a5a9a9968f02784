#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Friction remembered from a slide: objects are gripped, slide once and are gripped again elsewhere. The network that takes friction
reads S, and mu from frames that slide; prints the error of S and alarms before the slide and after it, told nothing and told mu.

Usage: studies/friction_loop.py NETWORK.onnx SET.h5 [--objects 1000] [--drift 0.1] [--build build]
SET is of pads, with noise (examples/pad_recall.toml). An object is two of its contacts whose mu differ by the drift, a relative
standard deviation: the first one slides, and that it does is known, as of a robot that moves while frames stand still. There S is 1, so
that mu is the largest for which the network, told it within 5 %, reads an S above 0.97; the median over these frames.
Alarm: S of a row above 0.9, where the true S is above 0.9. Debian: python3-numpy, python3-h5py."""
import pathlib
import sys

import numpy as np

import study

SLIDES, SPREAD, LOUD = 0.97, 0.1, 0.9
GRID = np.geomspace(0.1, 2, 40)  # of mu


def reads(network, frames, mu=0.0, spread=0.0):
    return network(np.hstack([frames, np.broadcast_to(np.float32([mu, spread]), (len(frames), 2))]))


def pairs(mu, contacts, slides, drift, count, random):
    """Contacts that slide and others whose mu is nearest to the drifted one."""
    order = np.argsort(mu)
    for first in random.permutation(contacts[slides])[:count]:
        wanted = mu[first] * np.exp(drift * random.standard_normal())
        at = np.clip(np.searchsorted(mu[order], wanted), 1, len(order) - 2)
        near = order[at - 1:at + 2]
        near = near[near != first]
        yield first, near[np.argmin(np.abs(mu[near] - wanted))]


def main():
    parser = study.options(__doc__)
    parser.add_argument("network", type=pathlib.Path)
    parser.add_argument("set", type=pathlib.Path)
    parser.add_argument("--objects", type=int, default=1000)
    parser.add_argument("--drift", type=float, default=0.1)
    options = parser.parse_args()
    sys.path.insert(0, str(options.build / "python"))
    import h5py
    import tactel
    network = tactel.Network.load(options.network)
    with h5py.File(options.set) as file:
        frames, S, mu, contact = (file[name][:] for name in ("inputs", "slip_index", "friction", "contact"))
    first = np.flatnonzero(np.r_[True, contact[1:] != contact[:-1]])
    rows = np.split(np.arange(len(S)), first[1:])
    mu_of, silent = mu[first], reads(network, frames)
    sliding = S > 0.99
    read_of = np.full(len(S), np.nan)
    below = np.stack([reads(network, frames[sliding], m, 0.05) for m in GRID], 1) < SLIDES  # S falls with mu
    read_of[sliding] = GRID[np.maximum(np.where(below.any(1), below.argmax(1), len(GRID) - 1) - 1, 0)]
    slides = np.array([sliding[r].any() for r in rows])
    random = np.random.default_rng(1)
    errors = {"told nothing": [], "told mu as read": [], "told mu exactly, within 5 %": []}
    loud = {name: np.zeros(4, int) for name in errors}  # right, missed, false, right silence
    read = []
    for a, b in pairs(mu_of, np.arange(len(rows)), slides, options.drift, options.objects, random):
        known = np.median(read_of[rows[a]][sliding[rows[a]]])
        read.append(known / mu_of[a])
        here = rows[b]
        answers = {"told nothing": silent[here], "told mu as read": reads(network, frames[here], known, np.hypot(SPREAD, options.drift)),
                   "told mu exactly, within 5 %": reads(network, frames[here], mu_of[b], 0.05)}
        for name, s in answers.items():
            errors[name].append(np.abs(s - S[here]))
            for row, (asks, slips) in enumerate(((True, True), (False, True), (True, False), (False, False))):
                loud[name][row] += np.count_nonzero(((s > LOUD) == asks) & ((S[here] > LOUD) == slips))
    read = np.log(read)
    print(f"{len(read)} objects. mu as read over mu: median {np.exp(np.median(read)):.3f}, "
          f"within 10 % in {np.mean(np.abs(read) < 0.1):.0%}, within 30 % in {np.mean(np.abs(read) < 0.3):.0%}.\n")
    print(study.head("second grip", "mean error of S", "alarms of rows above 0.9", "false of rows below"))
    for name in errors:
        right, missed, false, quiet = loud[name]
        print(study.row(name, f"{np.concatenate(errors[name]).mean():.3f}", f"{right / (right + missed):.1%}", f"{false / (false + quiet):.2%}"))


if __name__ == "__main__":
    main()
