# SPDX-License-Identifier: Apache-2.0
"""Floors of problems whose Bayes risk is known, and the command."""
import functools
import itertools
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

import numpy as np
from tactel import InputError, Sweep, floor

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"


def rows_of(frames, slip_index, largest=None):
    """One row a contact. frames: [rows, history, inputs]"""
    newest = np.abs(frames[:, 0]).max(1)
    return floor.Rows(frames, slip_index, newest if largest is None else np.full(len(frames), float(largest)), np.arange(len(frames)),
                      np.zeros((1, len(frames)), int))


class Density(unittest.TestCase):
    def test_is_that_of_the_covariance(self):
        random = np.random.default_rng(5)
        for history in (1, 3):
            for noise, gain in ((0.01, 0.0), (0.05, 0.2), (2e-4, 0.1)):
                frames = random.standard_normal((5, history, 4))
                sigma = noise * np.abs(frames).max((1, 2))
                readings = frames * 1.01 + 0.01
                found = floor.log_density(readings, frames, sigma, gain)
                for row, reading in enumerate(readings):
                    exact = covariance_density(frames[row], sigma[row], gain, reading)
                    # The inverse of the covariance loses 8 of 16 digits at gain / noise = 1e4, squared.
                    self.assertAlmostEqual(found[row], exact, delta=1e-6 * abs(exact))

    def test_a_frame_from_before_the_contact_is_read_as_zeros(self):
        frames = np.ones((2, 2, 3))
        frames[0, 1] = 0
        readings = frames.copy()
        self.assertTrue(np.isfinite(floor.log_density(readings, frames, np.ones(2), 0)).all())
        self.assertEqual(floor.log_density(readings, frames[::-1], np.ones(2), 0).tolist(), [-np.inf, -np.inf])


def covariance_density(frames, sigma, gain, reading):
    """The logarithm by the covariance matrices themselves, without (2 pi)^(-size/2)."""
    total = 0.0
    for f, x in zip(frames.T, reading.T):
        covariance = sigma**2 * np.eye(len(f)) + gain**2 * np.outer(f, f)
        r = x - f
        total -= 0.5 * (r @ np.linalg.solve(covariance, r) + np.linalg.slogdet(covariance)[1])
    return total


def floor_of_normal_error(deviation):
    """The floor of an S that is uniform in 0 ... 1 and read with a normal error, by quadrature: sqrt(2 / pi) of the deviation, but
    for the ends of S."""
    S = (np.arange(4000) + 0.5) / 4000
    read = np.arange(-5 * deviation, 1 + 5 * deviation, deviation / 4)[:, None]
    together = np.exp(-0.5 * ((read - S) / deviation)**2)
    below = np.cumsum(together, axis=1)
    median = S[(below < 0.5 * below[:, -1:]).sum(1)][:, None]
    return (together * np.abs(S - median)).sum() / together.sum()


