# SPDX-License-Identifier: Apache-2.0
"""How well S can be read at all from the frames of a sweep's contacts: the floor of the mean of |error of S|.

    python -m tactel.floor SWEEP.toml --noise 0.01

A reading is a row of a contact of the sweep with noise. What it leaves open is the posterior of the contact's numbers, and no
estimator errs by less than the posterior's median of S does. The posterior is sampled with the simulator in every likelihood:
a bank of contacts gives each reading its walkers, tempering brings them to the posterior (Neal 2001), and differential evolution
moves them, one half by the differences of the other (ter Braak 2006).
Two numbers must meet: the mean of |S - median| over the posterior, and that of the |S - median| of the true S. The rank of the
true S in the posterior is uniform. Where either fails the sampling has not converged, and there is no floor.
"""
from __future__ import annotations

import argparse
import glob
import itertools
import json
import os
import sys
import time
from dataclasses import dataclass

import numpy as np

from . import Cancelled, SlipEstimator, Sweep, __version__, _Progress
from ._calls import exit_code, input_error, write_text

REST = np.float32(0.05)  #: a frame below this share of the contact's largest stress ends the contact (nn/frame_history.h)
MOST_FRAMES = 64
EFFECTIVE = 60  #: rows of the bank that share the weight at the first temperature
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
    bank: int = 60_000  #: contacts
    readings: int = 100
    walkers: int = 48  #: of a reading
    iterations: int = 100  #: of the tempering, and again of the sampling
    seed: int = 1
    friction_spread: float | None = None  #: standard deviation of log mu as a reading is told it; None: it is not told


@dataclass(frozen=True)
class Rows:
    """Rows of contacts with S, a contact's rows one after the other."""

    frames: np.ndarray  #: [rows, history, inputs] MPa, newest frame first
    slip_index: np.ndarray  #: [rows]
    largest: np.ndarray  #: [rows] MPa, over which the noise is
    contact: np.ndarray  #: [rows] place of the contact among those simulated
    classes: np.ndarray  #: [families, rows] place in the family's classes
    friction: np.ndarray | None = None  #: [rows] mu, needed where it is told

    def __len__(self):
        return len(self.slip_index)

    def take(self, rows):
        friction = None if self.friction is None else self.friction[rows]
        return Rows(self.frames[rows], self.slip_index[rows], self.largest[rows], self.contact[rows], self.classes[:, rows], friction)


def log_density(readings, frames, sigma, gain):
    """Logarithm of the density of readings under frames, but for (2 pi)^(-size/2). readings, frames: [rows, history, inputs]
    MPa; sigma: [rows] MPa. Returns [rows].

    Reading m of transducer t is (1 + gain e_t) f_mt + sigma n_mt with normal e and n. For each transducer the covariance is
    sigma^2 I + gain^2 f f'; inverse and determinant by Sherman, Morrison (1950). Frames of zeros, from before the contact, are
    read as zeros."""
    f = frames.astype(float)
    r = readings - f
    over_variance = 1 / sigma**2
    squares = np.einsum("rmt,rmt->r", r, r)
    log = -np.log(sigma) * f[0].size
    if gain > 0:
        gain2 = (gain**2 * over_variance)[:, None]
        determinant = 1 + gain2 * np.einsum("rmt,rmt->rt", f, f)
        squares -= (gain2 / determinant * np.einsum("rmt,rmt->rt", r, f) ** 2).sum(1)
        log -= 0.5 * np.log(determinant).sum(1)
    log -= 0.5 * over_variance * squares
    if f.shape[1] > 1:
        log[(readings.any(2) != f.any(2))[:, 1:].any(1)] = -np.inf
    return log


def draw_told(rows, options, random):
    """Logarithms of mu that readings of rows are told, [rows]; None where they are told none."""
    spread = options.friction_spread
    return None if spread is None else np.log(rows.friction) + spread * random.standard_normal(len(rows))


def draw_readings(rows, options, random):
    """Readings of rows: [rows, history, inputs]. A frame of zeros, from before the contact, stays one."""
    count, _, inputs = rows.frames.shape
    gains = 1 + options.gain * random.standard_normal((count, 1, inputs))
    noise = options.noise * rows.largest[:, None, None] * random.standard_normal(rows.frames.shape)
    before = ~rows.frames.any(2)
    before[:, 0] = False
    return np.where(before[:, :, None], 0, gains * rows.frames + noise)


