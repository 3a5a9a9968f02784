# SPDX-License-Identifier: Apache-2.0
"""Fits gains, offsets and rubber of a sensor to readings of known presses, or chooses presses. Needs the package scipy of PyPI.

    python -m tactel.calibrate plan board.toml --scene press.toml --output plan.toml
    python -m tactel.calibrate sensor presses.toml --profile board.toml --output calibrated.toml

reading = offset + stress / gain of each transducer; the numbers of the rubber move the stress. solve_many answers at places of a
grid of these numbers, and between them the stress is a parabola in each: least_squares fits that with all gains and offsets, and the
grid follows until its middle is nearest. Every press is then solved on twice the elements; 0.35 of the difference counts as left.
A number that is held is one more column of the Jacobian. It is judged alone by a score test, one Newton step: from 4 standard
deviations on, it is named, and its step is a deviation, to which the deviations of all that is fitted answer."""

import argparse
import html
import io
import json
import math
import sys
from dataclasses import dataclass

import numpy as np

from . import InputError, Sides, __version__
from ._calls import exit_code, input_error, write_text
from ._known_presses import Grid, Options, Press, amplifier_response, by_force, is_pad, press_numbers, sensed, sensor_numbers, transducers
from ._press_files import calibrated_profile, read_presses
from ._press_plan import plan_command

OUTLIER = 3  # standard deviations, from which Huber's loss is linear
TRUST = 4  # steps of the grid that a fit may go at once
MODEL_ERROR_LEFT = 0.35  # of what twice the elements change: a further doubling changes 0.29 to 0.37 of it
ERROR_GROUPS = 16  # of presses, most: errors of presses differ in sign
MISFIT_FROM = 4  # standard deviations of a held number
UNJUDGED = 1e-6  # of the information on a number, left by the fitted ones: too little
DEGENERATE = 0.98  # correlation from which two numbers are not told apart
NOT_TOLD = 0.9  # of a friction's deviation before the fit
SWAPPED_SHARE = 0.25  # of its own squared residuals that a channel has on the other's stress
DEAD_SIGNAL = 20  # standard deviations that a working channel would have shown
WRONG_PRESS = 3  # times the median press's residual
WRONG_INDENTER, MODEL_ERROR = 2, 0.02  # times noise at rest and this share of a signal: what a bench knows
MISFIT = 1.25  # times noise at rest, which few frames tell up to 7 % too small
UNSURE_OFFSET = 0.5  # deviation of an offset over the noise at rest, from which it may pass for a shift (live/drift_watch.h)
PATIENCE, MOST_TURNS = 8, 30


@dataclass(frozen=True)
class Fault:
    kind: str  #: dead_channel, swapped_channels, saturated, wrong_press, wrong_indenter, model_misfit
    text: str


@dataclass(frozen=True)
class Fitted:
    value: float
    deviation: float = 0.0  #: 0: held fixed

    def within(self, true, deviations=2.0):
        return abs(self.value - true) <= deviations * self.deviation


@dataclass
class Calibration:
    converged: bool
    iterations: int
    numbers: dict  #: Fitted of young, poisson, thickness, shift, of a pad shift_y, time_constant
    friction: list  #: [presses] Fitted
    gain: list  #: [transducers] Fitted, MPa by the device's unit; NaN: left out
    offset: list
    noise: np.ndarray  #: [transducers] standard deviation of the residuals, the device's units
    fitted: list  #: names
    correlation: np.ndarray  #: [fitted, fitted]
    held: list  #: sentences: what is held fixed, and why
    faults: list
    residuals: list  #: [presses] [steps, transducers] reading less model over noise; NaN: left out
    names: list  #: of the transducers


def _scipy():
    try:
        import scipy.optimize
    except ImportError:
        raise input_error("scipy", "not installed", "install it: pip install scipy") from None
    return scipy.optimize


# The fit


def _huber(residuals):
    """Weights of residuals, 0 of those that are not there."""
    size = np.abs(np.nan_to_num(residuals))
    return np.where(np.isnan(residuals), 0, np.minimum(1, OUTLIER / np.maximum(size, OUTLIER)))


def _rms(values):
    return float(np.sqrt(np.nanmean(values**2))) if np.isfinite(values).any() else math.nan


