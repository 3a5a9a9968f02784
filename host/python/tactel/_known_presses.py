# SPDX-License-Identifier: Apache-2.0
"""Presses of tactel.calibrate, the numbers of sensor and presses that move their stresses, and the answers of solve_many to them."""

import math
import pickle
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import Box, Indenter, InputError, Pad, Profile, Punch, Scene, devices, heights, solve_many
from ._calls import input_error


@dataclass(frozen=True)
class Press:
    name: str
    scene: Scene  #: indenter, friction, load by depth or force, nominal sensor
    readings: np.ndarray  #: [steps, transducers] in the device's units, in the order of a frame; NaN: no reading
    P: Any = None  #: [steps] N/mm, of a pad N, measured; None: not measured
    timing: Any = None  #: (begin, end, time) [steps] s: motion to each load step, and its reading; needed where readings decay


@dataclass(frozen=True)
class Options:
    poisson: bool = True
    thickness: bool = False
    shift: bool = False
    fit_time_constant: bool = False
    time_constant: float = math.inf  #: s, of the charge amplifiers of all transducers; infinite: no decay
    friction: float = 0  #: standard deviation of each press's friction about its scene's, relative; 0: it is known
    force_noise: float = 0.01  #: standard deviation of the gauge's error, one for all forces of a press, relative
    lowest_reading: float = -math.inf
    highest_reading: float = math.inf  #: at or beyond, the converter is saturated
    rest_noise: Any = None  #: [transducers] of readings while the indenter rests, by which a wrong indenter is found
    rungs: Any = ()  #: of the fit and of its correction; (): 12 and 24 elements a side


def is_pad(scene):
    return isinstance(scene.sensor, Pad)


def by_force(scene):
    return len(scene.load.normal_force) > 0


def transducers(scene):
    """Names of the transducers, in the order of a frame."""
    if is_pad(scene):
        kinds = ("normal stress", "shear stress along x", "shear stress along y")[:scene.sensor.axes]
        count = scene.sensor.tactels[0] * scene.sensor.tactels[1]
    else:
        kinds, count = ("normal stress", "shear stress"), scene.sensor.tactels
    return [f"{kind} of tactel {i}" for kind in kinds for i in range(count)]


@dataclass
class Number:
    """What moves the stresses of presses: an amount of it, from 0 where the scenes have it, or from the last place of the grid."""

    name: str  #: for people; of a held number "": it is known to `deviation`, and not judged
    unit: str
    start: float  #: value, or its logarithm, where the amount is 0
    step: float  #: of the grid
    move: Any  #: (scene, amount) to scene; None: the time constant, which the scene has not
    presses: np.ndarray  #: [presses] of which it is a number
    key: str = ""  #: in JSON, of the sensor's numbers
    log: bool = False
    least: float = -math.inf  #: amounts
    most: float = math.inf
    deviation: float = 0  #: before the fit; 0: not known
    place: int = 0  #: of the grid

    @property
    def amount(self):
        return self.place * self.step

    def follow(self, d, late=False):
        """Moves the grid's place to where an amount from it is nearest; late, when it goes to and fro, a step at most. Returns whether it
        moved."""
        steps = round(d / self.step) if abs(d) > (1.5 if late else 0.75) * self.step else 0
        to = self.place + (max(-1, min(1, steps)) if late else steps)
        if math.isfinite(self.most):
            to = min(to, math.floor(self.most / self.step) - 1)
        if math.isfinite(self.least):
            to = max(to, math.ceil(self.least / self.step) + 1)
        moved, self.place = to != self.place, to
        return moved

    def value(self, amount):
        return math.exp(self.start + amount) if self.log else self.start + amount


def sensed(scene, **changes):
    return scene.with_(sensor=scene.sensor.with_(**changes))


def indented(scene, **changes):
    return scene.with_(indenter=scene.indenter.with_(**changes))


def _shift(axis):
    """Where the tactels are elsewhere, so is the indenter for them."""
    def move(scene, amount):
        place = scene.indenter.position
        return indented(scene, position=[p - amount * (axis == k) for k, p in enumerate(place)] if is_pad(scene) else place - amount)
    return move


