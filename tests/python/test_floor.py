# SPDX-License-Identifier: Apache-2.0
"""Floors of problems whose Bayes risk is known, and the command."""
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
ONE_FAMILY = {"all": ["one"]}


def bank_of(frames, slip_index, largest=None):
    """frames: [rows, history, inputs]"""
    newest = np.abs(frames[:, 0]).max(1)
    return floor.Bank(frames, slip_index, newest if largest is None else np.full(len(frames), float(largest)),
                      np.zeros((1, len(frames)), int))


def covariance_density(frames, sigma, gain, reading):
    """The logarithm by the covariance matrices themselves, without (2 pi)^(-size/2)."""
    total = 0.0
    for f, x in zip(frames.T, reading.T):
        covariance = sigma**2 * np.eye(len(f)) + gain**2 * np.outer(f, f)
        r = x - f
        total -= 0.5 * (r @ np.linalg.solve(covariance, r) + np.linalg.slogdet(covariance)[1])
    return total


class Density(unittest.TestCase):
    def test_is_that_of_the_covariance(self):
        random = np.random.default_rng(5)
        for history in (1, 3):
            for noise, gain in ((0.01, 0.0), (0.05, 0.2), (2e-4, 0.1)):  # the last: residuals row by row
                frames = random.standard_normal((5, history, 4))
                sigma = noise * np.abs(frames).max((1, 2))
                readings = frames[:3] * 1.01
                found = floor.LogDensity(frames, sigma, gain)(readings)
                for k, reading in enumerate(readings):
                    for row in range(len(frames)):
                        exact = covariance_density(frames[row], sigma[row], gain, reading)
                        # Terms of (f / sigma)^4 gain^2 <= 1e11 cancel, each rounded to 1e-16.
                        self.assertAlmostEqual(found[k, row], exact, delta=1e-8 * abs(exact) + 1e-3)


class Medians(unittest.TestCase):
    def test_is_where_half_of_the_weight_lies(self):
        values = np.array([1.0, 2, 3, 4])
        weights = np.array([[1, 1, 1, 1], [1, 1, 1, 4], [0, 0, 1, 0]], np.float32)
        self.assertEqual(floor.weighted_median(values, weights).tolist(), [2, 4, 3])

    def test_of_many_blocks_is_that_of_one_sum(self):
        random = np.random.default_rng(1)
        values, weights = np.sort(random.random(5000)), random.random((7, 5000)).astype(np.float32)
        sums = np.cumsum(weights, axis=1, dtype=float)
        exact = [values[np.searchsorted(one, one[-1] / 2)] for one in sums]
        self.assertEqual(floor.weighted_median(values, weights).tolist(), exact)