def _lines(x, y):
    """Fits offset and sensitivity of each column of y [rows, columns] to that of x; unexplained squares. NaN of y count for nothing."""
    there = np.isfinite(y)
    n = np.maximum(there.sum(0), 1)
    x0, y0 = np.where(there, x, 0), np.where(there, y, 0)
    dx, dy = np.where(there, x - x0.sum(0) / n, 0), np.where(there, y - y0.sum(0) / n, 0)
    squares, product = (dx * dx).sum(0), (dx * dy).sum(0)
    told = squares > 1e-12 * np.maximum((x0 * x0).sum(0), 1e-300)
    sensitivity = np.where(told, product / np.where(told, squares, 1), 0)
    return (y0.sum(0) - sensitivity * x0.sum(0)) / n, sensitivity, (dy * dy).sum(0) - sensitivity * product, squares


class _Fit:
    """The unknowns are x: amounts of the fitted numbers from the middle of the grid, then offsets and sensitivities (1 / gain) of the
    transducers that are used."""

    def __init__(self, presses, options):
        if not presses:
            raise input_error("presses", "none", "must be at least one known press")
        self.presses, self.options, self.names = list(presses), options, [press.name for press in presses]
        first = presses[0].scene
        self.pad, self.of = is_pad(first), transducers(first)
        for press in presses:
            shape = np.shape(press.readings)
            if is_pad(press.scene) != self.pad:
                raise input_error(f"{press.name}: scene", "its sensor is of another kind", f"must be that of {presses[0].name}")
            if self.pad and press.scene.sensor.layers:
                raise input_error(f"{press.name}: scene", "its sensor has layers", "must be of one layer: a calibration finds its thickness, E and nu")
            if len(shape) != 2 or shape[1] != len(self.of) or (press.P is not None and np.shape(press.P) != shape[:1]):
                raise input_error(f"{press.name}: readings", f"an array of {shape}", f"must have a row for each load step, and {len(self.of)} columns")
        # Free sides of a pad would take a kernel for each Poisson's ratio and thickness.
        self.scenes = [sensed(press.scene, sides=Sides.held) if self.pad else press.scene for press in presses]
        self.rungs = options.rungs or (("pad-12", "pad-24") if self.pad else ("patch-12", "patch-24"))
        self.value = np.vstack([np.asarray(press.readings, float) for press in presses])
        self.P = np.concatenate([np.full(len(p.readings), math.nan) if p.P is None else np.asarray(p.P, float) for p in presses])
        self.P[~(self.P > 0)] = math.nan
        self.used, self.press_used = np.ones(len(self.of), bool), np.ones(len(presses), bool)
        self.sensor, self.numbers = sensor_numbers(first, options, len(presses)), []
        self.faults, self.held, self.iterations, self.force_noise, self.correction = [], [], 0, options.force_noise, None
        self.middle = self.grid()
        for press, rows in zip(presses, self.middle.rows):
            if rows.stop - rows.start != len(press.readings):
                raise input_error(f"{press.name}: readings", f"{len(press.readings)} rows", f"must have {rows.stop - rows.start}, one for each load step")

    def grid(self, others=(), rung=0):
        """The grid at its present place, with parabolas in the fitted numbers and others."""
        return Grid(self.scenes, [press.timing for press in self.presses], self.names, self.options.time_constant, [*self.numbers, *others], self.rungs[rung])

    def over_measured(self, forces):
        """Mean of forces over those measured, [presses]: the gauge's error is one for all forces of a press. NaN: none is measured."""
        share = forces / self.P
        return np.array([np.nanmean(share[rows]) if np.isfinite(share[rows]).any() else math.nan for rows in self.middle.rows])

    def model(self, x):
        """Frames and forces, their derivatives by the numbers, offset and sensitivity of every transducer."""
        m, c = len(self.numbers), int(self.used.sum())
        frame, P, slopes = self.middle.at(x[:m])
        if self.correction is not None:
            E, more, more_P = self.correction
            for k, number in enumerate(self.numbers):
                if number.key == "young":  # it scales the correction, too: or a finer model would seem to tell E
                    scale = number.value(number.amount + x[k]) / E
                    more, more_P = scale * more, scale * more_P
                    slopes[k] = slopes[k][0] + more, slopes[k][1] + more_P
            frame, P = frame + more, P + more_P
        offset, sensitivity = np.full((2, len(self.of)), math.nan)
        offset[self.used], sensitivity[self.used] = x[m:m + c], x[m + c:]
        return frame, P, slopes, offset, sensitivity

    def left(self, x):
        """Reading less model over noise, [rows, transducers]; NaN: left out."""
        frame, _, _, offset, sensitivity = self.model(x)
        return (self.value - offset - sensitivity * frame) / self.noise

    def told(self):
        return [number for number in self.numbers if number.deviation > 0]

    def residuals(self, x):
        """Of readings, of forces, and of what is told of numbers."""
        of_forces = (1 - self.over_measured(self.model(x)[1])) / self.force_noise
        told = [(n.amount + d) / n.deviation for n, d in zip(self.numbers, x) if n.deviation > 0]
        return np.concatenate([self.left(x)[self.mask], of_forces[np.isfinite(of_forces)], told])

    def column(self, frame_by, P_by, sensitivity):
        """Derivatives of the residuals by what moves frames and forces."""
        of_forces = -self.over_measured(P_by) / self.force_noise
        return np.concatenate([(-sensitivity * frame_by / self.noise)[self.mask], of_forces[np.isfinite(of_forces)], np.zeros(len(self.told()))])

    def jacobian(self, x):
        frame, _, slopes, _, sensitivity = self.model(x)
        transducer, m, c = np.nonzero(self.mask)[1], len(self.numbers), int(self.used.sum())
        all_, told = np.zeros((len(self.residuals(x)), m + 2 * c)), self.told()
        for k, slope in enumerate(slopes):
            all_[:, k] = self.column(*slope, sensitivity)
        for k, number in enumerate(told):
            all_[k - len(told), self.numbers.index(number)] = 1 / number.deviation
        row, place = np.arange(len(transducer)), m + (np.cumsum(self.used) - 1)[transducer]
        all_[row, place] = -1 / self.noise[transducer]
        all_[row, place + c] = -frame[self.mask] / self.noise[transducer]
        return all_

    def choose(self):
        """E and gains are told apart where depth and force of a press are known, or where some presses have one and some the other."""
        force = np.array([by_force(scene) for scene in self.scenes])
        measured = np.isfinite(self.over_measured(self.P))
        used = self.press_used
        told = (used & ~force & measured).any() or ((used & force).any() and (used & ~force).any())
        why = {"young": "no press has both depth and force, and a softer rubber reads as smaller gains", "poisson": "not asked for",
               "thickness": "not asked for" if self.pad else "it and sensor.poisson change frames nearly alike, so measure it"}
        fits = [asked and (told or number.key != "young") for number, asked in self.sensor]
        self.held = [f"sensor.{number.key} is held: {why[number.key]}" for (number, _), fit_ in zip(self.sensor, fits) if not fit_ and number.key in why]
        places = {number.name: number.place for number in self.numbers}
        frictions, self.others = press_numbers(self.scenes, self.options, self.names, used)
        self.numbers = [number for (number, _), fit_ in zip(self.sensor, fits) if fit_] + frictions
        self.others = [number for (number, _), fit_ in zip(self.sensor, fits) if not fit_ and number.key in ("thickness", "shift", "shift_y")] + self.others
        for number in frictions:
            number.place = places.get(number.name, 0)

    def settle(self, optimize):
        """Fits about the middle of the grid, which follows, until it is nearest. Returns whether it did."""
        self.noise = None
        for turn in range(MOST_TURNS):
            self.iterations += 1
            self.middle = self.grid()
            frame = self.middle.frame + (0 if self.correction is None else self.correction[1])
            offset, sensitivity, unexplained, squares = _lines(frame, self.value)
            for channel in np.flatnonzero(self.used & ~(squares > 0)):
                self.leave_out(channel, "no press changes its stress; it has no gain")
            count, least = np.maximum(np.isfinite(self.value).sum(0) - 2, 1), 1e-12 * np.maximum(1, np.abs(offset))
            if self.noise is None:
                self.noise = np.maximum(np.sqrt(np.maximum(unexplained, 0) / count), least)
            self.mask = self.used & np.isfinite(self.value)
            low, high = ([pick(sign * TRUST * n.step, end(n) - n.amount) for n in self.numbers] for pick, sign, end in
                         ((max, -1, lambda n: n.least), (min, 1, lambda n: n.most)))
            free = [math.inf] * (2 * int(self.used.sum()))
            first = np.concatenate([np.clip(np.zeros(len(low)), low, high), offset[self.used], sensitivity[self.used]])
            found = optimize.least_squares(self.residuals, first, self.jacobian, x_scale="jac", loss="huber", f_scale=OUTLIER,
                                           bounds=(low + [-one for one in free], high + free))
            self.x, left = found.x, self.left(found.x)
            self.noise = np.maximum(self.noise * np.sqrt(np.nansum(_huber(left) * left**2, 0) / count), least)
            moved = [number.follow(d, turn >= PATIENCE) for number, d in zip(self.numbers, self.x)]
            if turn >= 2 and not any(moved):
                return bool(found.success)
        return False

    # Faults

    def fault(self, kind, text):
        self.faults.append(Fault(kind, text))

    def leave_out(self, channel, why):
        self.used[channel] = False
        self.fault("dead_channel", f"{self.of[channel]}: {why}")

    def find_constant_and_saturated(self):
        for c, name in enumerate(self.of):
            column = self.value[:, c]
            there = np.isfinite(column)
            end = there & ~((column > self.options.lowest_reading) & (column < self.options.highest_reading))
            if not there.any() or np.ptp(column[there]) == 0:
                self.leave_out(c, ("the reading never changes" if there.any() else "no readings") + "; it has no gain")
            elif end.any():
                column[end] = math.nan
                self.fault("saturated", f"{name}: {end.sum()} of {there.sum()} readings are at an end of the converter's range and left out")

    def find_swapped(self):
        best = {}
        for c in np.flatnonzero(self.used):
            left = np.where(self.used, _lines(self.middle.frame, np.repeat(self.value[:, [c]], len(self.of), 1))[2], math.inf)
            if left.min() < SWAPPED_SHARE * left[c]:
                best[c] = int(left.argmin())
        for c, d in best.items():
            if d > c and best.get(d) == c:
                self.used[[c, d]] = False
                self.fault("swapped_channels", f"{self.of[c]} and {self.of[d]} are swapped: each reads as the other should; exchange them in [channels]")

    def find_dead(self):
        frame, sensitivity = self.middle.frame, self.model(self.x)[4]
        squares, usual = _lines(frame, self.value)[3], np.nanmedian(np.abs(sensitivity))
        for c in np.flatnonzero(self.used):
            if abs(sensitivity[c]) <= 3 * self.noise[c] / math.sqrt(squares[c]) and usual * np.ptp(frame[:, c]) >= DEAD_SIGNAL * self.noise[c]:
                self.leave_out(c, "the reading does not follow the stress; it has no gain")

    def find_wrong_press(self):
        """The press with another indenter, depth or place than it says. Returns whether there is one."""
        left = self.left(self.x)
        sizes = np.array([_rms(left[rows]) for rows in self.middle.rows])
        usual, i = np.nanmedian(sizes), int(np.nanargmax(sizes))
        if np.isfinite(sizes).sum() < 4 or not sizes[i] > WRONG_PRESS * usual or 3 * ((~self.press_used).sum() + 1) > len(sizes):
            return False
        self.press_used[i] = False
        self.value[self.middle.rows[i]] = self.P[self.middle.rows[i]] = math.nan
        self.fault("wrong_press", f"{self.names[i]}: residuals {sizes[i] / usual:.1f} times those of the other presses; its indenter, depth or place is "
                   "another; left out")
        return True

    def find_misfit(self, better):
        """What the readings ask to change; without any of that, residuals beyond the noise at rest; a wrong indenter of all presses."""
        def over_rest(share):
            frame, sensitivity = self.model(self.x)[0], self.model(self.x)[4]
            expected = np.hypot(self.options.rest_noise, share * sensitivity * frame.std(0)) / self.noise
            over = self.left(self.x) / np.where(expected > 0, expected, math.nan)
            return np.array([_rms(over[rows]) for rows in self.middle.rows]), _rms(over)
        rest = self.options.rest_noise is not None
        of_presses, over = over_rest(0) if rest else ([], 0)
        if not better and over > MISFIT:
            worst = int(np.nanargmax(of_presses))
            better = [f"residuals are {over:.1f} times the noise at rest, {of_presses[worst]:.1f} times in {self.names[worst]}: thickness? indenter? tilt?"]
        if better:
            self.fault("model_misfit", "the model does not fit: " + "; ".join(better[:3]))
        over = over_rest(MODEL_ERROR)[1] if rest else 0
        if over > WRONG_INDENTER:
            self.fault("wrong_indenter", f"residuals are {over:.1f} times what noise at rest and {100 * MODEL_ERROR:g} % of the stress explain: all presses "
                       "have another indenter, friction or place")

    # Deviations

    def find_correction(self):
        """What twice the elements change."""
        try:
            finer = self.grid(rung=1)
        except InputError as error:
            self.held.append(f"the model's error is not known, and not counted: {error.place}: {error.problem}")
            return
        d = self.x[:len(self.numbers)]
        E = next(number.value(number.amount + sum(d for d, one in zip(self.x, self.numbers) if one is number)) for number, _ in self.sensor if number.key == "young")
        self.correction = [E, *(fine - coarse for fine, coarse in zip(finer.at(d)[:2], self.middle.at(d)[:2]))]

    def weaken_forces(self):
        """Forces that scatter by more than their noise have that of their scatter."""
        off = (1 - self.over_measured(self.model(self.x)[1])) / self.force_noise
        if np.isfinite(off).sum() > 1:
            self.force_noise *= math.sqrt(max(1, np.nansum(_huber(off) * off**2) / (np.isfinite(off).sum() - 1)))

    def errors(self, sensitivity):
        """Columns of the model's error: presses differ in its sign, so that each group has its own."""
        columns = []
        for group in range(0 if self.correction is None else min(ERROR_GROUPS, len(self.presses))):
            frame, P = (np.zeros_like(part) for part in self.correction[1:])
            for rows in self.middle.rows[group::ERROR_GROUPS]:
                frame[rows], P[rows] = self.correction[1][rows], self.correction[2][rows]
            columns.append(self.column(frame, P, sensitivity))
        return columns

    def answered(self):
        """The grid with those held numbers of which the model has other answers."""
        try:
            return self.grid(self.others)
        except InputError:
            for number in list(self.others):
                try:
                    self.grid([number])
                except InputError as error:
                    self.others.remove(number)
                    self.held.append(f"{number.name} is not judged: {error.place}: {error.problem}")
            return self.grid(self.others)

    def judge(self):
        """Covariance of x, and sentences on held numbers that the readings ask to change, the largest first."""
        sensitivity = self.model(self.x)[4]
        grid = self.answered()
        slopes = grid.at(np.concatenate([self.x[:len(self.numbers)], np.zeros(len(self.others))]))[2][len(self.numbers):]
        residuals = self.residuals(self.x)
        root = np.sqrt(_huber(residuals))
        J = self.jacobian(self.x) * root[:, None]
        H = np.array([self.column(*slope, sensitivity) for slope in slopes] + self.errors(sensitivity)).reshape(-1, len(root)).T * root[:, None]
        scale = np.maximum(np.linalg.norm(J, axis=0), 1e-300)
        inverse = np.linalg.pinv(J / scale) / scale[:, None]
        answer = -inverse @ H  # of x to the others
        alone = H + J @ answer  # what x leaves of them
        size, slope, count = np.linalg.norm(alone, axis=0), alone.T @ (root * residuals), len(self.others)
        deviations = np.array([number.deviation for number in self.others] + [MODEL_ERROR_LEFT] * (H.shape[1] - count))
        found = []
        for j, number in enumerate(self.others):
            if not number.name or not size[j] ** 2 > UNJUDGED * (H[:, j] @ H[:, j]):
                continue
            step = -slope[j] / size[j] ** 2
            over = abs(slope[j]) / np.hypot(size[j], MODEL_ERROR_LEFT * np.linalg.norm(alone[:, count:].T @ alone[:, j]))
            if over > MISFIT_FROM:
                deviations[j] = abs(step)
                found.append((over, f"{number.name}{self.of_presses(number.presses)}? the readings ask for {number.start + step:.3g}{number.unit}, "
                              f"not {number.start:.3g}{number.unit} ({over:.0f} standard deviations)"))
        return inverse @ inverse.T + (answer * deviations**2) @ answer.T, [sentence for _, sentence in sorted(found, key=lambda one: -one[0])]

    def of_presses(self, presses):
        own = [name for name, has in zip(self.names, presses) if has]
        return "" if (presses == self.press_used).all() else " of " + ", ".join(own[:2]) + (f" and {len(own) - 2} more" if len(own) > 2 else "")

    def spreads(self):
        """How much wider frictions may be off than their covariance says, 1 or more: where the contact no longer slides, a larger one
        changes nothing. By the readings' change over twice the deviation, all else held."""
        told, size = self.told(), np.linalg.norm(self.jacobian(self.x), axis=0)
        sizes = [size[self.numbers.index(number)] for number in told]
        far = [min(2 / max(one, 1e-300), 2 * number.deviation) for number, one in zip(told, sizes)]
        for number, distance in zip(told, far):
            number.place += distance / number.step
        grid, sensitivity = self.grid() if told else self.middle, self.model(self.x)[4]
        spreads = {}
        for number, distance, one in zip(told, far, sizes):
            number.place = round(number.place - distance / number.step)
            own = np.concatenate([np.full(rows.stop - rows.start, has) for rows, has in zip(grid.rows, number.presses)])
            change = self.column((grid.frame - self.middle.frame) * own[:, None], (grid.P - self.middle.P) * own, sensitivity)
            spreads[number.name] = max(1, distance * one / max(np.linalg.norm(change), 1e-300))
        return spreads

    def run(self):
        optimize = _scipy()
        self.find_constant_and_saturated()
        self.find_swapped()
        self.choose()
        self.settle(optimize)
        self.find_dead()
        settled = self.settle(optimize)
        while self.find_wrong_press():
            self.choose()
            settled = self.settle(optimize)
        self.find_correction()
        settled = self.settle(optimize) and settled
        self.weaken_forces()
        covariance, better = self.judge()
        self.find_misfit(better)
        return self.report(settled, covariance)

    def report(self, settled, covariance):
        m, c, deviation = len(self.numbers), int(self.used.sum()), np.sqrt(np.diag(covariance))
        friction, spreads, hardly = [Fitted(scene.friction) for scene in self.scenes], self.spreads(), []
        numbers = {number.key: Fitted(number.value(0)) for number, _ in self.sensor}
        for number, d, of in zip(self.numbers, self.x, deviation):
            value = number.value(number.amount + d)
            if number.key:
                numbers[number.key] = Fitted(value, of * (value if number.log else 1))
                if number.key == "time_constant" and of > 0.5:
                    self.held.append("transducer.time_constant is not told: readings decay too little within these presses")
                continue
            i = int(np.flatnonzero(number.presses)[0])
            friction[i] = Fitted(value, min(number.deviation, of * spreads[number.name]))
            if friction[i].deviation > NOT_TOLD * number.deviation:
                hardly.append(self.names[i])
        correlation = covariance[:m, :m] / np.outer(deviation[:m], deviation[:m])
        for k, j in zip(*np.nonzero(np.tril(np.abs(correlation) > DEGENERATE, -1))):
            self.held.append(f"{self.numbers[j].name} and {self.numbers[k].name} are not told apart (correlation {correlation[k, j]:.3f}): hold one of them")
        if hardly:
            self.held.append(f"friction is not told by {', '.join(hardly)}: hardly any of the contact slides")
        gain, offset = [Fitted(math.nan, math.nan)] * len(self.of), [Fitted(math.nan, math.nan)] * len(self.of)
        for k, channel in enumerate(np.flatnonzero(self.used)):
            s = float(self.x[m + c + k])
            gain[channel] = Fitted(1 / s, float(deviation[m + c + k]) / s**2)
            offset[channel] = Fitted(float(self.x[m + k]), float(deviation[m + k]))
        left = self.left(self.x)
        return Calibration(settled, self.iterations, numbers, friction, gain, offset, np.where(self.used, self.noise, math.nan),
                           [number.name for number in self.numbers], correlation, self.held, self.faults, [left[rows] for rows in self.middle.rows], self.of)


