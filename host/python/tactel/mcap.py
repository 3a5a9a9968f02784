# SPDX-License-Identifier: Apache-2.0
"""Lines of frames and answers to and from MCAP files, which Foxglove, Rerun and PlotJuggler read. Needs the package mcap of PyPI.

    tactel monitor ... --stresses | python -m tactel.mcap write grip.mcap
    python -m tactel.mcap read grip.mcap
    python -m tactel.mcap read robot.mcap --topic /skin --values data | tactel monitor --source csv:- ...

`write` takes lines of standard input: JSON objects as `monitor` prints them become messages of the topic /tactel/answers, lines of
numbers as `--source csv:-` reads them messages of /tactel/frames, {"time": s, "values": [...]}. `read` prints them as they were.
`--values` takes an array out of the JSON messages of any topic, as a line of numbers with its time.
Times: `arrival` of an answer, the column `time` of numbers, else when the line was read; s, in the file ns."""

import argparse
import json
import sys
import time

from . import InputError
from ._calls import input_error

ANSWERS, FRAMES = "/tactel/answers", "/tactel/frames"
SCHEMAS = {
    ANSWERS: ("tactel.Answer", {"type": "object", "properties": {"frame": {"type": "integer"}, "arrival": {"type": "number"}}}),
    FRAMES: ("tactel.Frame", {"type": "object", "properties": {"time": {"type": "number"}, "values": {"type": "array", "items": {"type": "number"}}}}),
}


def _mcap():
    try:
        import mcap.reader
        import mcap.writer
    except ImportError:
        raise input_error("mcap", "not installed", "install it: pip install mcap") from None
    return mcap


class Writer:
    """Writes lines into a file as they come; a context manager, at whose end the file is whole."""

    def __init__(self, path):
        package = _mcap()
        self._file = open(path, "wb")
        self._writer = package.writer.Writer(self._file, compression=package.writer.CompressionType.NONE)
        self._writer.start(library="tactel")
        self._channels, self._header, self._line = {}, None, 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._writer.finish()
        self._file.close()

    def add(self, line):
        """Takes a line. Throws InputError for one that is neither an answer nor numbers."""
        self._line += 1
        line = line.strip()
        if not line:
            return
        if line.startswith("{"):
            self._message(ANSWERS, line, self._number(self._answer(line), "arrival"))
        else:
            self._numbers(line.split(","))

    def _refuse(self, what, value, fix):
        raise input_error(f"line {self._line}: {what}", value, fix)

    def _answer(self, line):
        try:
            return json.loads(line)
        except ValueError:
            self._refuse("text", line[:40], "a JSON object, as tactel monitor prints, or numbers with commas in between")

    def _number(self, answer, key):
        found = answer.get(key)
        if isinstance(found, bool) or not isinstance(found, (int, float)) or not 0 <= found < 1e9:
            self._refuse(key, json.dumps(found), "s, 0 to 1e9")
        return round(1e9 * found)

    def _numbers(self, words):
        words = [word.strip() for word in words]
        try:
            values = [float(word) for word in words]
        except ValueError:
            if self._header is not None or FRAMES in self._channels:
                self._refuse("text", ",".join(words)[:40], "numbers with commas in between")
            self._header = words
            return
        if not all(abs(value) < float("inf") for value in values):
            self._refuse("values", ",".join(words)[:40], "finite numbers")
        names = self._header or []
        timed = names[:1] == ["time"]
        if names and len(names) != len(words):
            self._refuse("fields", len(words), f"{len(names)}, as in the header")
        stamp = self._number({"time": values[0]}, "time") if timed else time.time_ns()
        rest = words[1:] if timed else words
        head = f'"time": {words[0]}, ' if timed else ""
        self._message(FRAMES, f'{{{head}"values": [{", ".join(rest)}]}}', stamp, {"names": ",".join(names)})

    def _message(self, topic, text, stamp, metadata=None):
        if topic not in self._channels:
            name, schema = SCHEMAS[topic]
            number = self._writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
            self._channels[topic] = self._writer.register_channel(topic, "json", number, metadata or {})
        self._writer.add_message(self._channels[topic], stamp, text.encode(), stamp)


def _field(message, names, place):
    for name in names:
        if not isinstance(message, dict) or name not in message:
            raise input_error(place, "without " + ".".join(names), "give the name of an array of numbers, with dots in between: msg.data")
        message = message[name]
    flat = [number for item in message for number in (item if isinstance(item, list) else [item])] if isinstance(message, list) else [message]
    if not all(isinstance(text, str) for text in flat):
        raise input_error(place, ".".join(names), "an array of numbers")
    return flat


def lines(path, topic=None, values=None):
    """Yields the lines of a file: those that Writer took, or of `topic` the array `values` of each JSON message, with its time."""
    package = _mcap()
    wanted, number, begun = [topic] if topic else [ANSWERS, FRAMES], 0, False
    try:
        with open(path, "rb") as file:
            for _, channel, message in package.reader.make_reader(file).iter_messages(topics=wanted):
                number += 1
                place = f"{path}: message {number} of {channel.topic}"
                if channel.message_encoding != "json":
                    raise input_error(place, channel.message_encoding, "messages in JSON")
                text = message.data.decode()
                if channel.topic == ANSWERS and not values:
                    yield text
                    continue
                try:
                    found = json.loads(text, parse_float=str, parse_int=str)  # numbers keep their digits
                except ValueError:
                    raise input_error(place, text[:40], "JSON") from None
                timed = values is not None or "time" in found
                numbers = _field(found, (values or "values").split("."), place)
                stamp = found["time"] if values is None and timed else f"{message.log_time // 10**9}.{message.log_time % 10**9:09}"
                if not begun:
                    begun = True
                    names = channel.metadata.get("names") if values is None else "time," + ",".join(f"c{i}" for i in range(len(numbers)))
                    if names:
                        yield names
                yield ",".join([stamp, *numbers] if timed else numbers)
    except (OSError, package.exceptions.McapError, UnicodeDecodeError) as error:
        raise input_error(str(path), str(error) or type(error).__name__, "a file of MCAP") from None
    if number == 0:
        raise input_error(str(path), "no message of " + " or ".join(wanted), "--topic NAME, of those in the file")


def main(words=None):
    parser = argparse.ArgumentParser(prog="python -m tactel.mcap", description=__doc__.split("\n", 1)[0])
    commands = parser.add_subparsers(dest="command", required=True)
    write = commands.add_parser("write", help="lines of standard input into a file")
    write.add_argument("file")
    read = commands.add_parser("read", help="lines of a file to standard output")
    read.add_argument("file")
    read.add_argument("--topic", help=f"of the messages (default: {ANSWERS} and {FRAMES})")
    read.add_argument("--values", metavar="NAME", help="an array of the messages, as lines of numbers with their time")
    given = parser.parse_args(words)
    try:
        if given.command == "write":
            with Writer(given.file) as writer:
                for line in sys.stdin:
                    writer.add(line)
        else:
            for line in lines(given.file, given.topic, given.values):
                print(line)
    except BrokenPipeError:
        return 0
    except (InputError, OSError) as error:
        print(f"tactel.mcap: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
