#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the tactel program on mutated scenes, sweeps, sets, networks, recordings and profiles.

    mutate.py --program build/tactel --inputs 200 [--seed 1] [--first 0] [--keep DIR]

Every input is a function of the seed and its number. For each, the program must
- end by itself with exit code 0, 2 or 4 (3 blames the device, and here the file alone is wrong): no signal, no hang.
  A sweep may ask for any number of contacts; one that still runs after a while gets Ctrl-C, and must end with 130;
- say on stderr what is wrong where it ends with 2, in its own words, as one line that begins with "error: ";
- print valid JSON where it prints JSON.
Prints each finding with the command that repeats it, and ends with 1 where there was one.
"""

import argparse
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import zlib

import h5py
import numpy

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"
CPU_SECONDS = 120  # of one run: what is slower hangs
WALL_SECONDS = 900  # a run that sleeps for ever
INTERRUPT_SECONDS = 20  # after which `generate` gets Ctrl-C: a billion contacts take an hour
LARGEST_MEMORY = 3 << 20  # kB

BASE_SCENE = """title = "base"
[sensor]
columns = 9
rows = 3
tactels = 4
[indenter]
shape = "parabola"
radius = 10.0
[contact]
friction = 0.5
[load]
indentation = 0.1
tangential_step = 0.02
tangential_steps = 3
"""
BASE_SWEEP = """[sweep]
contacts = 6
seed = 7
[sensor]
columns = 9
rows = 3
tactels = 4
[[indenter]]
shape = "parabola"
radius = { log_uniform = [5, 50] }
[[indenter]]
shape = "flat"
half_width = { uniform = [1, 3] }
[contact]
friction = { uniform = [0.2, 1.0] }
[load]
indentation = { uniform = [0.05, 0.15] }
tangential = [0.01, 0.02]
"""


# --- mutations -------------------------------------------------------------------------------------------------------

NUMBERS = ["0", "-0.0", "-1", "1", "2", "1e-300", "5e-324", "1e300", "-1e300", "1e-9", "1e9", "nan", "inf", "-inf",
           "0.5", "0.4999999999", "0.5000001", "9223372036854775807", "-9223372036854775808", "2147483647",
           "2147483648", "-2147483648", "4294967296", "1_000", "0x10", "0b1", "1.", "1e", "true", '"text"', "[]",
           "[1, 2]", "{}", "[[1]]", "1979-05-27", ""]
# What a file may ask much work for: small, or beyond what is allowed, so that no legal input takes minutes.
COSTLY = {"columns", "rows", "contacts", "sensors", "indentation_steps", "tangential_steps", "tactels", "points"}
COSTLY_NUMBERS = ["0", "-1", "1", "2", "3", "5", "7", "1000000000", "9223372036854775807", "-9223372036854775808",
                  "2147483648", "nan", "1.5", '"text"', "[3]", ""]
WORDS = ["flat", "wedge", "parabola", "cylinder", "exponential", "trapezoid", "rounded_flat", "taylor", "profile",
         "bbar", "q4", "q4i", "q8", "reaction", "element", "bonded", "paper", "paper-recall", "glove", "generic",
         "measured.csv", "", "\\u0000", "\\u001b[31m", "../../../../etc/passwd", "/", "x" * 300, "\u00e4\u20ac"]
NUMBER = re.compile(r"(?<![\w.\"-])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def costly_line(line):
    return line.split("=")[0].strip() in COSTLY


def mutate_number(text, rng):
    lines = text.split("\n")
    there = [i for i, line in enumerate(lines) if NUMBER.search(line.split("#")[0])]
    if not there:
        return text
    i = rng.choice(there)
    found = rng.choice(list(NUMBER.finditer(lines[i])))
    allowed = COSTLY_NUMBERS if costly_line(lines[i]) else NUMBERS
    if rng.random() < 0.5 and not costly_line(lines[i]):
        value = repr(float(found[0]) * rng.choice([-1, 0.1, 0.5, 0.99, 1.01, 2, 10, 1e3]))
    else:
        value = rng.choice(allowed)
    lines[i] = lines[i][: found.start()] + value + lines[i][found.end():]
    return "\n".join(lines)


def mutate_word(text, rng):
    found = list(re.finditer(r'"[^"\n]*"', text))
    if not found:
        return text
    one = rng.choice(found)
    return text[: one.start()] + '"' + rng.choice(WORDS) + '"' + text[one.end():]


def mutate_lines(text, rng):
    lines = text.split("\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    what = rng.randrange(4)
    if what == 0:
        del lines[i]
    elif what == 1:
        lines.insert(j, lines[i])
    elif what == 2:
        lines[i], lines[j] = lines[j], lines[i]
    elif not costly_line(lines[j]) and not costly_line(lines[i]):  # a key gets another's value
        left, right = lines[i].split("="), lines[j].split("=")
        if len(left) > 1 and len(right) > 1:
            lines[i] = left[0] + "=" + right[1]
    return "\n".join(lines)


def mutate_characters(text, rng):
    if not text:
        return text
    i = rng.randrange(len(text))
    if text[i].isdigit():  # would make numbers of any size
        return text
    return text[:i] + rng.choice(['"', "[", "]", "{", "}", "=", ".", "\n", "#", "\x00", "\x1b", "\xff", "'", ""]) + text[i + 1:]


def mutate_text(text, rng):
    for _ in range(rng.choice([1, 1, 1, 2, 2, 3, 5])):
        text = rng.choices([mutate_number, mutate_word, mutate_lines, mutate_characters], [6, 2, 3, 1])[0](text, rng)
    if rng.random() < 0.03:
        text = text[: rng.randrange(len(text) + 1)]
    return text


def mutate_bytes(content, rng):
    content = bytearray(content)
    for _ in range(rng.choice([1, 1, 1, 2, 4, 16])):
        if not content:
            break
        at = rng.randrange(len(content))
        what = rng.randrange(7)
        if what == 0:
            content[at] ^= 1 << rng.randrange(8)
        elif what == 1:
            content[at] = rng.choice([0, 1, 0x7F, 0x80, 0xFF])
        elif what == 2:
            del content[at:]
        elif what == 3:
            del content[at : at + rng.randrange(1, 17)]
        elif what == 4:
            content[at:at] = rng.randbytes(rng.randrange(1, 17))
        elif what == 5:
            value = rng.choice([0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1, len(content)])
            content[at : at + 8] = struct.pack("<Q", value)
        else:
            content += rng.randbytes(rng.randrange(1, 65))
    return bytes(content)


def repair_recording(content):
    """Sets every record's CRC to that of its bytes."""
    content, at = bytearray(content), 8
    while at + 5 <= len(content):
        end = at + 5 + int.from_bytes(content[at + 1 : at + 5], "little")
        if end + 4 > len(content):
            break
        content[end : end + 4] = struct.pack("<I", zlib.crc32(content[at:end]))
        at = end + 4
    return bytes(content)


