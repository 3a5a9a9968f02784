# SPDX-License-Identifier: Apache-2.0
"""Pads in the Python package, against the program, closed forms and themselves."""

import json
import os
import pathlib
import pickle
import subprocess
import tempfile
import unittest

import h5py
import numpy as np
import tactel

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ["TACTEL_PROGRAM"]
PAD = tactel.Pad(tactels=(4, 3), pitch=(1.0, 1.5), thickness=2.0, young=1.0)
DRAG = tactel.Press(0.25, steps=2).drag_to([(0.05, 0.02), (0.1, 0.04), (0.1, 0.1)], twist=[0.5, 1.5, 3.0])
SPHERE = tactel.Scene(PAD, tactel.Sphere(8.0), friction=0.5, load=DRAG)


def bowl(heights_x, heights_y):
    """Heights on 41 x 61 points, row y, column x, 0.1 mm apart."""
    x, y = np.linspace(-2, 2, 41), np.linspace(-3, 3, 61)
    return tactel.HeightMap(np.add.outer(heights_y(y), heights_x(x)), pitch=0.1)


class Values(unittest.TestCase):
    def test_a_scene_is_of_the_kind_of_its_sensor(self):
        self.assertEqual(SPHERE.sensor.pitch, [1.0, 1.5])
        self.assertEqual(tactel.Pad(pitch=3).pitch, [3.0, 3.0])
        self.assertEqual(SPHERE.indenter, tactel.PadIndenter(tactel.Sphere(8.0)))
        self.assertIsNone(SPHERE.indenter.young)
        self.assertIsNone(SPHERE.sensor.curvature_radius)
        self.assertEqual(tactel.Scene(PAD).load, tactel.PadLoad())
        self.assertEqual(tactel.Scene().sensor, tactel.Sensor())
        SPHERE.validate()

    def test_soft_objects_and_curved_skins(self):
        soft = SPHERE.with_(indenter=SPHERE.indenter.with_(young=2.0, poisson=0.3), sensor=PAD.with_(curvature_radius=30.0))
        self.assertEqual((soft.indenter.young, soft.indenter.poisson, soft.sensor.curvature_radius), (2.0, 0.3, 30.0))
        self.assertEqual(pickle.loads(pickle.dumps(soft)), soft)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "soft.toml"
            file.write_text(soft.toml())
            self.assertEqual(tactel.read_scene(file), soft)
            self.assertNotIn("curvature_radius", SPHERE.toml())
            self.assertEqual(SPHERE.toml().count("poisson"), 1)
        rigid, gives_way = (tactel.solve(scene, precision="fp64").P[-1] for scene in (SPHERE, soft))
        self.assertLess(gives_way, 0.8 * rigid)
        with self.assertRaisesRegex(tactel.InputError, "indenter.young"):
            SPHERE.with_(indenter=SPHERE.indenter.with_(young=-1.0)).validate()

    def test_layers(self):
        layers = [tactel.RubberLayer(1.8, 0.7, 0.48), tactel.RubberLayer(0.2, 7.0)]
        pad = tactel.Pad(tactels=(3, 2), pitch=(1.0, 1.5), layers=layers)
        self.assertEqual((pad.thickness, pad.young, pad.poisson), (2.0, 7.0, 0.45))
        scene = tactel.Scene(pad, SPHERE.indenter, 0.5, tactel.PadLoad(indentation=[], normal_force=[1.0], tangential=[[0.05, 0]], twist=[0.0]))
        self.assertEqual(pickle.loads(pickle.dumps(scene)), scene)
        self.assertIn("RubberLayer(thickness=0.2, young=7.0, poisson=0.45)", repr(pad))
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "layers.toml"
            file.write_text(scene.toml())
            self.assertEqual(tactel.read_scene(file), scene)
        one = scene.with_(sensor=tactel.Pad(tactels=(3, 2), pitch=(1.0, 1.5), thickness=2.0, young=0.7, poisson=0.48))
        covered, bare = (tactel.solve(s, precision="fp64") for s in (scene, one))
        self.assertLess(covered.indentation[-1], bare.indentation[-1])  # a stiffer skin gives way less
        with self.assertRaisesRegex(tactel.InputError, "sensor.thickness.*left out beside sensor.layers"):
            scene.with_(sensor=tactel.Pad(thickness=3.0, layers=layers)).validate()
        with self.assertRaisesRegex(tactel.InputError, "sides are free"):
            scene.with_(sensor=pad.with_(length=20.0, width=20.0)).validate()
        steps = tactel.PadStepper(pad, 1, 0.5, cells=12, cell=1 / 3)
        steps.shapes(tactel.Sphere(8.0))
        pressed = tactel.solve(scene.with_(load=tactel.Press(0.2)), precision="fp64").P[-1]
        self.assertAlmostEqual(steps.move([[0.2, 0, 0, 0]]).force[0, 0] / pressed, 1, delta=0.03)

    def test_markers(self):
        markers, camera = tactel.Markers((3, 2), 0.8, 0.3), tactel.Camera(20.0, 10.0, (320.0, 240.0))
        self.assertEqual(markers.pitch, [0.8, 0.8])
        scene = SPHERE.with_(markers=markers, camera=camera)
        self.assertEqual(pickle.loads(pickle.dumps(scene)), scene)
        for one in (markers, camera):
            self.assertEqual(eval(repr(one), vars(tactel)), one)
        self.assertIsNone(SPHERE.markers)
        places = [[x, y] for y in (-0.4, 0.4) for x in (-0.8, 0, 0.8)]
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "markers.toml"
            for one in (scene, SPHERE.with_(markers=tactel.Markers(depth=0.3, places=places))):
                file.write_text(one.toml())
                self.assertEqual(tactel.read_scene(file), one)
        path = tactel.solve(scene, precision="fp64")
        self.assertEqual(path.markers.shape, (len(path), 6, 3))
        at = tactel.solve(SPHERE.with_(markers=tactel.Markers(depth=0.3, places=places)), precision="fp64")
        np.testing.assert_array_equal(path.markers, at.markers)
        self.assertEqual(at.pixels.shape, (len(path), 0, 2))
        u = path.markers
        expected = np.array([320, 240]) + 10 * (np.array(places) + u[..., :2] - np.array(places) * u[..., 2:] / 20)
        np.testing.assert_allclose(path.pixels, expected, atol=1e-9)
        for wrong, fix in ((SPHERE.with_(camera=camera), "camera.*given with"), (SPHERE.with_(markers=tactel.Markers(depth=9.0)), "markers.depth")):
            with self.assertRaisesRegex(tactel.InputError, fix):
                wrong.validate()
        with self.assertRaisesRegex(tactel.InputError, r"scenes\[1\].markers"):
            tactel.solve_many([SPHERE, scene])
        with self.assertRaisesRegex(tactel.InputError, "markers.*no Pad"):
            tactel.Scene(markers=markers)

    def test_steps_of_markers(self):
        """Below the middle of a ball that sticks they move with it, nearly; a step by cells of a scene is the scene."""
        pad = SPHERE.sensor
        markers = tactel.Markers((5, 3), 0.6, 0.2)
        steps = tactel.PadStepper(pad, 2, 1.0, cells=12, cell=1 / 3, markers=markers, camera=tactel.Camera(20.0, 10.0))
        again = pickle.loads(pickle.dumps(steps))
        scene = SPHERE.with_(indenter=tactel.Sphere(8.0), friction=1.0, markers=markers, load=tactel.Press(0.2).drag((0.03, 0.02), 1))
        path = tactel.solve(scene, precision="fp64")
        for stepper in (steps, again):
            stepper.shapes(tactel.Sphere(8.0))
            pressed = stepper.move([[0.2, 0, 0, 0], [0.1, 0, 0, 0]])
            self.assertEqual(pressed.markers.shape, (2, 15, 3))
            # Cells fixed to the pad beside cells fitted to the contact: 4 % of the depth.
            np.testing.assert_allclose(pressed.markers[0], path.markers[0], atol=0.008)
            out = stepper.move([[0.2, 0.03, 0.02, 0], [0.1, 0, 0, 0]])
            np.testing.assert_allclose(out.markers[0], path.markers[1], atol=0.008)
            self.assertEqual(out.pixels.shape, (2, 15, 2))
            with self.assertRaisesRegex(tactel.InputError, "before the next step"):
                pressed.markers
        plain = tactel.PadStepper(pad, 1, 1.0, cells=12, cell=1 / 3)
        plain.shapes(tactel.Sphere(8.0))
        self.assertEqual(plain.move([[0.2, 0, 0, 0]]).markers.shape, (1, 0, 3))
        with self.assertRaisesRegex(tactel.InputError, "camera"):
            tactel.PadStepper(pad, 1, 1.0, camera=tactel.Camera())
        with self.assertRaisesRegex(tactel.InputError, "markers.depth"):
            tactel.PadStepper(pad, 1, 1.0, markers=tactel.Markers(depth=5.0))

    def test_friction_map(self):
        wet = tactel.FrictionMap([[0.5, 0.5, 0.1], [0.5, 0.5, 0.2]], 1.0)
        scene = SPHERE.with_(friction_map=wet)
        self.assertEqual((wet.rows[1], wet.pitch, SPHERE.friction_map), ([0.5, 0.5, 0.2], 1.0, None))
        self.assertEqual(eval(repr(wet), vars(tactel)), wet)
        self.assertEqual(pickle.loads(pickle.dumps(scene)), scene)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "wet.toml"
            file.write_text(scene.toml())
            self.assertEqual(tactel.read_scene(file), scene)
        one = SPHERE.with_(friction_map=tactel.FrictionMap([[SPHERE.friction]], 1.0))
        even, dry, uneven = (tactel.solve(s, precision="fp64") for s in (one, SPHERE, scene))
        np.testing.assert_array_equal(even.normal_force, dry.normal_force)
        np.testing.assert_array_equal(even.tangential_force, dry.tangential_force)
        self.assertTrue((uneven.slip_index[1:] > dry.slip_index[1:]).all())  # less friction in a part of it
        for wrong, fix in ((scene.with_(friction=0.3), "contact.friction: 0.3; .*left out.* beside"),
                           (SPHERE.with_(friction_map=tactel.FrictionMap([[0.5], [0.5, 0.1]])), "contact.friction_map: 2; ")):
            with self.assertRaisesRegex(tactel.InputError, fix):
                wrong.validate()
        many, fine = tactel.solve_many([SPHERE, scene]), tactel.solve_many([SPHERE, scene], precision="fp64")
        np.testing.assert_array_equal(many.slip_index[0], tactel.solve_many([SPHERE]).slip_index[0])
        for paths, close in ((many, 3e-3), (fine, 1e-3)):
            np.testing.assert_allclose(paths.P[1], uneven.P, rtol=close)
            np.testing.assert_allclose(paths.slip_index[1], uneven.slip_index, atol=close)
            np.testing.assert_allclose(paths.force_ratio[1], uneven.force_ratio, atol=close)  # by the mean mu
        with self.assertRaisesRegex(tactel.InputError, "friction_map.*no Pad"):
            tactel.Scene(friction_map=wet)

    def test_steps_with_friction_of_cells(self):
        steps = tactel.PadStepper(SPHERE.sensor, 3, 0.5, cells=12, cell=0.3)
        steps.shapes(tactel.Sphere(8.0))
        mu = np.where(steps.cell_x > 0.4, [[0.1], [0.3], [0.5]], 0.5)
        steps.set_friction(mu)
        first = pickle.loads(pickle.dumps(steps))
        for k in range(3):
            steps.move([0.2, 0.02 * k, 0, 0])
        again = pickle.loads(pickle.dumps(steps))
        for one in (steps, again):
            out = one.move([0.2, 0.06, 0, 0])
            S, n, t = out.slip_index.copy(), *np.split(one.tractions(), [1], axis=1)
            self.assertTrue(S[0] > S[1] > S[2])
            self.assertTrue((np.hypot(*t.swapaxes(0, 1)) <= mu * n[:, 0] * (1 + 1e-5) + 1e-12).all())
        np.testing.assert_array_equal(steps.state(), again.state())
        for k in range(4):
            first.move([0.2, 0.02 * k, 0, 0])
        np.testing.assert_array_equal(steps.state(), first.state())
        dry = tactel.PadStepper(SPHERE.sensor, 3, np.broadcast_to(0.5, (3, 144)), cells=12, cell=0.3)
        dry.set_friction(0.5)
        dry.shapes(tactel.Sphere(8.0))
        dry.set_state(steps.state())
        self.assertFalse(np.array_equal(dry.move([0.2, 0.08, 0, 0]).force, steps.move([0.2, 0.08, 0, 0]).force))
        for wrong in (mu.T, mu[:2], np.full((3, 144), -0.1), np.full(144, 0.5)):
            with self.assertRaisesRegex(tactel.InputError, "friction"):
                steps.set_friction(wrong)
        for turned in (mu.T, mu.T.reshape(12, 12, 3)):
            for call in (steps.set_friction, lambda mu: tactel.PadStepper(SPHERE.sensor, 3, mu, cells=12, cell=0.3)):
                with self.assertRaisesRegex(tactel.InputError, r"friction.*\[3, 144\]"):
                    call(turned)

    def test_steps_that_creep(self):
        pad = SPHERE.sensor.with_(relaxation=[(0.2, 0.5), (0.1, 5.0)])
        self.assertEqual(pad.relaxation, [[0.2, 0.5], [0.1, 5.0]])
        steps = tactel.PadStepper(pad, 1, 0.5, cells=12, cell=1 / 3, dt=0.0, precision="fp64")
        steps.shapes(tactel.Sphere(8.0))
        first = float(steps.move([[0.2, 0, 0, 0]]).force[0, 0])
        elastic = tactel.PadStepper(SPHERE.sensor, 1, 0.5, cells=12, cell=1 / 3, precision="fp64")
        elastic.shapes(tactel.Sphere(8.0))
        self.assertAlmostEqual(first, float(elastic.move([[0.2, 0, 0, 0]]).force[0, 0]), delta=1e-6 * first)
        steps.set_dt(1.0)
        again = pickle.loads(pickle.dumps(steps))
        self.assertEqual(again.dt, 1.0)
        held = [float(one.move([[0.2, 0, 0, 0]]).force[0, 0]) for one in (steps, again)]
        self.assertEqual(held[0], held[1])
        # A depth that is held relaxes as E does; what has relaxed is as linear as the tractions in the second.
        self.assertAlmostEqual(held[0] / first, 1 - 0.2 * (1 - np.exp(-2)) - 0.1 * (1 - np.exp(-0.2)), delta=0.02)
        steps.set_dt(1e9)
        self.assertAlmostEqual(float(steps.move([[0.2, 0, 0, 0]]).force[0, 0]) / first, 0.7, delta=1e-3)
        for wrong in ([(1.0, 1.0)], [(0.1, -1.0)]):
            with self.assertRaisesRegex(tactel.InputError, "sensor.relaxation"):
                tactel.PadStepper(SPHERE.sensor.with_(relaxation=wrong), 1, 0.5)
        with self.assertRaisesRegex(tactel.InputError, "dt"):
            steps.set_dt(-1)
        with self.assertRaisesRegex(tactel.InputError, r"scenes\[1\].*load.times.*given"):
            tactel.solve_many([SPHERE, SPHERE.with_(sensor=pad)])
        with self.assertRaisesRegex(tactel.InputError, "load.times.*given"):
            tactel.solve(SPHERE.with_(sensor=pad))
        path = tactel.solve(SPHERE.with_(sensor=pad, load=tactel.PadLoad(indentation=[0.2], tangential=[[0, 0]], times=[0.0, 1e9])))
        self.assertAlmostEqual(path.P[1] / path.P[0], 0.7, delta=1e-6)
        drags = [SPHERE.with_(sensor=pad, load=DRAG.with_(times=np.cumsum(np.full(len(tactel.solve(SPHERE.with_(load=DRAG))), dt)).tolist())) for dt in (0.0, 0.1, 5.0)]
        many = tactel.solve_many([SPHERE.with_(load=DRAG), *drags])
        np.testing.assert_array_equal(many.P[0], tactel.solve_many([SPHERE.with_(load=DRAG)]).P[0])
        np.testing.assert_allclose(many.P[1], many.P[0], rtol=3e-3)
        for k, drag in enumerate(drags, 1):
            alone = tactel.solve(drag)
            np.testing.assert_allclose(many.P[k], alone.P, rtol=3e-3)
            np.testing.assert_allclose(many.slip_index[k], alone.slip_index, atol=5e-3)
        self.assertLess(many.P[3, -1], 0.8 * many.P[1, -1])
        with self.assertRaisesRegex(tactel.InputError, "load.times: 1 times"):
            SPHERE.with_(sensor=pad, load=DRAG.with_(times=[1.0])).validate()

    def test_steps_of_soft_objects(self):
        """A step is the press of the scene, but for its cells."""
        scene = SPHERE.with_(indenter=SPHERE.indenter.with_(young=2.0, poisson=0.3), load=tactel.Press(0.2))
        steps = tactel.PadStepper(PAD, 1, 0.5, cells=12, cell=1 / 3, object_young=2.0, object_poisson=0.3)
        steps.shapes(tactel.Sphere(8.0))
        out = steps.move([[0.2, 0, 0, 0]])
        self.assertAlmostEqual(out.force[0, 0] / tactel.solve(scene, precision="fp64").P[0], 1, delta=0.02)
        with self.assertRaisesRegex(tactel.InputError, "young"):
            steps.shapes(scene.indenter)

    def test_loads_of_a_pad(self):
        load = tactel.Force(3).drag((0.1, 0), steps=2).turn(4, steps=1).drag_to([(0, 0.5)])
        self.assertEqual(load, tactel.PadLoad([], [3], 1, [(0.1, 0), (0.2, 0), (0.2, 0), (0, 0.5)], [0, 0, 4, 0]))
        self.assertIsInstance(tactel.Press(0.1).drag(0.05, steps=2), tactel.Load)

    def test_survives_pickling(self):
        scene = SPHERE.with_(indenter=tactel.PadIndenter(bowl(np.square, np.square), position=(1, 0), yaw=20))
        again = pickle.loads(pickle.dumps(scene))
        self.assertEqual(again, scene)
        self.assertNotEqual(again.with_(indenter=bowl(np.square, np.abs)), scene)

    def test_shows_itself(self):
        self.assertEqual(repr(tactel.Box((1, 2), edge=0.5)), "Box(half_widths=[1.0, 2.0], edge=0.5)")

    def test_heights_never_change(self):
        own = np.zeros((2, 3))
        shape = tactel.HeightMap(own)
        own[0, 0] = 1
        self.assertEqual(shape.heights[0, 0], 0)
        with self.assertRaises(ValueError):
            shape.heights[0, 0] = 1


