#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What pad reads S to what error: floors of examples/pad_spheres.toml against noise, tactels and what is known of mu.
Prints the table of docs/notebook/2026-11-27-floor.md and draws docs/sensor_floor.svg.

Usage: studies/sensor_floor.py [--build build] FOLDER  (for the floors; one that lies there is read. Twenty minutes of a core.)
The table has readings whose S is 0.05 or more: half of all are presses, whose S is 0. Debian: python3-numpy,
python3-matplotlib."""
import json
import os
import pathlib
import subprocess
import sys

import numpy as np

import study

SWEEP = study.ROOT / "examples/pad_spheres.toml"
PADS = {  # of the area of the file's 4 x 4 tactels at 4.7 mm, on 4 mm
    "4 x 4 tactels": (["--tactels", 4], (0.001, 0.003, 0.01)),
    "8 x 8 tactels": (["--tactels", 8], (0.01,)),
    "4 x 4 tactels, mu known to 10 %": (["--friction-spread", 0.1, "--seed", 2], (0.01,)),
    "4 x 4 tactels, mu known to 5 %": (["--friction-spread", 0.05, "--seed", 2], (0.01,)),
}


def measured(build, file, noise, words):
    """The floor as tactel.floor has it in JSON. Little noise needs more steps of the walkers."""
    if not file.exists():
        sampling = ["--rung", "pad-8", "--readings", 64, "--walkers", 64, "--iterations", 500 if noise < 0.003 else 200]
        done = subprocess.run([sys.executable, "-m", "tactel.floor", *map(str, [
            SWEEP, "--noise-of", "contact", "--noise", noise, *words, *sampling, "--json", file, "--quiet"])],
            env={**os.environ, "PYTHONPATH": str(build / "python")}, stdout=subprocess.DEVNULL)
        if done.returncode not in (0, 4):  # 4: the two numbers do not meet
            raise SystemExit(f"tactel.floor: exit code {done.returncode}")
    return json.loads(file.read_text())


def dragged(floor, key):
    """Mean and standard error over the readings whose S is 0.05 or more."""
    classes = [one[key] for one in floor["classes"] if one["family"] == "torque" and one["class"] != "S below 0.05"]
    count, mean, error = (np.array([one[name] for one in classes]) for name in ("readings", "mean", "standard_error"))
    whole = (count * mean).sum() / count.sum()
    return whole, np.sqrt((count * (error**2 * count + (mean - whole) ** 2)).sum()) / count.sum()


parser = study.options(__doc__)
parser.add_argument("folder", type=pathlib.Path, metavar="FOLDER")
options = parser.parse_args()
options.folder.mkdir(parents=True, exist_ok=True)
figure, axes = study.panels(figsize=(6.4, 4))
print(study.head("pad", "noise", "floor", "true", "p of the ranks", "seconds"), flush=True)
for (name, (words, noises)), look in zip(PADS.items(), ("o-", "s", "^", "v")):
    drawn = []
    for noise in noises:
        file = options.folder / f"{'_'.join(map(str, words)).replace('-', '')}_{noise:g}.json"
        floor = measured(options.build, file, noise, words)
        drawn.append(dragged(floor, "estimate"))
        texts = ("{:.3f} +- {:.3f}".format(*number) for number in (drawn[-1], dragged(floor, "true")))
        print(study.row(name, f"{noise:g}", *texts, f"{floor['ranks_p']:.2f}" + ("" if floor["converged"] else ", no floor"),
                        f"{floor['seconds']:.0f}"), flush=True)
    axes.errorbar(noises, *zip(*drawn), fmt=look, capsize=3, label=name)
axes.set(xscale="log", yscale="log", xlabel="noise over the largest stress of the contact", ylabel="smallest mean error of S",
         yticks=(0.02, 0.03, 0.05, 0.1), yticklabels=("0.02", "0.03", "0.05", "0.1"))
axes.minorticks_off()
axes.legend(fontsize=8)
study.save(figure, study.DOCS / "sensor_floor.svg")
