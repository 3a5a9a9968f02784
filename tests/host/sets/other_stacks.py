#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Answers, sets, networks and what these say of frames, in batches and live, by PoCL, with vectors and with one lane, and by another
OpenCL stack on the processor have the same bits, or the program refuses a stack that leaves answers unwritten, as rusticl of Mesa 22.3 does on pads:
other_stacks.py intel|rusticl PROGRAM EXAMPLES

intel: installs intel-opencl-rt of PyPI (250 MB). rusticl: that of Mesa on llvmpipe, fp32, of Debian's mesa-opencl-icd, laid over /usr/lib
for this process alone, as root. Both go to a folder that is removed. Exits with 77 where one cannot be had.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import venv

import h5py
import numpy as np

# noise, spreads of sensors, free sides, grips
SETS = {"intel": [("learning_mix.toml", 1024, "patch-12"), ("learning_mix.toml", 1024, "mesh-321"), ("pad_sweep.toml", 64, "pad-8"), ("uskin_holds.toml", 8, "pad-8")],
        "rusticl": [("learning_mix.toml", 256, "patch-12"), ("pad_sweep.toml", 16, "pad-8")]}  # a kernel takes it a minute to compile
SCENES = [("parabola.toml", "paper"), ("pad.toml", "pad-8")]
PROFILE = """[format]
kind = "csv"
channels = 48
[pad]
tactels = [4, 4]
pitch = 4.7
[channels]
normal = [%s]
shear_x = [%s]
shear_y = [%s]
""" % tuple(", ".join(map(str, range(first, first + 16))) for first in (0, 16, 32))
OVERLAY = """mkdir upper work && mount -t tmpfs none work && mkdir work/u work/w &&
mount -t overlay overlay -o lowerdir=$PWD/usr/lib:/usr/lib,upperdir=$PWD/work/u,workdir=$PWD/work/w /usr/lib && cd "$0" && exec "$@\""""


def missing(why):
    print(f"skipped: {why}")
    sys.exit(77)


def intel(folder):
    """Returns a command's beginning, and its environment."""
    venv.create(folder / "intel", with_pip=True)
    if subprocess.run([folder / "intel/bin/pip", "install", "-q", "intel-opencl-rt", "intel-cmplr-lib-rt"]).returncode != 0:
        missing("PyPI gave no intel-opencl-rt")
    return [], {"OCL_ICD_VENDORS": str(folder / "intel/lib/libintelocl.so")}


def rusticl(folder):
    root = folder / "rusticl"
    root.mkdir()
    said = subprocess.run(["apt-get", "install", "--print-uris", "--no-install-recommends", "-y", "mesa-opencl-icd"], capture_output=True, text=True)
    for address in re.findall(r"^'(\S+)'", said.stdout, re.M):
        package = root / "package.deb"
        if subprocess.run(["curl", "-sSfo", package, address]).returncode != 0:
            missing(f"{address} could not be had")
        subprocess.run(["dpkg-deb", "-x", package, root], check=True)
    driver = root / "rusticl.icd"
    driver.write_text("/usr/lib/x86_64-linux-gnu/libRusticlOpenCL.so.1\n")
    begin = ["unshare", "-m", "bash", "-euc", f"cd '{root}'; rm -rf upper work; " + OVERLAY, os.getcwd()]
    if not (root / "usr/lib/x86_64-linux-gnu/libRusticlOpenCL.so.1").exists() or subprocess.run([*begin, "true"]).returncode != 0:
        missing("Mesa's OpenCL cannot be laid over /usr/lib: Debian 12 and root are needed")
    return begin, {"OCL_ICD_VENDORS": str(driver), "RUSTICL_ENABLE": "llvmpipe"}


class Refused(Exception):
    """A driver that leaves answers unwritten, in the program's words."""