def fit(presses, options=Options()):
    """Fits gains, offsets and rubber to presses on one sensor."""
    if options.fit_time_constant and not math.isfinite(options.time_constant):
        raise input_error("fit.time_constant", "true", "must be given with transducer.time_constant, s, from which the search starts")
    return _Fit(presses, options).run()


# What is said


def _null(value):
    return float(value) if math.isfinite(value) else None


def to_json(found, presses, noise):
    """Every number, with deviations and residuals."""
    def of(fitted):
        return {"value": _null(fitted.value), "deviation": _null(fitted.deviation)}
    return {"converged": found.converged, "iterations": found.iterations, **{key: of(number) for key, number in found.numbers.items()},
            "friction": [of(mu) for mu in found.friction], "fitted": found.fitted, "correlation": found.correlation.tolist(), "held": found.held,
            "faults": [{"kind": fault.kind, "text": fault.text} for fault in found.faults],
            "gain": [of(gain) for gain in found.gain], "offset": [of(offset) for offset in found.offset],
            "noise": [_null(one) for one in found.noise], "rest_noise": [_null(one) for one in noise],
            "residuals": [{"press": press.name, "steps": [[_null(one) for one in step] for step in left]} for press, left in zip(presses, found.residuals)]}


LABELS = {"young": ("sensor.young", " MPa"), "poisson": ("sensor.poisson", ""), "thickness": ("sensor.thickness", " mm"), "shift": ("shift of the tactels", " mm"),
          "shift_y": ("shift along y", " mm"), "time_constant": ("transducer.time_constant", " s")}


