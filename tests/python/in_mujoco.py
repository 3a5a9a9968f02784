# SPDX-License-Identifier: Apache-2.0
"""tactel.mujoco by statics: two fingers of MuJoCo hold a box whose weight, and its torque about the fingers, is known."""
import functools
import os
import pathlib
import re
import tempfile
import unittest

import mujoco
import numpy as np
import tactel
import tactel.mujoco

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/stepping.md"
MASS, LEVER, GRIP = 0.3, 0.0015, 6.0  # kg; m that the fingers hold it beside its middle, along y; N
WEIGHT = MASS * 9.81
SCENE = f"""<mujoco><option timestep="0.002" integrator="implicitfast" cone="elliptic" impratio="10"/><worldbody>
<body pos="0 0 .3"><joint name="lift" type="slide" axis="0 0 1" damping="50"/>
<geom type="box" size=".06 .02 .01" pos="0 0 .08" mass="1" contype="0" conaffinity="0"/>
<body name="left" pos="-.05 0 0"><joint name="l" type="slide" axis="1 0 0" damping="5"/><geom name="left" type="sphere" size=".012"
mass=".05" friction=".5 .003 .0001" condim="4" solref=".004 1"/><site name="left" xyaxes="0 1 0 0 0 1"/></body>
<body name="right" pos=".05 0 0"><joint name="r" type="slide" axis="-1 0 0" damping="5"/><geom name="right" type="sphere" size=".012"
mass=".05" friction=".5 .003 .0001" condim="4" solref=".004 1"/><site name="right" xyaxes="0 -1 0 0 0 1"/></body></body>
<body name="box" pos="0 {LEVER} .3"><freejoint/><geom type="box" size=".02 .03 .04" mass="{MASS}" friction=".5 .003 .0001" condim="4"/></body>
<geom type="plane" size="1 1 .1" pos="0 0 .26" friction="1 .003 .0001"/></worldbody>
<actuator><motor joint="l"/><motor joint="r"/><position joint="lift" kp="2000" kv="200"/></actuator></mujoco>"""
MIRRORED = [[0, 1, 0], [0, 0, 1], [-1, 0, 0]]  # of the right finger: x and y as the left one's, z to the box
PAD = tactel.Pad(tactels=(24, 24), pitch=1.5, thickness=3.0, young=2.0, poisson=0.48)


@functools.cache
def held():
    """The box above the ground; friction of MuJoCo creeps."""
    model = mujoco.MjModel.from_xml_string(SCENE)
    data = mujoco.MjData(model)
    for tick in range(500):
        data.ctrl[:] = GRIP, GRIP, np.clip(0.1 * (0.002 * tick - 0.3), 0, 0.02)
        mujoco.mj_step(model, data)
    assert data.ncon == 2 and data.body("box").xpos[2] > 0.31
    return model, data


def skin(**options):
    return tactel.mujoco.Skin(held()[0], {"left": "left", "right": "right"}, PAD, 0.5, tactel.Sphere(12), cells=12, cell=0.88, **options)