def targets(load):
    """Depths or forces of all load steps of a press."""
    ends = load.indentation or load.normal_force
    return [a + (b - a) * (k + 1) / load.indentation_steps for a, b in zip([0, *ends], ends) for k in range(load.indentation_steps)]


def deepened(scene, amount):
    if by_force(scene):
        return scene
    return scene.with_(load=scene.load.with_(indentation=[depth + amount for depth in targets(scene.load)], indentation_steps=1))


def _tilt(axis):
    """Degrees to the tilt along an axis of the indenter's frame. Its height at the axis stays."""
    def rise(shape, tilt):
        size = np.hypot(*tilt)
        reach = shape.radius if isinstance(shape, Punch) else np.abs(tilt) / (size or 1) @ shape.half_widths
        return reach * math.tan(math.radians(size))

    def move(scene, amount):
        indenter = scene.indenter
        if is_pad(scene):
            direction = math.radians(indenter.tilt_direction)
            before = indenter.tilt * np.array([math.cos(direction), math.sin(direction)])
            after = before + amount * np.array([axis == 0, axis == 1])
            tilted = indented(scene, tilt=float(np.hypot(*after)), tilt_direction=math.degrees(math.atan2(after[1], after[0])))
            return deepened(tilted, rise(indenter.shape, after) - rise(indenter.shape, before))
        x = np.linspace(-scene.sensor.length / 2, scene.sensor.length / 2, 1001)
        y = heights(Indenter(indenter.shape), x) + math.tan(math.radians(amount)) * x
        x, y = x[np.isfinite(y)], y[np.isfinite(y)]
        return deepened(indented(scene, shape=Profile(x, y - y.min())), -y.min())
    return move


def _shape(name, place):
    def move(scene, amount):
        value = getattr(scene.indenter.shape, name)
        changed = value + amount if place is None else [v + amount * (i == place) for i, v in enumerate(value)]
        return indented(scene, shape=scene.indenter.shape.with_(**{name: changed}))
    return move


def _shape_numbers(shape):
    """(name, place in a list or None, value) of the numbers of a shape, but for tables and for 0, which is a sharp edge."""
    if isinstance(shape, Profile) or hasattr(shape, "heights"):
        return []
    named = [(name, getattr(shape, name)) for name in shape._fields]
    flat = [(name, None, value) for name, value in named if np.ndim(value) == 0]
    flat += [(name, i, v) for name, value in named if np.ndim(value) == 1 for i, v in enumerate(value)]
    return [one for one in flat if isinstance(one[2], float) and one[2] != 0]


def sensor_numbers(scene, options, count):
    """The numbers of the sensor, fitted or held: [(number, whether it is asked for)]. E is told by forces alone."""
    sensor, pad = scene.sensor, is_pad(scene)
    every = np.ones(count, bool)
    reach = (0, 0.5) if pad else (max(0, sensor.poisson - 0.04), min(sensor.poisson + 0.04, 0.4995))
    h, nu = sensor.thickness, sensor.poisson
    numbers = [
        (Number("ln E", "MPa", math.log(sensor.young), 0.05, lambda s, a: sensed(s, young=s.sensor.young * math.exp(a)), every, "young", log=True), True),
        (Number("sensor.poisson", "", nu, 0.005, lambda s, a: sensed(s, poisson=s.sensor.poisson + a), every, "poisson",
                least=reach[0] - nu, most=reach[1] - nu), options.poisson),
        (Number("sensor.thickness", " mm", h, 0.01 * h, lambda s, a: sensed(s, thickness=s.sensor.thickness + a), every, "thickness", least=-0.5 * h), options.thickness),
        (Number("shift of the tactels" + " along x" * pad, " mm", 0, 0.01 * h, _shift(0), every, "shift"), options.shift),
    ]
    if pad:
        numbers.append((Number("shift of the tactels along y", " mm", 0, 0.01 * h, _shift(1), every, "shift_y"), options.shift))
    if math.isfinite(options.time_constant):
        numbers.append((Number("ln transducer.time_constant", "s", math.log(options.time_constant), 0.05, None, every, "time_constant", log=True),
                        options.fit_time_constant))
    for number, _ in numbers:
        number.follow(0)
    return numbers


