#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Presses of a paraboloid on rubber as thick as a half-space, without friction, on one grid by tactel.PadStepper and by Tamaas
(pip install tamaas), both judged by Hertz: bench/half_space.py [--python build/python]

Prints contacts of a processor second, medians of rounds in turns, and the largest |P - P of Hertz at the depth| over P of Hertz."""
import argparse
import os
import pathlib
import sys
import time

import numpy as np

RADIUS, YOUNG, POISSON = 8.0, 0.5, 0.48  # mm, MPa
THICKNESS = 1e4  # mm: 5000 contact radii, which raises P by 1.13 / 5000 (Dimitriadis)
DEPTHS = 0.5 * np.random.default_rng(1).uniform(0.5, 1, 500)  # mm, in no order
JUDGED = 50  # of them, all that Tamaas presses
SIDE = 2.4 * np.sqrt(RADIUS * 0.5)  # mm, of the grid: 1.2 times the largest contact
ROUNDS = 5


def hertz(depth):
    """N"""
    return 4 / 3 * YOUNG / (1 - POISSON**2) * np.sqrt(RADIUS) * depth**1.5


def tactel_presses(cells):
    """A call that presses all of DEPTHS; returns P."""
    import tactel
    pad = tactel.Pad(tactels=(1, 1), thickness=THICKNESS, young=YOUNG, poisson=POISSON)
    steps = tactel.PadStepper(pad, len(DEPTHS), friction=0, cells=cells, cell=SIDE / cells, precision="fp32")
    steps.shapes(tactel.Paraboloid([RADIUS, RADIUS]))
    poses = np.zeros((len(DEPTHS), 4))
    poses[:, 0] = DEPTHS

    def press():
        steps.reset(np.ones(len(DEPTHS), bool))
        return steps.move(poses).force[:, 0].astype(float)
    return press, lambda P: np.abs(P / hertz(DEPTHS) - 1)[:JUDGED].max()


def tamaas_presses(cells):
    """The same by Polonsky and Keer's gradients and an aperiodic FFT, from P; each press but the first starts from the one before."""
    import tamaas
    tamaas.set_log_level(tamaas.LogLevel.error)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [SIDE, SIDE], [cells, cells])
    model.E, model.nu = YOUNG, POISSON
    tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    x = (np.arange(cells) + 0.5) / cells * SIDE - SIDE / 2
    surface = -(x[:, None]**2 + x**2) / (2 * RADIUS)
    solver = tamaas.PolonskyKeerRey(model, surface, 1e-3)  # at 1e-7 the error is the same, and it takes two to three times as long
    solver.setIntegralOperator("dcfft")

    def press():
        pressures = []
        for P in hertz(DEPTHS[:JUDGED]):
            solver.solve(P / SIDE**2)
            pressures.append(np.array(model.traction).reshape(cells, cells))
        return pressures

    def error(pressures):
        worst, sunk = 0, np.zeros((cells, cells))
        for p in pressures:
            model.operators["dcfft"](p, sunk)
            worst = max(worst, abs(p.sum() * (SIDE / cells)**2 / hertz((sunk - surface)[p > 0].mean()) - 1))
        return worst
    return press, error


def compare(cells):
    """{program: (contacts a processor second, error)}"""
    calls = {"tactel": tactel_presses(cells), "Tamaas": tamaas_presses(cells)}
    rates, errors = {name: [] for name in calls}, {name: error(press()) for name, (press, error) in calls.items()}
    for _ in range(ROUNDS):
        for name, (press, _) in calls.items():
            start = time.process_time()
            contacts = len(press())
            rates[name].append(contacts / (time.process_time() - start))
    return {name: (sorted(rates[name])[ROUNDS // 2], errors[name]) for name in calls}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--python", default=pathlib.Path(__file__).resolve().parent.parent / "build/python")
    sys.path.insert(0, str(parser.parse_args().python))
    os.environ["OMP_NUM_THREADS"] = "1"
    for n in (8, 12, 16, 24):
        found = compare(n)
        print(f"{n} x {n} cells: " + ", ".join(f"{name} {rate:.0f} a second, error {error:.1e}" for name, (rate, error) in found.items())
              + f"; {found['tactel'][0] / found['Tamaas'][0]:.1f} times", flush=True)
