# SPDX-License-Identifier: Apache-2.0
"""studies/alarms.py and studies/laboratory.py: laws of the laboratory, windows and counts by hand, other sensors by hand, and a few grips
through the program. Usage: check_alarms.py BUILD"""
import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

import numpy as np

TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS.parent / "studies"), str(TESTS / "docs")]
import alarms  # noqa: E402
import laboratory  # noqa: E402

BUILD = pathlib.Path(sys.argv.pop()) if len(sys.argv) > 1 else pathlib.Path("build")


def flags(frames, *spans):
    on = np.zeros(frames, bool)
    for a, b in spans:
        on[a:b] = True
    return on


class Laws(unittest.TestCase):
    """Of the laboratory, which has no reference."""

    @classmethod
    def setUpClass(cls):
        grips = laboratory.draw_seed(1)
        cls.grips = [next(grip for grip in grips if grip.scene == scene) for scene in ("quiet", "pull_slip")]
        cls.hand = laboratory.Hand(cls.grips)
        cls.last = round(cls.grips[0].hold_at * laboratory.RATE) + 50
        for k in range(cls.last + 1):
            cls.hand.frame(k)

    def test_a_held_object_is_carried(self):
        k, grip, q, pressure = self.last, self.grips[0], self.hand.q[0], self.hand.pressure[0]
        force = (q[:, 0] * laboratory.MIRROR).sum() * laboratory.AREA, q[:, 1].sum() * laboratory.AREA
        wanted = -grip.mass[k] * grip.acceleration[k]  # on the object; the tremor shakes it by at most 0.2 of 9.81 m / s^2
        np.testing.assert_allclose(force, wanted, atol=0.04 * np.linalg.norm(wanted))
        np.testing.assert_allclose(pressure.sum((1, 2)) * laboratory.AREA, grip.force[k], rtol=1e-9)

    def test_shear_keeps_to_coulombs_law(self):
        size = np.sqrt((self.hand.q**2).sum(2))
        self.assertLessEqual((size - self.hand.mu * self.hand.pressure).max(), 1e-12)

    def test_springs_slide_where_all_are_at_their_limit(self):
        time, counts, load = laboratory.springs(mu=0.5)
        np.testing.assert_allclose(np.interp([5, 9, 12], time, load), [0.02, 0.02 + 0.65, 1], atol=1e-3)  # 1.3 in four seconds from 7 s on
        rows = counts - counts[:200].mean(0)
        ratio = np.linalg.norm(rows[1200, 0, :, :2].sum(0)) / rows[1200, 0, :, 2].sum()
        self.assertAlmostEqual(ratio, 0.5, delta=0.02)  # gains of 5 %: 0.05 / sqrt(16) of each sum


class Counts(unittest.TestCase):
    def test_judge_by_hand(self):
        quiet = flags(100, (0, 60))
        one = alarms.judge(flags(100, (10, 12), (30, 33), (70, 75)), quiet, (60, 80))
        self.assertEqual((one["false"], one["quiet"], one["on"], one["hit"], one["already"], one["late"]), (2, 60, 5, True, False, False))
        self.assertEqual(alarms.judge(flags(100, (0, 100)), quiet, (60, 80))["false"], 1)  # on from the first quiet frame
        self.assertTrue(alarms.judge(flags(100, (50, 100)), quiet, (60, 80))["already"])
        self.assertTrue(alarms.judge(flags(200, (90, 100)), flags(200), (60, 80))["late"])
        two = alarms.total([one, alarms.judge(flags(100), quiet, None)])
        self.assertEqual((two["slips"], two["hit"], two["holds"], two["alarmed"]), (1, 1, 2, 0.5))
        self.assertAlmostEqual(two["false"], 2 / (120 / 60 / 60))

    def test_latch_by_hand(self):
        on = alarms.latch(np.array([1, 2.4, 2.1, np.nan, 1.9, 2.1]), 2.4)
        self.assertEqual(list(on), [False, True, True, True, False, False])

    def test_a_null_that_tells_finds_its_slips_at_one_false_a_minute(self):
        grips = [alarms.Grip("", "", None, None, flags(3600, (0, 3500)), (3500, 3560)) for _ in range(2)]
        scores = [np.r_[np.zeros(100), one, np.zeros(3399), 5 * np.ones(100)] for one in (4.0, 3.0)]
        found = alarms.total(alarms.at_one(scores, grips))
        self.assertEqual(found["hit"], 1)
        self.assertLessEqual(found["false"], 1.001)

    def test_windows_by_hand(self):
        grip = laboratory.Grip(1, 1, "quiet", "box", {}, {}, {}, 1.0, *[None] * 4, None, 1)
        grip.time, grip.slip, grip.load = np.arange(300) / 60, np.zeros((300, 2)), np.zeros(300)
        grip.slip[200:, :] = np.minimum(np.arange(100) * 0.1, 3)[:, None]  # 0.1 mm at frame 201, beyond 1 mm at 211
        grip.load[100:103] = 0.9
        quiet, hit = alarms.windows(grip)
        self.assertEqual(hit, (201 - 60, 212))
        np.testing.assert_array_equal(quiet, flags(300, (90, 100), (109, 141)))  # S above 0.8, and six frames after
        grip.slip[:] = 0.2
        self.assertEqual((alarms.windows(grip)[0].any(), alarms.windows(grip)[1]), (False, None))


