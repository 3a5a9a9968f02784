#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sets by PoCL, with vectors and with one lane, and by Intel's runtime for processors have the same bits, and networks that learn from
them: tests/host/sets/intel_bits.py PROGRAM EXAMPLES

Installs intel-opencl-rt of PyPI (250 MB) into a folder that it removes. Exits with 77 where PyPI cannot be reached.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import venv

import h5py
import numpy as np

SETS = [("learning_mix.toml", 1024, "patch-12"), ("learning_mix.toml", 1024, "mesh-321"), ("pad_sweep.toml", 64, "pad-8"),
        ("uskin_holds.toml", 8, "pad-8")]  # noise, spreads of sensors, free sides, grips


def numbers(path):
    with h5py.File(path) as found:
        return {name: data[()] for name, data in found.items() if data.shape is not None and data.dtype.kind in "fiu"}


def main():
    program, examples = sys.argv[1], pathlib.Path(sys.argv[2])
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        venv.create(folder / "intel", with_pip=True)
        got = subprocess.run([folder / "intel/bin/pip", "install", "-q", "intel-opencl-rt", "intel-cmplr-lib-rt"])
        if got.returncode != 0:
            print("skipped: PyPI gave no intel-opencl-rt")
            sys.exit(77)
        drivers = {"pocl": {}, "one lane": {"TACTEL_LANES": "1"}, "intel": {"OCL_ICD_VENDORS": str(folder / "intel/lib/libintelocl.so")}}
        for example, contacts, rung in SETS:
            sweep = folder / example
            sweep.write_text(re.sub(r"(?m)^contacts = .*", f"contacts = {contacts}", (examples / example).read_text()))
            for precision in ("fp32", "fp64"):
                found = {}
                for driver, environment in drivers.items():
                    output = folder / f"{driver}.h5"
                    subprocess.run([program, "generate", sweep, "--output", output, "--rung", rung, "--precision", precision, "--device", "cpu", "--quiet",
                                    "--force"], check=True, env={**os.environ, **environment})
                    found[driver] = numbers(output)
                rows = len(found["pocl"]["contact"])
                differ = [f"{key} ({driver})" for key, data in found["pocl"].items() for driver in ("one lane", "intel")
                          if not np.array_equal(data, found[driver][key], equal_nan=data.dtype.kind == "f")]
                failed += bool(differ) or rows == 0
                print(f"{example} {rung} {precision}: {rows} rows, " + (f"differ in {', '.join(differ)}" if differ else "the same bits"))
        made = {}
        for driver in ("pocl", "intel"):
            subprocess.run([program, "train", folder / "pocl.h5", "--output", folder / driver, "--network", "48-12-1_leaky-relu", "--schedule", "batch",
                            "--cycles", "20", "--device", "cpu", "--quiet"], check=True, env={**os.environ, "TACTEL_LANES": "8", **drivers[driver]})
            made[driver], = [path.read_bytes() for path in (folder / driver).glob("*.onnx")]
        failed += made["pocl"] != made["intel"]
        print("a network: " + ("the same bits" if made["pocl"] == made["intel"] else "differs"))
    sys.exit(failed > 0)


main()
