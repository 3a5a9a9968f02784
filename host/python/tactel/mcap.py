# SPDX-License-Identifier: Apache-2.0
"""Lines of frames and answers to and from MCAP files, which Foxglove, Rerun and PlotJuggler read. Needs the package mcap of PyPI.

    tactel monitor ... --stresses | python -m tactel.mcap write grip.mcap
    python -m tactel.mcap read grip.mcap
    python -m tactel.mcap read robot.mcap --topic /skin --values 'sensors.*.taxels.*.[x,y,z]' | tactel monitor --source csv:- ...

`write` takes lines of standard input: JSON objects as `monitor` prints them become messages of the topic /tactel/answers, lines of
numbers as `--source csv:-` reads them messages of /tactel/frames, {"time": s, "values": [...]}. Each second what came is in the file,
compressed (zstd). Other lines are left out and counted. Ctrl-C and SIGTERM end the file well. `read` prints the lines as they were.
`--values` takes numbers out of the messages of any topic, as a line with its time: JSON, CDR of ROS 2 with mcap-ros2-support; bags of
ROS 1 and folders of ROS 2 with rosbags.
Times: `arrival` of an answer, the column `time` of numbers, else when the line was read; s, in the file ns."""

import argparse
import contextlib
import decimal
import json
import os
import re
import sys
import time as clock
import warnings

from . import InputError
from ._calls import input_error
from ._live_lines import LONGEST, PERIOD, LiveLines
from ._messages import LATEST, Digits, chosen, messages, numbers, package, seconds, steps_of

ANSWERS, FRAMES = "/tactel/answers", "/tactel/frames"
SCHEMAS = {
    ANSWERS: ("tactel.Answer", {"type": "object", "properties": {"frame": {"type": "integer"}, "arrival": {"type": "number"}}}),
    FRAMES: ("tactel.Frame", {"type": "object", "properties": {"time": {"type": "number"}, "values": {"type": "array", "items": {"type": ["number", "null"]}}}}),
}
_JSON_NUMBER = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][+-]?[0-9]+)?")


class Writer:
    """Writes lines into a new file, with `force` over one that exists; a context manager, at whose end the file is whole. At no line
    there is no file."""

    def __init__(self, path, force=False):
        library = package()
        try:
            self._file = os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | (0 if force else os.O_EXCL), 0o666), "wb")
        except FileExistsError:
            raise input_error(str(path), "exists", "give a new file, or --force to overwrite it") from None
        except OSError as error:
            raise input_error(str(path), error.strerror, "a file that can be written") from None
        self._path, self._writer = path, library.writer.Writer(self._file, compression=library.writer.CompressionType.ZSTD)
        self._channels, self._line, self._flushed, self.messages = {}, 0, 0.0, 0
        self._header, self._separator, self._begun = [], None, False  # of lines of numbers

    def __enter__(self):
        return self

    def __exit__(self, *_):
        with self._file:
            if self._channels:
                self._writer.finish()
                self._file.flush()
                os.fsync(self._file.fileno())
            elif os.fstat(self._file.fileno()).st_size == 0:
                os.unlink(self._path)

    def flush(self):
        """Puts into the file what was added."""
        self._flushed = clock.monotonic()
        if self._channels:
            self._writer.flush()

    def add(self, line):
        """Takes a line. Throws InputError for one that is neither an answer nor numbers, and leaves it out."""
        self._line += 1
        line = line.removeprefix("\ufeff" if self._line == 1 else "").strip()
        if len(line) > LONGEST:
            self._refuse("line", f"{line[:20]}...", f"at most {LONGEST} bytes")
        if line.startswith("{"):
            self._message(ANSWERS, line, self._stamp("arrival", self._answer(line).get("arrival")))
        elif line and (not line.startswith("#") or line[1:].split(",")[0].strip() == "time"):
            self._numbers(line.lstrip("#").strip())

    def _refuse(self, what, value, fix):
        raise input_error(f"line {self._line}: {what}", value, fix)

    def _answer(self, line):
        def refuse(name):
            raise ValueError(name)
        try:
            return json.loads(line, parse_float=Digits, parse_int=Digits, parse_constant=refuse)
        except (ValueError, RecursionError):
            self._refuse("text", repr(line[:40]), "a JSON object, as tactel monitor prints, or numbers with commas in between")

    def _stamp(self, key, found):
        """ns, of the digits of a number of s."""
        if not isinstance(found, Digits) or not 0 <= float(found) < LATEST:
            self._refuse(key, json.dumps(found), f"s, 0 to {LATEST:g}")
        return int(decimal.Decimal(found).scaleb(9).to_integral_value())

    def _numbers(self, line):
        if not self._begun:
            self._separator = next((mark for mark in ";\t," if mark in line), None)  # None: blanks
        words = [word.strip() for word in line.split(self._separator)]
        digits = [self._digits(word) for word in words]
        if not self._begun and not any(digits):
            self._header = words
            return
        if not all(digits):
            self._refuse("text", repr(line[:40]), "numbers with commas in between")
        if self._header and len(words) != len(self._header):
            if self._begun:
                self._refuse("fields", len(words), f"{len(self._header)}, as in the header")
            warnings.warn(f"line {self._line} has {len(words)} numbers; {','.join(self._header)[:40]!r} above is no header of it, and is left out")
            self._header = []
        self._begun, timed = True, self._header[:1] == ["time"]
        stamp = self._stamp("time", Digits(digits[0].replace("null", "nan"))) if timed else clock.time_ns()
        head = f'"time": {digits[0]}, ' if timed else ""
        self._message(FRAMES, f'{{{head}"values": [{", ".join(digits[timed:])}]}}', stamp, {"names": ",".join(self._header)})

    def _digits(self, word):
        """A number as JSON has it, NaN as null; None for what is no number, and for infinity."""
        word = word if self._separator == "," else word.replace(",", ".")
        with contextlib.suppress(ValueError):
            value = float(word)
            if abs(value) == float("inf"):
                return None
            return "null" if value != value else word if _JSON_NUMBER.fullmatch(word) else repr(value)

    def _message(self, topic, text, stamp, metadata=None):
        if not self._channels:
            self._file.truncate(0)
            self._writer.start(library="tactel")
        if topic not in self._channels:
            name, schema = SCHEMAS[topic]
            number = self._writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
            self._channels[topic] = self._writer.register_channel(topic, "json", number, metadata or {})
        self._writer.add_message(self._channels[topic], stamp, text.encode(), stamp)
        self.messages += 1
        if clock.monotonic() - self._flushed >= PERIOD:
            self.flush()