def mutate_recording(content, rng):
    if rng.random() < 0.3:  # a number in a packet's head
        places, at = [], 8
        while at + 14 <= len(content):
            if content[at : at + 1] == b"P":
                places.append(at + 5)
            at += 9 + int.from_bytes(content[at + 1 : at + 5], "little")
        at = rng.choice(places)
        value = rng.choice([float("nan"), float("inf"), -float("inf"), -1.0, 1e300, -1e300, 0.0, 5e-324])
        content = content[:at] + struct.pack("<d", value) + content[at + 8 :]
    else:
        content = mutate_bytes(content, rng)
    return repair_recording(content) if rng.random() < 0.8 else content


LARGEST_DATASET = 1 << 24  # elements of one that is read or written whole
SET_TYPES = ["f4", "f8", "i1", "u1", "i8", "u8", ">f4", ">i4", "S1", "S100", "bool", "c8"]


def any_values(shape, dtype, rng):
    kind = rng.randrange(4)
    if kind == 0 or dtype.kind not in "fc":
        return numpy.zeros(shape, dtype)
    value = rng.choice([numpy.nan, numpy.inf, -1.0, 1e30, -1e30, 1e-40, 2.0])
    return numpy.full(shape, value, "f8").astype(dtype)


def mutate_dataset(file, name, rng):
    shape = file[name].shape or (1,)  # an earlier mutation may have left a scalar
    if file[name].size > LARGEST_DATASET:  # or one that no memory holds
        shape = (1,) * len(shape)
    what = rng.randrange(6)
    if what == 0:
        del file[name]
    elif what == 1 and file[name].dtype.kind == "f" and 0 < file[name].size <= LARGEST_DATASET:  # some values
        values = file[name][...]
        for _ in range(rng.choice([1, 3, values.size])):
            values.flat[rng.randrange(values.size)] = rng.choice([numpy.nan, numpy.inf, -1.0, 1e30, -5.0, 1e-40, 0.0])
        file[name][...] = values
    elif what == 1 and file[name].dtype.kind in "iu" and 0 < file[name].size <= LARGEST_DATASET:
        values = file[name][...]
        values.flat[rng.randrange(values.size)] = rng.choice([0, 1, 2, 200])
        file[name][...] = values
    else:
        rows = rng.choice([0, 1, shape[0], shape[0] + 1, max(shape[0] - 1, 0)])
        other = rng.choice([shape, (rows,) + shape[1:], (rows,), (rows, 1), (rows, 0), (rows, 3, 2), ()])
        dtype = numpy.dtype(rng.choice(SET_TYPES)) if what < 4 else file[name].dtype
        del file[name]
        if what == 3:
            file.create_dataset(name, shape=rng.choice([(2**40,), (2**33, 8), (2**62,)]), dtype=dtype, chunks=True)
        else:
            file.create_dataset(name, data=any_values(other, dtype, rng))


