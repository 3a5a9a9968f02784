# SPDX-License-Identifier: Apache-2.0
"""tactel.uskin on small files of our own in the format of slip_detection_dataset_2021."""

import pathlib
import tempfile
import unittest

import h5py
import numpy as np
import tactel
import tactel.uskin
from uskin_file import HELD, REST, by_hand, write
class Trials(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name) / "slips.h5"

    def read(self, **options):
        return list(tactel.uskin.trials(self.path, **options))

    def test_a_grasp_computed_by_hand(self):
        normal, shear, label, slip_index = by_hand()
        for sign in (1, -1):  # the sensor may count pressure either way
            self.path.unlink(missing_ok=True)
            write(self.path, sign * normal, shear, label)
            (trial,) = self.read()
            self.assertEqual(trial.name, "PLANNER/brush/Pose1/Exp1")
            np.testing.assert_allclose(trial.P, 60, rtol=1e-13)
            self.assertAlmostEqual(trial.friction, 0.4, places=12)
            np.testing.assert_allclose(trial.slip_index, slip_index, atol=1e-12)
            np.testing.assert_allclose(trial.frames, np.hstack([-normal, shear])[REST:], atol=1e-5)  # fp32
            np.testing.assert_array_equal(trial.slipping, [False] * 20 + [True] * 20)
            self.assertAlmostEqual(trial.time[0], 5 * 5.5e-3, places=12)

    def test_no_slip_no_index(self):
        normal, shear, label, _ = by_hand()
        write(self.path, normal, shear, np.where((label == 1) | (label == 5), 4, label))
        write(self.path, normal, shear, np.where(label == 3, 4, label), name="PLANNER/brush/Pose1/Exp2")  # never grasped
        (trial,) = self.read()
        self.assertTrue(np.isnan(trial.friction) and np.isnan(trial.slip_index).all())

    def test_the_object_let_go_is_no_contact(self):
        normal, shear, label, _ = by_hand()
        label[-3] = 2
        write(self.path, normal, shear, label)
        self.assertEqual(self.read()[0].label.size, HELD - 3)

    def test_a_simulated_drag(self):
        """Under a layer as thick as the pitch, sums over the inner tactels follow P and Q."""
        sensor = tactel.Sensor(length=42, thickness=6, tactels=8)
        scene = tactel.Scene(sensor, tactel.Parabola(radius=20), friction=0.6, load=tactel.Press(0.3).drag(0.04, steps=60))
        path = tactel.solve(scene)
        still = np.zeros((REST, 6))
        label = [0] * REST + [3] + [1 if slip_index > 0.999 else 0 for slip_index in path.slip_index[1:]]
        counts = {"normal": -1e4 * path.tactels.normal[:, 1:-1], "shear": 1e4 * path.tactels.shear[:, 1:-1]}
        write(self.path, *(np.vstack([still, frames]) for frames in counts.values()), label)
        (trial,) = self.read()
        # What the ends of the layer carry, 4.6 % of P and 7.2 % of Q, is missing from the sums, and cancels in S.
        self.assertAlmostEqual(trial.friction, 0.6, delta=0.6 * (0.046 + 0.072))
        np.testing.assert_allclose(trial.slip_index, path.slip_index, atol=0.02)

    def test_what_is_no_such_file(self):
        normal, shear, label, _ = by_hand()
        wrong = {"times": {"tactile_timestamps": np.arange(3.0)}, "fall": {"tactile_timestamps": -np.arange(float(len(label)))},
                 "labels 7": {"tactile_slips_label": np.full(len(label), 7)}, "finite": {"tactile_data_raw": np.full((18, 3, len(label)), np.nan)},
                 "3 dimensions": {"tactile_data_raw": np.zeros((18, len(label)))}, "no dataset": {"tactile_slips_label": None},
                 "numbers": {"tactile_slips_label": np.array([b"1"] * len(label))}, "0 frames": {"tactile_data_raw": np.zeros((18, 3, 0))}}
        for said, changes in wrong.items():
            with self.subTest(said):
                self.path.unlink(missing_ok=True)
                write(self.path, normal, shear, label, **changes)
                with self.assertRaisesRegex(tactel.InputError, f"PLANNER/brush/Pose1/Exp1.*{said}.*; "):
                    self.read()
        with h5py.File(self.path, "w"):
            pass
        with self.assertRaisesRegex(tactel.InputError, "no group with tactile_data_raw"):
            self.read()
        for options in ({"shear": "z"}, {"row": 3}):
            with self.assertRaisesRegex(tactel.InputError, next(iter(options))):
                self.read(**options)
        with self.assertRaisesRegex(tactel.InputError, "NUL byte"):  # h5py would cut it there
            list(tactel.uskin.trials(f"{self.path}\0x"))


if __name__ == "__main__":
    unittest.main()