def remarks_of(found, presses, noise):
    """Sentences on what was found."""
    def line(name, fitted, unit):
        return f"{name} = {fitted.value:.5g}" + (f" +- {fitted.deviation:.2g}{unit}" if fitted.deviation else f"{unit} (held)")
    said = [line(LABELS[key][0], number, LABELS[key][1]) for key, number in found.numbers.items()]
    said += [line(f"friction of {press.name}", mu, "") for press, mu in zip(presses, found.friction) if mu.deviation]
    known = [i for i, gain in enumerate(found.gain) if math.isfinite(gain.value) and math.isfinite(noise[i])]
    stresses = [noise[i] * abs(found.gain[i].value) for i in known]
    unsure = sum(found.offset[i].deviation > UNSURE_OFFSET * noise[i] for i in known)
    if known:
        said.append(f"transducer.noise = {np.median(stresses):.2g} MPa (median; {min(stresses):.2g} to {max(stresses):.2g})")
    else:
        said.append("noise at rest is not known: no window has four frames; tare with this profile")
    if unsure:
        said.append(f"{unsure} of {len(known)} offsets are not known within {UNSURE_OFFSET:g} of the noise at rest: tare with this profile, or drift may be reported falsely")
    return said + found.held


def _figure(found, presses):
    """Gains with two deviations, and the sizes of the residuals by press and by tactel."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise input_error("matplotlib", "not installed", "install it: pip install matplotlib") from None
    kinds = list(dict.fromkeys(name.rsplit(" of tactel ", 1)[0] for name in found.names))
    count = len(found.names) // len(kinds)
    figure = Figure(figsize=(9, 6), layout="constrained")
    rows = figure.subplots(2, 2)
    gain, deviation = (np.array([getattr(one, name) for one in found.gain]) for name in ("value", "deviation"))
    tactel, press = np.arange(count), np.arange(1, len(presses) + 1)
    size = np.array([[_rms(left[:, k * count:(k + 1) * count]) for left in found.residuals] for k in range(len(kinds))])
    of_tactel = np.array([_rms(np.vstack(found.residuals)[:, c]) for c in range(len(found.names))]) * found.noise * np.abs(gain) * 1000
    for k, kind in enumerate(kinds):
        own = slice(k * count, (k + 1) * count)
        rows[0, 0].errorbar(tactel, gain[own], 2 * deviation[own], fmt=".", capsize=3, label=kind)
        rows[1, 0].plot(press, size[k], "o", label=kind)
        rows[1, 1].plot(tactel, of_tactel[own], "o", label=kind)
    mean = np.array([np.nanmean(left, 0) if np.isfinite(left).any() else np.full(len(found.names), math.nan) for left in found.residuals])
    most = np.nanmax(np.abs(mean)) if np.isfinite(mean).any() else 1
    shown = rows[0, 1].imshow(mean, aspect="auto", cmap="RdBu", vmin=-most, vmax=most, extent=(-0.5, len(found.names) - 0.5, len(presses) + 0.5, 0.5))
    figure.colorbar(shown, ax=rows[0, 1])
    rows[0, 0].set(title="gains, two deviations", xlabel="tactel", ylabel="MPa by the device's unit")
    rows[0, 1].set(title="mean residual over noise", xlabel="transducer", ylabel="press")
    rows[1, 0].set(title="residuals by press", xlabel="press", ylabel="rms over noise", ylim=(0, None))
    rows[1, 1].set(title="residuals by tactel", xlabel="tactel", ylabel="rms, kPa", ylim=(0, None))
    rows[0, 0].legend(fontsize="small")
    return figure


def page(found, presses, remarks):
    """A page of HTML that needs no other file."""
    drawn = io.StringIO()
    _figure(found, presses).savefig(drawn, format="svg")
    relative = np.array([abs(gain.deviation / gain.value) for gain in found.gain])
    verdict = f"Gains of {np.isfinite(relative).sum()} of {len(relative)} transducers are found, with a median deviation of {100 * np.nanmedian(relative):.2g} %." \
        if found.converged else "The fit did not converge; its numbers say nothing."

    def cell(one, digits):
        return "left out" if not math.isfinite(one.value) else f"{one.value:.{digits}g} ± {one.deviation:.2g}"
    rows = "".join(f"<tr><td>{name}<td>{cell(gain, 4)}<td>{cell(offset, 5)}<td>{noise:.2g}" for name, gain, offset, noise in
                   zip(found.names, found.gain, found.offset, found.noise))
    said = "".join(f"<li>{html.escape(one)}" for one in [f"fault: {fault.text}" for fault in found.faults] or ["no fault is found"]) + "".join(
        f"<li>{html.escape(one)}" for one in remarks)
    return (f"<!doctype html><html lang='en'><meta charset='utf-8'><title>tactel: a calibrated sensor</title><style>body{{font-family:sans-serif;"
            "max-width:60em;margin:auto}td{padding:0 1em}svg{max-width:100%;height:auto}</style>"
            f"<h1>{verdict}</h1><ul>{said}</ul>{drawn.getvalue()[drawn.getvalue().index('<svg'):]}<table><tr><th>transducer<th>gain<th>offset<th>noise{rows}"
            f"</table><p>{len(presses)} presses, by tactel {__version__}</html>\n")


def _warn(text):
    print(f"tactel.calibrate: warning: {text}", file=sys.stderr)


def _sensor_command(given):
    _scipy()
    presses, options, noise = read_presses(given.recordings, given.profile)
    found = fit(presses, options)
    remarks = remarks_of(found, presses, noise)
    if given.json:
        write_text(given.json, json.dumps(to_json(found, presses, noise), indent=2) + "\n")
    if given.html:
        write_text(given.html, page(found, presses, remarks))
    if given.plot:
        _figure(found, presses).savefig(given.plot)
    if not given.quiet:
        print("\n".join(remarks))
        for fault in found.faults:
            _warn(fault.text)
    wrong = any(fault.kind == "wrong_indenter" for fault in found.faults)
    if wrong or not found.converged:
        print(f"tactel.calibrate: {given.output} was not written: " + ("the recordings do not fit their scenes" if wrong else "the fit did not converge"),
              file=sys.stderr)
        return 4
    remarks += [fault.text for fault in found.faults if fault.kind == "model_misfit"]
    write_text(given.output, calibrated_profile(given.profile, found, noise, remarks))
    if not given.quiet:
        print(f"the calibrated profile is in {given.output}")
    return 0


def _arguments(words):
    parser = argparse.ArgumentParser(prog="python -m tactel.calibrate", description="Plan presses, or calibrate a sensor by them.",
                                     epilog="Exit codes: 0 done, 2 wrong input, 3 a damaged recording, 4 no profile, as the recordings do not fit.")
    commands = parser.add_subparsers(dest="command", required=True)
    sensor = commands.add_parser("sensor", help="fit gains, offsets and rubber of a sensor to recordings of known presses and drags")
    add = sensor.add_argument
    add("recordings", metavar="RECORDINGS.toml", help="scenes, recordings, times and forces of the presses")
    add("--profile", required=True, metavar="P.toml", help="profile of the device")
    add("--output", required=True, metavar="FILE.toml", help="profile to write, with the new calibration")
    add("--json", metavar="FILE", help="write all numbers, with deviations and residuals")
    add("--html", metavar="FILE.html", help="write a page: gains with deviations, residuals, faults (matplotlib)")
    add("--plot", metavar="FILE.svg|png|pdf", help="draw gains and residuals (matplotlib)")
    add("--quiet", action="store_true", help="no warnings and no summary")
    plan = commands.add_parser("plan", help="choose the presses and drags that tell most of a line, before recording them")
    add = plan.add_argument
    add("profile", metavar="PROFILE.toml", help="profile of the device")
    either = plan.add_mutually_exclusive_group()
    either.add_argument("--scene", metavar="SCENE.toml", help="scene whose sensor and friction the usual presses take")
    either.add_argument("--candidates", metavar="LIST.toml", help="presses to choose from: scenes, places, depths and drags (default: rods, a flat and a wedge)")
    add("--presses", type=int, default=10, help="number of presses to choose (default: %(default)s)")
    add("--noise", type=float, help="standard deviation of a reading over the largest stress (default: the profile's, or 0.01)")
    add("--without-force", action="store_true", help="P will not be measured")
    add("--output", metavar="FILE.toml", help="recordings file to fill in; scenes are written beside it")
    add("--json", metavar="FILE", help="write the plan with all deviations")
    add("--quiet", action="store_true", help="no warnings and no table")
    return parser.parse_args(words)


def main(words=None):
    given = _arguments(words)
    if given.command == "sensor":
        return exit_code("calibrate", _sensor_command, given)
    return exit_code("calibrate", plan_command, given, _warn)


if __name__ == "__main__":
    sys.exit(main())