class _Sampler:
    """Walkers of every reading, [readings, walkers, numbers]: quantiles of a contact's numbers."""

    def __init__(self, simulate, steady, readings, told, options, random):
        """simulate(quantiles [contacts, numbers]) returns Rows; steady: [numbers] of no choice; readings: [readings, history, inputs];
        told: [readings] log mu, or None."""
        self._simulate, self._steady, self._readings, self._told = simulate, np.asarray(steady), readings, told
        self._options, self._random = options, random

    def _log_told(self, reading, rows):
        """Logarithm of the density of the mu that is told of a reading, or of each of as many readings as rows."""
        if self._told is None:
            return 0
        return -0.5 * ((self._told[reading] - np.log(rows.friction)) / self._options.friction_spread) ** 2

    def _like(self, walkers):
        """Log likelihood and S [readings, walkers]. Every row of a contact may be the one that was read; S is that of one of
        them, drawn by the rows' densities."""
        count, each, numbers = walkers.shape
        log, S = np.full(count * each, -np.inf), np.full(count * each, np.nan)
        rows = self._simulate(walkers.reshape(-1, numbers))
        if len(rows):
            of_row = rows.contact // each
            density = log_density(self._readings[of_row], rows.frames, self._options.noise * rows.largest, self._options.gain)
            density = density + self._log_told(of_row, rows)
            first = np.flatnonzero(np.diff(rows.contact, prepend=-1))
            of = np.repeat(np.arange(len(first)), np.diff(first, append=len(rows)))
            most = np.maximum.reduceat(density, first)
            share = np.add.reduceat(np.exp(density - np.where(np.isfinite(most), most, 0)[of]), first)
            with np.errstate(divide="ignore"):
                log[rows.contact[first]] = np.where(np.isfinite(most), most + np.log(share), -np.inf)
            drawn = density + self._random.gumbel(size=len(density))
            chosen = np.lexsort((drawn, of))[np.append(first[1:], len(rows)) - 1]  # the largest of each contact
            S[rows.contact[first]] = rows.slip_index[chosen]
        return log.reshape(count, each), S.reshape(count, each)

    def start(self, quantiles, rows):
        """Walkers from a bank at the temperature at which some of its rows share the weight."""
        options, count = self._options, len(self._readings)
        flat = rows.frames.reshape(len(rows), -1).astype(float)
        squares, size = np.einsum("rk,rk->r", flat, flat), flat.shape[1]
        variance = (options.noise * rows.largest) ** 2 + options.gain**2 * squares / size
        self._walkers = np.empty((count, options.walkers, quantiles.shape[1]))
        self._power = np.empty(count)
        for q, x in enumerate(self._readings.reshape(count, -1)):
            log = -0.5 * (squares - 2 * flat @ x + x @ x) / variance - 0.5 * size * np.log(variance) + self._log_told(q, rows)
            log -= log.max()

            def effective(power):
                weight = np.exp(power * log)
                return weight.sum() ** 2 / (weight * weight).sum()
            low, high = 1e-9, 1.0
            if effective(1.0) >= EFFECTIVE:
                low = 1.0
            for _ in range(40):
                middle = np.sqrt(low * high)
                low, high = (middle, high) if effective(middle) > EFFECTIVE else (low, middle)
            weight = np.exp(low * log)
            self._power[q] = low
            self._walkers[q] = quantiles[rows.contact[self._random.choice(len(rows), options.walkers, p=weight / weight.sum())]]
        self._log, self._slip = self._like(self._walkers)

    def _resample(self, power):
        """From the temperatures so far to the next ones."""
        change = (power - self._power)[:, None] * np.where(np.isfinite(self._log), self._log, -1e300)
        weight = np.exp(change - change.max(1, keepdims=True))
        weight /= weight.sum(1, keepdims=True)
        walkers = self._options.walkers
        for q in np.flatnonzero((power > self._power) & (1 / (weight**2).sum(1) < 0.9 * walkers)):
            places = np.searchsorted(np.cumsum(weight[q]), (np.arange(walkers) + self._random.random()) / walkers).clip(0, walkers - 1)
            places = self._random.permutation(places)
            self._walkers[q], self._log[q], self._slip[q] = self._walkers[q, places], self._log[q, places], self._slip[q, places]
        self._power = power

    def _proposal(self, mine, others):
        """Steps by differences of the other half's walkers; of one proposal in eight a number drawn anew. Numbers are on a
        circle: a step beyond an end comes in at the other, which is as likely the other way round."""
        random, (count, each, numbers) = self._random, mine.shape
        first = random.integers(0, others.shape[1], (count, each))
        second = (first + random.integers(1, others.shape[1], (count, each))) % others.shape[1]
        step = np.take_along_axis(others, first[..., None], 1) - np.take_along_axis(others, second[..., None], 1)
        step = np.where(self._steady, (step + 0.5) % 1 - 0.5, 0)
        some = random.random(mine.shape) < random.choice([1.0, 0.6, 0.3], (count, each, 1))
        whole = random.random((count, each, 1))  # a whole step goes from mode to mode
        scale = np.where(whole < 0.1, 1.0, 2.38 / np.sqrt(2 * np.maximum(some.sum(2, keepdims=True), 1)) * random.uniform(0.3, 1.2, (count, each, 1)))
        moved = mine + np.where(some, scale * step, 0) + np.where(self._steady, 1e-4 * random.standard_normal(mine.shape), 0)
        anew = random.random((count, each)) < 0.125
        which = np.where(anew, random.integers(0, numbers, (count, each)), -1)[..., None] == np.arange(numbers)
        moved = np.where(anew[..., None], np.where(which, random.random(mine.shape), mine), moved) % 1
        return np.minimum(moved, np.nextafter(1.0, 0.0))

    def _sweep(self):
        half = self._options.walkers // 2
        for mine, others in ((slice(0, half), slice(half, None)), (slice(half, None), slice(0, half))):
            moved = self._proposal(self._walkers[:, mine], self._walkers[:, others])
            log, S = self._like(moved)
            old = self._log[:, mine]
            with np.errstate(invalid="ignore"):
                better = self._power[:, None] * (log - old)
            taken = np.isfinite(log) & (~np.isfinite(old) | (np.log(self._random.random(log.shape)) < better))
            self._walkers[:, mine] = np.where(taken[..., None], moved, self._walkers[:, mine])
            self._log[:, mine], self._slip[:, mine] = np.where(taken, log, old), np.where(taken, S, self._slip[:, mine])

    def run(self, progress):
        """Samples of S of the posterior: [readings, samples]."""
        first, count, samples = self._power.copy(), self._options.iterations, []
        for k in range(2 * count):
            if k < count:
                self._resample(first ** (1 - min((k + 1) / (0.7 * count), 1)))
            self._sweep()
            if k >= count and k % 2 == 0:
                samples.append(self._slip.copy())
            if not progress(k + 1, 2 * count):
                raise Cancelled("floor: cancelled by progress")
        return np.concatenate(samples, axis=1)