class Errors(unittest.TestCase):
    def test_names_place_problem_and_fix(self):
        for place, problem, fix, call in (
                ("indenter", "Parabola", "PadIndenter, Sphere", lambda: tactel.Scene(PAD, tactel.Parabola())),
                ("indenter", "Sphere", "Indenter, Flat", lambda: tactel.Scene(tactel.Sensor(), tactel.Sphere())),
                ("indenter", "PadIndenter", "no Pad", lambda: SPHERE.with_(sensor=tactel.Sensor())),
                ("load", "drag", "Press", lambda: tactel.Scene(PAD, load=tactel.Press(0.1).drag(0.1, steps=2))),
                ("load", "PadLoad", "no Pad", lambda: tactel.Scene(load=DRAG)),
                ("heights", "1 axes", "two", lambda: tactel.HeightMap([1, 2, 3])),
                ("sensor.poisson", "0.6", "0.5", lambda: tactel.solve(SPHERE.with_(sensor=PAD.with_(poisson=0.6)))),
                ("load.twist", "2 twists", "positions, 1", lambda: tactel.solve(
                    SPHERE.with_(load=tactel.Press(0.1).drag_to([(1, 1)], twist=[1, 2])))),
                ("rung", "patch-12", "pad-12", lambda: tactel.solve(SPHERE, rung="patch-12")),
                ("scenes[1]", "other kind", "all Sensor or all Pad", lambda: tactel.solve_many([SPHERE, tactel.Scene()])),
                ("scenes[1]", "other kind", "all Sensor or all Pad", lambda: tactel.solve_many([tactel.Scene(), SPHERE])),
                ("scenes[1].sensor.tactels", "4 x 4", "4 x 3", lambda: tactel.solve_many(
                    [SPHERE, SPHERE.with_(sensor=tactel.Pad())])),
                ("scenes[2].contact.friction", "-1", "friction", lambda: tactel.solve_many(
                    [SPHERE, SPHERE, SPHERE.with_(friction=-1)]))):
            with self.subTest(place=place, problem=problem):
                with self.assertRaises(tactel.InputError) as raised:
                    call()
                self.assertEqual(raised.exception.place, place)
                self.assertIn(problem, raised.exception.problem)
                self.assertIn(fix, raised.exception.fix)

    def test_lines_do_not_turn(self):
        with self.assertRaises(TypeError):
            tactel.Press(0.1).drag(0.05, steps=2, twist=1)


