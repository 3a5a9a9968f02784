# SPDX-License-Identifier: Apache-2.0
"""Messages of MCAP files and bags of ROS, and the numbers in them. What decodes messages of ROS is imported where a file needs it."""

import dataclasses
import importlib
import json
import pathlib
import re
import warnings
from collections import namedtuple

from . import InputError
from ._calls import input_error

LATEST = 1.8e10  # s: the ns of MCAP have 64 bits
_MAGIC = b"\x89MCAP0\r\n"
_ROS = {"cdr": ("mcap_ros2.decoder", "mcap-ros2-support"), "ros1": ("mcap_ros1.decoder", "mcap-ros1-support")}  # encoding: module, package
_STAMP = ("sec", "nanosec"), ("secs", "nsecs"), ("sec", "nsec")

Message = namedtuple("Message", "topic stamp names data decode")  # stamp: ns; names: of the columns, where known; decode: makes values of data


class Digits(str):
    """A number of JSON, as it is written there."""


def of_json(data):
    return json.loads(data, parse_float=Digits, parse_int=Digits, parse_constant=Digits)


def package():
    try:
        import mcap.reader
        import mcap.writer
    except ImportError:
        raise input_error("mcap", "not installed", "install it: pip install mcap") from None
    if not hasattr(mcap.writer.Writer, "flush"):
        raise input_error("mcap", "too old", "install 1.6 or newer: pip install -U mcap")
    return mcap


def messages(path, topics):
    """Yields each Message of these topics. Throws InputError where there is none, and for a file that is damaged."""
    known, found = [], 0
    try:
        of_ros = pathlib.Path(path).is_dir() or pathlib.Path(path).suffix == ".bag"
        for message in (_of_bag if of_ros else _of_mcap)(path, topics, known):
            found += 1
            yield message
    except InputError:
        raise
    except Exception as error:  # libraries raise anything where a file is damaged
        raise input_error(str(path), str(error) or type(error).__name__, f"a bag or a file of MCAP that is whole; {found} messages were read") from None
    if not found:
        raise input_error(str(path), "no message of " + " or ".join(topics), "--topic NAME, of those in the file: " + (", ".join(sorted(set(known))) or "none"))


def _of_mcap(path, topics, known):
    """In the order of times. Of a file without its end the messages that are whole, in the order of the file, with a warning."""
    library, decoders = package(), {}
    with open(path, "rb") as file:
        whole = file.seekable() and file.seek(0, 2) > 2 * len(_MAGIC) and file.seek(-len(_MAGIC), 2) and file.read() == _MAGIC
        if file.seekable():
            file.seek(0)
        reader = (library.reader.make_reader if whole else library.reader.NonSeekingReader)(file, validate_crcs=True)
        if whole and (summary := reader.get_summary()):
            known += [channel.topic for channel in summary.channels.values()]
        try:
            for schema, channel, message in reader.iter_messages(topics=topics, log_time_order=bool(whole)):
                if channel.id not in decoders:
                    decoders[channel.id] = _decoder(channel.message_encoding, schema, f"{path}: {channel.topic}")
                yield Message(channel.topic, message.log_time, channel.metadata.get("names"), message.data, decoders[channel.id])
        except InputError:
            raise
        except Exception:
            if whole or not decoders:
                raise
            warnings.warn(f"{path}: has no end, as a recording that was killed; what is whole was read")


def _decoder(encoding, schema, place):
    if encoding == "json":
        return of_json
    if encoding not in _ROS:
        raise input_error(place, f"messages in {encoding}", "JSON, or messages of ROS")
    module, name = _ROS[encoding]
    try:
        decode = importlib.import_module(module).DecoderFactory().decoder_for(encoding, schema)
    except ImportError:
        raise input_error(place, f"messages of ROS, in {encoding}", f"install what reads them: pip install {name}") from None
    if decode is None:
        raise input_error(place, f"a definition in {schema.encoding if schema else 'no language'}", "one in ros2msg or ros1msg")
    return decode


def _of_bag(path, topics, known):
    """A bag of ROS 1, or the folder of a bag of ROS 2."""
    try:
        from rosbags.highlevel import AnyReader  # type: ignore[import]
        from rosbags.typesys import Stores, get_typestore  # type: ignore[import]
    except ImportError:
        raise input_error(str(path), "a bag of ROS", "install what reads it: pip install rosbags") from None
    with AnyReader([pathlib.Path(path)], default_typestore=get_typestore(Stores.LATEST)) as reader:
        known += [of.topic for of in reader.connections]
        if wanted := [of for of in reader.connections if of.topic in topics]:
            for of, stamp, data in reader.messages(wanted):
                yield Message(of.topic, stamp, None, data, lambda data, kind=of.msgtype: reader.deserialize(data, kind))


def steps_of(path):
    """The steps of a path: NAME.*.3.[x,y]. Throws InputError."""
    steps = re.findall(r"\[[^\[\]]+\]|[^.\[\]]+", path)
    if ".".join(steps) != path:
        raise input_error("values", path, "names with dots in between, * of all in an array, [x,y,z] of some: sensors.*.taxels.*.[x,y,z]")
    return steps


def _fields(value):
    """The parts of an object, by name; None for what is no object."""
    if isinstance(value, dict):
        return value
    if dataclasses.is_dataclass(value):
        return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    return {name: getattr(value, name) for name in value.__slots__} if hasattr(type(value), "__slots__") else None


def _items(value):
    value = value.tolist() if hasattr(value, "tolist") else value
    return list(value) if isinstance(value, (list, tuple, bytes)) else None


def chosen(value, steps):
    """What a path names. A name goes into each object of an array; * takes all, a number one of an array. Throws LookupError."""
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    items, fields = _items(value), _fields(value)
    if step == "*" and (items is not None or fields):
        return [chosen(one, rest) for one in (items if items is not None else fields.values())]
    if items is not None:
        return chosen(items[int(step)], rest) if step.isdecimal() else [chosen(one, steps) for one in items]
    if step.startswith("["):
        return [chosen(value, [name.strip(), *rest]) for name in step[1:-1].split(",")]
    if fields is None or step not in fields:
        raise LookupError(f"without {step}")
    return chosen(fields[step], rest)


def numbers(value):
    """Yields the texts of all numbers in a value, in its order; nan for null. Throws ValueError for what is no number."""
    if value is None:
        yield "nan"
    elif isinstance(value, Digits):
        yield value if value[-1].isdecimal() else value.lower().replace("infinity", "inf")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield repr(value)
    else:
        fields = _fields(value)
        parts = fields.values() if fields is not None else _items(value)
        if parts is None:
            raise ValueError(f"{str(value)[:40]!r} among the numbers")
        for part in parts:
            yield from numbers(part)


def seconds(value):
    """The text of a time in s: of a number, or of a stamp of ROS. Throws ValueError, LookupError."""
    fields = _fields(value)
    if fields is not None:
        whole, part = next((pair for pair in _STAMP if set(pair) <= set(fields)), (None, None))
        if whole is None:
            raise LookupError("time without sec, nanosec")
        text = f"{int(fields[whole])}.{int(fields[part]):09}"
    else:
        text, = numbers(value) if _items(value) is None else ("nan",)
    if not 0 <= float(text) < LATEST:
        raise ValueError(f"time {text}: s, 0 to {LATEST:g}")
    return text