class OtherSensors(unittest.TestCase):
    def test_by_hand(self):
        rows = np.random.default_rng(2).normal(0, 1, (60, 2, 16, 3)) + [3, 0, 100]
        new = lambda kind: alarms.changed(kind, rows)[0]
        np.testing.assert_allclose(new("shear x 2.7")[..., :2], 2.7 * rows[..., :2])
        np.testing.assert_allclose(new("P -20 %")[..., 2].mean(), 80, atol=1)
        turned, mirrored = new("turned by 90 degrees"), new("mirrored")
        np.testing.assert_allclose(turned.sum(2)[..., 1], -rows.sum(2)[..., 0])
        np.testing.assert_allclose(mirrored.sum(2), rows.sum(2) * [-1, 1, 1])
        np.testing.assert_allclose(mirrored[:, :, 0, 1:], rows[:, :, 3, 1:])  # the first tactel was the last of its row
        np.testing.assert_allclose(new("counts x 100000"), 1e5 * rows)
        np.testing.assert_allclose(new("drift of 2 % a second")[-1], rows[-1] * (1 + 0.02 * 59 / 60))
        self.assertEqual(len(new("a third of the rate")), 20)
        self.assertTrue(30 < len(new("30 % lost")) < 54)
        self.assertAlmostEqual(np.diff(new("noise x 2")[..., 0], axis=0).std(), 2 * np.sqrt(2), delta=0.2)
        self.assertEqual(np.abs(new("a dead tactel")[:, 0, 5]).max(), 0)
        self.assertEqual(np.ptp(new("a stuck channel")[:, 0, 5, 0]), 0)
        for kind in alarms.CHANGES:
            self.assertFalse(len(new(kind)) == 60 and np.array_equal(new(kind), rows), kind)

    def test_places_of_events_move_with_the_frames(self):
        grip = alarms.Grip("", "", np.ones((60, 2, 16, 3)), np.arange(60) / 60, flags(60, (0, 30)), (30, 40))
        other = next(alarms.of_changed("half the rate", [alarms.Sensor(np.ones((60, 2, 16, 3)), [], [grip])])).grips[0]
        self.assertEqual((len(other.rows), other.quiet.sum(), other.hit), (30, 15, (15, 20)))


class Played(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_people_by_hand(self):
        frames, start = 400, 300
        rows = np.zeros((frames, 16, 3), np.int32)
        rows[150:, :, 2] = 1000 + np.arange(250)[:, None] % 2
        turn = np.where(np.arange(frames) >= 320, 4500, 0)
        change = np.diff(rows.reshape(frames, 48), axis=0, prepend=0).T.astype(np.int16)
        np.savez(self.folder / "007.npz", change=np.tile(change, 4), scale=0.003, frames=[frames] * 4, start=[start] * 4, end=[340] * 4,
                 turn_object=np.tile(turn, 4), turn_relative=np.tile(turn, 4))
        sensor, = alarms.of_people(self.folder)
        self.assertEqual(([len(hold) for hold in sensor.holds], sensor.empty.shape), ([70] * 3, (100, 1, 16, 3)))
        last = sensor.grips[3]
        self.assertEqual((last.scene, last.hit), ("over 40", (290, 326)))
        self.assertEqual([grip.quiet.sum() for grip in sensor.grips], [0, 0, 0, 70])
        self.assertAlmostEqual(last.rows[200, 0, :, 2].mean(), 3, delta=0.01)

    def test_a_few_grips_through_the_program(self):
        seed = laboratory.draw_seed(3)
        three = [seed[0], *(grip for grip in seed if grip.scene in ("quiet", "pull_slip"))]
        for grip in three:
            grip.force, grip.mass = grip.force[:420], grip.mass[:420]  # of 9 s or more: seven have the slide
        hold, quiet, slides = laboratory.simulate(three)
        zero = hold.counts[:48].mean(0)
        grips = [alarms.Grip(grip.name, grip.scene, grip.counts - zero, grip.time, *alarms.windows(grip)) for grip in (quiet, slides)]
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            sensor = alarms.Sensor(hold.counts[:54] - zero, [hold.counts - zero], grips)
            alarms.Judge(BUILD, self.folder, True).play("laboratory", [sensor], ("hold", "no hold"))
        rows = dict(line.strip("| ").split(" | ", 1) for line in said.getvalue().replace("|Q| / P", "Q / P").splitlines())
        self.assertIn("laboratory, hold, 1 of 1 accepted", rows)
        self.assertTrue(rows["laboratory, no hold"].startswith("1 | 1.00 | 0.00 | 0.00"), rows)  # the slide is found
        self.assertTrue(rows["... quiet"].endswith("| 0.0 | 0.000 | 0.00 of 1"), rows)  # and the hold is silent
        self.assertEqual(len([name for name in rows if not name.startswith(("laboratory", "..."))]), 5)  # moved, and four nulls


if __name__ == "__main__":
    unittest.main()