class KnownFloors(unittest.TestCase):
    """Problems whose floor has a closed form. Both numbers are within two of their errors, and the ranks are uniform."""

    def near(self, found, exact):
        for key in ("estimate", "true"):
            error = found["all"][key]
            self.assertAlmostEqual(error["mean"], exact, delta=2 * error["standard_error"], msg=key)
        self.assertGreater(found["ranks_p"], 0.05)

    def test_of_one_element(self):
        # One element touches: r = Q / P is read without error, S = r / mu, and mu is uniform in 0.1 ... 1, S in 0 ... 1. Given r, mu
        # has the density 1 / mu (dS = dr / mu) from max(r, 0.1) to 1, and S = r / mu is log-uniform from a = r to b = min(1, 10 r):
        # its median is the geometric mean of the ends, its mean absolute deviation (sqrt b - sqrt a)^2 / ln(b / a). Over r, whose
        # density is ln(b / a) / 0.9, the floor is the integral of (sqrt b - sqrt a)^2 / 0.9: with (sqrt 10 - 1)^2 r up to 0.1, then
        # 1 - 2 sqrt r + r.
        def tail(r):
            return r - 4 / 3 * r**1.5 + r * r / 2
        exact = ((math.sqrt(10) - 1)**2 * 0.005 + tail(1) - tail(0.1)) / 0.9
        self.assertAlmostEqual(exact, 0.135, delta=0.01)

        def simulate(u):
            return rows_of(np.stack([-np.ones(len(u)), (0.1 + 0.9 * u[:, 0]) * u[:, 1]], 1)[:, None, :], u[:, 1])
        found = floor.floor_of(simulate, [True, True], floor.Options(noise=0.001, readings=300, bank=10000, walkers=24, iterations=40))
        self.near(found, exact)

    def test_of_two_shapes_that_look_alike(self):
        # The frame tells u; S is u under one shape and 1 - u under the other, as likely: the mean of |S - median| is |1 - 2 u| / 2, over
        # u one quarter. The walkers must go from shape to shape.
        def simulate(u):
            return rows_of(np.stack([np.ones(len(u)), u[:, 1]], 1)[:, None, :], np.where(u[:, 0] < 0.5, u[:, 1], 1 - u[:, 1]))
        found = floor.floor_of(simulate, [False, True], floor.Options(noise=0.001, readings=200, bank=3000, iterations=60))
        self.near(found, 0.25)

    def test_of_a_history(self):
        # S is u, read three times in frames of which it is one, two and half: sigma / sqrt(1 + 4 + 1 / 4). The noise is over a stress of
        # 2 MPa, that of the contact.
        def simulate(u):
            one = np.ones(len(u))
            return rows_of(np.stack([one, u[:, 0], one, 2 * u[:, 0], one, u[:, 0] / 2], 1).reshape(len(u), 3, 2), u[:, 0], largest=2)
        found = floor.floor_of(simulate, [True], floor.Options(noise=0.005, noise_of_contact=True, history=3, readings=300, bank=3000, walkers=24, iterations=40))
        self.near(found, floor_of_normal_error(0.01 / math.sqrt(5.25)))

    def test_of_a_friction_that_is_told(self):
        # The frame says nothing, S is log mu, and log mu is told with a normal error.
        def simulate(u):
            rows = rows_of(np.ones((len(u), 1, 1)), u[:, 0])
            return floor.Rows(rows.frames, rows.slip_index, rows.largest, rows.contact, rows.classes, np.exp(u[:, 0]))
        options = floor.Options(readings=300, bank=2000, walkers=24, iterations=40, friction_spread=0.005)
        self.near(floor.floor_of(simulate, [True], options), floor_of_normal_error(0.005))

    def test_rows_of_a_contact_are_told_apart_by_their_frames(self):
        # Each contact has the rows S = 0 and S = 1 with frames that differ: nothing is left open.
        def simulate(u):
            frames = np.array([[1.0, 0.0], [1.0, 0.5]])[np.tile([0, 1], len(u))][:, None, :]
            rows = rows_of(frames, np.tile([0.0, 1.0], len(u)))
            return floor.Rows(rows.frames, rows.slip_index, rows.largest, np.repeat(np.arange(len(u)), 2), rows.classes)
        found = floor.floor_of(simulate, [True], floor.Options(noise=0.01, readings=20, bank=100, iterations=10))
        self.assertEqual(found["all"]["estimate"]["mean"], 0)
        self.assertEqual(found["all"]["true"]["mean"], 0)

    def test_numbers_that_do_not_meet_are_no_floor(self):
        # The second simulation is that of the contacts that are read: their S is not what the sampler believes.
        calls = itertools.count()

        def simulate(u):
            return rows_of(np.stack([np.ones(len(u)), u[:, 0]], 1)[:, None, :], u[:, 0] + 0.3 * (next(calls) == 1))
        found = floor.floor_of(simulate, [True], floor.Options(noise=0.01, readings=50, bank=500, walkers=16, iterations=20))
        self.assertFalse(found["converged"])
        self.assertLess(found["ranks_p"], 1e-6)
        self.assertIn(floor.NO_FLOOR, floor.table(found))


class PadRows(unittest.TestCase):
    def test_have_classes_of_torque_and_tactels(self):
        # Four steps of a contact on two tactels with three axes: S of 0.6 with 0.45, 0.3 and 0.1 by the force alone, and a small S.
        frames = np.array([[-1, -0.04, 9, 9, 9, 9], [-1, -0.06, 0, 0, 0, 0], [-1, 1, 0, 0, 0, 0], [0, -1, 0, 0, 0, 0]], np.float32)
        class Rows(types.SimpleNamespace):
            def __len__(self):
                return len(self.contact)
        rows = Rows(
            axes=3, frames=frames, slip_index=np.array([0.6, 0.6, 0.6, 0.04]), force_ratio=np.array([0.45, 0.3, 0.1, 0.0]),
            friction=np.full(4, 0.5), status=np.zeros(4), contact=np.zeros(4, int), step=np.arange(4), indenter=np.full(4, 2), contact_nodes=np.full(4, 99))
        bank = floor._collect(rows, floor.Options())
        self.assertEqual(bank.classes.tolist(), [[2, 2, 2, 2], [1, 2, 3, 0], [0, 0, 0, 0]])
        rows.frames = np.concatenate([frames[:, :2]] * 3 + [frames[:, 2:]] * 2, axis=1)[:, :18]  # six tactels
        touching = floor._collect(rows, floor.Options()).classes[2]
        self.assertEqual(touching.tolist(), [0, 1, 1, 0])  # three; six; six; three


