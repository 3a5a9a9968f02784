# SPDX-License-Identifier: Apache-2.0
"""studies/real_pads.py on a folder of numbers made here: zero, gains and scores by hand, S by another reader of the network,
errors. Usage: check_real_pads.py BUILD"""
import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

import numpy as np

TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS.parent / "studies"), str(TESTS / "python")]
import onnx_numpy  # noqa: E402
import real_pads  # noqa: E402

FRAMES, LEAVES, ZERO = 140, 110, 38000.0
BUILD = pathlib.Path(sys.argv.pop()) if len(sys.argv) > 1 else pathlib.Path("build")


def held(drag=-300):
    """Load [tactels, 3] of a held box: z 1000 everywhere, x `drag` with -40 and 40 at the outer columns, y -60 and 60 at the outer
    rows: outward (80 + 120) / 4 over 1000."""
    load = np.zeros((4, 4, 3))
    load[..., 2], load[..., 0] = 1000, drag
    load[:, 0, 0] -= 40
    load[:, 3, 0] += 40
    load[0, :, 1] -= 60
    load[3, :, 1] += 60
    return load.reshape(16, 3)


def write(folder, name, leaves=None, moves_from=None):
    """A trial whose net shear, to -x on pad 1 and to x on pad 2, grows by a tenth from frame 60 on, and which ends without load
    from frame `leaves` on."""
    path = folder / f"data_sample_{name}"
    path.mkdir(parents=True)
    for pad, drag in ((1, -300), (2, 300)):
        load = np.tile(held(drag), (FRAMES, 1, 1))
        load[60:, :, 0] += drag / 10
        load[leaves if leaves is not None else FRAMES:] = 0
        if leaves is not None:
            load[leaves:] += (-1.0)**np.arange(FRAMES - leaves)[:, None, None]  # noise
        counts = load + ZERO + 10 * pad + np.arange(48).reshape(16, 3)
        np.savetxt(path / f"xela_sensor{pad}.csv", counts.reshape(FRAMES, 48), delimiter=",", header="names", comments="")
    time = np.arange(FRAMES) / 60
    np.savetxt(path / "robot_state.csv", np.column_stack([0 * time, time]), delimiter=",", header="position,time", comments="")
    way = 0.003 * (np.arange(FRAMES) >= (FRAMES if moves_from is None else moves_from))
    pose = np.column_stack([way, 0 * way, 0 * way, 0 * way, 0 * way, 0 * way, 0 * way - 1])
    np.savetxt(path / "marker.csv", pose, delimiter=",", header="pose", comments="")
    return path


