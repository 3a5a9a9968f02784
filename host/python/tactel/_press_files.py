# SPDX-License-Identifier: Apache-2.0
"""The files of tactel.calibrate: recordings of presses with their scenes, and the profile with the new calibration."""

import json
import math
import re
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from . import open_sensor, read_scene
from ._calls import _tactel, input_error
from ._known_presses import Options, Press, is_pad, targets, transducers

FEWEST_FRAMES = 4  # of a window, for its noise


class Table:
    """A table of a TOML file, read strictly."""

    def __init__(self, file, name, values):
        self.place, self.left, self.known = f"{file}: {name}", dict(values), []

    def refuse(self, key, problem, fix):
        raise input_error(f"{self.place}.{key}", problem, fix)

    def take(self, key, usual, allowed, good):
        self.known.append(key)
        value = self.left.pop(key, None)
        if value is None:
            return usual
        if not good(value):
            self.refuse(key, json.dumps(value, default=str), f"must be {allowed}")
        return value

    def flag(self, key, usual):
        return self.take(key, usual, "true or false", lambda v: isinstance(v, bool))

    def number(self, key, usual, allowed, good=lambda v: True):
        return float(self.take(key, usual, allowed, lambda v: _is_number(v) and good(v)))

    def text(self, key, allowed):
        return self.take(key, None, allowed, lambda v: isinstance(v, str)) or self.refuse(key, "missing", f"must be {allowed}")

    def numbers(self, key, allowed, good=lambda v: True, one=False):
        value = self.take(key, None, allowed, lambda v: one and _is_number(v) or isinstance(v, list) and v and all(map(_is_number, v)) and good(v))
        return value if value is None else [float(v) for v in (value if isinstance(value, list) else [value])]

    def finish(self):
        for key in self.left:
            self.refuse(key, "unknown", f"must be one of {', '.join(self.known)}")


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def read_tables(path):
    """The tables of a TOML file."""
    try:
        import tomllib
    except ImportError:  # Python 3.10 and older
        try:
            import tomli as tomllib  # type: ignore[import, no-redef]
        except ImportError:
            raise input_error("tomli", "not installed", "install it: pip install tomli") from None
    try:
        tables = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise input_error(path, str(error), "must be a TOML file") from None
    for name, table in tables.items():
        if not isinstance(table, dict):
            raise input_error(f"{path}: {name}", "no table", "must be a table: [fit], [transducer], or one of a press")
    return tables


def read_fit(path, tables):
    """The tables [fit] and [transducer]."""
    fit_, of = Table(path, "fit", tables.get("fit", {})), Table(path, "transducer", tables.get("transducer", {}))
    options = Options(
        poisson=fit_.flag("poisson", True), thickness=fit_.flag("thickness", False), shift=fit_.flag("shift", False),
        fit_time_constant=fit_.flag("time_constant", False),
        friction=fit_.number("friction", 0, "standard deviation of each press's friction, relative, 0 to 1", lambda v: 0 <= v < 1),
        force_noise=fit_.number("force_noise", 0.01, "standard deviation of P over P, above 0, at most 1", lambda v: 0 < v <= 1),
        lowest_reading=fit_.number("lowest_reading", -math.inf, "the lowest reading of the converter"),
        highest_reading=fit_.number("highest_reading", math.inf, "the highest reading of the converter"),
        time_constant=of.number("time_constant", math.inf, "s above 0, of the charge amplifiers", lambda v: v > 0))
    fit_.finish(), of.finish()
    if not options.lowest_reading < options.highest_reading:
        fit_.refuse("lowest_reading", f"{options.lowest_reading:g}", "must be below highest_reading")
    if options.fit_time_constant and not math.isfinite(options.time_constant):
        fit_.refuse("time_constant", "true", "must be given with transducer.time_constant, s, from which the search starts")
    return options


def same_sensor(path, name, scene, first, expected):
    if not (is_pad(scene) == is_pad(expected) and scene.sensor == expected.sensor):
        raise input_error(f"{path}: {name}.scene", "another sensor", f"must be a scene with the sensor of {first}")


def _windows(path, profile_name, profile, times, width, refuse):
    """Of each window about a time of a recording, its readings [frames, transducers]; NaN where a transducer has no channel."""
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as raw:
        raw.write("[calibration]\noffset = 0\ngain = 1\n")
        raw.flush()
        found, first = [[] for _ in times], None
        with open_sensor(f"replay:{path}", profile_name, raw.name) as stream:
            for frame in stream:
                first = frame.arrival if first is None else first
                for k, time in enumerate(times):
                    if abs(frame.arrival - first - time) <= width / 2:
                        found[k].append(np.array(frame.stress, float))
    absent = np.array(profile["channel"]) < 0
    for time, frames in zip(times, found):
        if not frames:
            refuse("times", f"{time:g} s has no frame", f"must be times within the recording {path}")
    return [np.where(absent, math.nan, np.array(frames)) for frames in found]


def _rest(windows):
    """Noise of single readings and of means, [transducers]: the median over windows; a noise below half a step of the converter may be
    hidden in it. NaN: not known."""
    noise, least, of_mean = [], [], []
    for frames in windows:
        change = np.abs(np.diff(frames, axis=0))
        if not len(change):
            continue
        step = np.where(change > 0, change, math.inf).min(0)
        half = np.where(np.isfinite(step), step / 2, math.nan)
        of_frame = np.sqrt((change**2).mean(0) / 2)
        least.append(half)
        if len(frames) >= FEWEST_FRAMES:
            noise.append(of_frame)
            of_mean.append(np.where(of_frame > np.nan_to_num(half), of_frame / math.sqrt(len(frames)), half))
    unknown = np.full(windows[0].shape[1], math.nan)

    def over(values, measure):
        kept = np.array(values)
        return np.array([measure(column[np.isfinite(column)]) if np.isfinite(column).any() else math.nan for column in kept.T]) if len(kept) else unknown
    single, half = over(noise, np.median), over(least, np.min)
    return np.where(half > single, half, single), over(of_mean, np.median)


