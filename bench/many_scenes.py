#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The rate of solve_many from Python beside that of C++, on the same scenes, in turns.

Usage: PYTHONPATH=build/python bench/many_scenes.py [--program build/bench/tactel_many_scenes] [--scenes 100000] [--calls 5] [--pads]
Prints both rates (medians) and their ratio. Ends with 1 where the answers differ in a bit, or with --least RATIO
where the ratio is below it."""
import argparse
import statistics
import subprocess
import sys
import time

import tactel

STEPS = 9  # load steps of a scene


def spread(k, step):
    """Number k of a sequence that fills 0 ... 1 evenly."""
    return (0.5 + k * step) % 1.0


def scene(k):
    load = tactel.Press(0.05 + 0.15 * spread(k, 0.5698402909980532)).drag(0.03, steps=STEPS - 1)
    return tactel.Scene(indenter=tactel.Parabola(5 + 45 * spread(k, 0.6180339887498949)),
                        friction=0.1 + 0.9 * spread(k, 0.7548776662466927), load=load)


def pad_scene(k):
    load = tactel.Press(0.05 + 0.25 * spread(k, 0.5698402909980532)).drag((0.03, 0.01), steps=STEPS - 1, twist=0.2)
    return tactel.Scene(tactel.Pad(), tactel.Sphere(5 + 10 * spread(k, 0.6180339887498949)),
                        friction=0.1 + 0.9 * spread(k, 0.7548776662466927), load=load)


def from_python(scenes):
    start = time.perf_counter()
    paths = tactel.solve_many(scenes)
    seconds = time.perf_counter() - start
    total = 0.0
    for row in paths.slip_index.tolist():
        for s in row:
            total += s
    return seconds, total


def from_cpp(program, count, kind):
    said = subprocess.run([program, str(count), "1", *kind], check=True, capture_output=True, text=True).stdout.split()
    return float(said[0]), float(said[1])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default="build/bench/tactel_many_scenes")
    parser.add_argument("--scenes", type=int, default=100_000)
    parser.add_argument("--calls", type=int, default=5)
    parser.add_argument("--pads", action="store_true", help="scenes on pads")
    parser.add_argument("--least", type=float, default=0.0)
    options = parser.parse_args()
    kind, make = (["pads"], pad_scene) if options.pads else ([], scene)
    scenes = [make(k) for k in range(options.scenes)]
    tactel.solve_many(scenes[:100])  # kernels are compiled
    runs = [(from_cpp(options.program, options.scenes, kind), from_python(scenes)) for _ in range(options.calls)]
    if len({total for pair in runs for _, total in pair}) != 1:
        sys.exit(f"the answers differ: {runs}")
    seconds = [statistics.median(pair[k][0] for pair in runs) for k in (0, 1)]
    for name, taken in zip(("C++", "Python"), seconds):
        print(f"{name:6} {options.scenes / taken:10.0f} scenes/s {STEPS * options.scenes / taken / 1e6:8.2f} million load steps/s")
    ratio = seconds[0] / seconds[1]
    print(f"Python over C++ {ratio:.3f}")
    sys.exit(ratio < options.least)


if __name__ == "__main__":
    main()