def _network_errors(networks, readings, asked, options):
    """|error of S| of each network, of |S| where it answers that. {file: [readings]}, NaN without an answer."""
    rows, history, inputs = readings.shape
    errors = {}
    for file, network in networks.items():
        width = network.inputs
        if network.metadata("target"):
            raise input_error(file, network.metadata("target"), "a network of slip_index")
        own = tuple(float(network.metadata(key) or default) for key, default in (("history", 1), ("stride", 1), ("history_change", 0.1)))
        if width not in (inputs, history * inputs):
            raise input_error(file, f"{width} inputs", f"a network of {inputs} inputs, as many as a frame")
        if width != inputs and own != (history, options.stride, options.change):
            raise input_error(file, "another history", f"--history {own[0]:g}:{own[1]:g} --history-change {own[2]:g}, or another network")
        answers = network(readings.reshape(rows, -1)[:, :width].astype(np.float32))
        truth = np.abs(asked.slip_index) if network.metadata("magnitude") else asked.slip_index
        errors[file] = np.abs(answers - truth)
    return errors


def _mean(errors):
    errors = np.asarray(errors)
    errors = errors[~np.isnan(errors)]
    if len(errors) == 0:
        return {"mean": None, "standard_error": None, "readings": 0}
    return {"mean": float(errors.mean()), "standard_error": float(errors.std() / np.sqrt(len(errors))), "readings": len(errors)}


