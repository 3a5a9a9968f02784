# SPDX-License-Identifier: Apache-2.0
"""The vector environment of examples/gymnasium_grip.py: 256 grippers on one stepper, reset by mask, copied and pickled."""
import pathlib
import pickle
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples"))
from gymnasium_grip import GripVector  # noqa: E402

ENVS = 256


def actions(step):
    return np.random.default_rng(step).uniform(-0.5, 1, (ENVS, 1))


class Calls:
    """The calls of a stepper, which passes on what they return."""

    def __init__(self, steps):
        self.steps, self.names = steps, []

    def __getattr__(self, name):
        self.names.append(name)
        return getattr(self.steps, name)


def begun(steps):
    envs = GripVector(ENVS)
    envs.reset(seed=3)
    for step in range(steps):
        envs.step(actions(step))
    return envs


class InGymnasium(unittest.TestCase):
    def assert_same(self, found, wanted, where=slice(None)):
        """What two steps returned, in all their bits."""
        for one, other in zip((*found[:4], found[4]["slip_index"]), (*wanted[:4], wanted[4]["slip_index"])):
            np.testing.assert_array_equal(one[where], other[where])

    def test_a_pickled_environment_goes_on_with_its_bits(self):
        envs = begun(12)
        again, ended = pickle.loads(pickle.dumps(envs)), 0
        for step in range(12, 40):
            there, here = again.step(actions(step)), envs.step(actions(step))
            self.assert_same(there, here)
            ended += (here[2] | here[3]).sum()
        self.assertGreater(ended, 20)  # episodes, whose next begin in both with the same numbers

    def test_a_reset_by_mask_is_one_call_and_leaves_the_others(self):
        envs = begun(12)
        other, mask = pickle.loads(pickle.dumps(envs)), np.arange(ENVS) % 3 == 1
        before = envs.press(np.zeros(ENVS, bool)).frames.copy()  # no contact steps: the last answer
        envs.steps = Calls(envs.steps)
        frames, _ = envs.reset(options={"reset_mask": mask})
        self.assertEqual(envs.steps.names, ["set_friction", "reset", "press"])
        np.testing.assert_array_equal(frames[~mask], before[~mask])
        self.assertTrue((envs.age[mask] == 0).all() and (envs.age[~mask] == other.age[~mask]).all())
        alone = GripVector(ENVS)  # those that begin are as if nothing had touched
        alone.mu, alone.weight, alone.grip, alone.pace = envs.mu, envs.weight, envs.grip, envs.pace
        alone.steps.set_friction(envs.mu)
        np.testing.assert_array_equal(frames[mask], alone.press().frames[mask])
        same = ~mask & ~envs.over
        for step in range(12, 40):
            there, here = other.step(actions(step)), envs.step(actions(step))
            self.assert_same(there, here, same)
            same &= ~(here[2] | here[3])  # the next episode has other random numbers
        self.assertGreater(same.sum(), 20)


if __name__ == "__main__":
    unittest.main()
