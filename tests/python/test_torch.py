# SPDX-License-Identifier: Apache-2.0
"""Inputs of sets for networks of other programs, and tactel.torch with a stand-in for PyTorch."""
import importlib
import pathlib
import sys
import types
import unittest
from unittest import mock

import numpy as np
import tactel

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"


class Inputs(unittest.TestCase):
    def setUp(self):
        self.set = tactel.Sweep(EXAMPLES / "uskin_grips.toml").generate(40)

    def test_one_frame_is_the_set(self):
        inputs, target = self.set.inputs()
        good = np.isfinite(self.set.slip_index)
        self.assertTrue(good.all())
        self.assertTrue(np.array_equal(inputs, self.set.frames) and np.array_equal(target, self.set.slip_index))

    def test_the_rest_stands_behind_the_frame(self):
        frames = self.set.frames
        inputs, target = self.set.inputs(reference="rest", target="slid")
        self.assertEqual(inputs.shape, (len(frames), 2 * frames.shape[1]))
        self.assertTrue(np.array_equal(inputs[:, :frames.shape[1]], frames))
        rows = {row.tobytes() for row in frames}
        self.assertTrue(all(rest.tobytes() in rows for rest in inputs[:, frames.shape[1]:]))  # each rest is a frame of the set
        self.assertTrue(((target >= 0) & (target < 1)).all() and target.max() > 0.3)

    def test_what_is_told_stands_behind_the_frame(self):
        inputs, target = self.set.inputs(friction=True)
        self.assertTrue(np.array_equal(inputs[:, :-2], self.set.frames) and np.array_equal(target, self.set.slip_index))
        self.assertAlmostEqual((inputs[:, -2] > 0).mean(), 0.75, delta=0.1)

    def test_a_network_learns_the_same_from_them(self):
        pressed = tactel.Sweep(EXAMPLES / "pad_learning.toml").generate(30)  # with the rows of the pressing
        inputs, target = pressed.inputs(history=2)
        network = tactel.train(pressed, (inputs.shape[1], 5, 1), schedule="batch", cycles=1, history=2)[0]
        answers = network(inputs)
        self.assertAlmostEqual(float(np.abs(answers - target).mean()), network.learning_errors.mean, places=4)

    def test_wrong_calls_are_named(self):
        with self.assertRaisesRegex(tactel.InputError, "reference: zero; rest"):
            self.set.inputs(reference="zero")
        with self.assertRaisesRegex(tactel.InputError, "target"):
            self.set.inputs(target="colour")


class Torch(unittest.TestCase):
    def batches(self, worker, **options):
        data = types.ModuleType("torch.utils.data")
        data.IterableDataset, data.get_worker_info = object, lambda: worker
        torch = types.ModuleType("torch")
        torch.from_numpy = lambda array: array
        with mock.patch.dict(sys.modules, {"torch": torch, "torch.utils": types.ModuleType("torch.utils"), "torch.utils.data": data}):
            sys.modules.pop("tactel.torch", None)
            contacts = importlib.import_module("tactel.torch").Contacts
            return [batch[0] for batch in contacts(EXAMPLES / "random_sweep.toml", 50, batches=5, seed=3, **options)]

    def test_workers_share_the_batches_of_one(self):
        alone = self.batches(None)
        self.assertEqual(len(alone), 5)
        first, second = (self.batches(types.SimpleNamespace(id=k, num_workers=2)) for k in (0, 1))
        for found, expected in ((first, alone[::2]), (second, alone[1::2])):
            self.assertTrue(len(found) == len(expected) and all(np.array_equal(a, b) for a, b in zip(found, expected)))

    def test_shuffled_rows_are_those_of_the_batches(self):
        alone, mini = (self.batches(None, rows=lambda found: (np.column_stack([found.frames, found.slip_index]),), **options)
                       for options in ({}, {"shuffle": 64}))
        at = 0
        for batch in alone:  # frames and answers stay together
            parts = mini[at:at + -(-len(batch) // 64)]
            self.assertTrue(all(len(part) == 64 for part in parts[:-1]))
            rows = np.concatenate(parts)
            self.assertFalse(np.array_equal(rows, batch))
            np.testing.assert_array_equal(rows[np.lexsort(rows.T)], batch[np.lexsort(batch.T)])
            at += len(parts)
        self.assertEqual(at, len(mini))
        again = self.batches(None, rows=lambda found: (np.column_stack([found.frames, found.slip_index]),), shuffle=64)
        self.assertTrue(all(np.array_equal(a, b) for a, b in zip(mini, again)))
        with self.assertRaisesRegex(tactel.InputError, "shuffle: 0; rows"):
            self.batches(None, shuffle=0)

    def test_rows_are_those_that_are_asked_for(self):
        self.assertEqual(self.batches(None, rows=lambda found: (found.P,))[0].ndim, 1)


if __name__ == "__main__":
    unittest.main()
