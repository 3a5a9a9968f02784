#!/usr/bin/env python3
"""Recall error against the size of the learning set, at equal work: network 42-42-21-1 sees ten million rows of sets
of 10^2 ... 10^7 rows. Prints a table and draws docs/set_size.svg. Usage: docs/set_size.py FOLDER (for the sets, 3 GB).
"""
import json
import pathlib
import subprocess
import sys

import h5py
import numpy as np

TACTEL = "build/tactel"
BLOCK = 80_000  # rows that a training reads at a time; smaller sets are repeated to fill it
SEEN = 10_000_000


def tactel(*arguments):
    subprocess.run([TACTEL, *map(str, arguments), "--quiet"], check=True)


def repeated(path, times):
    """The same set with its rows `times` over."""
    copy = path.with_suffix(".repeated.h5")
    with h5py.File(path) as source, h5py.File(copy, "w") as target:
        target.attrs.update(source.attrs)
        for name, data in source.items():
            target[name] = np.concatenate([data[:]] * times)
    return copy


folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
mix = pathlib.Path("examples/learning_mix.toml").read_text()
tactel("generate", "examples/recall_any_friction.toml", "--output", folder / "recall.h5", "--force")
lines = []
for exponent in range(2, 8):
    rows = 10**exponent
    sweep = folder / "sweep.toml"
    sweep.write_text(mix.replace("contacts = 1000000", f"contacts = {rows // 10}"))
    learning = folder / f"learning_{exponent}.h5"
    tactel("generate", sweep, "--output", learning, "--force")
    shown = repeated(learning, BLOCK // rows) if rows < BLOCK else learning
    networks = folder / f"networks_{exponent}"
    tactel("train", shown, "--block", BLOCK, "--rows", SEEN, "--network", 6, "--seeds", 2, "--scaling", "frame",
           "--learning-rate", 0.02, "--recall", folder / "recall.h5", "--output", networks, "--force")
    means, several = [], []
    for network in json.loads((networks / "training.json").read_text())["networks"]:
        groups = [g for g in network["by_contact_nodes"] if g["contact_nodes"] > 1]
        means.append(network["recalling"]["mean"])
        several.append(sum(g["mean"] * g["rows"] for g in groups) / sum(g["rows"] for g in groups))
    lines.append((rows, np.mean(means), np.mean(several)))
    print(f"| 10^{exponent} | {lines[-1][1]:.4f} | {lines[-1][2]:.4f} |", flush=True)

data = "\n".join(" ".join(map(str, line)) for line in lines)
subprocess.run(["gnuplot"], check=True, text=True, input=f"""
$data << END
{data}
END
set terminal svg size 640,400 font "DejaVu Sans,12" background "white"
set output "docs/set_size.svg"
set logscale xy
set xlabel "rows of the learning set"; set ylabel "mean error of S"
set format x "10^{{%L}}"; set yrange [0.01:0.3]; set grid; set key top right
plot $data using 1:2 with linespoints pt 7 lc rgb "#1f5fa8" title "recall, all rows", \\
     $data using 1:3 with linespoints pt 9 lc rgb "#d9660a" title "more than one node in contact"
""")