class Sweeps(unittest.TestCase):
    def test_have_the_rows_of_the_program(self):
        text = (ROOT / "examples/pad_sweep.toml").read_text(encoding="utf-8").replace("contacts = 20000", "contacts = 6")
        with tempfile.TemporaryDirectory() as folder:
            file, of_program = os.path.join(folder, "pads.toml"), os.path.join(folder, "pads.h5")
            pathlib.Path(file).write_text(text, encoding="utf-8")
            subprocess.run([PROGRAM, "generate", file, "--output", of_program, "--quiet"], check=True)
            sweep, there = tactel.Sweep(file), tactel.read_set(of_program)
            rows = sweep.generate()
            self.assertEqual((sweep.axes, sweep.tactels, rows.axes), (3, 16, 3))
            self.assertEqual(rows.Q.shape, (len(rows), 2))
            for name in ("frames", "slip_index", "P", "Q", "M", "twist", "force_ratio", "tangential", "contact", "step"):
                np.testing.assert_array_equal(getattr(rows, name), getattr(there, name), name)
            rows.save(os.path.join(folder, "saved.h5"))
            self.assertTrue(pathlib.Path(folder, "saved.h5").read_bytes() == pathlib.Path(of_program).read_bytes())
            with h5py.File(of_program) as saved:
                for name, its in (("inputs", ("row", "input")), ("tangential_force", ("row", "direction")),
                                  ("tactel_y", ("tactel",)), ("parameters", ("contacts", "parameter"))):
                    self.assertEqual([along[0].name for along in saved[name].dims], ["/" + one for one in its])
                    self.assertEqual(saved[name].shape, tuple(len(saved[one]) for one in its))
            for k in range(6):  # the scene has the irregular path; the sweeps' tolerance is 1e-3
                path, own = tactel.solve(sweep.scene(k), precision="fp32"), rows.contact == k
                np.testing.assert_allclose(rows.slip_index[own], path.slip_index[rows.step[own]], atol=2e-3)
            self.assertEqual(sweep.generate(2, rung="pad-8").axes, 3)
            with self.assertRaisesRegex(tactel.InputError, "rung"):
                sweep.generate(2, accuracy=0.01)


    def test_have_the_markers_of_the_program(self):
        text = """[sweep]\ncontacts = 8\n[sensor]\nkind = "pad"\nthickness = 2\n[indenter]\nshape = "sphere"
radius = { uniform = [4, 9] }\n[load]\nindentation = 0.2\ntangential = [[0.05, { uniform = [-0.1, 0.1] }]]
[markers]\ncounts = [5, 3]\npitch = 0.6\ndepth = 0.2\n[camera]\nnoise_px = 0.01\n"""
        with tempfile.TemporaryDirectory() as folder:
            file, of_program = os.path.join(folder, "marked.toml"), os.path.join(folder, "marked.h5")
            pathlib.Path(file).write_text(text, encoding="utf-8")
            subprocess.run([PROGRAM, "generate", file, "--output", of_program, "--quiet"], check=True)
            subprocess.run([PROGRAM, "check", of_program], check=True, stdout=subprocess.DEVNULL)
            rows, there = tactel.Sweep(file).generate(), tactel.read_set(of_program)
            self.assertEqual(rows.markers.shape, (len(rows), 15, 3))
            np.testing.assert_array_equal(rows.markers, there.markers)
            rows.save(os.path.join(folder, "saved.h5"))
            self.assertTrue(pathlib.Path(folder, "saved.h5").read_bytes() == pathlib.Path(of_program).read_bytes())
            with h5py.File(of_program) as saved:
                self.assertEqual([along[0].name for along in saved["markers"].dims], ["/row", "/displacement"])
                np.testing.assert_array_equal(saved["markers"][:].reshape(-1, 15, 3), rows.markers)
            scene = tactel.Sweep(file).scene(3)
            self.assertEqual(scene.markers, tactel.Markers((5, 3), 0.6, 0.2))
            path, own = tactel.solve(scene, precision="fp32"), rows.contact == 3
            far = np.abs(path.markers).max()
            np.testing.assert_allclose(rows.markers[own], path.markers[rows.step[own]], atol=0.005 * far)
            np.testing.assert_array_equal(rows.pixels, there.pixels)
            np.testing.assert_allclose(rows.pixels[own], path.pixels[rows.step[own]], atol=0.05 + 0.2 * far)  # 5 deviations; 20 pixels/mm
            self.assertEqual(scene.camera.noise_px, 0.01)
        self.assertEqual(tactel.Sweep(ROOT / "examples/pad_spheres.toml").generate(1).markers.shape[1:], (0, 3))


