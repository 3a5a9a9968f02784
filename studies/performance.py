#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures rates, sets and starts, and prints their tables; --write makes a page of them, docs/notebook/DATE-performance.md.

Usage: studies/performance.py [--build build] [--json FILE] [--contacts N] [--write]
--json reads what `tactel_bench --benchmark_format=json` wrote instead of measuring; sets, start and memory are always measured.
--contacts: of each set that is timed. Three minutes and 1.2 GB of $TMPDIR on an idle machine."""
import datetime
import json
import math
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import tempfile
import time

import study
from study import DOCS, ROOT, row

FILTER = ("^contact/(mesh_[AB]/fp(32|64)/real|mesh_B/reference|patch_[0-9]+/mix)|^contact/mesh_[AB]/tactels|^contact/patch_12_sensors|^scaling/|fma_peak/fp32"
          "|^train/(online/6x100/kernel|batch/42-42-21-1/adam.*/64)|^forward/42-42-21-1/(kernel/threads:[12]/(4096|262144)|one_frame)")


def number(value, digits=2):
    """Three significant digits at most: 15.7, 4.49, 0.784."""
    return f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"


class Runs:
    """The results of one run of tactel_bench, by name."""

    def __init__(self, text):
        data = json.loads(text)
        self.of = {run["name"].removesuffix("/real_time").removesuffix("/manual_time"): run for run in data["benchmarks"]}
        self.context = data["context"]

    def million(self, name, counter="steps_per_second"):
        return number(self.of[name][counter] / 1e6, 3)

    def peak(self, threads):
        return self.of[f"device/fma_peak/fp32/threads:{threads}"]["GFLOP/s"]

    def of_peak(self, name, threads):
        """Share of the multiply-add peak of so many threads, in fp32."""
        return f"{100 * self.of[name]['GFLOP/s'] / self.peak(threads):.0f} %"

    def machine(self):
        label = next(run["label"] for run in self.of.values() if run.get("label"))
        date = self.context["date"][:10]
        commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=DOCS, capture_output=True, text=True).stdout.strip()
        return (f"One run of {date} on `{label}`, {self.context['num_cpus']} cores, commit {commit or 'unknown'}.\n"
                f"Its multiply-add peak in fp32 is {self.peak(1):.0f} GFLOP/s on one thread and {self.peak(2):.0f} on two.\n")


def contacts(runs):
    lines = [study.head("model", "one thread", "two threads", "of peak, two threads")]
    for elements in (8, 12, 16, 24):
        one, two = (f"contact/patch_{elements}/mix/fp32/threads:{threads}" for threads in (1, 2))
        path = f"{100 * runs.of[two]['path_of_peak']:.0f} % (load path)"
        lines.append(row(f"`patch-{elements}`, a mix of shapes", runs.million(one), runs.million(two), path))
    lines.append(row("`patch-12`, parabolas, a sensor each", "", runs.million("contact/patch_12_sensors/fp32"), ""))
    for mesh, size in (("B", "41 x 11"), ("A", "123 x 33")):
        for what, name in (("stresses at the tactels", "tactels/fp32"), ("fp32", "fp32"), ("fp64", "fp64")):
            run = f"contact/mesh_{mesh}/{name}"
            lines.append(row(f"mesh {size}, parabolas, {what}", "", runs.million(run), "" if what == "fp64" else runs.of_peak(run, 2)))
    return [*lines, row("mesh 41 x 11, `--solver full-mesh`", runs.million("contact/mesh_B/reference"), "", "")]


def networks(runs):
    lines = [study.head("", "million a second", "of peak")]
    rows = {"training pattern by pattern, the six networks from 100 seeds each, two threads": ("train/online/6x100/kernel", 2),
            "training 42-42-21-1 in batches of 64 (Adam), one thread": ("train/batch/42-42-21-1/adam/threads:1/64", 1)}
    for shown, (name, threads) in rows.items():
        lines.append(row(shown, runs.million(name, "patterns_per_second"), runs.of_peak(name, threads)))
    for threads, frames in ((1, 4096), (2, 262144)):
        name = f"forward/42-42-21-1/kernel/threads:{threads}/{frames}"
        lines.append(row(f"frames to S in batches of {frames}, {('one thread', 'two threads')[threads - 1]}",
                         runs.million(name, "frames_per_second"), runs.of_peak(name, threads)))
    return lines


def one_frame(runs):
    lines = [study.head("one frame of 42 stresses, us", "median", "99 %", "99.9 %")]
    for shown, name in (("`tactel::infer`, also in `tactel monitor`", "one_frame_infer"), ("Eigen, for comparison", "one_frame_eigen")):
        run = runs.of[f"forward/42-42-21-1/{name}"]
        lines.append(row(shown, *(f"{run[key]:.2f}" for key in ("p50_us", "p99_us", "p99.9_us"))))
    return lines


def exponents(sizes, rates):
    """Growth of the time of a load step from each size to the next."""
    pairs = list(zip(sizes, rates))
    return [math.log(a[1] / b[1]) / math.log(b[0] / a[0]) for a, b in zip(pairs, pairs[1:])]


def table(title, heads, *rows):
    """Rows of cells below a row of heads, and an empty line."""
    return [study.head(title, *heads), *(row(name, *cells) for name, cells in rows), ""]


def powers(values):
    """Exponents from the second column on."""
    return ["", *(f"{value:.1f}" for value in values)]


def scaling(runs):
    batches = [10**k for k in range(7)]
    rates = [runs.of[f"scaling/contacts:{count}"]["steps_per_second"] for count in batches]
    lines = table("contacts in a launch", [f"{count:,}".replace(",", " ") for count in batches],
                  ("million load steps a second", [number(rate / 1e6, 3) for rate in rates]),
                  ("exponent of the launch's time; expected from full lanes on: 1", powers(1 + e for e in exponents(batches, rates))))
    columns = [41, 81, 161, 321, 641]
    of = [runs.of[f"scaling/columns:{count}"] for count in columns]
    lines += table("columns of the mesh", columns,
                   ("million load steps a second", [number(run["steps_per_second"] / 1e6, 3) for run in of]),
                   ("exponent of a load step's time", powers(exponents(columns, [run["steps_per_second"] for run in of]))),
                   ("expected: of its operations", powers(exponents(columns, [1 / run["kFLOP_a_step"] for run in of]))))
    elements = [8, 12, 16, 24]
    of = [runs.of[f"contact/patch_{count}/mix/fp32/threads:2"] for count in elements]
    lines += table("elements of the patch", elements,
                   ("million load steps a second", [number(run["steps_per_second"] / 1e6, 3) for run in of]),
                   ("exponent of a load step's time", powers(exponents(elements, [run["steps_per_second"] for run in of]))),
                   ("exponent of the load path's time", powers(exponents(elements, [1 / run["path_us"] for run in of]))),
                   ("expected: of its operations",
                    powers(exponents(elements, [1 / (run["path_us"] * run["path_GFLOP/s"]) for run in of]))))
    sensors = [1, 16, 256, 4096, 65536]
    lines += table("sensors of 65 536 contacts", sensors,
                   ("million load steps a second", [runs.million(f"scaling/sensors:{count}") for count in sensors]))
    return lines[:-1]


def measure(command, **environment):
    """(seconds, memory in MB, what it printed) of a command, which must succeed."""
    with tempfile.TemporaryFile("w+") as said:
        begin = time.perf_counter()
        child = subprocess.Popen(command, stdout=said, stderr=subprocess.STDOUT, env={**os.environ, **environment})
        _, status, usage = os.wait4(child.pid, 0)
        seconds = time.perf_counter() - begin
        said.seek(0)
        text = said.read()
    if status:
        raise SystemExit(f"{' '.join(map(str, command))}: status {status}\n{text}")
    return seconds, usage.ru_maxrss / 1024, text


def sets(program, contacts):
    """Sets and a stream from start to end; sets on cores and by processes. A run of few contacts first fills caches of kernels and tables."""
    mix = (ROOT / "examples/learning_mix.toml").read_text()
    cores = sorted(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def sweep(count, model):
            path = folder / "sweep.toml"
            path.write_text(re.sub(r"^contacts = .*$", f"contacts = {count}", mix, flags=re.M).replace('model = "mesh"', f'model = "{model}"'))
            return path

        def generate(model, before=(), arguments=(), **environment):
            out = folder / "set.h5"
            for count in (2000, contacts):
                command = [*before, program, "generate", sweep(count, model), "--output", out, "--force", *arguments]
                seconds, memory, text = measure(command, **environment)
            kernels = re.search(r"in kernels ([0-9.]+) ([kM]) steps/s", text)
            share = 10 * contacts / seconds / (float(kernels[1]) * {"k": 1e3, "M": 1e6}[kernels[2]]) if kernels else math.nan
            size = out.stat().st_size
            out.unlink()
            return {"rate": 10 * contacts / seconds / 1e6, "share": share, "GB/s": size / seconds / 1e9, "memory": memory}

        models = {"`patch-8`": ("patch", ["--rung", "patch-8"]), "`patch-12`": ("patch", []), "mesh 41 x 11": ("mesh", [])}
        made = [generate(model, arguments=arguments) for model, arguments in models.values()]
        streams = []
        for networks in (["42-42-21-1"], [str(k) for k in range(1, 7)]):
            chosen = [word for network in networks for word in ("--network", network)]
            for rows in (50000, 10 * contacts):
                seconds, _, _ = measure([program, "train", "--stream", sweep(contacts, "patch"), "--rows", str(rows), *chosen, "--scaling", "frame",
                                         "--output", folder / "networks", "--force"])
            streams.append(f"{rows / seconds / 1e6:.2f}")
            shutil.rmtree(folder / "networks")
        lines = table(f"{10 * contacts / 1e6:.3g} million rows, from file to set", models,
                      ("million rows a second", [f"{run['rate']:.2f}" for run in made]),
                      ("share of the rate of its kernels", [f"{100 * run['share']:.0f} %" for run in made]),
                      ("GB written a second", [f"{run['GB/s']:.2f}" for run in made]),
                      ("memory at most, MB", [f"{run['memory']:.0f}" for run in made]))
        lines += table("`train --stream`, `patch-12`", ["42-42-21-1", "the six networks"], ("million rows a second", streams))
        counts = [count for count in (1, 2, 4, 8, 16, 32, 64) if count <= len(cores)]
        by_cores = [generate("patch", ["taskset", "-c", ",".join(map(str, cores[:count]))], models["`patch-8`"][1]) for count in counts]
        lines += table("cores, one process, `patch-8`", counts, ("million rows a second", [f"{run['rate']:.2f}" for run in by_cores]))
        if shutil.which("mpirun"):
            counts = [1, 2, 4]
            ranks = [generate("patch", ["mpirun", "--oversubscribe", "-n", str(count)], models["`patch-8`"][1], TACTEL_THREADS="1",
                              OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1") for count in counts]
            lines += table("processes, one kernel thread each, `patch-8`", counts, ("million rows a second", [f"{run['rate']:.2f}" for run in ranks]))
    return lines[:-1]


def start(program):
    """`tactel solve` with empty caches and with full ones: the first run and the median of ten."""
    lines = [study.head("`tactel solve`, start to end", "empty caches", "full caches", "memory")]
    examples = ROOT / "examples"
    for shown, scene in (("a patch, `cylinder.toml`", "cylinder.toml"), ("a mesh, `parabola.toml`", "parabola.toml")):
        with tempfile.TemporaryDirectory() as cache:
            runs = [measure([program, "solve", examples / scene, "--quiet"], TACTEL_CACHE_DIR=cache) for _ in range(11)]
        warm = statistics.median(seconds for seconds, _, _ in runs[1:])
        lines.append(row(shown, f"{runs[0][0]:.1f} s", f"{1e3 * warm:.0f} ms", f"{max(memory for _, memory, _ in runs):.0f} MB"))
    return lines


def main():
    parser = study.options(__doc__)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--contacts", type=int, default=500000)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    written = DOCS / f"notebook/{datetime.date.today()}-performance.md"
    if options.write and written.exists():
        parser.error(f"{written}: a page of the notebook is never edited; move it first")
    if options.json:
        text = options.json.read_text()
    else:
        command = [options.build / "bench/tactel_bench", f"--benchmark_filter={FILTER}", "--benchmark_format=json", "--benchmark_min_time=0.2"]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    runs, program = Runs(text), study.Program(options.build).path
    parts = {"Contacts": contacts(runs), "From file to set": sets(program, options.contacts), "Scaling": scaling(runs),
             "Networks": networks(runs), "One frame": one_frame(runs), "First use": start(program)}
    page = "# Performance: what was measured\n\n" + runs.machine() + "`studies/performance.py` wrote this page.\n"
    for heading, lines in parts.items():
        page += f"\n## {heading}\n\n" + "\n".join(lines) + "\n"
    print(page)
    if options.write:
        written.write_text(page)


if __name__ == "__main__":
    main()
