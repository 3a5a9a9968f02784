#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kills `tactel generate` at random moments, resumes it, and compares every finished set byte for byte with one that was
never interrupted. Usage: kill_set.py TACTEL SWEEP.toml KILLS [SEED]"""
import pathlib
import random
import subprocess
import sys
import tempfile
import time

tactel, sweep, kills = sys.argv[1], sys.argv[2], int(sys.argv[3])
random.seed(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
folder = pathlib.Path(tempfile.mkdtemp())


def command(output, *more):
    return [tactel, "generate", sweep, "--output", str(output), "--quiet", *more]


begin = time.time()
subprocess.run(command(folder / "whole.h5"), check=True)
seconds = time.time() - begin
whole = (folder / "whole.h5").read_bytes()
killed = finished = 0
output = folder / "killed.h5"
while killed < kills:
    process = subprocess.Popen(command(output, "--resume"), stderr=subprocess.DEVNULL)
    try:
        code = process.wait(timeout=random.uniform(0, 0.7 * seconds))
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        killed += 1
        continue
    if code != 0 or output.read_bytes() != whole:
        sys.exit(f"after {killed} kills: exit code {code}, or other bytes")
    finished += 1
    output.unlink()
subprocess.run(command(output, "--resume"), check=True)
if output.read_bytes() != whole:
    sys.exit("other bytes after the last kill")
print(f"{killed} kills, {finished + 1} sets finished, all the same {len(whole)} bytes")
