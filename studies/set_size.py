#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Recall error against the size of the learning set, at equal work: network 42-42-21-1 sees ten million rows of sets
of 10^2 ... 10^7 rows. Prints a table and draws docs/set_size.svg.

Usage: studies/set_size.py [--build build] FOLDER  (for the sets, 3 GB)"""
import json
import pathlib

import h5py
import numpy as np

import study

EXAMPLES = study.ROOT / "examples"
BLOCK = 80_000  # rows that a training reads at a time; smaller sets are repeated to fill it
SEEN = 10_000_000


def repeated(path, times):
    """The same set with its rows `times` over."""
    copy = path.with_suffix(".repeated.h5")
    with h5py.File(path) as source, h5py.File(copy, "w") as target:
        target.attrs.update(source.attrs)
        for name, data in source.items():
            target[name] = np.concatenate([data[:]] * times)
    return copy


parser = study.options(__doc__)
parser.add_argument("folder", type=pathlib.Path, metavar="FOLDER")
options = parser.parse_args()
tactel, folder = study.Program(options.build), options.folder
folder.mkdir(parents=True, exist_ok=True)
mix = (EXAMPLES / "learning_mix.toml").read_text()
tactel("generate", EXAMPLES / "recall_any_friction.toml", "--output", folder / "recall.h5", "--force", "--quiet")
lines = []
for exponent in range(2, 8):
    rows = 10**exponent
    sweep = folder / "sweep.toml"
    sweep.write_text(mix.replace("contacts = 1000000", f"contacts = {rows // 10}"))
    learning = folder / f"learning_{exponent}.h5"
    tactel("generate", sweep, "--output", learning, "--force", "--quiet")
    shown = repeated(learning, BLOCK // rows) if rows < BLOCK else learning
    networks = folder / f"networks_{exponent}"
    tactel("train", shown, "--block", BLOCK, "--rows", SEEN, "--network", 6, "--seeds", 2, "--scaling", "frame",
           "--learning-rate", 0.02, "--recall", folder / "recall.h5", "--output", networks, "--force",
           "--quiet")
    means, several = [], []
    for network in json.loads((networks / "training.json").read_text())["networks"]:
        groups = [g for g in network["by_contact_nodes"] if g["contact_nodes"] > 1]
        means.append(network["recalling"]["mean"])
        several.append(sum(g["mean"] * g["rows"] for g in groups) / sum(g["rows"] for g in groups))
    lines.append((rows, np.mean(means), np.mean(several)))
    print(study.row(f"10^{exponent}", *(f"{error:.4f}" for error in lines[-1][1:])), flush=True)

rows, *errors = zip(*lines)
figure, axes = study.panels(figsize=(6.4, 4))
for error, look, label in zip(errors, ("o-", "^--"), ("recall, all rows", "more than one node in contact")):
    axes.loglog(rows, error, look, label=label)
axes.set(xlabel="rows of the learning set", ylabel="mean error of S", ylim=(0.01, 0.3))
axes.legend()
study.save(figure, study.DOCS / "set_size.svg")
