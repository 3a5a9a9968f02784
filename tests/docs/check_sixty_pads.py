# SPDX-License-Identifier: Apache-2.0
"""studies/rubber_block.py: a bar by hand, a bonded cube by CalculiX, sliding by Coulomb, the slip index by hand; pads of
studies/sixty_pads.py. Usage: check_sixty_pads.py"""
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "studies"))
import rubber_block as rubber  # noqa: E402
import sixty_pads  # noqa: E402

BOTH, ALL = [(1, 1), (-1, 1)], [(1, 1), (-1, 1), (1, -1), (-1, -1)]


class Block(unittest.TestCase):
    def whole(self, nu, mirrored, bricks=2):
        edges = np.linspace(0, 0.5, bricks + 1)
        block = rubber.Block(edges, edges, rubber.levels(1, False), nu, [(0.3, 0.1), (-0.3, 0.1)]).condense(BOTH if mirrored else ALL)
        x, y, quarter, signs = block.surface(mirrored)
        return (*block.whole(quarter, signs), np.stack([x, y], 1))

    def test_a_bar_without_lateral_strain_bears_E_times_its_strain(self):
        compliance, stress, places = self.whole(0, False)
        answer = rubber.slide(compliance, stress, places, np.zeros(len(places)), 0.0, 0.01, [], 1, 1)[0]
        self.assertAlmostEqual(answer["P"], 0.01, delta=1e-5)  # E = 1, one by one; sweeps settle to 2e-5
        np.testing.assert_allclose(answer["stress"], [[-0.01, 0, 0]] * 2, atol=1e-5)

    def test_half_a_surface_answers_as_the_whole(self):
        answers = []
        for mirrored in (False, True):
            compliance, stress, places = self.whole(0.45, mirrored)
            answers.append(rubber.slide(compliance, stress, places, np.zeros(len(places)), 0.3, 0.01, [[0.004, 0, 0]], 2, 2,
                                        1 + mirrored)[-1])
        for name in ("P", "S"):
            self.assertAlmostEqual(answers[0][name], answers[1][name], delta=2e-4 * answers[0][name])
        np.testing.assert_allclose(answers[0]["stress"], answers[1]["stress"], atol=1e-5)

    def test_sliding_bears_mu_times_the_pressure(self):
        compliance, stress, places = self.whole(0.3, True)
        answer = rubber.slide(compliance, stress, places, np.zeros(len(places)), 0.2, 0.01, [[0.1, 0, 0]], 1, 4, 2)[-1]
        self.assertAlmostEqual(answer["Q"][0], 0.2 * answer["P"], delta=0.002 * answer["P"])  # some nodes slip inwards
        self.assertGreater(answer["S"], 0.99)

    def test_a_bonded_cube_is_as_stiff_as_in_calculix(self):
        # 8 mm, nu 0.3, pressed by 0.4 mm, dragged by 0.3: 2000 C3D20R have 3.40473 and 0.61994 N/MPa.
        edges = rubber.graded(0.5, [], 3, least=0.05)
        block = rubber.Block(edges, edges, rubber.levels(1, False), 0.3, [(0, 0)]).condense(BOTH)
        _, y, quarter, signs = block.surface(True)
        compliance, _ = block.whole(quarter, signs)
        moved = np.zeros((len(y), 3, 2))
        moved[:, 2, 0], moved[:, 0, 1] = -0.05, 0.0375
        free = np.ones((len(y), 3), bool)
        free[y < 1e-9, 1] = False
        force = np.zeros((3 * len(y), 2))
        free = free.ravel()
        force[free] = np.linalg.solve(compliance[np.ix_(free, free)], moved.reshape(-1, 2)[free])
        self.assertAlmostEqual(-2 * 64 * force[2::3, 0].sum(), 3.4047, delta=0.004)  # few bricks: 0.1 %
        self.assertAlmostEqual(2 * 64 * force[::3, 1].sum(), 0.61994, delta=0.0007)


class SlipIndex(unittest.TestCase):
    def test_of_a_ring(self):
        angle = np.arange(12) * np.pi / 6
        places, limit = np.stack([np.cos(angle), np.sin(angle)], 1), np.full(12, 0.5)
        self.assertAlmostEqual(rubber.slip_index(limit, places, [3, 0], 0), 0.5)  # 6 is borne
        self.assertAlmostEqual(rubber.slip_index(limit, places, [0, 0], -3), 0.5)
        self.assertEqual(rubber.slip_index(limit, places, [0, 0], 0), 0)


class Pads(unittest.TestCase):
    def test_have_all_kinds_from_cubes_to_plates(self):
        pads = [sixty_pads.pad(k) for k in range(60)]
        self.assertEqual({p["kind"] for p in pads}, set(sixty_pads.KINDS))
        self.assertEqual({p["nu"] for p in pads}, set(sixty_pads.NU))
        self.assertLess(min(p["length"] for p in pads), 1.2)
        self.assertGreater(max(p["length"] for p in pads), 8)
        for p in pads:  # the axis lies on the pad
            self.assertLessEqual(abs(p["x"]), p["length"] / 2)
            self.assertLessEqual(abs(p["y"]), p["width"] / 2)

    def test_bricks_resolve_the_contact_of_a_ball(self):
        for first, last in ((0.0, 0.5), (1.0, 2.0), (2.6, 3.3)):
            edges = sixty_pads.across_ball(3.0, first, last, 0.14, 0.5)
            self.assertEqual((edges[0], edges[-1]), (0, 3))
            inside = (edges[1:] > first) & (edges[:-1] < last)
            self.assertLess(np.diff(edges)[inside].max(), 0.2)  # the outermost ones reach beyond
            self.assertLess(len(edges), 20)


if __name__ == "__main__":
    unittest.main()