RUBBER = """[sensor]
kind = "pad"
thickness = 4
young = 0.5
poisson = 0.48
[contact]
friction = { uniform = [0.2, 1.2] }
"""

ONE_DRAG = """[load.irregular]
press_steps = 1
stroke = { log_uniform = [0.03, 1.0] }
stroke_steps = 1
"""

SPHERES = """
[sweep]
contacts = 100
""" + RUBBER + """[indenter]
shape = "sphere"
radius = { log_uniform = [5, 40] }
position = [{ uniform = [-5, 5] }, { uniform = [-5, 5] }]
[load]
indentation = { uniform = [0.1, 0.6] }
""" + ONE_DRAG + """direction = { uniform = [0, 360] }
"""


FEW = ("--rung", "pad-8", "--bank", "1000", "--readings", "40", "--walkers", "12", "--iterations", "16")

ONE_SPHERE = """
[sweep]
contacts = 10000
seed = 5
""" + RUBBER + """[indenter]
shape = "sphere"
radius = 15
position = [1.0, -0.5]
[load]
indentation = { uniform = [0.2, 0.4] }
""" + ONE_DRAG + """direction = 30
"""


class Simulated(unittest.TestCase):
    def test_floor_is_that_of_weighted_contacts_of_the_sweep(self):
        # Friction, depth and stroke of one sphere are open. Where so little is, contacts of the sweep weighted by their densities are
        # the posterior (importance sampling from the prior), without walkers, tempering or quantiles.
        noise, random, seeds = 0.1, np.random.default_rng(11), int(os.environ.get("TACTEL_FLOOR_SEEDS", 1))
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "sweep.toml")
            with open(file, "w", encoding="utf-8") as toml:
                toml.write(ONE_SPHERE)
            found = [floor.measure(Sweep(file), floor.Options(noise=noise, readings=70, bank=3000, walkers=16, iterations=24, seed=seed), rung="pad-8")
                     for seed in range(1, 1 + seeds)]
            rows = Sweep(file).generate(rung="pad-8")
        frames, S = rows.frames.astype(float), rows.slip_index.astype(float)
        sigma = noise * np.abs(frames).max(1)
        order, squares = np.argsort(S), (frames**2).sum(1)
        errors, shared = [], []
        for k in random.choice(len(S), 400, replace=False):
            reading = frames[k] + sigma[k] * random.standard_normal(frames.shape[1])
            log = -0.5 * (squares - 2 * frames @ reading + reading @ reading) / sigma**2 - frames.shape[1] * np.log(sigma)
            weight = np.exp(log - log.max())
            weight /= weight.sum()
            median = S[order[np.searchsorted(np.cumsum(weight[order]), 0.5)]]
            errors.append(weight @ np.abs(S - median))
            shared.append(1 / (weight**2).sum())
        self.assertGreater(np.median(shared), 100)  # rows that share the weight
        exact, error = np.mean(errors), np.std(errors) / math.sqrt(len(errors))
        for key in ("estimate", "true"):
            ones = [one["all"][key] for one in found]
            mean, spread = (math.fsum(one[name]**power for one in ones) for name, power in (("mean", 1), ("standard_error", 2)))
            self.assertAlmostEqual(mean / seeds, exact, delta=2 * math.hypot(error, math.sqrt(spread) / seeds), msg=key)
        self.assertTrue(all(one["ranks_p"] > 0.05 / seeds for one in found), [one["ranks_p"] for one in found])
        # One seed in twenty is not within two deviations of its own, by chance; all together are.
        differences = [one["difference"] for one in found]
        spread = math.sqrt(math.fsum(one["standard_error"] ** 2 for one in differences))
        self.assertLess(abs(math.fsum(one["mean"] for one in differences)), 2 * spread)