def _read_press(path, name, values, profile_name, profile, windows):
    table = Table(path, name, values)
    scene_file, recording = table.text("scene", "a scene file"), table.text("recording", "a file of tactel record")
    times = table.numbers("times", "an array of s since the first frame, above 0, each later than the one before",
                          lambda t: t[0] > 0 and all(a < b for a, b in zip(t, t[1:])))
    if times is None:
        table.refuse("times", "missing", "must be an array of s since the first frame, one for each load step")
    longest = min([2 * times[0], *np.diff(times)])
    window = table.number("window", 0.1, f"s above 0, over which frames are averaged; at most {longest:g}, so that windows begin with the recording "
                          "and do not overlap", lambda v: 0 < v <= longest * (1 + 1e-9))
    alike = f"as long as times, {len(times)}"
    P = table.numbers("P", f"an array of N/mm (pads: N) above 0, {alike}; left out where the force was not measured", lambda v: min(v) > 0 and len(v) == len(times))
    begin = table.numbers("begin", f"an array of s, {alike}", lambda v: len(v) == len(times)) or [0, *(t + window / 2 for t in times[:-1])]
    end = table.numbers("end", f"an array of s, {alike}", lambda v: len(v) == len(times)) or [t - window / 2 for t in times]
    table.finish()
    for k, (b, e, t) in enumerate(zip(begin, end, times)):
        if not b >= (times[k - 1] if k else 0):
            table.refuse("begin", f"{b:g}", "must be s, not before the reading of the last load step")
        if not b <= e <= t:
            table.refuse("end", f"{e:g}", "must be s, not before begin, and not after the reading")
    scene = read_scene(Path(path).parent / scene_file)
    pads = [tuple(pad) for pad in profile["pads"]]
    fits = pads == [tuple(scene.sensor.tactels)] if is_pad(scene) else not pads
    if not fits or len(transducers(scene)) != len(profile["channel"]):
        wanted = f"of a line with the profile's {len(profile['channel']) // 2} tactels" if not pads else \
            f"of a pad with the profile's {pads[0][0]} x {pads[0][1]} tactels of {len(profile['channel']) // np.prod(pads[0])} axes"
        table.refuse("scene", "another sensor", "must be used with the profile of one pad: calibrate pads one by one" if len(pads) > 1 else f"must be a scene {wanted}")
    count = steps(scene)
    if count != len(times):
        table.refuse("times", f"{len(times)} numbers", f"must be as long as the scene has load steps, {count or 'of a drag with a number of steps'}")
    read = _windows(Path(path).parent / recording, profile_name, profile, times, window, table.refuse)
    windows.extend(read)
    with np.errstate(all="ignore"):
        readings = np.array([np.mean(frames, 0) for frames in read])
    return Press(name, scene, readings, P, (begin, end, times))


def steps(scene):
    """Load steps of a scene; 0: its drag ends by sliding."""
    load = scene.load
    drags = len(load.tangential) or (0 if is_pad(scene) or load.tangential_step == 0 else load.tangential_steps)
    return 0 if drags is None else len(targets(load)) + drags


def read_presses(path, profile_name):
    """Presses, options and the noise of single readings at rest, [transducers], of a file of recordings."""
    tables, profile, windows = read_tables(path), _tactel._read_profile(str(profile_name)), []
    options = read_fit(path, tables)
    presses = [_read_press(path, name, table, str(profile_name), profile, windows) for name, table in tables.items() if name not in ("fit", "transducer")]
    if not presses:
        raise input_error(f"{path}: press", "none", "must be at least one table of a press: scene, recording, times")
    for press in presses:
        same_sensor(path, press.name, press.scene, presses[0].name, presses[0].scene)
    noise, of_means = _rest(windows)
    rest = np.nan_to_num(of_means) if np.isfinite(of_means).any() else None
    return presses, replace(options, rest_noise=rest), noise


def calibrated_profile(profile_name, found, noise, remarks):
    """The text of the profile with the new calibration, and remarks as comments before it."""
    profile = _tactel._read_profile(str(profile_name))
    gain, offset, noises = list(profile["gain"]), list(profile["offset"]), list(profile["noise"])
    if not noises and np.isfinite(noise).any():
        noises = [0.0] * len(gain)
    for channel, new_gain, new_offset, of_frame in zip(profile["channel"], found.gain, found.offset, noise):
        if channel >= 0 and math.isfinite(of_frame):
            noises[channel] = float(of_frame)
        if channel >= 0 and math.isfinite(new_gain.value):
            gain[channel], offset[channel] = new_gain.value, new_offset.value
    kept, old, thresholds = [], False, []
    for line in profile["text"].splitlines():
        table = re.match(r"\s*\[([\w.]+)\]\s*(#.*)?$", line)
        old = table[1] == "calibration" if table else old
        if not old:
            kept.append(line)
        elif re.match(r"\s*(moved|slid)\s*=", line):
            thresholds.append(line.strip())
    kept += ["# " + re.sub(r"[\x00-\x1f\x7f]", " ", remark) for remark in remarks] + ["[calibration]"]
    if any(math.isfinite(one.value) for one in found.gain) or re.search(r"(?m)^\s*offset\s*=", profile["text"]):
        kept.append(f"offset = {offset}  # the device's units, at rest")
    kept.append(f"gain = {gain}  # MPa by the device's unit")
    if noises:
        kept.append(f"noise = {noises}  # the device's units, standard deviation at rest")
    return "\n".join(kept + thresholds) + "\n"