def mutate_attribute(attributes, name, rng):
    what = rng.randrange(6)
    del attributes[name]
    if what == 1:
        attributes[name] = "text of variable length"
    elif what == 2:
        attributes[name] = numpy.array([b"tactel contact set 1"] * rng.randrange(1, 500))
    elif what == 3:
        attributes[name] = rng.choice([numpy.int64(-1), numpy.float64("nan"), numpy.arange(1000.0), numpy.uint8(3)])
    elif what == 4:
        attributes[name] = numpy.bytes_(rng.choice([b"", b"\xff\xfe", b"a\nb\nc", b"-1", b"9" * 40, b"x" * 20000]))
    elif what == 5:
        attributes.create(name, ["several", "of variable length"], dtype=h5py.string_dtype())


def mutate_set(path, rng):
    if rng.random() < 0.4:
        path.write_bytes(mutate_bytes(path.read_bytes(), rng))
        return
    with h5py.File(path, "r+") as file:
        for _ in range(rng.choice([1, 1, 2, 3])):
            if rng.random() < 0.35 and len(file.attrs):
                mutate_attribute(file.attrs, rng.choice(sorted(file.attrs)), rng)
            elif len(file):
                mutate_dataset(file, rng.choice(sorted(file)), rng)


# --- running ---------------------------------------------------------------------------------------------------------


