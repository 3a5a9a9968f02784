# SPDX-License-Identifier: Apache-2.0
"""Steps of contacts with a pad in the Python package, against whole paths, by wrench and by gaps, and from a state."""

import copy
import pickle
import threading
import unittest

import numpy as np
import tactel

PAD = tactel.Pad(tactels=(4, 3), pitch=(1.0, 1.5), thickness=2.0, young=1.0)
MU = np.array([0.3, 0.5, 0.8])


def ball(count=3, friction=MU, **options):
    steps = tactel.PadStepper(PAD, count, friction, cells=12, cell=0.4, **options)
    steps.shapes(tactel.Sphere(8.0))
    return steps


class Steps(unittest.TestCase):
    def test_steps_are_close_to_the_path(self):
        poses = [(0.25, 0.05 * k, 0.02 * k, 0.5 * k) for k in range(1, 5)]
        load = tactel.Press(0.25).drag_to([pose[1:3] for pose in poses], twist=[pose[3] for pose in poses])
        steps = ball()
        for k in (1, 2, 3, 4):
            steps.move([0.25 * k / 4, 0, 0, 0])
        found = [steps.move(pose, travel=False) for pose in poses]
        paths = tactel.solve_many([tactel.Scene(PAD, tactel.PadIndenter(tactel.Sphere(8.0)), friction=mu, load=load) for mu in MU])
        for i in range(len(MU)):
            S = np.array([out.slip_index[i] for out in found])
            np.testing.assert_allclose(S, paths.slip_index[i, 1:], atol=0.02)  # seven cells across
            P = np.array([out.force[i, 0] for out in found])
            np.testing.assert_allclose(P, paths.P[i, 1:], rtol=0.04)

    def test_a_wrench_is_met_and_held(self):
        steps = ball()
        steps.press([0.5, 0, 0, 0])
        wrench = np.array([(0.5, 0.5 * mu * 0.6, 0, 0.01) for mu in MU])
        out = steps.press(wrench)
        np.testing.assert_allclose(out.force[:, :3], wrench[:, :3], atol=2.1e-3 * 0.5)
        self.assertFalse((out.flags & (steps.UNMET | steps.OPEN | steps.SLIDES)).any())
        again = steps.press(wrench)
        np.testing.assert_array_equal(again.slip_index, out.slip_index)
        np.testing.assert_array_equal(again.solves, 0)
        self.assertTrue((steps.press([0, 0, 0, 0]).flags == steps.OPEN).all())

    def test_gaps_are_those_of_a_shape(self):
        by_shape, by_gaps = ball(), tactel.PadStepper(PAD, 3, MU, cells=12, cell=0.4)
        height = 8 - np.sqrt(64 - by_gaps.cell_x**2 - by_gaps.cell_y**2)
        last = np.zeros(3)
        for depth, x in ((0.1, 0), (0.2, 0), (0.2, 0.05), (0.2, 0.1)):
            a = by_shape.move([depth, x, 0, 0], travel=False)
            b = by_gaps.move(gaps=np.tile(height - depth, (3, 1)), motion=np.array([x, 0, 0]) - last)
            last = np.array([x, 0, 0])
            np.testing.assert_allclose(b.force[:, :3], a.force[:, :3], atol=1e-4)  # fp32 heights
            np.testing.assert_allclose(b.slip_index, a.slip_index, atol=2e-3)

    def test_shapes_travel(self):
        steps = ball()
        steps.shapes(tactel.Sphere(4.0))
        for k in range(1, 5):
            steps.move([0.025 * k, 0, 0, 0])
        for k in range(20):  # far past sliding
            out = steps.move([0.1, 0.05 * k, 0, 0])
        pressure = steps.tractions()[:, 0]
        middle = (pressure @ steps.cell_x) / pressure.sum(1)
        np.testing.assert_allclose(middle, 0.95, atol=0.1)  # a quarter of a cell
        self.assertTrue((out.flags & steps.SLIDES).all())

    def test_frames_sum_to_the_pressure_of_a_wide_array(self):
        wide = tactel.Pad(tactels=(32, 32), pitch=0.75, thickness=2.0, young=1.0)
        steps = tactel.PadStepper(wide, 1, 0.5, cells=12, cell=0.4)
        steps.shapes(tactel.Sphere(8.0))
        steps.press([0.5, 0, 0, 0])
        out = steps.press([0.5, 0.1, -0.05, 0])
        sums = out.frames.reshape(3, -1).sum(1) * 0.75**2  # MPa times mm^2
        np.testing.assert_allclose(sums, [-0.5, 0.1, -0.05], atol=3e-3)  # what the rubber beyond the array bears

    def test_a_state_goes_on(self):
        steps, other = ball(), ball(2, MU[[2, 0]])
        steps.press([0.5, 0, 0, 0])
        steps.press([0.5, 0.05, 0, 0])
        other.set_state(steps.state([2, 0]))
        a, b = steps.press([0.5, 0.1, 0, 0]), other.press([0.5, 0.1, 0, 0])
        np.testing.assert_array_equal(b.force, a.force[[2, 0]])
        np.testing.assert_array_equal(b.frames, a.frames[[2, 0]])
        steps.reset([True, False, True])
        flags = steps.press([[0.5, 0.1, 0, 0], [0, 0, 0, 0], [0.5, 0, 0, 0]]).flags
        self.assertEqual(flags[1], steps.OPEN)

    def test_contacts_that_a_mask_leaves_out_stay_as_they_are(self):
        for precision in ("fp32", "fp64"):
            steps, all_step = (ball(precision=precision) for _ in range(2))
            for each in (steps, all_step):
                each.press([0.5, 0, 0, 0])
                before = each.press([0.5, 0.05, 0, 0])
            state, frames = steps.state(), before.frames.copy()
            out, other = steps.press([0.5, 0.1, 0, 0], mask=[True, False, True]), all_step.press([0.5, 0.1, 0, 0])
            expected = {name: np.where(np.arange(3).reshape((3,) + (1,) * (getattr(out, name).ndim - 1)) == 1, getattr(before, name), getattr(other, name))
                        for name in ("force", "pose", "slip_index", "stick_fraction", "flags", "residual", "solves", "sweeps")}
            for name, values in expected.items():
                np.testing.assert_array_equal(getattr(out, name), values, name)
            np.testing.assert_array_equal(out.frames[[0, 2]], other.frames[[0, 2]])
            np.testing.assert_array_equal(out.frames[1], frames[1])
            np.testing.assert_array_equal(steps.state([1]), state[1:2])
            steps.press([[0, 0, 0, 0], [np.nan] * 4, [0, 0, 0, 0]], mask=[True, False, True])  # a wrench that nobody reads
            np.testing.assert_array_equal(steps.state([1]), state[1:2])

    def test_contacts_that_are_reset_are_as_new_ones(self):
        """Bits of a first press do not depend on what the neighbours have behind them."""
        depth = np.linspace(0.5, 8, 32)
        wrench = np.stack([depth, 0 * depth, 0 * depth, 0 * depth], 1)
        fresh = ball(32, 0.5, most_solves=6).press(wrench).frames.copy()
        steps, mask = ball(32, 0.5, most_solves=6), np.arange(32) % 3 == 1
        for part in (0.3, 0.6):
            steps.press(wrench * part + [0, 0.02 * part, 0, 0])
        steps.reset(mask)
        np.testing.assert_array_equal(steps.press(wrench).frames[mask], fresh[mask])

    def test_a_copy_goes_on_as_the_original(self):
        given = np.array([0.3, 0.5, 0.8])
        by_shape = tactel.PadStepper(PAD, 3, given, cells=12, cell=0.4, precision="fp64")
        given[:] = 0.1  # the stepper has its own
        by_shape.shapes([tactel.PadIndenter(tactel.Sphere(8.0))] * 3)
        by_shape.places([[0.1, 0, 0], [0, 0.2, 0], [0.1, 0.1, 10]])
        by_shape.press([0.5, 0, 0, 0])
        by_shape.set_friction([0.4, 0.6, 0.7])
        by_gaps = ball()
        by_gaps.move(gaps=8 - np.sqrt(64 - by_gaps.cell_x**2 - by_gaps.cell_y**2) - 0.1)
        for steps in (by_shape, by_gaps):
            copies = [pickle.loads(pickle.dumps(steps)), copy.deepcopy(steps)]
            out = steps.press([0.5, 0.1, 0.05, 0.01])
            for other in copies:
                np.testing.assert_array_equal(other.press([0.5, 0.1, 0.05, 0.01]).force, out.force)
                np.testing.assert_array_equal(other.state(), steps.state())

    def test_frames_belong_to_the_last_step(self):
        steps = ball()
        out = steps.press([0.5, 0, 0, 0])
        self.assertEqual(out.frames.shape, (3, 36))
        self.assertEqual(out.frames.dtype, np.float32)
        with self.assertRaises(ValueError):
            out.frames[0] = 1
        if np.__version__ >= "1.23":
            np.testing.assert_array_equal(np.from_dlpack(out), out.frames)
        steps.press([0.4, 0, 0, 0])
        with self.assertRaisesRegex(tactel.InputError, "before the next step"):
            out.frames

    def test_a_stepper_is_one_threads_at_a_time(self):
        steps, alone = ball(512, 0.5), ball(1, 0.5).move([0.25, 0, 0, 0]).force
        made, refused, other = [], [], []

        def call():
            for _ in range(10):
                try:
                    made.append(np.array(steps.move([0.25, 0, 0, 0]).force))
                    steps.state([0])
                except tactel.InputError as error:
                    refused.append(str(error))
                except Exception as error:
                    other.append(error)

        threads = [threading.Thread(target=call) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(other, [])
        self.assertEqual(set(refused), {"PadStepper: a call while another thread is in one; must wait for it, or make another"})
        self.assertTrue(made)
        for force in made:
            np.testing.assert_allclose(force, np.repeat(alone, 512, axis=0), rtol=5e-3, atol=1e-3)  # tolerance of the sweeps: 1e-3

    def test_a_grid_is_fitted_to_a_pad_with_sides(self):
        pad = PAD.with_(length=6.0, width=3.0)
        fitted, own = tactel.PadStepper(pad, 1, 0.5, cells=12), tactel.PadStepper(pad, 1, 0.5, cells=[12, 4], cell=(0.5, 0.4))
        for steps, x, y in ((fitted, 6.0, 3.0), (own, 6.0, 1.6)):
            for places, length in ((steps.cell_x, x), (steps.cell_y, y)):
                sides = np.unique(np.round(places, 9))
                self.assertAlmostEqual(len(sides) * (sides[1] - sides[0]), length)
        self.assertEqual(len(fitted.cell_x), 144)
        with self.assertRaisesRegex(tactel.InputError, "one of 12 x 12 cells of .*; must be one of 12 x 4 cells"):
            own.set_state(fitted.state())
        for steps, flags in ((fitted, 0), (own, own.EDGE | own.REACH)):
            steps.shapes(tactel.Box((9.0, 9.0)))
            self.assertEqual(steps.move([0.05, 0, 0, 0]).flags[0], flags)
        self.assertEqual(fitted.move([0.1, 0, 0, 0]).flags[0], fitted.DEEP)  # 5 % of the thickness
        self.assertTrue(fitted.move([0.1, 1e20, 0, 0]).flags[0] & fitted.INVALID)

    def test_what_is_wrong_is_said(self):
        with self.assertRaisesRegex(tactel.InputError, "cell: 0.5; must be 0.25 mm at most, as 16 cells lie within the pad"):
            tactel.PadStepper(PAD.with_(length=4, width=5), 3, MU, cell=0.5)
        with self.assertRaisesRegex(tactel.InputError, "friction"):
            tactel.PadStepper(PAD, 2, MU)
        with self.assertRaisesRegex(tactel.InputError, "count: 2147483648; must be .* at most"):
            tactel.PadStepper(PAD, 2**31, 0.5)
        steps = ball()
        state = steps.state()
        with self.assertRaisesRegex(tactel.InputError, "one of 12 x 12 cells of 0.2 x 0.2 H, nu 0.45; must be one of 12 x 12 cells of 0.15 x 0.15 H"):
            tactel.PadStepper(PAD, 3, MU, cells=12, cell=0.3).set_state(state)
        state[1, -1] = np.nan
        with self.assertRaisesRegex(tactel.InputError, "finite"):
            steps.set_state(state)
        for wrong in (lambda: steps.press(np.zeros((2, 4))), lambda: steps.move(), lambda: steps.set_state(np.zeros((3, 7))),
                      lambda: steps.shapes([tactel.PadIndenter(tactel.Sphere(8))] * 2), lambda: steps.reset([True]),
                      lambda: steps.press([1, 0, 0, 0], cover=np.ones(144)), lambda: steps.state([7]),
                      lambda: steps.press([1, 0, 0, 0], mask=[True]), lambda: steps.press([1, 0, 0, 0], mask=[])):
            with self.assertRaises(tactel.InputError):
                wrong()
        out = steps.press([[0.5, 0, 0, 0], [np.nan, 0, 0, 0], [0.5, 0, 0, 0]])
        self.assertEqual(list((out.flags & steps.INVALID) != 0), [False, True, False])


if __name__ == "__main__":
    unittest.main()