class KnownFloors(unittest.TestCase):
    def near(self, found, exact, more=0.0):
        for key in ("lower", "upper"):
            error = found["all"][key]
            self.assertAlmostEqual(error["mean"], exact, delta=4 * error["standard_error"] + more, msg=key)

    def test_of_a_linear_gaussian_problem_is_its_posterior(self):
        # S is a normal number of deviation 0.2, and the frame is (1, S) read with noise 0.1: the posterior of S has the variance
        # 1 / (1 / 0.2^2 + 1 / 0.1^2) = 0.008, and the mean of |error| is sqrt(2 / pi) sqrt(0.008) = 0.07136.
        def drawn(rows, seed):
            s = 0.2 * np.random.default_rng(seed).standard_normal(rows)
            return bank_of(np.stack([np.ones(rows), s], 1)[:, None, :], s)
        options = floor.Options(noise=0.1, readings=3000)
        found = floor.floor_of(drawn(5000, 1), drawn(6000, 2), options, ONE_FAMILY)
        exact = math.sqrt(2 / math.pi) * math.sqrt(0.008)
        # Of 5000 rows in one dimension some 2000 lie within the noise: the numbers differ by the readings' scatter alone.
        self.near(found, exact)
        self.assertLess(found["all"]["lower"]["standard_error"], 0.02 * exact)
        self.assertEqual(found["spread"], 1)
        self.assertEqual([step["bank_rows"] for step in found["convergence"]], [312, 1250, 5000])

    def test_of_a_history_is_its_posterior(self):
        # The same S, read in two more frames of which it is twice and half: 1 / (1 / 0.2^2 + (1 + 4 + 1 / 4) / 0.1^2). The noise is
        # over a stress of 2 MPa, that of the contact. The rows of a contact before its first frame have zeros there.
        for begun, told in ((False, 1.25), (True, 5.25)):
            def drawn(rows, seed):
                s = 0.2 * np.random.default_rng(seed).standard_normal(rows)
                one = np.ones(rows)
                frames = np.stack([one, s, one * begun, 2 * s * begun, one, s / 2], 1).reshape(rows, 3, 2)
                return bank_of(frames, s, largest=2)
            options = floor.Options(noise=0.05, noise_of_contact=True, history=3, readings=1000)
            found = floor.floor_of(drawn(3000, 1), drawn(2000, 2), options, ONE_FAMILY)
            self.near(found, math.sqrt(2 / math.pi / (25 + told * 100)))

    def test_of_one_element_has_a_closed_form(self):
        # One element touches: r = Q / P is read without error, S = r / mu, and mu is uniform in 0.1 ... 1, S in 0 ... 1. Given r, mu
        # has the density 1 / mu (dS = dr / mu) from max(r, 0.1) to 1, and S = r / mu is log-uniform from a = r to b = min(1, 10 r):
        # its median is the geometric mean of the ends, its mean absolute deviation (sqrt b - sqrt a)^2 / ln(b / a). Over r, whose
        # density is ln(b / a) / 0.9, the floor is the integral of (sqrt b - sqrt a)^2 / 0.9: with (sqrt 10 - 1)^2 r up to 0.1, then
        # 1 - 2 sqrt r + r.
        def tail(r):
            return r - 4 / 3 * r**1.5 + r * r / 2
        exact = ((math.sqrt(10) - 1)**2 * 0.005 + tail(1) - tail(0.1)) / 0.9
        self.assertAlmostEqual(exact, 0.135, delta=0.01)

        def drawn(rows, seed):
            random = np.random.default_rng(seed)
            mu, s = random.uniform(0.1, 1, rows), random.random(rows)
            return bank_of(np.stack([-np.ones(rows), mu * s], 1)[:, None, :], s)
        options = floor.Options(noise=0.001, readings=3000)
        found = floor.floor_of(drawn(30000, 1), drawn(6000, 2), options, ONE_FAMILY)
        # Some 60 rows lie within the noise of a reading: the posterior's median is off by 1 / (4 60) of its spread squared, some 2 %
        # of the error, and the readings scatter.
        self.near(found, exact, 0.02 * exact)

    def test_a_bigger_bank_narrows_the_gap(self):
        # In 20 dimensions a bank of 16 000 rows is thin: the numbers stand apart, and more rows bring them together.
        def drawn(rows, seed):
            frames = 1 + 0.3 * np.random.default_rng(seed).standard_normal((rows, 1, 20))
            return bank_of(frames, 0.5 + 0.1 * (frames[:, 0, 1] - 1) / 0.3)
        options = floor.Options(noise=0.05, readings=500)
        steps = floor.floor_of(drawn(16000, 1), drawn(1000, 2), options, ONE_FAMILY)["convergence"]
        for before, step in zip(steps, steps[1:]):
            self.assertGreaterEqual(step["lower"], 0.9 * before["lower"])
            self.assertLess(step["upper"], before["upper"])
        self.assertTrue(all(step["lower"] < step["upper"] for step in steps))


class PadRows(unittest.TestCase):
    def test_have_classes_of_torque_and_tactels(self):
        # Four steps of a contact on two tactels with three axes: S of 0.6 with 0.45, 0.3 and 0.1 by the force alone, and a small S.
        frames = np.array([[-1, -0.04, 9, 9, 9, 9], [-1, -0.06, 0, 0, 0, 0], [-1, 1, 0, 0, 0, 0], [0, -1, 0, 0, 0, 0]], np.float32)
        class Rows(types.SimpleNamespace):
            def __len__(self):
                return len(self.contact)
        rows = Rows(
            axes=3, frames=frames, slip_index=np.array([0.6, 0.6, 0.6, 0.04]), force_ratio=np.array([0.45, 0.3, 0.1, 0.0]),
            status=np.zeros(4), contact=np.zeros(4, int), step=np.arange(4), indenter=np.full(4, 2), contact_nodes=np.full(4, 99))
        bank, _ = floor._collect(rows, floor.Options())
        self.assertEqual(bank.classes.tolist(), [[2, 2, 2, 2], [1, 2, 3, 0], [0, 0, 0, 0]])
        rows.frames = np.concatenate([frames[:, :2]] * 3 + [frames[:, 2:]] * 2, axis=1)[:, :18]  # six tactels
        touching = floor._collect(rows, floor.Options())[0].classes[2]
        self.assertEqual(touching.tolist(), [0, 1, 1, 0])  # three; six; six; three


