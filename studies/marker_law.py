#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Markers of a drag beside the law of fast simulators, which move them by A exp(-L r^2) of the way of the object, r from its middle, and
know no friction (as FOTS does, IEEE RA-L 9, 2024). A and L are fitted to the first drag, the best that the law can do.

Usage: studies/marker_law.py [SCENE.toml] [--way 1.5] [--steps 15] [--build build]
Prints, a drag a line, S, the rms motion of the markers since the press, and the law's rms error over it. Debian: python3-scipy."""
import pathlib
import sys

import numpy as np

import study


def main():
    parser = study.options(__doc__)
    parser.add_argument("scene", type=pathlib.Path, nargs="?", default=pathlib.Path("examples/gel_markers.toml"))
    parser.add_argument("--way", type=float, default=1.5, help="mm along x")
    parser.add_argument("--steps", type=int, default=15)
    options = parser.parse_args()
    sys.path.insert(0, str(options.build / "python"))
    import tactel
    from scipy.optimize import least_squares

    scene = tactel.read_scene(options.scene)
    load = tactel.PadLoad(indentation=scene.load.indentation, normal_force=scene.load.normal_force)
    path = tactel.solve(scene.with_(load=load.drag((options.way / options.steps, 0), options.steps)), precision="fp64")
    markers = scene.markers
    if markers.places:
        places = np.array(markers.places)
    else:
        along = [(np.arange(n) - (n - 1) / 2) * p for n, p in zip(markers.counts, markers.pitch)]
        places = np.stack([v.ravel() for v in np.meshgrid(*along)], 1)
    pressed = len(path) - options.steps - 1
    moved = path.markers[pressed + 1:, :, :2] - path.markers[pressed, :, :2]
    way = path.tangential[pressed + 1:] - path.tangential[pressed]

    def law(numbers, k):
        r2 = ((places - np.array(scene.indenter.position) - way[k]) ** 2).sum(1)
        return numbers[0] * np.exp(-numbers[1] * r2)[:, None] * way[k]

    fitted = least_squares(lambda numbers: (law(numbers, 0) - moved[0]).ravel(), [0.8, 0.1]).x
    print(f"A {fitted[0]:.3f}, L {fitted[1]:.3f} per mm^2")
    print("way (mm)     S   motion (mm)   error of the law over it")
    for k, S in enumerate(path.slip_index[pressed + 1:]):
        motion = np.sqrt((moved[k] ** 2).mean())
        print(f"{way[k, 0]:8.2f}  {S:.3f}   {motion:11.4f}   {np.sqrt(((law(fitted, k) - moved[k]) ** 2).mean()) / motion:.2f}")


if __name__ == "__main__":
    main()
