# SPDX-License-Identifier: Apache-2.0
"""Simulated sensors, whose gains, offsets, E and nu a calibration does not know, and their readings of known presses."""
import functools

import numpy as np

import tactel
from tactel import calibrate

NOMINAL = tactel.Sensor(length=20, thickness=1.5, young=2.0, poisson=0.45, tactels=21)
POISSONS = (0.43, 0.447, 0.46, 0.475)


def presses(sensor=NOMINAL, count=20, radius=1.0):
    """Presses and drags of two cylinders along the array. radius: over what their scenes say."""
    return [tactel.Scene(sensor, tactel.Indenter(tactel.Cylinder((6.0 if k % 2 else 15.0) * radius), -7.5 + 15 * k / (count - 1)), friction=0.6,
                         load=tactel.Press(0.1 + 0.02 * (k % 4), steps=2).drag_to([0.02, 0.05, 0.08])) for k in range(count)]


@functools.cache
def truth(poisson, thickness, radius, count, tactels):
    """Frames [presses, steps, transducers] and forces at E = 1, on twice the elements of a fit."""
    sensor = NOMINAL.with_(young=1.0, poisson=poisson, thickness=thickness, tactels=tactels)
    paths = tactel.solve_many(presses(sensor, count, radius), rung="patch-24", precision="fp64")
    return np.concatenate([paths.tactels.normal, paths.tactels.shear], 2), np.array(paths.P)


class Known:
    """A sensor of its own: what it is, and its presses with noise. E is drawn, gains have 20 % and offsets 50 units of spread."""

    def __init__(self, seed, noise=0.01, thickness=1.5, radius=1.0, poisson=None, gauge=0.01, count=20, tactels=21, time_constant=np.inf, timing=None):
        """noise: of a reading over the largest stress on the nominal sensor; gauge: one error of P a press, relative."""
        random = np.random.default_rng(seed)
        self.poisson = POISSONS[seed % 4] if poisson is None else poisson
        self.young = 2 * np.exp(0.3 * random.standard_normal())
        frames, forces = truth(self.poisson, thickness, radius, count, tactels)
        self.noise = noise * 2 * np.abs(truth(0.45, 1.5, 1.0, count, tactels)[0]).max()
        self.gain = 0.001 * (1 + 0.2 * random.standard_normal(2 * tactels))
        self.offset = 2048 + 50 * random.standard_normal(2 * tactels)
        self.rest_noise = self.noise / self.gain
        response = np.eye(frames.shape[1]) if timing is None else calibrate.amplifier_response(timing, time_constant)
        self.presses = []
        for k, scene in enumerate(presses(NOMINAL.with_(tactels=tactels), count)):
            stress = self.young * response @ frames[k]
            readings = (stress + self.noise * random.standard_normal(stress.shape)) / self.gain + self.offset
            P = self.young * forces[k] * (1 + gauge * random.standard_normal())
            self.presses.append(calibrate.Press(f"press {k + 1}", scene, readings, P, timing))

    def within(self, found, deviations=2):
        """How many gains are within so many of their deviations."""
        return sum(gain.within(true, deviations) for gain, true in zip(found.gain, self.gain))


def pad_presses(pad):
    """Two spheres pressed and dragged beside 4 x 4 tactels, and a flat between them."""
    found = []
    for k in range(20):
        shape, place, depth = tactel.Sphere(6.0 if k % 3 else 10.0), (4.7 * (k % 4 - 1.5) + 0.8, 4.7 * (k // 4 - 1.5) - 0.6), 0.6 + 0.1 * (k % 5)
        if k >= 16:
            shape, place, depth = tactel.Punch(2.5), (4.7 if k % 2 else -4.7, 4.7 if k < 18 else -4.7), 0.3 + 0.05 * (k - 16)
        side = -0.2 if k % 2 else 0.2
        found.append(tactel.Scene(pad, tactel.PadIndenter(shape, place), 0.8, tactel.Press(depth, steps=2).drag_to([(side, 0.0), (side, -side), (0.0, -side)])))
    return found


class KnownPad:
    """A pad of its own: gains have 15 % and offsets 50 units of spread, E 30 %, H 5 %; nu is 0.43 to 0.495."""

    def __init__(self, seed, noise=0.005, gauge=0.01):
        random = np.random.default_rng(seed)
        nominal = tactel.Pad(thickness=4, young=0.5, poisson=0.46)
        self.young, self.poisson, self.thickness = 0.5 * np.exp(0.3 * random.standard_normal()), random.uniform(0.43, 0.495), 4 * (1 + 0.05 * random.standard_normal())
        self.gain, self.offset = 1e-5 * (1 + 0.15 * random.standard_normal(48)), 20000 + 50 * random.standard_normal(48)
        own = nominal.with_(young=self.young, poisson=self.poisson, thickness=self.thickness)
        paths = tactel.solve_many(pad_presses(own), rung="pad-24", precision="fp64")
        stress = np.concatenate([np.reshape(s, (*paths.P.shape, 16)) for s in (paths.tactels.normal, paths.tactels.shear_x, paths.tactels.shear_y)], 2)
        noise *= np.abs(stress).max()
        self.rest_noise = noise / self.gain
        readings = (stress + noise * random.standard_normal(stress.shape)) / self.gain + self.offset
        self.presses = [calibrate.Press(f"press {k + 1}", scene, readings[k], np.array(paths.P[k]) * (1 + gauge * random.standard_normal()))
                        for k, scene in enumerate(pad_presses(nominal))]


def texts(found, kind=None):
    return [fault.text for fault in found.faults if kind in (None, fault.kind)]