def floor_of(simulate, steady, options, families=None, networks=None, progress=None):
    """The floor of contacts as functions of uniform numbers: {"all", "classes", "ranks", ...} as `--json` has it.

    simulate, steady: see _Sampler. families: {name: names of classes} in the order of Rows.classes. networks:
    {file: SlipEstimator}. progress(done, count) -> False: stop."""
    families, networks, start = families or {}, networks or {}, time.monotonic()
    random, numbers = np.random.default_rng(options.seed), len(steady)
    quantiles = random.random((options.bank, numbers))
    bank = simulate(quantiles)
    judged = simulate(random.random((4 * options.readings, numbers)))
    if min(len(bank), len(judged)) < 2:
        raise input_error("sweep", "no row with normal stress", "contacts that press on a tactel")
    asked = judged.take(np.sort(random.choice(len(judged), min(options.readings, len(judged)), replace=False)))
    readings = draw_readings(asked, options, random)
    sampler = _Sampler(simulate, steady, readings, draw_told(asked, options, random), options, random)
    sampler.start(quantiles, bank)
    samples = sampler.run(lambda done, count: progress is None or progress(done, count) is not False)
    median = np.median(samples, axis=1)
    posterior, true = np.abs(samples - median[:, None]).mean(1), np.abs(asked.slip_index - median)
    equal = samples == asked.slip_index[:, None]
    rank = (samples < asked.slip_index[:, None]).mean(1) + random.random(len(asked)) * equal.mean(1)
    ranks = np.histogram(rank, np.linspace(0, 1, 6))[0]
    expected = len(asked) / 5
    chi2 = ((ranks - expected) ** 2 / expected).sum()
    difference = _mean(posterior - true)
    of_networks = _network_errors(networks, readings, asked, options)

    def line(those=slice(None)):
        return {"estimate": _mean(posterior[those]), "true": _mean(true[those]),
                "networks": {file: _mean(errors[those]) for file, errors in of_networks.items()}}
    classes = [{"family": family, "class": name, **line(asked.classes[f] == kind)}
               for f, (family, names) in enumerate(families.items()) for kind, name in enumerate(names) if (asked.classes[f] == kind).any()]
    return {"noise": options.noise, "gain": options.gain, "noise_of": "contact" if options.noise_of_contact else "frame",
            "friction_spread": options.friction_spread,
            "history": options.history, "stride": options.stride, "history_change": options.change, "bank_contacts": options.bank,
            "walkers": options.walkers, "iterations": options.iterations, "seed": options.seed, "seconds": time.monotonic() - start,
            "all": line(), "classes": classes, "ranks": ranks.tolist(),
            "ranks_p": float(np.exp(-chi2 / 2) * (1 + chi2 / 2)),  # of chi squared with four degrees of freedom
            "difference": difference, "converged": bool(abs(difference["mean"]) <= 2 * difference["standard_error"])}


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


def _collect(rows, options):
    """The Rows of a Set whose newest frame has normal stress."""
    frames, inputs = rows.frames, rows.frames.shape[1]
    answered = (rows.status != 2) & np.isfinite(rows.slip_index)
    edges = np.flatnonzero(np.diff(rows.contact, prepend=rows.contact[:1] - 1 if len(rows) else [], append=-1 if len(rows) else []))
    at = np.flatnonzero(answered)
    largest = np.abs(frames[at]).max(1, initial=0)
    if options.noise_of_contact:
        largest = np.repeat(np.maximum.reduceat(np.abs(frames).max(1), edges[:-1]), np.diff(edges))[at] if len(at) else largest
    places = at[:, None]
    if options.history > 1:
        contacts = np.split(at, np.flatnonzero(np.diff(rows.contact[at])) + 1) if len(at) else []
        places = np.concatenate([np.empty((0, options.history), int)] + [_kept(those, frames, rows.step, options) for those in contacts])
    normals = inputs // rows.axes
    normal = np.abs(frames[at, :normals])
    felt = normal.any(1)
    at, places, largest, normal = at[felt], places[felt], largest[felt], normal[felt]
    touching = (normal > 0.05 * normal.max(1, keepdims=True)).sum(1)
    if rows.axes == 2:
        second = np.searchsorted([2, 5, 9, 16], rows.contact_nodes[at], "right")
    else:
        S = rows.slip_index[at]
        second = np.where(S < 0.05, 0, 1 + np.searchsorted([1 / 3, 2 / 3], 1 - rows.force_ratio[at] / np.maximum(S, 0.05)))
    classes = np.stack([rows.indenter[at], second, np.searchsorted([4, 7, 11], touching, "right")]).astype(np.int64)
    history = np.where((places >= 0)[:, :, None], frames[places], 0)
    return Rows(history, rows.slip_index[at].astype(float), largest.astype(float), rows.contact[at].astype(np.int64), classes,
                rows.friction[at].astype(float))