class Conversion(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_counts_to_load(self):
        write(self.folder, "a")
        write(self.folder, "b", leaves=LEAVES)
        stays, leaves = real_pads.read_trials(self.folder)
        self.assertIsNone(stays.gone())
        self.assertEqual(leaves.gone(), LEAVES - 15)  # the first frame without load 15 frames later
        self.assertEqual((leaves.load.shape, len(leaves.time), len(leaves.turn)), ((2, LEAVES - 15, 16, 3), LEAVES - 15, LEAVES - 15))
        for pad, drag in ((0, -300), (1, 300)):
            np.testing.assert_allclose(stays.load[pad, :60], np.broadcast_to(held(drag), (60, 16, 3)), atol=1e-9)
        np.testing.assert_allclose(real_pads.spread(stays.load[:, 0]), 0.05, atol=1e-12)

    def test_scores_by_hand(self):
        load = np.tile(held(), (2, 100, 1, 1))
        load[:, 60:, :, 0] -= 30  # net shear 300 to 330 of 1000
        load[:, 80:, :, 2] -= 100
        turn = np.zeros((4, 4, 3))  # x = -2 row, y = 2 column: curl 4
        turn[..., 0] = -2 * (np.arange(4) - 1.5)[:, None]
        turn[..., 1] = 2 * (np.arange(4) - 1.5)
        load[:, 90:] += turn.reshape(16, 3)
        scores = real_pads.baselines(load)
        hand = {"Q / P over its start": {0: 1, 70: 1.1, 85: 1.1 / 0.9}, "change of net shear": {59: 0, 60: 480, 95: 480},
                "loss of P": {79: 0, 80: 1600}, "curl of the shear": {89: 0, 90: 4},
                "change within 5 frames": {59: 0, 60: 120, 64: 120, 65: 0, 80: 400, 85: 0}}  # sqrt(16) 30, sqrt(16) 100
        self.assertEqual(hand.keys(), scores.keys())
        for name, frames in hand.items():
            for frame, value in frames.items():
                self.assertAlmostEqual(scores[name][frame], value, places=9, msg=f"{name}, frame {frame}")

    def test_scores_of_a_network_are_the_larger_of_both_pads(self):
        S = np.full((2, 50), [[0.2], [0.5]])
        S[0, 40:] = 0.6  # pad 1 from 0.2 to 0.6: less its start 0.4
        scores = real_pads.network_scores(S, S + 0.1)
        np.testing.assert_allclose([scores["S"][45], scores["bound"][0]], [0.6, 0.6])
        np.testing.assert_allclose(scores["S less its start"][[0, 45]], [0, 0.4], atol=1e-12)
        nulls = real_pads.null_scores(np.full((2, 50, 16, 3), 2.0))  # P of a pad is 32
        np.testing.assert_allclose([nulls["1 / P at rest"][7], nulls["frame number"][7]], [1 / 32, 7])

    def test_events_by_hand(self):
        way, turn = np.zeros(60), np.zeros(60)
        way[20:], turn[25:] = 0.6, 2.6  # mm, degrees
        way[10:14] = 5  # four frames are none
        trial = real_pads.Trial("a", None, None, turn, way)
        self.assertEqual((trial.first, trial.moves), (20, 25))
        self.assertEqual(real_pads.Trial("b", None, None, 0 * turn, way * 0.2).first, None)
        for begins, said in ((19, "false at 19"), (20, "-5"), (28, "+3"), (60, "none")):
            self.assertEqual(real_pads.events(trial, np.arange(60) >= begins), said)
        self.assertEqual(list(real_pads.hysteresis([1, 2.4, 2.1, 1.9, 2.1], 2.4)), [False, True, True, False, False])

    def test_motion_by_hand(self):
        half = np.radians(3) / 2
        marker = np.tile([1, 2, 3, 0, 0, 0, 1.0], (30, 1))
        marker[25] = [1, 2, 3.002, 0, -np.sin(half), 0, -np.cos(half)]  # the same turn as with both signs changed
        turn, way = real_pads.motion(marker)
        np.testing.assert_allclose([turn[25], way[25]], [3, 2], atol=1e-6)
        np.testing.assert_allclose([turn[29], way[29]], [0, 0], atol=1e-5)

    def test_area_by_hand(self):
        label = np.array([False, True, False, True])
        self.assertEqual(real_pads.area(np.array([1, 2, 2, 3]), label), 3.5 / 4)  # pairs 2-1, 2-2, 3-1, 3-2: 1, 1/2, 1, 1
        self.assertEqual(real_pads.area(-np.array([1, 2, 2, 3]), label), 0.5 / 4)
        self.assertTrue(np.isnan(real_pads.area(np.arange(4), label | True)))

    def assert_wrong(self, place, *words):
        with self.assertRaises(SystemExit) as caught:
            real_pads.read_trials(self.folder)
        said = str(caught.exception)
        self.assertRegex(said, f"{place}: .*; ")
        for word in words:
            self.assertIn(word, said)

    def test_folders_without_trials(self):
        self.assert_wrong(self.folder, "data_sample_")
        path = write(self.folder, "a")
        self.assert_wrong(self.folder, "no trial ends without the object")
        write(self.folder, "b", leaves=LEAVES)
        lines = (path / "marker.csv").read_text().splitlines()
        (path / "marker.csv").write_text("\n".join(lines[:-1]))
        self.assert_wrong(path, "139, 140 frames")
        (path / "marker.csv").unlink()
        self.assert_wrong(path / "marker.csv", "cannot be read")
        (path / "xela_sensor2.csv").write_text("a,b\n1,2\n3,4\n")
        self.assert_wrong(path / "xela_sensor2.csv", "48 numbers")
        (path / "xela_sensor2.csv").write_text("a,b\n1,2\n3\n")
        self.assert_wrong(path / "xela_sensor2.csv", "different lengths")

    def test_a_folder_without_the_program(self):
        with self.assertRaisesRegex(SystemExit, "tactel: no such program; .*--build"):
            real_pads.Chain(self.folder, self.folder)

    def test_from_counts_to_areas(self):
        write(self.folder, "a")
        write(self.folder, "b", leaves=LEAVES, moves_from=60)
        output, said, arguments = self.folder / "answers", io.StringIO(), sys.argv
        sys.argv = ["real_pads.py", str(self.folder), "--output", str(output), "--build", str(BUILD), "--contacts", "100"]
        try:
            with contextlib.redirect_stdout(said):
                real_pads.main()
        finally:
            sys.argv = arguments
        lines = said.getvalue().splitlines()
        # 35 frames have moved; of 200 others, 60 + 60 have lower scores and 80 the same. 16 tactels by 30 of P = 16000: 0.0075.
        self.assertIn("| moved, without a network | 0.009 | 0.800 1.000 |  | none | 0 |", lines)
        self.assertIn("| Q / P over its start | 1.32 | 0.800 1.000 |  | none | 0 |", lines)
        self.assertIn("| b | 95 | 60 | 60 | 0.0 | 3.0 |", lines)
        for name in "ab":
            self.assertEqual("moved, by the marker" in (output / f"{name}.svg").read_text(), name == "b")
        trial = real_pads.read_trials(self.folder)[0]
        network = sorted((output / "network").glob("*.onnx"))[3]
        S, upper, unlike, alarm = real_pads.Chain(BUILD, output).answers(trial.load, 3.0, network)
        self.assertEqual((S.shape, unlike.shape, alarm.shape), ((2, FRAMES), (2, FRAMES), (FRAMES,)))
        for pad in (0, 1):
            load = trial.load[pad] * 1e-5
            frames = np.hstack([-load[..., 2], 3 * load[..., 0], 3 * load[..., 1]]).astype(np.float32)
            truth = onnx_numpy.evaluate(network, frames)
            np.testing.assert_allclose(S[pad], truth["slip_index"][:, 0], atol=1e-5)  # fp32, 48 terms a neuron
            np.testing.assert_allclose(upper[pad], truth["slip_upper"][:, 0], atol=1e-5)
        np.testing.assert_array_equal(alarm, upper.max(0) >= real_pads.ALARM)  # the bound does not fall by 0.05 in these frames


if __name__ == "__main__":
    unittest.main()
