#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Pads of 16 tactels with three axes, 48 numbers a pad in a line, through a pipe to `tactel monitor` by the clock.

Usage: bench/live_pads.py [--program build/tactel] [--pads 2] [--device NAME] [--frames 20000] [--rate 1000] [--busy 0]
The network is uskin-4x4, which takes the rest of the grip. Prints how many lines came back, the latency from the write of
a line to the read of its answer, and the part of it inside the program. Ends with 1 where a frame was lost or dropped
as late, or a line is missing. --device: OpenCL's kernel answers. --busy: so many processes compute beside it."""
import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import threading
import time

REST = (16000.0, 16500.0, 39000.0)  # counts of x, y, z


def lines(frames, pads, load=2000.0, drag=800.0):
    """Readings of pads that are pressed and dragged, with noise; the time is written in front when it is sent."""
    dice = random.Random(1)
    for frame in range(frames):
        part = frame / frames
        moved = (drag * part, 0.3 * drag * part, load * min(1.0, 4 * part))
        yield ",".join(f"{rest + more + dice.gauss(0, 20):.0f}" for _ in range(pads * 16)
                       for rest, more in zip(REST, moved))


def tared(program, folder, profiles, pads):
    rest, offsets = folder / "rest.csv", folder / "offsets.toml"
    rest.write_text("\n".join(lines(200, pads, 0, 0)) + "\n")
    subprocess.run([program, "tare", "--source", f"csv:{rest}", *profiles, "--output", offsets], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return offsets


def send(pipe, texts, rate, sent):
    try:
        pipe.write(("time" + "," * texts[0].count(",") + ",\n").encode())
        start = time.monotonic()
        for frame, text in enumerate(texts):
            wait = start + frame / rate - time.monotonic()
            if wait > 0:
                time.sleep(wait)
            sent.append(time.monotonic())
            pipe.write(f"{sent[-1]:.9f},{text}\n".encode())
            pipe.flush()
        pipe.close()
    except BrokenPipeError:  # the program ended: its message says why
        pass


def share(values, part):
    return sorted(values)[min(int(part * len(values)), len(values) - 1)]


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--program", default="build/tactel")
    options.add_argument("--pads", type=int, choices=(1, 2), default=2)
    options.add_argument("--device")
    options.add_argument("--frames", type=int, default=20000)
    options.add_argument("--rate", type=float, default=1000)
    options.add_argument("--busy", type=int, default=0)
    options = options.parse_args()
    profiles = ["--profile", "uskin-4x4"] * options.pads
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        offsets = tared(options.program, folder, profiles, options.pads)
        texts = list(lines(options.frames, options.pads))
        busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(options.busy)]
        child = subprocess.Popen([options.program, "monitor", "--source", "csv:-", *profiles, "--calibration", offsets,
                                  "--network", "uskin-4x4", "--quiet",
                                  *(["--device", options.device] if options.device else [])],
                                 stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        sent, read = [], []
        sender = threading.Thread(target=send, args=(child.stdin, texts, options.rate, sent))
        sender.start()
        try:
            for answer in child.stdout:
                read.append((time.monotonic(), answer))
        finally:
            for process in busy:
                process.kill()
        sender.join()
        said = child.stderr.read().decode()
        if child.wait() != 0:
            sys.exit(said)
    answers = [(now, json.loads(answer)) for now, answer in read]
    numbers = [line["frame"] for _, line in answers]
    assert numbers == sorted(set(numbers)) and all(len(line.get("pads", [line])) == options.pads for _, line in answers)
    latency = [1e3 * (now - line["device_time"]) for now, line in answers]
    summary = json.loads(said.strip().splitlines()[-1])
    inside = summary["latency_us"]
    print(f"{options.frames} lines of {options.pads * 48} numbers in {sent[-1] - sent[0]:.2f} s, answered by "
          f"{summary['device']}: {len(latency)} answers, {summary['lost']} lost, {summary['late']} dropped as late")
    print("from pipe to pipe: " + ", ".join(f"{name} {share(latency, part):.2f} ms" for name, part in
                                            (("p50", 0.5), ("p99", 0.99), ("p99.9", 0.999))) +
          f", largest {max(latency):.2f} ms")
    print("from the read of a line to S: " + ", ".join(f"{name} {1e-3 * inside[name]:.3f} ms" for name in inside))
    return int(len(latency) != options.frames or summary["lost"] + summary["late"] > 0)


if __name__ == "__main__":
    sys.exit(main())