def _active(simulate, count, random):
    """Which numbers change a contact: those of a table that is never drawn, or of strokes that a path has not, do not."""
    contacts = 64
    quantiles = np.repeat(random.random((contacts, 1, count)), count + 1, axis=1)
    quantiles[:, np.arange(1, count + 1), np.arange(count)] = random.random((contacts, count))
    rows = simulate(quantiles.reshape(-1, count))
    mark = np.zeros(contacts * (count + 1))
    np.add.at(mark, rows.contact, np.abs(rows.frames).sum((1, 2)) + rows.slip_index)
    mark = mark.reshape(contacts, count + 1)
    return (mark[:, 1:] != mark[:, :1]).any(0)


def measure(sweep, options=Options(), networks=None, device="", progress=None, rung=""):
    """The floor of a sweep's contacts; a [transducer] of the sweep is not applied. networks: {file: SlipEstimator}. rung: as of
    Sweep.generate.

    Raises InputError for a listed sweep, or where no row has normal stress."""
    if not sweep.endless:
        raise input_error(sweep.path, "sweep.set: a listed set", "left out: a floor draws its contacts (sweep.contacts)")

    def simulate(quantiles):
        return _collect(next(sweep._of_quantiles(quantiles)._batches(len(quantiles), 0, True, {"rung": rung, "device": device}, False)), options)
    families = {name: names or sweep.indenter_names for name, names in (FAMILIES if sweep.axes == 2 else PAD_FAMILIES).items()}
    steady = np.array(sweep._numbers())
    active = _active(simulate, len(steady), np.random.default_rng(options.seed))

    def simulate_active(quantiles):
        every = np.full((len(quantiles), len(steady)), 0.5)
        every[:, active] = quantiles
        return simulate(every)
    return floor_of(simulate_active, steady[active], options, families, networks, progress)


def _text(error):
    return "-" if error["readings"] == 0 else f"{error['mean']:.4f} +- {error['standard_error']:.4f}"


NO_FLOOR = "no floor: the two numbers differ by more than two standard errors; more --iterations or --walkers bring them together"


def _verdict(floor):
    return [] if floor["converged"] else [NO_FLOOR]


def table(floor):
    """A line a class of contacts."""
    frames = floor["history"]
    networks = list(floor["all"]["networks"])

    def line(one, name):
        texts = [_text(one[key]) for key in ("estimate", "true")] + [_text(one["networks"][file]) for file in networks]
        return f"{name:<34}" + "".join(f"{text:>18}" for text in texts)

    told = "" if floor["friction_spread"] is None else f", mu told within {floor['friction_spread']:g}"
    lines = [
        f"mean |error of S| that the frames allow: noise {floor['noise']:g}, gains {floor['gain']:g}, {frames} "
        f"frame{'s' if frames > 1 else ''}{told}; {floor['all']['true']['readings']} readings",
        '"floor" is over the posterior of each reading, "true" of the true S: they must agree', "",
        f"{'contacts':<34}" + "".join(f"{text:>18}" for text in ("floor", "true", *(f"network {i + 1}" for i in range(len(networks))))),
        line(floor["all"], "all")]
    for family, ones in itertools.groupby(floor["classes"], key=lambda one: one["family"]):
        lines += ["", family] + [line(one, "  " + one["class"]) for one in ones]
    lines += ["", f"ranks of the true S, in fifths: {' '.join(map(str, floor['ranks']))} (p = {floor['ranks_p']:.2g})"]
    return "\n".join(lines + _verdict(floor) + [f"network {i + 1}: {file}" for i, file in enumerate(networks)])