def _time(message, found, name):
    """The text of a message's time in s, and the path it has there; without one the time of its recording."""
    for path in [name] if name else ["header.stamp", "time"]:
        try:
            if path != "log" and (float(text := seconds(chosen(found, steps_of(path)))) > 0 or name):
                return text, path
        except (ValueError, LookupError):
            if name:
                raise
    return f"{message.stamp // 10**9}.{message.stamp % 10**9:09}", "log"


def _frame(found):
    """The numbers of a message that Writer made, and whether a time is first."""
    timed = "time" in found
    return ([seconds(found["time"])] if timed else []) + list(numbers(found["values"])), timed


def lines(path, topic=None, values=None, time=None):
    """Yields the lines of a file: those that Writer took, or of `topic` the numbers `values` of each message, with its time. `time` names
    that in the message, "log" is that of the recording; None: header.stamp or time of the message, else of the recording.
    Leaves messages out that have none, and a file without its end from there on, each with a warning. Throws
    InputError for a file that has no such messages, and where one is damaged."""
    steps = steps_of(values) if values else None
    total, begun, left_out, first = 0, False, 0, ""
    for total, message in enumerate(messages(path, [topic] if topic else [ANSWERS, FRAMES]), 1):
        try:
            found = message.decode(message.data)
            if message.topic == ANSWERS and not steps:
                yield _one_line(message.data.decode(), found)
                continue
            if steps:
                stamp, time = _time(message, found, time)
                row, timed = [stamp, *numbers(chosen(found, steps))], True
            else:
                row, timed = _frame(found)
            if len(row) == timed:
                raise ValueError("no numbers")
        except Exception as error:  # decoders raise anything
            left_out, first = left_out + 1, first or f"message {total} of {message.topic}: {error or type(error).__name__}"
            continue
        names = message.names if not steps else None
        if not begun and (timed or names):
            fits = names and names.isprintable() and len(names.split(",")) == len(row)
            yield names if fits else ",".join(["time"] * timed + [f"c{i}" for i in range(len(row) - timed)])
        begun = True
        yield ",".join(row)
    if left_out == total:
        raise input_error(str(path), first, "give the path of numbers in these messages: msg.data, or sensors.*.taxels.*.[x,y,z]")
    if left_out:
        warnings.warn(f"{path}: {left_out} of {total} messages are left out; the first, {first}")


def _one_line(text, found):
    if not isinstance(found, dict):
        raise ValueError("no JSON object")
    return text.replace("\r", " ").replace("\n", " ")  # white space of JSON: in texts there is none


def _write(path, force):
    """Writes standard input; returns whether a signal ended it."""
    bad, first = 0, ""
    with LiveLines(0) as source, Writer(path, force) as writer:
        for line in source:
            try:
                writer.flush() if line is None else writer.add(line.decode())
            except ValueError as error:  # InputError, or no UTF-8
                bad, first = bad + 1, first or str(error)
    if not writer.messages and not source.stopped:
        raise input_error("standard input", "no line of numbers or answers" + (f"; {first}" if bad else ""), "write a line for each frame")
    if bad:
        warnings.warn(f"{bad} lines are left out; the first, {first}")
    return source.stopped


def main(words=None):
    parser = argparse.ArgumentParser(prog="python -m tactel.mcap", description=__doc__.split("\n", 1)[0])
    commands = parser.add_subparsers(dest="command", required=True)
    write = commands.add_parser("write", help="lines of standard input into a file")
    write.add_argument("file")
    write.add_argument("--force", action="store_true", help="overwrite the file where it exists")
    read = commands.add_parser("read", help="lines of a file to standard output")
    read.add_argument("file", help="MCAP, a bag of ROS 1 (.bag), or the folder of a bag of ROS 2")
    read.add_argument("--topic", help=f"of the messages (default: {ANSWERS} and {FRAMES})")
    read.add_argument("--values", metavar="PATH", help="numbers of the messages, as lines with their time: msg.data, sensors.*.taxels.*.[x,y,z]")
    read.add_argument("--time", metavar="PATH", help="their time in the messages, or log: that of the recording (default: header.stamp or time of the messages, else log)")
    given = parser.parse_args(words)
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.showwarning = lambda message, *_: print(f"tactel.mcap: {message}", file=sys.stderr)
        try:
            if given.command == "write":
                return 130 if _write(given.file, given.force) else 0
            for line in lines(given.file, given.topic, given.values, given.time):
                print(line)
            sys.stdout.flush()
        except BrokenPipeError:
            with contextlib.suppress(AttributeError, OSError, ValueError):  # what is left has no reader
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        except InputError as error:
            print(f"tactel.mcap: {error}", file=sys.stderr)
            return 2
        except OSError as error:
            print(f"tactel.mcap: {given.file}: {error.strerror or error}; what is whole of it can be read", file=sys.stderr)
            return 2
        except KeyboardInterrupt:
            return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
