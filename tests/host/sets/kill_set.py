#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kills `tactel generate` at random moments, resumes it, and compares every finished set byte for byte with one that was
never interrupted. With PROCESSES, each run has a random number of them under mpirun, and one of these is killed.
Usage: kill_set.py TACTEL SWEEP.toml KILLS [SEED [PROCESSES]]"""
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

tactel, sweep, kills = sys.argv[1], sys.argv[2], int(sys.argv[3])
random.seed(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
processes = int(sys.argv[5]) if len(sys.argv) > 5 else 0
os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
folder = pathlib.Path(tempfile.mkdtemp())


def command(output, *more):
    several = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(random.randint(1, processes))] if processes and more else []
    return [*several, tactel, "generate", sweep, "--output", str(output), "--quiet", *more]


begin = time.time()
subprocess.run(command(folder / "whole.h5"), check=True)
seconds = time.time() - begin
whole = (folder / "whole.h5").read_bytes()
killed = finished = 0
output = folder / "killed.h5"
while killed < kills:
    process = subprocess.Popen(command(output, "--resume"), stderr=subprocess.DEVNULL)
    try:
        code = process.wait(timeout=random.uniform(0, (2 if processes else 0.7) * seconds))
    except subprocess.TimeoutExpired:
        ranks = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True).stdout.split()
        if ranks:
            os.kill(int(random.choice(ranks)), signal.SIGKILL)  # mpirun ends the others
        else:
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