class Command(unittest.TestCase):
    def run_floor(self, *words, exit_code=0):
        ran = subprocess.run([sys.executable, "-m", "tactel.floor", *words, "--quiet"], capture_output=True, text=True)
        self.assertEqual(ran.returncode, exit_code, ran.stderr)
        return ran

    def floor_json(self, *words):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "floor.json")
            self.text = self.run_floor(*words, "--json", file).stdout
            with open(file, encoding="utf-8") as text:
                return json.load(text)

    def test_gives_numbers_below_and_above(self):
        found = self.floor_json(str(EXAMPLES / "random_sweep.toml"), "--noise", "0.02", "--bank", "4000", "--readings", "200")
        self.assertIn("rows of the bank", self.text)
        self.assertLess(found["all"]["lower"]["mean"], found["all"]["upper"]["mean"])
        self.assertGreater(found["all"]["estimate"]["mean"], 0)
        self.assertGreaterEqual(found["bank_rows"], 4000)
        self.assertEqual(len(found["convergence"]), 3)
        listed = self.run_floor(str(EXAMPLES / "paper_learning.toml"), exit_code=2)
        self.assertIn("sweep.set", listed.stderr)

    def test_takes_the_frames_of_a_networks_input(self):
        # Where no load changes by more than the largest stress, no second frame is kept: four frames are one and zeros, with the
        # estimate of one frame. Where every frame is kept they tell more.
        sweep = ('[sweep]\ncontacts = 100\nseed = 3\npress_rows = true\n[contact]\nfriction = { uniform = [0.1, 1.0] }\n'
                 '[indenter]\nshape = "parabola"\nradius = { log_uniform = [5, 50] }\n[load]\nindentation = 0.1\n[load.irregular]\n'
                 'press_steps = { uniform = [1, 3] }\nstroke = { uniform = [0.05, 0.2] }\nstroke_steps = 4\n')
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "short.toml")
            with open(file, "w", encoding="utf-8") as text:
                text.write(sweep)

            def estimate(*history):
                return self.floor_json(file, "--bank", "500", "--readings", "10", *history)["all"]["estimate"]["mean"]
            one = estimate()
            self.assertAlmostEqual(estimate("--history", "4", "--history-change", "1"), one, delta=1e-9 * one)
            self.assertLess(estimate("--history", "4", "--history-change", "0"), 0.9 * one)
            self.assertNotEqual(estimate("--noise-of", "contact"), one)  # first steps of a press are below the contact's largest
            self.assertIn("--history", self.run_floor(file, "--history", "0", exit_code=2).stderr)
            self.run_floor(file, "--history-change", "0.2", exit_code=2)  # one frame has no change

    def test_refuses_a_network_of_another_target(self):
        class Network:
            inputs = 4

            @staticmethod
            def metadata(key):
                return {"target": "stick_fraction"}.get(key, "")
        with self.assertRaisesRegex(InputError, "a network of slip_index"):
            floor._network_errors({"n.onnx": Network}, np.zeros((2, 1, 4)), None, None)

    def test_takes_pads(self):
        # Three axes tell more than the normal one alone, of the same contacts; a network is judged beside.
        sweep = ('[sweep]\ncontacts = 100\nseed = 3\n[sensor]\nkind = "pad"\nthickness = 4\n[contact]\nfriction = { uniform = [0.1, 1.0] }\n'
                 '[indenter]\nshape = "sphere"\nradius = { log_uniform = [5, 50] }\nposition = [{ uniform = [-3, 3] }, 0]\n[load]\n'
                 'indentation = 0.4\n[load.irregular]\npress_steps = 1\nstroke = { uniform = [0.1, 0.5] }\nstroke_steps = 2\n'
                 'direction = { uniform = [0, 360] }\ntwist = { uniform = [-5, 5] }\n')
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "pad.toml")

            def found(axes):
                with open(file, "w", encoding="utf-8") as text:
                    text.write(sweep.replace("thickness", f"axes = {axes}\nthickness"))
                return self.floor_json(file, "--bank", "500", "--readings", "60")
            three, one = found(3), found(1)
            self.assertLess(three["all"]["estimate"]["mean"], 0.8 * one["all"]["estimate"]["mean"])
            self.assertEqual({line["family"] for line in three["classes"]}, set(floor.PAD_FAMILIES))

    def test_compares_skins(self):
        # A line of the table is the floor of a file with that sensor.
        sweep = str(EXAMPLES / "random_sweep.toml")
        few = ("--bank", "4000", "--readings", "20", "--noise", "0.1")
        skins = self.floor_json(sweep, *few, "--tactels", "8", "--tactels", "21", "--thickness", "3")["skins"]
        self.assertIn("      8   2.86           3", self.text)
        self.assertEqual(skins[1]["tactels"], 21)
        self.assertAlmostEqual(skins[0]["pitch"], 20 / 7)
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "eight.toml")
            with open(sweep, encoding="utf-8") as text, open(file, "w", encoding="utf-8") as eight:
                eight.write(text.read().replace("[sensor]", "[sensor]\ntactels = 8\nthickness = 3"))
            self.assertEqual(self.floor_json(file, *few)["all"], skins[0]["all"])
            self.assertIn("thickness", self.run_floor(file, *few, "--thickness", "1e-9", exit_code=2).stderr)


if __name__ == "__main__":
    unittest.main()
