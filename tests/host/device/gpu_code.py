#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles every variant of every kernel to the machine code of GPUs, without one: tests/host/device/gpu_code.py KERNELS CLANG [largest]

largest: of each kernel the variant with the last values, in fp64, which asks for the most memory.
A variant has one value of each word of a kernel's line "defines" that stands in VALUES, and the line's values of the others.
Prints for each variant and precision the bytes of private memory of a work-item, and on AMD registers and spills. Fails where a kernel does
not compile. CLANG: 15 knows sm_86, 16 and newer sm_90. Without libclc of the same version, calls of fma and kin stay calls: the numbers
then are those around them.
"""

import concurrent.futures
import itertools
import os
import pathlib
import re
import subprocess
import sys
import tempfile

TARGETS = [("nvptx64-unknown-nvcl", ["-march={}"], ["sm_90", "sm_86", "sm_80"]), ("amdgcn-amd-amdhsa", ["-mcpu={}", "-nogpulib"], ["gfx90a"])]

VALUES = {"ELEMENTS": (8, 12, 24), "CELLS": (8, 12, 16, 24), "FORCE_CONTROL": (0, 1), "FRICTION": (0, 1), "SENSORS": (0, 1), "OWN_TABLES": (0, 1),
          "MIRRORED": (0, 1), "DENSE": (0, 1), "LEAKY_RELU": (0, 1), "BOUND": (0, 1), "OUTPUTS": (1, 3), "HIDDEN2": (0, 21), "CREEP_TERMS": (0, 2)}


def variants(kernel):
    """The -D options of each variant of a kernel."""
    line = re.search(r"^// defines( of WIDE)?: *(.*)", kernel.read_text(encoding="utf-8"), re.M)
    words = dict(word.split("=") for word in line[2].split()) if line else {}
    if line and line[1]:
        words["WIDE"] = "1"
    choices = [[f"-D{name}={value}" for value in VALUES.get(name, (value,))] for name, value in words.items()]
    return list(itertools.product(*choices))


def private_bytes(code):
    """Of NVIDIA's code the frames of all functions, of AMD's the scratch memory of the kernel."""
    frames = re.findall(r"__local_depot\d+\[(\d+)\]", code) or re.findall(r"; ScratchSize: (\d+)", code)
    return max(map(int, frames), default=0)


def compiled(clang, target, kernel, variant, real):
    """Returns (chip, code), or (None, complaint)."""
    triple, options, names = target
    with tempfile.TemporaryDirectory() as folder:
        code = pathlib.Path(folder, "code.s")
        for chip in names:
            call = [clang, "-x", "cl", "-cl-std=CL1.2", f"--target={triple}", *(option.format(chip) for option in options),
                    "-Xclang", "-finclude-default-header", "-O3", "-DLANES=1", f"-DREAL={real}", f"-I{kernel.parent}",
                    *variant, "-S", "-o", code, kernel]
            done = subprocess.run(call, capture_output=True, text=True)
            if done.returncode == 0:
                return chip, code.read_text(encoding="utf-8")
            if "unknown target CPU" not in done.stderr:
                break
    return None, done.stderr


def main():
    folder, clang = pathlib.Path(sys.argv[1]), sys.argv[2]
    kernels = sorted(folder.glob("*.cl"))
    jobs = [(target, kernel, variant, real) for target in TARGETS for kernel in kernels for variant in variants(kernel) for real in ("float", "double")]
    if sys.argv[3:] == ["largest"]:
        jobs = [job for job in jobs if job[2] == variants(job[1])[-1] and job[3] == "double"]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(lambda job: compiled(clang, *job), jobs))
    failed = 0
    for (_, kernel, variant, real), (chip, code) in zip(jobs, found):
        if chip is None:
            failed += 1
            print(f"{kernel.name} {' '.join(variant)} {real}: not compiled\n{code}", file=sys.stderr)
            continue
        registers = re.findall(r"; NumVgprs: (\d+)", code)
        spills = re.findall(r"\.vgpr_spill_count: (\d+)", code)
        of_amd = f", {max(map(int, registers))} vector registers, {max(map(int, spills), default=0)} spilled" if registers else ""
        print(f"{chip:7} {kernel.stem:16} {' '.join(word[2:] for word in variant):60} {real:6} {private_bytes(code):6} bytes{of_amd}")
    print(f"{len(jobs) - failed} of {len(jobs)} compiled")
    sys.exit(failed > 0 or not jobs)


main()