def press_numbers(scenes, options, names, used):
    """Numbers of presses that may be other than their scenes say: fitted frictions, and those that are held."""
    pad, frictions, held = is_pad(scenes[0]), [], []

    def of(test):
        return np.array([bool(test(scene)) for scene in scenes]) & used

    def add(name, unit, start, step, move, presses, **more):
        if presses.any():
            held.append(Number(name, unit, start, step, move, presses, **more))

    axes = (" along their x", " along their y") if pad else ("",)
    for axis, name in enumerate(axes):
        add("tilt of the indenters" + name, " degrees", 0, 0.2, _tilt(axis), of(lambda s: not pad or isinstance(s.indenter.shape, (Punch, Box))))
    add("zero of the depth", " mm", 0, 0.002 * scenes[0].sensor.thickness, deepened, of(lambda s: not by_force(s)))
    shapes, known = [], []
    for i, scene in enumerate(scenes):
        mu, shape = scene.friction, scene.indenter.shape
        alone = np.arange(len(scenes)) == i
        if 0 < mu < math.inf:
            def rub(s, amount):
                return s.with_(friction=s.friction + amount)
            if options.friction > 0:
                if used[i]:
                    frictions.append(Number("friction of " + names[i], "", mu, 0.05 * mu, rub, alone, least=-0.8 * mu, deviation=options.friction * mu))
            elif mu not in known:
                known.append(mu)
                add("contact.friction", "", mu, 0.05 * mu, rub, of(lambda s: s.friction == mu))
        if shape not in shapes:
            shapes.append(shape)
            for name, place, value in _shape_numbers(shape):
                unit = " degrees" if "angle" in name else "" if name in ("rate", "slope", "coefficients", "powers") else " mm"
                add(f"indenter.{name}" + (f"[{place}]" if place is not None else ""), unit, value, 0.01 * abs(value), _shape(name, place),
                    of(lambda s: s.indenter.shape == shape))
        if by_force(scene):
            def press_harder(s, amount):
                return s.with_(load=s.load.with_(normal_force=[force * (1 + amount) for force in s.load.normal_force]))
            add("", "", 0, 0.01, press_harder, alone & used, deviation=options.force_noise)
    return frictions, held


# Answers

_solved: dict = {}  # (rung, pickled scene of E = 1) to frames and forces: fits and plans ask for the same scenes again


def answers(scenes, rung, names):
    """Frames [steps, transducers] MPa and forces [steps] of scenes."""
    youngs = [scene.sensor.young for scene in scenes]
    units = []
    for scene, young in zip(scenes, youngs):
        unit = sensed(scene, young=1.0)
        if by_force(scene):
            unit = unit.with_(load=unit.load.with_(normal_force=[force / young for force in scene.load.normal_force]))
        units.append(unit)
    keys = [(rung, pickle.dumps(unit)) for unit in units]
    missing = {key: i for i, key in enumerate(keys) if key not in _solved}
    if missing:
        order, exact = list(missing.values()), any(device.fp64 and device.is_default for device in devices())
        try:
            paths = solve_many([units[i] for i in order], rung=rung, precision="fp64" if exact else "fp32")
        except InputError as error:
            of = re.match(r"scenes\[(\d+)\]\.?(.*)", error.place)
            raise input_error(f"{names[order[int(of[1])]]}: {of[2]}", error.problem, error.fix) if of else error from None
        normal = np.asarray(paths.tactels.normal)
        stresses = [normal] + ([paths.tactels.shear] if not is_pad(scenes[0]) else
                               [paths.tactels.shear_x, paths.tactels.shear_y] if scenes[0].sensor.axes == 3 else [])
        frames = np.concatenate([np.reshape(stress, (*normal.shape[:2], -1)) for stress in stresses], 2)
        for k, (key, i) in enumerate(missing.items()):
            steps = int(paths.steps_made[k])
            good = np.asarray(paths.converged[k, :steps]).all()
            _solved[key] = (frames[k, :steps].copy(), np.array(paths.P[k, :steps])) if good else None
    found = [_solved[key] for key in keys]
    for one, name in zip(found, names):
        if one is None:
            raise input_error(f"{name}: scene", "no solution meets its tolerance", "must be another depth, drag or indenter")
    return [(young * frame, young * P) for young, (frame, P) in zip(youngs, found)]


