#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what docs/performance.md shows, and prints its tables; --write puts them between its marks `<!-- table NAME -->`.

Usage: docs/performance.py [--bench build/bench/tactel_bench] [--program build/tactel] [--json FILE] [--write]
--json reads what `tactel_bench --benchmark_format=json` wrote instead of measuring; start and memory are always measured. A minute on
an idle machine."""
import argparse
import json
import math
import os
import pathlib
import re
import statistics
import subprocess
import tempfile
import time

PAGE = pathlib.Path(__file__).resolve().parent / "performance.md"
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

    def machine(self):
        label = next(run["label"] for run in self.of.values() if run.get("label"))
        peaks = [self.of[f"device/fma_peak/fp32/threads:{threads}"]["GFLOP/s"] for threads in (1, 2)]
        date = self.context["date"][:10]
        return (f"One run of {date} on `{label}`, {self.context['num_cpus']} cores.\n"
                f"Its multiply-add peak in fp32 is {peaks[0]:.0f} GFLOP/s on one thread and {peaks[1]:.0f} on two.\n")


def contacts(runs):
    lines = ["| model | one thread | two threads |", "|---|---|---|"]
    for elements in (8, 12, 16, 24):
        rates = [runs.million(f"contact/patch_{elements}/mix/fp32/threads:{threads}") for threads in (1, 2)]
        lines.append(f"| `patch-{elements}`, a mix of shapes | {rates[0]} | {rates[1]} |")
    lines.append(f"| `patch-12`, parabolas, a sensor each | | {runs.million('contact/patch_12_sensors/fp32')} |")
    for mesh, size in (("B", "41 x 11"), ("A", "123 x 33")):
        lines.append(f"| mesh {size}, parabolas, stresses at the tactels | | {runs.million(f'contact/mesh_{mesh}/tactels/fp32')} |")
        for precision in ("fp32", "fp64"):
            rate = runs.million(f"contact/mesh_{mesh}/{precision}")
            lines.append(f"| mesh {size}, parabolas, {precision} | | {rate} |")
    reference = runs.of["contact/mesh_B/reference"]["steps_per_second"]
    lines.append(f"| mesh 41 x 11, `--solver reference` | {number(reference / 1e6, 3)} | |")
    return lines


def networks(runs):
    lines = ["| | million a second |", "|---|---|"]
    rows = {"training pattern by pattern, the six networks from 100 seeds each, two threads": "train/online/6x100/kernel",
            "training 42-42-21-1 in batches of 64 (Adam), one thread": "train/batch/42-42-21-1/adam/threads:1/64"}
    for shown, name in rows.items():
        lines.append(f"| {shown} | {runs.million(name, 'patterns_per_second')} |")
    for threads, frames in ((1, 4096), (2, 262144)):
        rate = runs.million(f"forward/42-42-21-1/kernel/threads:{threads}/{frames}", "frames_per_second")
        lines.append(f"| frames to S in batches of {frames}, {('one thread', 'two threads')[threads - 1]} | {rate} |")
    return lines


def one_frame(runs):
    lines = ["| one frame of 42 stresses, us | median | 99 % | 99.9 % |", "|---|---|---|---|"]
    for shown, name in (("`tactel::infer`", "one_frame_infer"), ("`tactel monitor`'s network", "one_frame"),
                        ("Eigen, for comparison", "one_frame_eigen")):
        run = runs.of[f"forward/42-42-21-1/{name}"]
        lines.append(f"| {shown} | " + " | ".join(f"{run[key]:.2f}" for key in ("p50_us", "p99_us", "p99.9_us")) + " |")
    return lines


def exponents(sizes, rates):
    """Growth of the time of a load step from each size to the next."""
    pairs = list(zip(sizes, rates))
    return [math.log(a[1] / b[1]) / math.log(b[0] / a[0]) for a, b in zip(pairs, pairs[1:])]


def scaling(runs):
    batches = [10**k for k in range(7)]
    lines = ["| contacts in a launch | " + " | ".join(f"{count:,}".replace(",", " ") for count in batches) + " |", "|---" * 8 + "|",
             "| million load steps a second | " + " | ".join(runs.million(f"scaling/contacts:{count}") for count in batches) + " |", ""]
    columns = [41, 81, 161, 321]
    rates = [runs.of[f"scaling/columns:{count}"]["steps_per_second"] for count in columns]
    lines += ["| columns of the mesh | " + " | ".join(map(str, columns)) + " |", "|---" * 5 + "|",
              "| million load steps a second | " + " | ".join(number(rate / 1e6, 3) for rate in rates) + " |",
              "| exponent of the time; 2 for equal sweeps | | " + " | ".join(f"{e:.1f}" for e in exponents(columns, rates)) + " |", ""]
    elements = [8, 12, 16, 24]
    rates = [runs.of[f"contact/patch_{count}/mix/fp32/threads:2"]["steps_per_second"] for count in elements]
    lines += ["| elements of the patch | " + " | ".join(map(str, elements)) + " |", "|---" * 5 + "|",
              "| million load steps a second | " + " | ".join(number(rate / 1e6, 3) for rate in rates) + " |",
              "| exponent of the time; 2 for equal sweeps and increments | | " + " | ".join(f"{e:.1f}" for e in exponents(elements, rates)) + " |"]
    return lines


def start(program):
    """Seconds and memory of `tactel solve` with empty caches and with full ones: the first run and the median of ten."""
    lines = ["| `tactel solve`, start to end | empty caches | full caches | memory |", "|---|---|---|---|"]
    examples = PAGE.parent.parent / "examples"
    for shown, scene in (("a patch, `cylinder.toml`", "cylinder.toml"), ("a mesh, `parabola.toml`", "parabola.toml")):
        with tempfile.TemporaryDirectory() as cache:
            seconds, memory = [], 0
            for _ in range(11):
                begin = time.perf_counter()
                child = subprocess.Popen([program, "solve", examples / scene, "--quiet"], stdout=subprocess.DEVNULL,
                                         env={**os.environ, "TACTEL_CACHE_DIR": cache})
                _, status, usage = os.wait4(child.pid, 0)
                seconds.append(time.perf_counter() - begin)
                memory = max(memory, usage.ru_maxrss / 1024)
                if status:
                    raise SystemExit(f"{program} solve {scene}: status {status}")
        lines.append(f"| {shown} | {seconds[0]:.1f} s | {1e3 * statistics.median(seconds[1:]):.0f} ms | {memory:.0f} MB |")
    return lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bench", default="build/bench/tactel_bench")
    parser.add_argument("--program", default="build/tactel")
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    if options.json:
        text = options.json.read_text()
    else:
        command = [options.bench, f"--benchmark_filter={FILTER}", "--benchmark_format=json", "--benchmark_min_time=0.2"]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    runs = Runs(text)
    tables = {"machine": runs.machine(), "contacts": "\n".join(contacts(runs)) + "\n",
              "networks": "\n".join(networks(runs)) + "\n", "one_frame": "\n".join(one_frame(runs)) + "\n",
              "scaling": "\n".join(scaling(runs)) + "\n", "start": "\n".join(start(options.program)) + "\n"}
    page = PAGE.read_text()
    for name, table in tables.items():
        print(table)
        page, found = re.subn(rf"(<!-- table {name} -->\n).*?(<!-- end -->)", lambda m, t=table: f"{m[1]}\n{t}\n{m[2]}", page, flags=re.S)
        if found != 1:
            raise SystemExit(f"{PAGE}: has {found} places for the table {name}")
    if options.write:
        PAGE.write_text(page)


if __name__ == "__main__":
    main()