class Bench:
    """Whole files to mutate, made by the program itself, and where to run it."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        self.scenes = [BASE_SCENE] * 6
        self.sweeps = [BASE_SWEEP]
        for path in sorted(EXAMPLES.glob("*.toml")):
            text = path.read_text()
            if "[sweep]" not in text:
                self.scenes.append(re.sub(r"(?m)^(\[sensor\])$", r"\1", text))
        self.base = folder / "base"
        self.base.mkdir()
        shutil.copy(EXAMPLES / "measured.csv", self.base)
        (self.base / "scene.toml").write_text(BASE_SCENE)
        (self.base / "sweep.toml").write_text(BASE_SWEEP)
        self.make("generate", "sweep.toml", "--output", "set.h5", "--quiet")
        self.make("train", "set.h5", "--network", "8-4-1", "--network", "8-4-2-1", "--cycles", "3", "--output", "networks", "--quiet")
        self.make("record", "--source", "simulate:scene.toml?rate=100&paced=0&slip=0", "--output", "recording", "--quiet")
        self.network = sorted((self.base / "networks").glob("*.onnx"))[0]
        help_text = subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout
        self.has_check = re.search(r"(?m)^ +check ", help_text) is not None

    def make(self, *arguments):
        made = subprocess.run([self.program, *arguments], cwd=self.base, capture_output=True, text=True)
        if made.returncode not in (0, 4):
            sys.exit(f"mutate.py: tactel {' '.join(arguments)} ended with {made.returncode}: {made.stderr}")


def scene_case(bench, where, rng):
    shutil.copy(bench.base / "measured.csv", where)
    (where / "scene.toml").write_text(mutate_text(rng.choice(bench.scenes), rng), errors="surrogateescape")
    command = ["solve", "scene.toml", "--json", "-"]
    if rng.random() < 0.4:
        command += ["--solver", "reference"]
    return command


def profile_csv_case(bench, where, rng):
    (where / "measured.csv").write_text(mutate_text((bench.base / "measured.csv").read_text(), rng))
    scene = BASE_SCENE.replace('shape = "parabola"\nradius = 10.0', 'shape = "profile"\nfile = "measured.csv"\nsmooth = 0.1')
    (where / "scene.toml").write_text(scene)
    return ["solve", "scene.toml", "--json", "-", "--solver", "reference"]


def sweep_case(bench, where, rng):
    (where / "sweep.toml").write_text(mutate_text(rng.choice(bench.sweeps), rng))
    return ["generate", "sweep.toml", "--output", "set.h5"]


def set_case(bench, where, rng):
    shutil.copy(bench.base / "set.h5", where)
    mutate_set(where / "set.h5", rng)
    commands = [["recall", str(bench.base / "networks"), "set.h5", "--json", "-"],
                ["train", "set.h5", "--network", "8-4-1", "--cycles", "2", "--output", "trained"],
                ["train", "set.h5", "--network", "8-4-1", "--block", "5", "--rows", "20", "--output", "trained"]]
    if bench.has_check:
        commands.append(["check", "set.h5"])
    return rng.choice(commands)


def network_case(bench, where, rng):
    (where / "network.onnx").write_bytes(mutate_bytes(bench.network.read_bytes(), rng))
    if rng.random() < 0.5:
        return ["recall", "network.onnx", str(bench.base / "set.h5"), "--json", "-"]
    return ["monitor", "--source", f"replay:{bench.base / 'recording'}", "--network", "network.onnx", "--quiet"]


def recording_case(bench, where, rng):
    (where / "recording").write_bytes(mutate_recording((bench.base / "recording").read_bytes(), rng))
    return ["monitor", "--source", "replay:recording", "--network", str(bench.network), "--quiet"]


CASES = [(scene_case, 5), (profile_csv_case, 1), (sweep_case, 2), (set_case, 4), (network_case, 2), (recording_case, 3)]


def no_constant(name):
    raise ValueError(f"{name} is no JSON")


def json_complaint(command, stdout):
    if "--json" in command:
        texts = [stdout]
    elif command[0] == "monitor":
        texts = stdout.splitlines()
    else:
        return None
    for text in texts:
        try:
            json.loads(text, parse_constant=no_constant)
        except ValueError as error:
            return f"what it printed is no JSON: {error}: {text[:200]!r}"
    return None


FOREIGN_WORDS = re.compile(r"std::|bad_alloc|basic_string|vector::|_M_|json\.exception|filesystem error|stoi|stod|terminate")


def message_complaint(stderr):
    errors = [line for line in stderr.splitlines() if line.startswith("error: ")]
    if not errors:
        return "exit 2 without a line \"error: ...\""
    if FOREIGN_WORDS.search(errors[-1]):
        return "a library's own words instead of ours"
    if any(ord(c) < 32 for c in errors[-1]):
        return "control characters in the message"
    return None


def complaint_about(command, status, stdout, stderr, memory, interrupted):
    if os.WIFSIGNALED(status):
        name = os.WTERMSIG(status)
        return "hangs" if name in (9, 24) else f"ended by signal {name}"
    code = os.WEXITSTATUS(status)
    if code == 3:
        return "exit 3 blames the device, but the file is wrong"
    if code == 130 and interrupted:
        return None if "--resume" in stderr else "interrupted without a word on --resume"
    if code not in (0, 2, 4):
        return f"exit code {code}"
    if memory > LARGEST_MEMORY:
        return f"took {memory >> 10} MB"
    if code == 2:
        return message_complaint(stderr)
    return json_complaint(command, stdout)


def limit():
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(program, command, where):
    """Exit status as os.wait4 gives it, output, errors, memory in kB, and whether the run got Ctrl-C."""
    interrupted = threading.Event()
    with open(where / "stdout", "wb") as out, open(where / "stderr", "wb") as err:
        child = subprocess.Popen([program, *command], cwd=where, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                 preexec_fn=limit)

        def interrupt():
            interrupted.set()
            child.send_signal(signal.SIGINT)

        timers = [threading.Timer(WALL_SECONDS, child.kill)]
        if command[0] == "generate":
            timers.append(threading.Timer(INTERRUPT_SECONDS, interrupt))
        for timer in timers:
            timer.start()
        _, status, usage = os.wait4(child.pid, 0)
        for timer in timers:
            timer.cancel()
        child.returncode = status  # it was waited for
    text = [(where / name).read_text(errors="replace") for name in ("stdout", "stderr")]
    return status, text[0], text[1], usage.ru_maxrss, interrupted.is_set()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/tactel")
    parser.add_argument("--inputs", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", help="folder that keeps the inputs of findings")
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    keep = pathlib.Path(options.keep).resolve() if options.keep else None
    findings, codes = 0, {}
    with tempfile.TemporaryDirectory(prefix="tactel_mutate.") as temporary:
        folder = pathlib.Path(temporary)
        bench = Bench(program, folder)
        for number in range(options.first, options.first + options.inputs):
            rng = random.Random(f"{options.seed}:{number}")
            where = folder / "case"
            where.mkdir()
            make = rng.choices([case for case, _ in CASES], [weight for _, weight in CASES])[0]
            command = make(bench, where, rng)
            status, stdout, stderr, memory, interrupted = run(program, command, where)
            kind = make.__name__.removesuffix("_case")
            code = os.WEXITSTATUS(status) if os.WIFEXITED(status) else -os.WTERMSIG(status)
            codes.setdefault(kind, {}).setdefault(code, 0)
            codes[kind][code] += 1
            complaint = complaint_about(command, status, stdout, stderr, memory, interrupted)
            if complaint:
                findings += 1
                print(f"input {number} ({kind}): {complaint}\n  tactel {' '.join(command)}\n  {stderr[-400:].strip()}\n"
                      f"  again: {sys.argv[0]} --program {options.program} --seed {options.seed} --first {number} "
                      f"--inputs 1 --keep DIR", flush=True)
                if keep:
                    shutil.copytree(where, keep / f"input-{number}", dirs_exist_ok=True)
            shutil.rmtree(where)
    for kind, counts in sorted(codes.items()):
        print(f"{kind}: " + ", ".join(f"exit {code}: {count}" for code, count in sorted(counts.items())))
    print(f"{options.inputs} inputs, {findings} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