class InMujoco(unittest.TestCase):
    def test_each_finger_bears_half_of_a_box(self):
        """z of the left pad is along the world's x, y of both up. The box turns both pads about the world's -x."""
        model, data = held()
        left, right = skin().wrench(data)
        turn = 1000 * WEIGHT * data.body("box").xpos[1] / 2  # N mm
        within = 0.01 * np.array([GRIP, WEIGHT / 2, WEIGHT / 2, turn])  # what MuJoCo's solver leaves is less
        for found, wanted in ((left, [GRIP, 0, -WEIGHT / 2, -turn]), (right, [GRIP, 0, -WEIGHT / 2, turn]),
                              (tactel.mujoco.wrench(model, data, "right", MIRRORED), [GRIP, 0, -WEIGHT / 2, -turn]),
                              (tactel.mujoco.wrench(model, data, model.geom("right").id, model.site("right").id), [GRIP, 0, -WEIGHT / 2, turn])):
            self.assertTrue((np.abs(found - wanted) < within).all(), f"{found} {wanted}")

    def test_wrenches_are_those_that_mujoco_sums(self):
        """mj_rnePostConstraint sums the contacts of a body about the centre of its tree."""
        model, data = held()
        mujoco.mj_rnePostConstraint(model, data)
        at = (2.0, -3.0)  # mm
        for name in ("left", "right"):
            body = model.body(name)
            torque, force = data.cfrc_ext[body.id].reshape(2, 3)
            x, y, z = data.site(name).xmat.reshape(3, 3).T
            origin = data.site(name).xpos + (at[0] * x + at[1] * y) / 1000
            torque = torque + np.cross(data.subtree_com[model.body_rootid[body.id]] - origin, force)
            wanted = [-force @ z, force @ x, force @ y, 1000 * torque @ z]
            np.testing.assert_allclose(tactel.mujoco.wrench(model, data, name, name, at), wanted, rtol=1e-6, atol=1e-6)

    def test_axes_turn_with_the_finger(self):
        """A box that tumbles on the ground: by a site, and by the same axes in those of the body."""
        model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody><geom type="plane" size="1 1 .1"/><body pos="0 0 .04" euler="20 30 40"><freejoint/>
            <geom name="box" type="box" size=".02 .03 .01" condim="4"/><site name="pad" euler="50 -30 70"/></body></worldbody></mujoco>""")
        data, axes = mujoco.MjData(model), np.zeros(9)
        mujoco.mju_quat2Mat(axes, model.site("pad").quat)
        axes, felt = axes.reshape(3, 3).T, []
        for _ in range(150):
            mujoco.mj_step(model, data)
            by_axes, by_site = (tactel.mujoco.wrench(model, data, "box", frame) for frame in (axes, "pad"))
            np.testing.assert_allclose(by_axes, by_site, atol=1e-9)
            np.testing.assert_allclose(tactel.mujoco.wrench(model, data, "box", axes * [[-1], [1], [1]]), by_site * [1, -1, 1, -1], atol=1e-9)  # mirrored in x
            felt.append(np.abs(by_site).min())
        self.assertGreater(max(felt), 0.01)

    def test_the_pads_feel_it(self):
        """Base shear points down on both pads, and turns each as the box does."""
        hand = skin()
        out = hand.press([[GRIP, 0, 0, 0]] * 2)
        for part in (0.5, 1.0):  # friction remembers the way
            out = hand.press(hand.wrench(held()[1]) * [1, part, part, part])
        self.assertEqual(list(out.flags), [0, 0])
        x, y = (a.ravel() for a in np.meshgrid((np.arange(24) - 11.5) * 1.5, (np.arange(24) - 11.5) * 1.5))
        area = 1.5 ** 2
        for frame, wrench in zip(out.frames.reshape(2, 3, 576).astype(float), hand.wrench(held()[1])):
            sums = area * np.array([-frame[0].sum(), frame[1].sum(), frame[2].sum(), (x * frame[2] - y * frame[1]).sum()])
            # 4 %: the rubber beyond the array, its sums by tactels, and what press leaves
            np.testing.assert_allclose(sums, wrench, atol=0.04 * np.abs(wrench).max(where=[True, True, True, False], initial=0))
            self.assertAlmostEqual(sums[3] / wrench[3], 1, delta=0.1)

    def test_worlds_are_contacts_of_one_stepper(self):
        model, data = held()
        hands, one = skin(worlds=3), skin()
        wrench = hands.wrench([data] * 3)
        np.testing.assert_array_equal(wrench, np.tile(one.wrench(data), (3, 1)))
        frames = one.press(wrench[:2] / 2).frames.copy()
        hands.press(wrench / 2)
        again = one.step(data).frames.copy()
        hands.reset([False, True, False])
        found = hands.press(np.where(np.repeat([False, True, False], 2)[:, None], wrench / 2, wrench)).frames.reshape(3, 2, -1)
        np.testing.assert_array_equal(found[[0, 2]], [again, again])
        np.testing.assert_array_equal(found[1], frames)

    def test_the_lines_of_the_page(self):
        """In a folder with hand.xml, whose fingers springs close."""
        code, = [block for block in re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.M | re.S) if "mujoco" in block]
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "hand.xml").write_text(SCENE.replace('damping="5"', 'damping="5" stiffness="1000" springref=".024"'))
            names, before = {}, os.getcwd()
            os.chdir(folder)
            try:
                exec(code.replace("range(100)", "range(40)"), names)
            finally:
                os.chdir(before)
        self.assertEqual(names["out"].frames.shape, (2, 48))
        np.testing.assert_allclose(names["out"].force[:, 0], names["skin"].wrench(names["data"])[:, 0], rtol=0.02)
        self.assertGreater(names["out"].force[:, 0].min(), 1)

    def test_what_is_wrong_is_said(self):
        model, data = held()
        for words, wrong in (("geom: no 'pad'", lambda: tactel.mujoco.wrench(model, data, "pad", "left")), ("site: 9", lambda: tactel.mujoco.wrench(model, data, "left", 9)),
                             ("frame: ", lambda: tactel.mujoco.wrench(model, data, "left", np.ones((3, 3)))), ("data: 2 worlds", lambda: skin().wrench([data] * 2)),
                             ("mask: an array", lambda: skin().reset([True] * 3))):
            with self.subTest(words), self.assertRaisesRegex(tactel.InputError, words):
                wrong()


if __name__ == "__main__":
    unittest.main()
