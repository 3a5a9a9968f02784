# SPDX-License-Identifier: Apache-2.0
"""How well S can be read at all from the frames of a sweep's contacts: the floor of the mean of |error of S|.

    python -m tactel.floor SWEEP.toml --noise 0.01

The floor lies between two numbers.
Below: a bank of rows is drawn from the sweep, and a reading of one of them. The estimator knows the bank and asks only which
row it was: it answers the weighted median of S, with the density of the reading under each row as its weight, which no
estimator can beat there. To know the bank is to know more than the sweep: its error is below that of every estimator on the
sweep, and rises to the floor as the bank grows.
Above: the same weighted median, of readings of contacts that are not in the bank. That is an estimator, and its error is
therefore above the floor. Its weights are flattened by a factor, `spread`, that half of the readings choose; the other half
judge it.
Estimate: at little noise no bank is dense enough, and the two numbers stand far apart. Each row then has an estimate of its own
by derivatives of its frames and S by the drawn numbers, each over its range. It is no bound: it takes the shape, what is
chosen from a list and normal numbers as told, S as linear and the posterior as local. On pads it is too low by a factor of
about two; also where two shapes look alike, and where noise is large.
"""

import argparse
import glob
import itertools
import json
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from . import Cancelled, InputError, SlipEstimator, Sweep, __version__, _Progress, _tactel

SPREADS = 4.0 ** np.arange(8)
CHANGE = 1 / 64  #: of a number's range, for derivatives
REST = np.float32(0.05)  #: a frame below this share of the contact's largest stress ends the contact (nn/frame_history.h)
MOST_FRAMES = 64
CONTACTS = 4096  #: simulated at once
FAMILIES = {
    "indenter": None,
    "elements that touch": ("1", "2 to 4", "5 to 8", "9 to 15", "16 or more"),
    "tactels above 5 % of the largest": ("1 to 3", "4 to 6", "7 to 10", "11 or more"),
}
#: Of pads: 1 - |Q| / (mu P) / S in thirds, as tactel recall has it.
PAD_FAMILIES = {
    "indenter": None,
    "torque": ("S below 0.05", "torque below 1/3", "torque 1/3 to 2/3", "torque above 2/3"),
    "tactels above 5 % of the largest": FAMILIES["tactels above 5 % of the largest"],
}


@dataclass(frozen=True)
class Options:
    noise: float = 0.01  #: standard deviation of a reading's noise, over the largest |stress| of its frame or contact
    gain: float = 0.0  #: standard deviation of the transducers' gains about 1; they do not change along a contact
    noise_of_contact: bool = False
    history: int = 1  #: frames of a reading, as a network's input has them
    stride: int = 1
    change: float = 0.1
    bank: int = 200_000  #: rows, at least
    readings: int = 2000
    seed: int = 1  #: of noise and gains


@dataclass(frozen=True)
class Bank:
    """Rows of contacts with S."""

    frames: np.ndarray  #: [rows, history, inputs] MPa, newest frame first
    slip_index: np.ndarray  #: [rows]
    largest: np.ndarray  #: [rows] MPa, over which the noise is
    classes: np.ndarray  #: [families, rows] place in the family's classes

    def __len__(self):
        return len(self.slip_index)

    def take(self, rows):
        return Bank(self.frames[rows], self.slip_index[rows], self.largest[rows], self.classes[:, rows])


def _joined(banks):
    return Bank(*(np.concatenate([getattr(bank, name) for bank in banks], axis=-1 if name == "classes" else 0)
                  for name in ("frames", "slip_index", "largest", "classes")))