class Networks(unittest.TestCase):
    def test_networks_with_features_answer_mirror_images_alike(self):
        rows = tactel.Sweep(ROOT / "examples/pad_spheres.toml").generate(20)
        frames = np.asarray(rows.frames, np.float32)
        mirrored = frames.reshape(-1, 3, 4, 4)[:, :, :, ::-1].copy()
        mirrored[:, 1] *= -1  # tau_x
        (network,) = tactel.train(rows, (48, 8, 1), scaling="frame", features="pad", cycles=2)
        self.assertEqual(network.topology, "66-8-1")
        answers = network.estimator(frames)
        np.testing.assert_array_equal(network.estimator(mirrored.reshape(-1, 48)), answers)
        mirrored[:, 1] *= -1  # a mirror image with the shear of the other side
        self.assertFalse(np.array_equal(network.estimator(mirrored.reshape(-1, 48)), answers))
        with self.assertRaisesRegex(tactel.InputError, "must be frame"):
            tactel.train(rows, (48, 8, 1), features="pad")

    def test_of_markers_are_those_of_stresses_in_their_place(self):
        """They are those of stresses on x and y of the markers in the place of stresses, to the bit."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "sweep.toml"
            file.write_text("[sweep]\ncontacts = 40\npress_rows = true\n[sensor]\nkind = 'pad'\ntactels = [2, 2]\nthickness = 2\n"
                            "[indenter]\nshape = 'sphere'\nradius = { uniform = [4, 9] }\n[load]\nindentation = 0.2\n"
                            "tangential = [[{ uniform = [0, 0.1] }, 0.05], [0.1, 0.1]]\n[markers]\ncounts = [3, 2]\npitch = 1.5\n")
            rows = tactel.Sweep(file).generate(rung="pad-8")
        seen = rows.markers[:, :, :2].reshape(len(rows), 12)
        solved = rows.status < 2
        swapped = tactel.Set(seen[solved], rows.slip_index[solved])
        (ours,), (same,) = (tactel.train(data, (12, 8, 1), cycles=20, inputs=of) for data, of in ((rows, "markers"), (swapped, "stresses")))
        np.testing.assert_array_equal(ours(seen), same(seen))
        self.assertEqual(ours.errors(rows).mean, same.errors(swapped).mean)
        self.assertEqual(ours.errors(rows).rows, solved.sum())
        # Contact by contact, as its history asks: better than a constant.
        (path,) = tactel.train(rows, (24, 8, 1), cycles=300, inputs="markers", history=2)
        s = rows.slip_index[solved]
        self.assertLess(path.errors(rows).mean, 0.5 * np.abs(s - np.median(s)).mean())
        for wrong in (lambda: tactel.train(swapped, (12, 8, 1), inputs="markers"), lambda: ours.errors(swapped)):
            with self.assertRaisesRegex(tactel.InputError, "markers"):
                wrong()
        with self.assertRaisesRegex(tactel.InputError, "--scaling|scaling"):
            tactel.train(rows, (12, 8, 1), inputs="markers", scaling="frame")
        with self.assertRaisesRegex(tactel.InputError, "network: of markers; give one of stresses"):
            tactel.Alarm(ours)


class Solve(unittest.TestCase):
    def test_equals_the_program(self):
        for name in ("pad_twist.toml",):  # Answers of test_tactel have pad.toml
            file = str(ROOT / "examples" / name)
            answer = json.loads(subprocess.run([PROGRAM, "solve", file, "--json", "-"], check=True, capture_output=True,
                                               text=True).stdout)
            path = tactel.solve(tactel.read_scene(file))
            for member, key in ((path.P, "P"), (path.Q, "Q"), (path.M, "M"), (path.slip_index, "slip_index"),
                                (path.force_ratio, "force_ratio"), (path.stick_fraction, "stick_fraction"),
                                (path.indentation, "indentation"), (path.tangential, "tangential"), (path.twist, "twist"),
                                (path.slip_distance, "slip_distance"), (path.converged, "converged"),
                                (path.normal_force, "normal_force"), (path.tangential_force, "tangential_force")):
                self.assertEqual(member.tolist(), [step[key] for step in answer["steps"]], key)
            for grid, key in ((path.tactels.normal, "sigma_z"), (path.tactels.shear_x, "tau_x"), (path.tactels.shear_y, "tau_y")):
                self.assertEqual(grid.shape, (len(path), len(path.tactel_y), len(path.tactel_x)))
                self.assertEqual(grid.reshape(len(path), -1).tolist(), [step[key] for step in answer["steps"]], key)
            words = np.array(["open", "stick", "slip"])
            self.assertEqual(words[path.status].tolist(), [step["status"] for step in answer["steps"]])
            self.assertEqual((path.cell_x.tolist(), path.cell_y.tolist()), (answer["cell_x"], answer["cell_y"]))
            self.assertEqual(path.cell_width, answer["cell_width"])
            self.assertEqual(np.tile(path.tactel_x, len(path.tactel_y)).tolist(), answer["tactel_x"])
            self.assertEqual(np.repeat(path.tactel_y, len(path.tactel_x)).tolist(), answer["tactel_y"])
            self.assertEqual((path.model, path.rung, path.warnings), (answer["model"], answer["rung"], answer["warnings"]))
            self.assertEqual(list(path.error.values()), list(answer["discretisation_error"].values()))

    def test_sums_over_cells(self):
        path = tactel.solve(SPHERE)
        self.assertTrue(path.converged.all())
        np.testing.assert_allclose(path.normal_force.sum(axis=1), path.P, rtol=1e-12)
        np.testing.assert_allclose(path.tangential_force.sum(axis=1), path.Q, atol=1e-12)
        moment = path.tangential_force[:, :, 1] @ path.cell_x - path.tangential_force[:, :, 0] @ path.cell_y
        np.testing.assert_allclose(moment, path.M, atol=1e-12)
        np.testing.assert_allclose(path.force_ratio, np.hypot(*path.Q.T) / (0.5 * path.P), rtol=1e-12)
        np.testing.assert_array_equal((path.status > 0), path.normal_force > 0)
        self.assertLessEqual(path.residual.max(), 1e-6)

    def test_tactels_side_by_side_bear_the_forces(self):
        """Squares of 1 mm over 28 x 28 mm of a pad 2 mm thick measure what the rubber bears at its base: the stress
        falls like exp(-0.74 r / H) or faster; 0.2 % of P and 0.6 % of Q lie beyond."""
        sensor = tactel.Pad(tactels=(28, 28), pitch=1.0, tactel_size=1.0, thickness=2.0, young=1.0)
        path = tactel.solve(SPHERE.with_(sensor=sensor))
        total = lambda stress: stress.sum(axis=(1, 2))  # noqa: E731
        np.testing.assert_allclose(-total(path.tactels.normal), path.P, rtol=1e-2)
        np.testing.assert_allclose(total(path.tactels.shear_x), path.Q[:, 0], atol=1e-2 * path.Q.max())
        np.testing.assert_allclose(total(path.tactels.shear_y), path.Q[:, 1], atol=1e-2 * path.Q.max())

    def test_rows_are_along_y(self):
        """A sphere above the tactel of row 2, column 0 presses that one most; dragged along y it shears in y."""
        scene = SPHERE.with_(indenter=tactel.PadIndenter(tactel.Sphere(3), position=(-1.5, 1.5)),
                             load=tactel.Press(0.1).drag((0, 0.02), steps=1))
        path = tactel.solve(scene)
        self.assertEqual((path.tactel_x.tolist(), path.tactel_y.tolist()), ([-1.5, -0.5, 0.5, 1.5], [-1.5, 0.0, 1.5]))
        self.assertEqual(np.unravel_index(path.tactels.normal[-1].argmin(), (3, 4)), (2, 0))
        self.assertEqual(np.unravel_index(path.tactels.shear_y[-1].argmax(), (3, 4)), (2, 0))
        self.assertGreater(path.tactels.shear_y[-1, 2, 0], 10 * abs(path.tactels.shear_x[-1, 2, 0]))
        normal, shear_x, shear_y = path.frames.reshape(2, 3, 3, 4).swapaxes(0, 1)
        np.testing.assert_array_equal(normal, path.tactels.normal.astype(np.float32))
        np.testing.assert_array_equal(shear_y, path.tactels.shear_y.astype(np.float32))
        one = tactel.solve(scene.with_(sensor=PAD.with_(axes=1)))
        np.testing.assert_array_equal(one.frames, path.frames[:, :12])

    def test_a_height_map_is_its_shape(self):
        """A paraboloid of radii 4 (x) and 12 mm (y) as heights: its bilinear chords lie 0.1^2 / (8 r) = 0.3 um above it."""
        shape = bowl(lambda x: 5 + x**2 / 8, lambda y: y**2 / 24)
        scene = SPHERE.with_(load=tactel.Press(0.15).drag((0.05, 0), steps=1))
        mapped, exact = (tactel.solve(scene.with_(indenter=s), precision="fp64") for s in (shape, tactel.Paraboloid((4, 12))))
        np.testing.assert_allclose(mapped.P, exact.P, rtol=0.02)  # cells of the search differ
        # Longer along y: the pressed cells reach farther there, as roots of the radii do for thick rubber.
        pressed = mapped.normal_force[0] > 0
        self.assertGreater(np.ptp(mapped.cell_y[pressed]), 1.3 * np.ptp(mapped.cell_x[pressed]))

    def test_many_are_the_same_as_one_by_one(self):
        scenes = [SPHERE, SPHERE.with_(friction=0.9), SPHERE.with_(load=tactel.Press(0.1)),
                  SPHERE.with_(indenter=tactel.PadIndenter(tactel.Box((1, 0.5), edge=0.5), yaw=30))]
        many = tactel.solve_many(scenes)
        self.assertEqual((len(many), many.tactels.normal.shape, many.Q.shape), (4, (4, 5, 3, 4), (4, 5, 2)))
        for i, scene in enumerate(scenes):
            one = tactel.solve(scene, precision="fp32")
            k = many.steps_made[i]
            self.assertEqual(k, len(one))
            for name in ("P", "Q", "M", "slip_index", "force_ratio", "stick_fraction", "twist", "tangential"):
                np.testing.assert_array_equal(getattr(many, name)[i, :k], getattr(one, name), name)
                self.assertTrue(np.isnan(getattr(many, name)[i, k:]).all())
            for name in ("normal", "shear_x", "shear_y"):
                np.testing.assert_array_equal(getattr(many.tactels, name)[i, :k], getattr(one.tactels, name), name)
            np.testing.assert_array_equal(many.frames[i, :k], one.frames)

    def test_arrays_are_views_that_keep_their_owner(self):
        many = tactel.solve_many([SPHERE])
        p, normal = many.P, many.tactels.normal
        self.assertIs(p.base, many)
        self.assertIs(normal.base, many)
        self.assertEqual(p.__array_interface__["data"], many.P.__array_interface__["data"])
        expected = p.copy()
        del many
        np.testing.assert_array_equal(p, expected)
        self.assertEqual(tactel.solve_many([SPHERE] * 2, keep="tactels").shape, (2, 5, 36))

    def test_progress_is_told_and_may_stop(self):
        told = []
        tactel.solve_many([SPHERE] * 3, progress=lambda done, total: told.append((done, total)))
        self.assertEqual(told, [(0, 3), (3, 3)])

        def fail(done, total):
            raise RuntimeError("enough")

        with self.assertRaisesRegex(RuntimeError, "enough"):
            tactel.solve_many([SPHERE] * 3, progress=fail)


if __name__ == "__main__":
    unittest.main()