def amplifier_response(timing, time_constant):
    """What charge amplifiers make of the stresses at load steps, [steps, steps]: readings = response @ stresses. v' = x' - v / RC for
    ramps from begin to end, read at time (nn/charge_amplifier.h)."""
    begin, end, time = (np.asarray(t, float) for t in timing)
    motion = (end - begin) / time_constant
    since = (time[:, None] - end) / time_constant
    left = np.where(motion > 0, -np.expm1(-motion) / np.where(motion > 0, motion, 1), 1) * np.exp(-since)
    left = np.tril(left)
    response = left.copy()
    response[:, :-1] -= left[:, 1:]
    return response


def stacked(scenes, logs, timings, rung, names):
    """Frames [rows, transducers] and forces [rows] of scenes, one below the other, as amplifiers read them."""
    found = answers(scenes, rung, names)
    frames = [frame if log is None else amplifier_response(timing, math.exp(log)) @ frame
              for (frame, _), log, timing in zip(found, logs, timings)]
    return frames, [P for _, P in found]


class Grid:
    """Frames and forces of all presses about a place of the grid of their numbers, and the parabolas in each number."""

    def __init__(self, scenes, timings, names, time_constant, numbers, rung):
        self.numbers = numbers
        log = math.log(time_constant) if math.isfinite(time_constant) else None

        def at(i, number=None, amount=0.0):
            scene, of_log = scenes[i], log
            for one in numbers:
                if one.presses[i] and (one.place != 0 or one is number):
                    by = one.amount + (amount if one is number else 0)
                    if one.move is None:
                        of_log += by
                    else:
                        scene = one.move(scene, by)
            return scene, of_log

        asked = [(i, *at(i)) for i in range(len(scenes))]
        for number in numbers:
            asked += [(i, *at(i, number, sign * number.step)) for sign in (1, -1) for i in np.flatnonzero(number.presses)]
        frames, forces = stacked([one[1] for one in asked], [one[2] for one in asked], [timings[one[0]] for one in asked], rung,
                                 [names[one[0]] for one in asked])
        count = len(scenes)
        ends = np.cumsum([len(frame) for frame in frames[:count]])
        self.rows = [slice(end - len(frame), end) for end, frame in zip(ends, frames)]
        self.frame, self.P = np.vstack(frames[:count]), np.concatenate(forces[:count])
        self.parabolas = []
        for number in numbers:
            by, P_by = np.zeros((2, *self.frame.shape)), np.zeros((2, len(self.P)))
            own = np.flatnonzero(number.presses)
            for k, i in enumerate(own):
                up, down = count + k, count + len(own) + k
                for found, middle, to in ((frames, self.frame, by), (forces, self.P, P_by)):
                    to[0, self.rows[i]] = (found[up] - found[down]) / (2 * number.step)
                    to[1, self.rows[i]] = (found[up] - 2 * middle[self.rows[i]] + found[down]) / (2 * number.step**2)
            count += 2 * len(own)
            self.parabolas.append((by, P_by))

    def at(self, amounts):
        """Frames and forces at amounts from the middle, and their derivatives by the numbers: [(of frames, of forces)]."""
        frame, P, slopes = self.frame.copy(), self.P.copy(), []
        for d, (by, P_by) in zip(amounts, self.parabolas):
            frame += d * by[0] + d * d * by[1]
            P += d * P_by[0] + d * d * P_by[1]
            slopes.append((by[0] + 2 * d * by[1], P_by[0] + 2 * d * P_by[1]))
        return frame, P, slopes