class Stacks:
    """The program by each stack in turn."""

    def __init__(self, other, program, folder):
        self.program, self.folder, self.failed = program, folder, 0
        self.drivers = {"pocl": ([], {}), "one lane": ([], {"TACTEL_LANES": "1"}), other: {"intel": intel, "rusticl": rusticl}[other](folder)}

    def run(self, driver, *words, **environment):
        begin, own = self.drivers[driver]
        done = subprocess.run([*begin, self.program, *map(str, words)], capture_output=True, text=True, env={**os.environ, **environment, **own})
        if done.returncode == 3 and "left answers unwritten on device" in done.stderr:
            raise Refused
        if done.returncode != 0:
            sys.exit(f"{driver}: {' '.join(map(str, words))}: {done.returncode}, {done.stderr}")
        return done.stdout

    def answers(self, answer, drivers):
        """Returns {driver: answer(driver)} of those that are not refused; PoCL is never."""
        found = {}
        for driver in drivers:
            try:
                found[driver] = answer(driver)
            except Refused:
                print(f"refused: {driver}; ", end="")
        return found

    def compare(self, what, answers):
        """answers: {driver: a dict of arrays, bytes or a list}"""
        first = answers["pocl"]
        if isinstance(first, dict):
            differ = [f"{key} ({driver})" for driver, answer in answers.items() for key in first
                      if not np.array_equal(first[key], answer[key], equal_nan=first[key].dtype.kind == "f")]
        else:
            differ = [driver for driver, answer in answers.items() if answer != first]
        self.failed += bool(differ) or len(first) == 0
        print(f"{what}: " + (f"differ in {', '.join(differ)}" if differ else "the same bits"), flush=True)

    def scene(self, example, rung):
        def solved(driver):
            path = self.folder / "answer.json"
            self.run(driver, "solve", example, "--rung", rung, "--precision", "fp32", "--quiet", "--json", path)
            return json.loads(path.read_text())["steps"]
        self.compare(f"{example.name} {rung}", self.answers(solved, self.drivers))

    def set(self, example, contacts, rung, precision):
        sweep = self.folder / example.name
        sweep.write_text(re.sub(r"(?m)^contacts = .*", f"contacts = {contacts}", example.read_text()))

        def made(driver):
            output = self.folder / f"{driver}.h5"
            self.run(driver, "generate", sweep, "--output", output, "--rung", rung, "--precision", precision, "--device", "cpu", "--quiet", "--force")
            with h5py.File(output) as file:
                return {name: data[()] for name, data in file.items() if data.shape is not None and data.dtype.kind in "fiu"}
        found = self.answers(made, self.drivers)
        self.compare(f"{example.name} {rung} {precision}, {len(found['pocl']['contact'])} rows", found)

    def network(self, layers):
        def made(driver):
            self.run(driver, "train", self.folder / "pocl.h5", "--output", self.folder / f"of {driver}", "--network", layers, "--schedule", "batch", "--cycles", 20,
                     "--device", "cpu", "--quiet", TACTEL_LANES="8")
            return next((self.folder / f"of {driver}").glob("*.onnx")).read_bytes()
        self.compare("a network", self.answers(made, [driver for driver in self.drivers if driver != "one lane"]))

    def frames(self):
        """The network of PoCL reads the rows of its set, and the same frames live, both by the kernel."""
        network = next((self.folder / "of pocl").glob("*.onnx"))
        with h5py.File(self.folder / "pocl.h5") as file:
            np.savetxt(self.folder / "frames.csv", file["inputs"][:200], "%.9g", ",")
        profile = self.folder / "profile.toml"
        profile.write_text(PROFILE)

        def recalled(driver):
            rows = self.folder / "rows.csv"
            self.run(driver, "recall", network, self.folder / "pocl.h5", "--rows", rows, "--device", "cpu", "--quiet")
            return rows.read_bytes()

        def live(driver):
            said = self.run(driver, "monitor", "--source", f"csv:{self.folder / 'frames.csv'}", "--profile", profile, "--network", network,
                            "--device", "cpu", "--late", 1e6, "--quiet")
            return [json.loads(line)["slip_index"] for line in said.splitlines()]
        self.compare("frames in batches", self.answers(recalled, self.drivers))
        self.compare("frames live", self.answers(live, self.drivers))

    def refuses_fp64(self, driver, example):
        """llvmpipe has none in Mesa 22.3."""
        begin, own = self.drivers[driver]
        done = subprocess.run([*begin, self.program, "solve", example, "--precision", "fp64", "--quiet"], capture_output=True, text=True, env={**os.environ, **own})
        named = done.returncode == 3 and "fp64: not supported on device llvmpipe" in done.stderr
        self.failed += not named
        print(f"fp64 by {driver}: " + ("refused" if named else f"{done.returncode}, {done.stderr}"), flush=True)


def main():
    other, program, examples = sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]).resolve()
    with tempfile.TemporaryDirectory() as name:
        stacks = Stacks(other, program, pathlib.Path(name))
        for example, rung in SCENES:
            stacks.scene(examples / example, rung)
        for example, contacts, rung in SETS[other]:
            for precision in ("fp32", "fp64") if other == "intel" else ("fp32",):
                stacks.set(examples / example, contacts, rung, precision)
        stacks.network("48-12-1_leaky-relu")
        stacks.frames()
        if other == "rusticl":
            stacks.refuses_fp64(other, examples / SCENES[0][0])
    sys.exit(stacks.failed > 0)


main()