class LogDensity:
    """Logarithm of the density of readings under every row of a bank, but for (2 pi)^(-size/2).

    Reading m of transducer t is (1 + gain e_t) f_mt + sigma n_mt with normal e and n. For each transducer the covariance is
    sigma^2 I + gain^2 f f'; inverse and determinant by Sherman, Morrison (1950). With s = 1 / sigma^2, r = x - f and
    D_t = 1 + gain^2 s f_t.f_t it is

        -1/2 s sum_t (r_t.r_t - gain^2 s (r_t.f_t)^2 / D_t) - 1/2 sum_t ln D_t - size ln sigma,

    whose terms expand into products of what belongs to the reading and what belongs to the row: two or three matrix products,
    in fp64, which holds the differences of large terms down to a noise of 1e-3. Below that residuals are formed row by row.
    """

    def __init__(self, frames, sigma, gain):
        """frames: [rows, history, inputs] MPa; sigma: [rows] MPa."""
        f, s, gain2 = frames.astype(float), 1 / sigma**2, gain**2
        ff = np.einsum("bmt,bmt->bt", f, f)
        determinant = 1 + gain2 * s[:, None] * ff
        self._frames, self._over_variance, self._gain = f, s, gain2 * s[:, None] / determinant
        self._constant = -0.5 * np.log(determinant).sum(1) - f[0].size * np.log(sigma)
        self._expands = gain == 0 or bool(np.all(sigma >= 0.99e-3 * np.abs(f).max((1, 2))))
        if not self._expands:
            return
        linear = f if gain == 0 else f * (1 - (self._gain * ff))[:, None, :]
        own = ff - self._gain * ff**2
        self._terms = [s[:, None] * linear.reshape(len(f), -1)]
        self._constant = self._constant - 0.5 * s * own.sum(1)
        if gain > 0:
            self._terms += [0.5 * (s[:, None] * self._gain * f[:, m] * f[:, n] * (1 if m == n else 2)) for m, n in _pairs(f)]
        self._terms = np.concatenate([*self._terms, -0.5 * s[:, None]], axis=1).T.copy()

    def __call__(self, readings):
        """readings: [n, history, inputs] MPa. Returns [n, rows]."""
        x = readings.astype(float)
        if not self._expands:
            return np.stack([self._of(one) for one in x])
        terms = [x.reshape(len(x), -1)]
        if len(self._terms) > x[0].size + 1:
            terms += [x[:, m] * x[:, n] for m, n in _pairs(x)]
        terms.append(np.einsum("nmt,nmt->n", x, x)[:, None])
        return np.concatenate(terms, axis=1) @ self._terms + self._constant

    def _of(self, x):
        r = x - self._frames
        rf = np.einsum("bmt,bmt->bt", r, self._frames)
        return self._constant - 0.5 * self._over_variance * (np.einsum("bmt,bmt->b", r, r) - (self._gain * rf**2).sum(1))


def _pairs(frames):
    return list(itertools.combinations_with_replacement(range(frames.shape[1]), 2))


def draw_readings(bank, options, seed):
    """Readings of the bank's rows: [rows, history, inputs]. A frame of zeros, from before the contact, stays one."""
    random = np.random.default_rng(seed)
    rows, _, inputs = bank.frames.shape
    gains = 1 + options.gain * random.standard_normal((rows, 1, inputs))
    noise = options.noise * bank.largest[:, None, None] * random.standard_normal(bank.frames.shape)
    before = ~bank.frames.any(2)
    before[:, 0] = False
    return np.where(before[:, :, None], 0, gains * bank.frames + noise)


def weighted_median(values, weights):
    """The smallest value at or below which half of the weight lies. values: [n] increasing; weights: [k, n]. Returns [k]."""
    block = 512
    edges = np.arange(0, len(values), block)
    ends = np.cumsum(np.add.reduceat(weights, edges, axis=1, dtype=float), axis=1)
    half = 0.5 * ends[:, -1]
    # The block in which half of the weight is passed, then the row.
    passed = np.argmax(ends >= half[:, None], axis=1)
    found = np.empty(len(weights), dtype=int)
    for k, b in enumerate(passed):
        before = ends[k, b - 1] if b else 0.0
        inside = before + np.cumsum(weights[k, b * block:(b + 1) * block], dtype=float)
        found[k] = b * block + min(np.searchsorted(inside, half[k]), len(inside) - 1)
    return values[found]