class Command(unittest.TestCase):
    def run_floor(self, *words, exit_code=0):
        ran = subprocess.run([sys.executable, "-m", "tactel.floor", *words, "--quiet"], capture_output=True, text=True)
        self.assertIn(ran.returncode, (0, 4) if exit_code is None else (exit_code,), ran.stderr)
        return ran

    def floor_json(self, *words):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "floor.json")
            self.text = self.run_floor(*words, "--json", file, exit_code=None).stdout
            with open(file, encoding="utf-8") as text:
                return json.load(text)

    def floor_of_text(self, text, *words):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "sweep.toml")
            with open(file, "w", encoding="utf-8") as toml:
                toml.write(text)
            return self.floor_json(file, *words)

    @staticmethod
    @functools.cache
    def floor_of_spheres():
        """The same for every test: numbers and text."""
        run = Command()
        return run.floor_of_text(SPHERES, *FEW), run.text

    def test_says_the_floor_and_whether_it_is_one(self):
        found, text = self.floor_of_spheres()
        self.assertIn("ranks of the true S, in fifths", text)
        self.assertEqual(sum(found["ranks"]), 40)
        self.assertEqual(found["all"]["estimate"]["readings"], 40)
        self.assertLess(found["all"]["true"]["mean"], 0.3)  # without a reading .3
        listed = self.run_floor(str(EXAMPLES / "paper_learning.toml"), exit_code=2)
        self.assertIn("sweep.set", listed.stderr)

    def test_takes_the_frames_of_a_networks_input(self):
        # Where no load changes by more than the largest stress, no second frame is kept: four frames are one and zeros, and tell as
        # much. Where every frame is kept they tell more.
        text = ('[sweep]\ncontacts = 100\nseed = 3\npress_rows = true\n[contact]\nfriction = { uniform = [0.1, 1.0] }\n'
                '[indenter]\nshape = "parabola"\nradius = { log_uniform = [5, 50] }\n[load]\nindentation = 0.1\n[load.irregular]\n'
                'press_steps = 2\nstroke = { uniform = [0.05, 0.2] }\nstroke_steps = 4\n')

        def estimate(*history):
            found = self.floor_of_text(text, "--bank", "500", "--readings", "40", "--walkers", "8", "--iterations", "12", *history)
            return found["all"]["estimate"]["mean"], found["all"]["estimate"]["standard_error"]
        (one, error), (zeros, its) = estimate(), estimate("--history", "4", "--history-change", "1")
        self.assertAlmostEqual(zeros, one, delta=3 * math.hypot(error, its))
        self.assertLess(estimate("--history", "4", "--history-change", "0")[0], 0.8 * min(one, zeros))
        file = str(EXAMPLES / "random_sweep.toml")
        self.assertIn("--history", self.run_floor(file, "--history", "0", exit_code=2).stderr)
        self.run_floor(file, "--history-change", "0.2", exit_code=2)  # one frame has no change

    def test_refuses_a_network_of_another_target(self):
        class Network:
            inputs = 4

            @staticmethod
            def metadata(key):
                return {"target": "stick_fraction"}.get(key, "")
        with self.assertRaisesRegex(InputError, "^n.onnx: stick_fraction; a network of slip_index"):
            floor._network_errors({"n.onnx": Network}, np.zeros((2, 1, 4)), None, None)

    def test_three_axes_tell_more_than_one(self):
        three, one = self.floor_of_spheres()[0], self.floor_of_text(SPHERES.replace("thickness", "axes = 1\nthickness"), *FEW)
        self.assertLess(three["all"]["true"]["mean"], 0.8 * one["all"]["true"]["mean"])
        self.assertLessEqual({line["family"] for line in three["classes"]}, set(floor.PAD_FAMILIES))

    def test_a_friction_that_is_told_leaves_less_open(self):
        untold, told = self.floor_of_spheres()[0], self.floor_of_text(SPHERES, *FEW, "--friction-spread", "0.05")
        self.assertIn("mu told within 0.05", self.text)
        self.assertLess(told["all"]["true"]["mean"], 0.8 * untold["all"]["true"]["mean"])

    def test_compares_skins(self):
        # A line of the table is the floor of a file with that sensor. Eight tactels on the area of four have half the pitch.
        few = ("--rung", "pad-8", "--bank", "200", "--readings", "10", "--noise", "0.1", "--walkers", "8", "--iterations", "10")
        skins = self.floor_of_text(SPHERES, *few, "--tactels", "8", "--tactels", "4", "--thickness", "3")["skins"]
        self.assertIn("     64   2.35           3", self.text)
        eight = SPHERES.replace("thickness = 4", "thickness = 3\ntactels = [8, 8]\npitch = 2.35")
        self.assertEqual(self.floor_of_text(eight, *few)["all"], skins[0]["all"])
        self.assertIn("thickness", self.run_floor(str(EXAMPLES / "random_sweep.toml"), *few, "--thickness", "1e-9", exit_code=2).stderr)


if __name__ == "__main__":
    unittest.main()