def skin_table(skins):
    """A line a skin: tactels, pitch, thickness, frames, noise, gains, mu as it is told, and the floor of all contacts."""
    networks = list(skins[0]["all"]["networks"])
    lines = [
        f"mean |error of S| that the frames allow; {skins[0]['all']['true']['readings']} readings",
        '"floor" is over the posterior of each reading, "true" of the true S: they must agree', "",
        "tactels  pitch   thickness  frames  noise   gains  mu told" + f"{'floor':>18}{'true':>18}"
        + "".join(f"{f'network {i + 1}':>11}" for i in range(len(networks))), "            mm          mm"]
    for skin in skins:
        told = "no" if skin["friction_spread"] is None else f"{skin['friction_spread']:.3g}"
        lines.append(f"{skin['tactels']:>7}{skin['pitch']:>7.3g}{skin['thickness']:>12.3g}{skin['history']:>8}{skin['noise']:>7.3g}{skin['gain']:>8.3g}{told:>9}"
                     f"{_text(skin['all']['estimate']):>18}{_text(skin['all']['true']):>18}"
                     + "".join(f"{skin['all']['networks'][file]['mean']:>11.4f}" for file in networks) + "".join(f"  {text[:8]}" for text in _verdict(skin)))
    if not all(skin["converged"] for skin in skins):
        lines.append(NO_FLOOR)
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
        prog="python -m tactel.floor", description="How well S can be read at all from the frames of a sweep: the smallest mean "
        "error, by sampling the posterior of each reading.", epilog="Example: python -m tactel.floor examples/random_sweep.toml --noise 0.01")
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
    add("--friction-spread", action="append", type=_number(float, 1e-3, 10), help="tell each reading its mu, but for a factor "
        "whose logarithm has this standard deviation; repeatable (default: mu is not told)")
    add("--tactels", action="append", type=_number(int, 2, 4096), help="number of tactels, of a pad along each side of the "
        "same area, instead of the file's; repeatable")
    add("--thickness", action="append", type=_number(float, 1e-9, 1e6), help="mm of rubber, instead of the file's; repeatable")
    add("--network", action="append", default=[], metavar="DIR|FILE.onnx", help="also judge these networks on the readings; repeatable")
    add("--readings", type=_number(int, 10, 10_000_000), default=Options.readings, help="readings that are judged (default: %(default)s)")
    add("--bank", type=_number(int, 100, 100_000_000), default=Options.bank, help="contacts that walkers begin from (default: %(default)s)")
    add("--walkers", type=_number(int, 8, 10_000), default=Options.walkers, help="of each reading (default: %(default)s)")
    add("--iterations", type=_number(int, 10, 1_000_000), default=Options.iterations, help="of the tempering, and again of the sampling "
        "(default: %(default)s)")
    add("--seed", type=_number(int, 0, 2**64 - 1), default=1, help="of contacts, noise and walkers (default: 1)")
    add("--json", metavar="FILE", help="write all numbers as JSON; - for standard output, instead of the table")
    add("--rung", default="", metavar="NAME", help="model of the contacts, as of tactel generate")
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
        raise input_error(paths[0], "no network", "a folder with files *.onnx, or one file")
    return {os.path.basename(file): SlipEstimator.load(file) for file in files}


def _run(given):
    def sweep_of(tactels, thickness):
        return Sweep(given.sweep, tactels=tactels, thickness=thickness)

    options = [Options(noise, gain, given.noise_of == "contact", *history, 0.1 if given.history_change is None else given.history_change,
                       given.bank, given.readings, given.walkers, given.iterations, given.seed, spread)
               for history in given.history or [(1, 1)] for noise in given.noise or [0.01] for gain in given.gain or [0.0]
               for spread in given.friction_spread or [None]]
    skins = list(itertools.product(given.tactels or [None], given.thickness or [None], options))
    sweeps = [sweep_of(tactels, thickness) for tactels, thickness, _ in skins]  # an error before minutes of work
    networks = _networks(given.network)
    floors = []
    with _Progress(not given.quiet, "floor", "iterations") as show:
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
                           **measure(sweep, option, networks, given.device, progress, given.rung)})
    found = {"tactel": __version__, "sweep": given.sweep}
    if len(floors) == 1:
        found.update({key: value for key, value in floors[0].items() if key not in ("tactels", "pitch", "thickness")})
    else:
        found["skins"] = floors
    text = json.dumps(found, indent=2) + "\n"
    if given.json == "-":
        sys.stdout.write(text)
        return 0 if all(one["converged"] for one in floors) else 4
    if given.json:
        write_text(given.json, text)
    print(table(found) if len(floors) == 1 else skin_table(floors))
    return 0 if all(one["converged"] for one in floors) else 4


def main(words=None):
    return exit_code("floor", _run, _arguments(words))


if __name__ == "__main__":
    sys.exit(main())