def _error(errors):
    errors = np.asarray(errors)
    if len(errors) == 0:
        return {"mean": None, "standard_error": None, "readings": 0}
    return {"mean": float(errors.mean()), "standard_error": float(errors.std() / np.sqrt(len(errors))), "readings": len(errors)}


class _Sorted:
    """A bank by increasing S, with the densities of readings under its rows."""

    def __init__(self, bank, options):
        self.bank = bank.take(np.argsort(bank.slip_index, kind="stable"))
        self._density = LogDensity(self.bank.frames, options.noise * self.bank.largest, options.gain)
        self._members = [{kind: np.flatnonzero(family == kind) for kind in np.unique(family)} for family in self.bank.classes]
        self._at_once = int(np.clip(2**24 // len(bank), 1, 256))

    def errors(self, asked, readings, of_chunk, progress):
        """Calls of_chunk(rows, log densities less their largest, fp32) for chunks of the readings, from several threads."""
        places = [np.arange(k, min(k + self._at_once, len(asked))) for k in range(0, len(asked), self._at_once)]

        def one(rows):
            logs = self._density(readings[rows])
            if not np.isfinite(logs).all():
                raise ArithmeticError("a density is not finite")
            logs -= logs.max(1, keepdims=True)
            return of_chunk(rows, logs.astype(np.float32))

        with ThreadPoolExecutor(os.cpu_count()) as threads:
            found = []
            for rows, part in zip(places, threads.map(one, places)):
                found.append(part)
                if not progress(rows[-1] + 1, len(asked)):
                    raise Cancelled("floor: cancelled by progress")
        return np.concatenate(found, axis=-1)

    def below(self, asked, readings, progress):
        """[1 + families, readings]: in all, and told the class."""
        def of_chunk(rows, logs):
            weights = np.exp(logs)
            medians = np.empty((1 + len(self._members), len(rows)))
            medians[0] = weighted_median(self.bank.slip_index, weights)
            for f, members in enumerate(self._members):
                kinds = asked.classes[f, rows]
                for kind in np.unique(kinds):
                    those, rows_of_bank = np.flatnonzero(kinds == kind), members[kind]
                    medians[1 + f, those] = weighted_median(self.bank.slip_index[rows_of_bank], weights[np.ix_(those, rows_of_bank)])
            return np.abs(medians - asked.slip_index[rows])
        return self.errors(asked, readings, of_chunk, progress)

    def above(self, asked, readings, progress):
        """[spreads, readings]"""
        def of_chunk(rows, logs):
            medians = [weighted_median(self.bank.slip_index, np.exp(logs / np.float32(spread))) for spread in SPREADS]
            return np.abs(np.stack(medians) - asked.slip_index[rows])
        return self.errors(asked, readings, of_chunk, progress)


def _network_errors(networks, readings, asked, options):
    """|error of S| of each network, of |S| where it answers that. {file: [readings]}, NaN without an answer."""
    rows, history, inputs = readings.shape
    errors = {}
    for file, network in networks.items():
        width = network.inputs
        if network.metadata("target"):
            raise InputError(file, network.metadata("target"), "a network of slip_index")
        own = tuple(float(network.metadata(key) or default) for key, default in (("history", 1), ("stride", 1), ("history_change", 0.1)))
        if width not in (inputs, history * inputs):
            raise InputError(file, f"{width} inputs", f"a network of {inputs} inputs, as many as a frame")
        if width != inputs and own != (history, options.stride, options.change):
            raise InputError(file, "another history", f"--history {own[0]:g}:{own[1]:g} --history-change {own[2]:g}, or another network")
        answers = network(readings.reshape(rows, -1)[:, :width].astype(np.float32))
        truth = np.abs(asked.slip_index) if network.metadata("magnitude") else asked.slip_index
        errors[file] = np.abs(answers - truth)
    return errors


def floor_of(bank, outside, options, families=None, networks=None, progress=None):
    """The floor of a bank and of readings of rows outside of it: {"all", "classes", "convergence", ...} as `--json` has it.

    families: {name: names of classes} in the order of Bank.classes. networks: {file: SlipEstimator}."""
    if min(len(bank), len(outside)) < 2:
        raise InputError("bank", f"{min(len(bank), len(outside))} rows", "at least 2 rows")
    families, networks, start = families or {}, networks or {}, time.monotonic()
    random = np.random.default_rng(options.seed)

    def drawn(rows, count):
        return random.choice(rows, min(count, rows), replace=False)

    judged = outside.take(drawn(len(outside), 2 * options.readings))
    readings = draw_readings(judged, options, [options.seed, 1])
    second = slice(len(judged) // 2, None)  # the first half chooses the spread
    convergence, shares = [], (16, 4, 1)
    for part, share in enumerate(shares):
        def told(done, count, part=2 * part):
            return progress is None or progress(part * count + done, 2 * len(shares) * count) is not False
        some = _Sorted(bank.take(slice(max(len(bank) // share, 1))), options)
        asked = some.bank.take(drawn(len(some.bank), options.readings))
        below = some.below(asked, draw_readings(asked, options, [options.seed, 2]), told)
        above = some.above(judged, readings, lambda done, count, part=2 * part + 1: told(done, count, part))
        best = int(np.argmin(above[:, :len(judged) // 2].sum(1)))
        above = above[best, second]
        convergence.append({"bank_rows": len(some.bank), "lower": float(below[0].mean()), "upper": float(above.mean())})
    of_networks = {file: errors[second] for file, errors in _network_errors(networks, readings, judged, options).items()}

    def line(below, above, those=slice(None)):
        return {"lower": _error(below), "estimate": _error([]), "upper": _error(above),
                "networks": {file: _error(e[those][~np.isnan(e[those])]) for file, e in of_networks.items()}}

    classes = []
    for f, (family, names) in enumerate(families.items()):
        for kind, name in enumerate(names):
            told_rows, judged_rows = asked.classes[f] == kind, judged.classes[f, second] == kind
            if told_rows.any() or judged_rows.any():
                classes.append({"family": family, "class": name, "_place": (f, kind),
                                **line(below[1 + f, told_rows], above[judged_rows], judged_rows)})
    return {"noise": options.noise, "gain": options.gain, "noise_of": "contact" if options.noise_of_contact else "frame",
            "history": options.history, "stride": options.stride, "history_change": options.change, "bank_rows": len(bank),
            "spread": float(SPREADS[best]), "seed": options.seed, "seconds": time.monotonic() - start,
            "all": line(below[0], above), "classes": classes, "convergence": convergence}


def _kept(rows, frames, step, options):
    """Rows of the frames of each reading, [rows, history], -1 before the first: the rule of nn/frame_history.h."""
    found = np.full((len(rows), options.history), -1)
    kept, largest, last = [], np.float32(0), None
    for k, row in enumerate(rows):
        if last is not None and step[row] != last + 1:
            kept, largest = [], np.float32(0)
        last = step[row]
        most = np.abs(frames[row]).max()
        if most < REST * largest:
            kept, largest = [], np.float32(0)
        largest = max(largest, most)
        if not kept or np.abs(frames[row] - frames[kept[-1]]).max() > np.float32(options.change) * largest:
            kept.append(row)
        found[k, 0] = row
        for i in range(1, options.history):
            if i * options.stride < len(kept):
                found[k, i] = kept[-1 - i * options.stride]
    return found


def _collect(rows, options, every=1):
    """The bank of a Set's rows whose newest frame has normal stress, and the rows [bank rows, history] of its frames (-1: none).
    Contacts whose number is a multiple of `every` count."""
    frames, inputs = rows.frames, rows.frames.shape[1]
    answered = (rows.status != 2) & np.isfinite(rows.slip_index)
    edges = np.flatnonzero(np.diff(rows.contact, prepend=rows.contact[:1] - 1 if len(rows) else [], append=-1 if len(rows) else []))
    places, largest = [], []
    for first, end in zip(edges[:-1], edges[1:]):
        if rows.contact[first] % every:
            continue
        those = first + np.flatnonzero(answered[first:end])
        places.append(_kept(those, frames, rows.step, options) if options.history > 1 else those[:, None])
        if options.noise_of_contact:
            largest.append(np.full(len(those), np.abs(frames[first:end]).max()))
    places = np.concatenate(places) if places else np.empty((0, options.history), int)
    newest, normals = frames[places[:, 0]], inputs // rows.axes
    felt = newest[:, :normals].any(1)
    largest = (np.concatenate(largest) if largest else np.abs(newest).max(1, initial=0))[felt]
    places, newest = places[felt], newest[felt]
    normal = np.abs(newest[:, :normals])
    touching = (normal > 0.05 * normal.max(1, keepdims=True)).sum(1)
    at = places[:, 0]
    if rows.axes == 2:
        second = np.searchsorted([2, 5, 9, 16], rows.contact_nodes[at], "right")
    else:
        S = rows.slip_index[at]
        second = np.where(S < 0.05, 0, 1 + np.searchsorted([1 / 3, 2 / 3], 1 - rows.force_ratio[at] / np.maximum(S, 0.05)))
    classes = np.stack([rows.indenter[at], second, np.searchsorted([4, 7, 11], touching, "right")]).astype(np.int64)
    history = np.where((places >= 0)[:, :, None], frames[places], 0)
    return Bank(history, rows.slip_index[places[:, 0]].copy(), largest.astype(float), classes), places


def _estimates(rows, options, every):
    """Estimates of a Set's unchanged contacts: (errors, classes)."""
    bank, places = _collect(rows, options, every)
    errors = _tactel._linear_errors(rows, every, CHANGE, places, options.noise * bank.largest, options.gain)
    return np.asarray(errors), bank.classes


def measure(sweep, options=Options(), networks=None, device="", progress=None):
    """The floor of a sweep's contacts; a [transducer] of the sweep is not applied. networks: {file: SlipEstimator}.

    Raises InputError for a listed sweep, or where no row has normal stress."""
    if not sweep.endless:
        raise InputError(sweep.path, "sweep.set: a listed set", "left out: a floor draws its contacts (sweep.contacts)")
    batches = sweep._batches(CONTACTS, 0, True, None, "", "", device, None, False)
    contacts = 0

    def collect(count):
        nonlocal contacts
        parts, rows = [], 0
        while rows < count:
            if len(parts) > 64 and rows == 0:
                raise InputError(sweep.path, "no row with normal stress", "contacts that press on a tactel")
            parts.append(_collect(next(batches), options)[0])
            rows += len(parts[-1])
            contacts += CONTACTS
        return _joined(parts)

    bank, outside = collect(options.bank), collect(2 * options.readings)
    families = {name: names or sweep.indenter_names for name, names in (FAMILIES if sweep.axes == 2 else PAD_FAMILIES).items()}
    floor = floor_of(bank, outside, options, families, networks, progress)
    changed = sweep._changed(CHANGE)
    every = changed._changes
    errors, classes = np.empty(0), np.empty((len(families), 0), int)
    at_once = 128
    for rows in changed._batches(at_once * every, contacts * every, True, None, "", "fp64", device, 1e-8, False):
        more, kinds = _estimates(rows, options, every)
        errors, classes = np.concatenate([errors, more]), np.concatenate([classes, kinds], axis=1)
        if len(errors) >= options.readings:
            break
    floor["all"]["estimate"] = _error(errors)
    for one in floor["classes"]:
        f, kind = one.pop("_place")
        one["estimate"] = _error(errors[classes[f] == kind])
    return floor


def _text(error):
    return "-" if error["readings"] == 0 else f"{error['mean']:.4f} +- {error['standard_error']:.4f}"


def table(floor):
    """A line a class of contacts."""
    frames = floor["history"]
    networks = list(floor["all"]["networks"])

    def line(one, name):
        texts = [_text(one[key]) for key in ("lower", "estimate", "upper")] + [_text(one["networks"][file]) for file in networks]
        return f"{name:<34}" + "".join(f"{text:>18}" for text in texts)

    lines = [
        f"mean |error of S| that the frames allow: noise {floor['noise']:g}, gains {floor['gain']:g}, {frames} "
        f"frame{'s' if frames > 1 else ''}; a bank of {floor['bank_rows']} rows",
        'the floor lies between "below" (any estimator) and "above" (one estimator);',
        '"estimate" is by derivatives, and no bound', "",
        f"{'contacts':<34}" + "".join(f"{text:>18}" for text in ("below", "estimate", "above", *(f"network {i + 1}" for i in range(len(networks))))),
        line(floor["all"], "all")]
    for family, ones in itertools.groupby(floor["classes"], key=lambda one: one["family"]):
        lines += ["", family] + [line(one, "  " + one["class"]) for one in ones]
    lines += ["", "rows of the bank        below    above"]
    lines += [f"{step['bank_rows']:<20}{step['lower']:>9.4f}{step['upper']:>9.4f}" for step in floor["convergence"]]
    return "\n".join(lines + [f"network {i + 1}: {file}" for i, file in enumerate(networks)])


def skin_table(skins):
    """A line a skin: tactels, pitch, thickness, frames, noise, gains and the floor of all contacts."""
    networks = list(skins[0]["all"]["networks"])
    lines = [
        f"mean |error of S| that the frames allow; a bank of {min(skin['bank_rows'] for skin in skins)} rows or more",
        'the floor lies between "below" (any estimator) and "above" (one estimator);',
        '"estimate" is by derivatives, and no bound', "",
        "tactels  pitch   thickness  frames  noise   gains   below  estimate   above" + "".join(f"{f'network {i + 1}':>11}" for i in range(len(networks))),
        "            mm          mm"]
    for skin in skins:
        means = {key: skin["all"][key]["mean"] for key in ("lower", "estimate", "upper")}
        lines.append(f"{skin['tactels']:>7}{skin['pitch']:>7.3g}{skin['thickness']:>12.3g}{skin['history']:>8}{skin['noise']:>7.3g}{skin['gain']:>8.3g}"
                     f"{means['lower']:>8.4f}{means['estimate']:>10.4f}{means['upper']:>8.4f}"
                     + "".join(f"{skin['all']['networks'][file]['mean']:>11.4f}" for file in networks))
    return "\n".join(lines + [f"network {i + 1}: {file}" for i, file in enumerate(networks)])


def _number(kind, least, most):
    def read(text):
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{text}; {least:g} to {most:g}")
        return value
    return read


def _history(text):
    frames, _, stride = text.partition(":")
    try:
        found = int(frames), int(stride or 1)
    except ValueError:
        found = 0, 0
    if not (1 <= found[0] <= MOST_FRAMES and 1 <= found[1] <= 1000):
        raise argparse.ArgumentTypeError(f"{text}; frames, or frames:stride: 1 to {MOST_FRAMES} frames, a stride of 1 to 1000")
    return found


def _arguments(words):
    parser = argparse.ArgumentParser(
        prog="python -m tactel.floor", description="How well S can be read at all from the frames of a sweep: numbers below and "
        "above the smallest error.", epilog="Example: python -m tactel.floor examples/random_sweep.toml --noise 0.01")
    add = parser.add_argument
    add("sweep", metavar="SWEEP.toml", help="sweep file")
    add("--noise", action="append", type=_number(float, 1e-6, 10), help="standard deviation of a reading's noise, over the largest "
        "|stress| of --noise-of; repeatable (default: 0.01)")
    add("--noise-of", choices=("frame", "contact"), default="frame", help="frame: the newest frame; contact: all frames of the contact")
    add("--gain", action="append", type=_number(float, 0, 10), help="standard deviation of the transducers' gains about 1; they do not "
        "change along a contact; repeatable (default: 0)")
    add("--history", action="append", type=_history, metavar="K[:STRIDE]", help="frames of a reading, kept as those of a network's input; "
        "repeatable (default: 1)")
    add("--history-change", type=_number(float, 0, 1), help="with --history: change of load from one kept frame to the next, over the "
        "contact's largest stress (default: 0.1)")
    add("--tactels", action="append", type=_number(int, 2, 4096), help="number of tactels, instead of the file's; repeatable")
    add("--thickness", action="append", type=_number(float, 1e-9, 1e6), help="mm of rubber, instead of the file's; repeatable")
    add("--network", action="append", default=[], metavar="DIR|FILE.onnx", help="also judge these networks on the readings; repeatable")
    add("--bank", type=_number(int, 100, 100_000_000), default=Options.bank, help="rows of the bank; more rows narrow the gap (default: %(default)s)")
    add("--readings", type=_number(int, 10, 10_000_000), default=Options.readings, help="readings that are judged (default: %(default)s)")
    add("--seed", type=_number(int, 0, 2**64 - 1), default=1, help="of noise and gains (default: 1)")
    add("--json", metavar="FILE", help="write all numbers as JSON; - for standard output, instead of the table")
    add("--device", default="", metavar="NAME|INDEX", help="OpenCL device: a part of its name or its index")
    add("--quiet", action="store_true", help="print only errors and the result")
    given = parser.parse_args(words)
    several = any(frames > 1 for frames, _ in given.history or [])
    if given.history_change is not None and not several:
        parser.error("argument --history-change: given; left out, or with --history of 2 frames or more")
    return given


def _networks(paths):
    files = [file for path in paths for file in (sorted(glob.glob(os.path.join(path, "*.onnx"))) if os.path.isdir(path) else [path])]
    if paths and not files:
        raise InputError(paths[0], "no network", "a folder with files *.onnx, or one file")
    return {os.path.basename(file): SlipEstimator.load(file) for file in files}


def _run(given):
    def sweep_of(tactels, thickness):
        return Sweep(given.sweep, tactels=tactels, thickness=thickness)

    options = [Options(noise, gain, given.noise_of == "contact", *history, 0.1 if given.history_change is None else given.history_change,
                       given.bank, given.readings, given.seed)
               for history in given.history or [(1, 1)] for noise in given.noise or [0.01] for gain in given.gain or [0.0]]
    skins = list(itertools.product(given.tactels or [None], given.thickness or [None], options))
    sweeps = [sweep_of(tactels, thickness) for tactels, thickness, _ in skins]  # an error before minutes of work
    networks = _networks(given.network)
    floors = []
    with _Progress(not given.quiet, "floor", "readings") as show:
        for sweep, (_, _, option) in zip(sweeps, skins):
            def progress(done, count, before=len(floors)):
                return show and show(before * count + done, len(skins) * count)
            sensor = sweep.scene(0).sensor
            if sweep.axes == 2:
                span = sensor.length if sensor.tactel_span is None else sensor.tactel_span
                pitch = span / (sensor.tactels - 1)
            else:
                pitch = sensor.pitch[0]
            floors.append({"tactels": sweep.tactels, "pitch": pitch, "thickness": sensor.thickness,
                           **measure(sweep, option, networks, given.device, progress)})
    found = {"tactel": __version__, "sweep": given.sweep}
    if len(floors) == 1:
        found.update({key: value for key, value in floors[0].items() if key not in ("tactels", "pitch", "thickness")})
    else:
        found["skins"] = floors
    text = json.dumps(found, indent=2) + "\n"
    if given.json == "-":
        sys.stdout.write(text)
        return
    if given.json:
        with open(given.json, "w", encoding="utf-8") as file:
            file.write(text)
    print(table(found) if len(floors) == 1 else skin_table(floors))


def main(words=None):
    given = _arguments(words)
    try:
        _run(given)
    except (InputError, OSError) as error:
        print(f"tactel.floor: {error}", file=sys.stderr)
        return 2
    except (KeyboardInterrupt, Cancelled):
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
