#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What networks of `slid`, and `moved`, tell of simulated grips that nobody learnt: 1000 grips of 300 frames of
examples/uskin_holds.toml with another seed. Prints the share of those that slide, by more than their elastic limit, with an answer
above a threshold that 1 % of those that hold, or 1 % or 10 % of those whose S stays below 0.7, have; by class; and the area under the
ROC curve.

Usage: studies/grips.py [NETWORK.onnx...] [--build build] [--grips N]  (uskin-4x4 by default). Debian: python3-h5py."""
import pathlib
import re
import sys
import tempfile

import study

parser = study.options(__doc__)
parser.add_argument("networks", type=pathlib.Path, nargs="*", default=[study.ROOT / "nn/infer/networks/uskin-4x4.onnx"])
parser.add_argument("--grips", type=int, default=1000)
options = parser.parse_args()
sys.path.insert(0, str(options.build.resolve() / "python"))
import h5py
import numpy as np
import tactel

REST = 30  # step of the rest: the weight is taken up, at most a few grips move already
ROUGHNESS = (0.003, 0.01, 0.03)  # mm, rms
SAFE = 0.7  # S of a grip that holds with a margin


def simulated(folder):
    """Rows of all grips: inputs with the rest behind them, and what classes are made of, by name."""
    run, text, parts = study.Program(options.build), (study.ROOT / "examples/uskin_holds.toml").read_text(), []
    for key in ("frames", "press", "rest", "move_frames", "pause"):
        text = re.sub(rf"\n{key} = .*", "", text)  # the defaults, of 300 frames
    for k, rms in enumerate(ROUGHNESS):
        count = (options.grips + k) // len(ROUGHNESS)
        sweep, made = folder / f"{k}.toml", folder / f"{k}.h5"
        sweep.write_text(re.sub(r"rms = {.*?}", f"rms = {rms}", text).replace("contacts = 8000", f"contacts = {count}")
                         .replace("seed = 9", f"seed = {77 + k}"))
        run("generate", sweep, "--output", made, "--rung", "pad-8")
        with h5py.File(made) as set_file:
            parts.append({name: set_file[name][...] for name in ("inputs", "contact", "step", "slip_path", "slip_index", "friction", "status")})
        parts[-1]["rms"] = np.full(len(parts[-1]["contact"]), rms)
        parts[-1]["contact"] = parts[-1]["contact"] + k * options.grips
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def area(score, label):
    _, place, count = np.unique(score, return_inverse=True, return_counts=True)
    rank, hits = (np.cumsum(count) - (count - 1) / 2)[place], label.sum()
    return (rank[label].sum() - hits * (hits + 1) / 2) / (hits * (len(label) - hits))


with tempfile.TemporaryDirectory() as scratch:
    rows = simulated(pathlib.Path(scratch))
_, first = np.unique(rows["contact"], return_index=True)
lengths = np.diff(np.r_[first, len(rows["contact"])])
rest = np.repeat([a + np.searchsorted(rows["step"][a:a + n], REST) for a, n in zip(first, lengths)], lengths)
after = np.arange(len(rest)) >= rest
step = np.where(after & (np.arange(len(rest)) > rest), np.diff(rows["slip_path"], prepend=0), 0)  # elastic limits
ways = np.cumsum(np.where(rows["status"] == 1, step, 0))
way = ways - ways[rest]  # while no cell sticks; no cell holds a grip then
at_rest, change = rows["inputs"][rest], rows["inputs"] - rows["inputs"][rest]


def largest(values):
    return np.maximum.reduceat(np.where(after, values, 0), first)


scores = {"moved": np.linalg.norm(change, axis=1) / -at_rest[:, :change.shape[1] // 3].sum(1)}
for path in options.networks:
    scores[path.stem] = np.asarray(tactel.Network.load(str(path))(np.hstack([rows["inputs"], at_rest]))).ravel()
end, S = largest(way), largest(rows["slip_index"])
holds, slides, safe = end <= 1e-3, end > 1, (end <= 1e-3) & (S < SAFE)
speed = largest(np.r_[0, np.diff(way)])  # elastic limits a frame
own = {"S at rest": rows["slip_index"][rest][first], "friction": rows["friction"][first], "rms, mm": rows["rms"][first],
       "limits a frame": speed}
print(f"{len(first)} grips: {holds.sum()} hold, {safe.sum()} with S below {SAFE}; {slides.sum()} slide.\n")
classes = [(f"{name} {low:.3g} to {high:.3g}", (values >= low) & (values <= high)) for name, values in own.items()
           for low, high in ([(rms, rms) for rms in ROUGHNESS] if name.startswith("rms") else
                             zip(*(lambda cuts: (cuts[:-1], cuts[1:]))(np.quantile(values[slides], [0, 1 / 3, 2 / 3, 1]))))]
head = list(scores)
rules = {"1 % of holds": (holds, 0.99), "1 % of safe": (safe, 0.99), "10 % of safe": (safe, 0.9)}
print(study.head("share of those that slide that are detected", *(f"{name}, {rule}" for name in head for rule in rules)))
limits = {name: [np.quantile(largest(score)[kind], share) for kind, share in rules.values()] for name, score in scores.items()}
for name, kind in [("all", slides)] + [(name, slides & own_class) for name, own_class in classes]:
    print(study.row(name, *(f"{(largest(scores[score])[kind] > limit).mean():.3f}" for score in head for limit in limits[score])))
print(study.row("threshold", *(f"{limit:.3f}" for score in head for limit in limits[score])))
areas = {name: area(score[after][::7], (way > 0.5)[after][::7]) for name, score in scores.items()}
print(study.row("area under the ROC curve of half a limit", *(cell for name in head for cell in (f"{areas[name]:.3f}", "", ""))))
