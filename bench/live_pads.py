#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two pads of 16 tactels with three axes, 96 numbers a line, through a pipe to `tactel monitor` by the clock.

Usage: bench/live_pads.py [--program build/tactel] [--frames 20000] [--rate 1000]
Teaches a network on a few simulated contacts first. Prints how many lines came back, the latency from the write of
a line to the read of its answer, and the part of it inside the program. Ends with 1 where a frame was lost or dropped
as late, or a line is missing."""
import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import threading
import time

PADS = 2
REST = (16000.0, 16500.0, 39000.0)  # counts of x, y, z


def network(program, folder):
    example = pathlib.Path(__file__).parent.parent / "examples" / "uskin_4x4.toml"
    sweep = folder / "sweep.toml"
    sweep.write_text(example.read_text().replace("contacts = 20000", "contacts = 200"))
    quiet = {"check": True, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    subprocess.run([program, "generate", sweep, "--output", folder / "set.h5"], **quiet)
    subprocess.run([program, "train", folder / "set.h5", "--network", "48-24-12-1", "--schedule", "batch", "--scaling",
                    "frame", "--cycles", "10", "--output", folder / "nets"], **quiet)
    return next((folder / "nets").glob("*.onnx"))


def lines(frames):
    """Readings of a pressed and dragged pad with noise; the time is written in front when it is sent."""
    dice = random.Random(1)
    for frame in range(frames):
        load = 2000.0 * min(1.0, frame / frames * 4)
        drag = 800.0 * frame / frames
        yield ",".join(f"{rest + part + dice.gauss(0, 20):.0f}" for _ in range(PADS * 16)
                       for rest, part in zip(REST, (drag, 0.3 * drag, load)))


def send(pipe, texts, rate, sent):
    pipe.write(("time" + "," * (PADS * 48) + "\n").encode())
    start = time.monotonic()
    for frame, text in enumerate(texts):
        wait = start + frame / rate - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        sent.append(time.monotonic())
        pipe.write(f"{sent[-1]:.9f},{text}\n".encode())
        pipe.flush()
    pipe.close()


def share(values, part):
    return sorted(values)[min(int(part * len(values)), len(values) - 1)]


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--program", default="build/tactel")
    options.add_argument("--frames", type=int, default=20000)
    options.add_argument("--rate", type=float, default=1000)
    options = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        model = network(options.program, pathlib.Path(folder))
        texts = list(lines(options.frames))
        child = subprocess.Popen([options.program, "monitor", "--source", "csv:-", *["--profile", "uskin-4x4"] * PADS,
                                  "--network", model, "--touch", "0", "--quiet"],
                                 stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        sent, latency = [], []
        sender = threading.Thread(target=send, args=(child.stdin, texts, options.rate, sent))
        sender.start()
        for answer in child.stdout:
            now = time.monotonic()
            line = json.loads(answer)
            assert len(line["pads"]) == PADS and line["frame"] == len(latency)
            latency.append(1e3 * (now - line["device_time"]))
        sender.join()
        summary = json.loads(child.stderr.read().decode().strip().splitlines()[-1])
    seconds = sent[-1] - sent[0]
    inside = summary["latency_us"]
    print(f"{options.frames} lines of {PADS * 48} numbers in {seconds:.2f} s: {len(latency)} answers, "
          f"{summary['lost']} lost, {summary['late']} dropped as late")
    print("from pipe to pipe: " + ", ".join(f"{name} {share(latency, part):.2f} ms" for name, part in
                                            (("p50", 0.5), ("p99", 0.99), ("p99.9", 0.999))) +
          f", largest {max(latency):.2f} ms")
    print("from the read of a line to S: " + ", ".join(f"{name} {1e-3 * inside[name]:.3f} ms" for name in inside))
    return int(len(latency) != options.frames or summary["lost"] + summary["late"] > 0)


if __name__ == "__main__":
    sys.exit(main())
