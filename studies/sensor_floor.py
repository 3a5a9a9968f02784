#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What pad reads S to what error: the floor of examples/pad_spheres.toml against noise, tactels, rubber and what is known of
mu. Prints the table of docs/notebook/2026-11-27-floor.md and draws docs/sensor_floor.svg.

Usage: studies/sensor_floor.py [--build build] [--readings 100] [PAD ...]  (some 15 minutes on two cores; all pads by default)
PAD is the name of a line: 4x4, 8x8, thin, told10, told5. Debian: python3-numpy, python3-matplotlib."""
import json
import os
import subprocess
import sys

import study

SWEEP = study.ROOT / "examples/pad_spheres.toml"
NOISE = (0.001, 0.003, 0.01)
PADS = {  # of the area of the file's 4 x 4 tactels at 4.7 mm, on 4 mm
    "4x4": ("4 x 4 tactels, 4 mm", []),
    "8x8": ("8 x 8 tactels, 4 mm", ["--tactels", 8]),
    "thin": ("8 x 8 tactels, 2 mm", ["--tactels", 8, "--thickness", 2]),
    "told10": ("4 x 4 tactels, 4 mm, mu known to 10 %", ["--friction-spread", 0.1]),
    "told5": ("4 x 4 tactels, 4 mm, mu known to 5 %", ["--friction-spread", 0.05]),
}


def floors(build, words):
    """The floors at all noises, as tactel.floor has them in JSON."""
    noises = [word for noise in NOISE for word in ("--noise", noise)]
    done = subprocess.run([sys.executable, "-m", "tactel.floor", SWEEP, "--noise-of", "contact", "--rung", "pad-8", "--json", "-", "--quiet",
                           *map(str, noises + words)], capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(build / "python")})
    if done.returncode not in (0, 4):  # 4: the two numbers of some floor do not meet
        raise SystemExit(f"tactel.floor: exit code {done.returncode}\n{done.stderr}")
    return json.loads(done.stdout)["skins"]


parser = study.options(__doc__)
parser.add_argument("pads", nargs="*", metavar="PAD", help="of " + ", ".join(PADS))
parser.add_argument("--readings", type=int, default=100, help="of each floor")
options = parser.parse_args()
unknown = set(options.pads) - set(PADS)
if unknown:
    parser.error(f"PAD: {', '.join(sorted(unknown))}; one of {', '.join(PADS)}")

figure, axes = study.panels(figsize=(6.4, 4))
print(study.head("pad", "noise", "floor", "of the true S", "ranks", "s"), flush=True)
for name, look in zip(PADS, ("o-", "s-", "^-", "o--", "o:")):
    if options.pads and name not in options.pads:
        continue
    label, words = PADS[name]
    found = floors(options.build, [*words, "--readings", options.readings])
    for one in found:
        numbers = (f"{number['mean']:.4f} +- {number['standard_error']:.4f}" for number in (one["all"]["estimate"], one["all"]["true"]))
        print(study.row(label, f"{one['noise']:g}", *numbers, f"{one['ranks_p']:.2f}" + ("" if one["converged"] else ", no floor"),
                        f"{one['seconds']:.0f}"), flush=True)
    axes.errorbar(NOISE, [one["all"]["estimate"]["mean"] for one in found],
                  [one["all"]["estimate"]["standard_error"] for one in found], fmt=look, label=label)
axes.set(xscale="log", yscale="log", xlabel="noise over the largest stress of the contact", ylabel="smallest mean error of S")
axes.legend(fontsize=8)
if not options.pads:
    study.save(figure, study.DOCS / "sensor_floor.svg")
