# SPDX-License-Identifier: Apache-2.0
"""The Python package against laws, the program and itself: python3 -m unittest with PYTHONPATH=build/python."""

import ast
import functools
import html
import inspect
import io
import itertools
import json
import os
import pathlib
import pickle
import re
import select
import subprocess
import sys
import tempfile
import threading
import types
import unittest
from unittest import mock

import numpy as np
import onnx_numpy
import tactel
from tactel import _calls

try:
    import onnxruntime
except ImportError:
    onnxruntime = None

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ["TACTEL_PROGRAM"]


@functools.cache
def example(name, **options):
    """The same path for every test that looks at it."""
    return tactel.solve(tactel.read_scene(ROOT / f"examples/{name}.toml"), estimate_error=True, **options)


PARABOLA = tactel.Scene(tactel.Sensor(), tactel.Parabola(radius=10), friction=0.5, load=tactel.Press(0.15).drag(0.05, steps=8))


class Arrays(unittest.TestCase):
    def test_every_step_has_its_own_numbers(self):
        path = tactel.solve(PARABOLA)
        drags = 0.05 * np.arange(9)  # one press, eight drags
        np.testing.assert_allclose(path.tangential, drags, rtol=1e-12)
        self.assertEqual([path.tangential[k] for k in range(9)], path.tangential.tolist())
        self.assertGreater(path.slip_index[-1] - path.slip_index[0], 0.5)

    def test_a_build_that_does_not_fit_refuses(self):
        self.assertTrue(np.__version__.startswith(os.environ.get("TACTEL_NUMPY", "")))
        if np.__version__.startswith("1."):
            import old_pybind11  # noqa: F401: by pybind11 2.10
        else:
            with self.assertRaisesRegex(ImportError, "pybind11 2.10, does not fit NumPy 2.*; build it with a newer"):
                import old_pybind11  # noqa: F401


class Values(unittest.TestCase):
    def test_fields_are_those_of_the_constructor(self):
        sensor = tactel.Sensor(thickness=2.0, poisson=0.3, tactels=8)
        self.assertEqual((sensor.length, sensor.thickness, sensor.poisson, sensor.tactels), (20.0, 2.0, 0.3, 8))
        self.assertEqual(sensor.with_(young=3.0).young, 3.0)
        self.assertEqual(sensor.young, 2.0)
        self.assertEqual(sensor, tactel.Sensor(20.0, 2.0, 2.0, 0.3, 8))
        self.assertNotEqual(sensor, tactel.Sensor())
        covered = tactel.Sensor(layers=[tactel.RubberLayer(1.2, 1.0), tactel.RubberLayer(0.3, 10.0, 0.48)])
        self.assertEqual((covered.thickness, covered.young, covered.poisson), (1.5, 10.0, 0.48))
        self.assertIn("RubberLayer(thickness=0.3, young=10.0, poisson=0.48)", repr(covered))

    def test_a_wrong_field_is_named(self):
        with self.assertRaisesRegex(TypeError, "Parabola.with_: no argument raduis; did you mean radius?"):
            tactel.Parabola(3).with_(raduis=4)
        with self.assertRaises(AttributeError):
            PARABOLA.friction = 0.1  # a copy that would be lost elsewhere

    def test_survives_pickling(self):
        scene = PARABOLA.with_(indenter=tactel.Indenter(tactel.Taylor([1, 3], scale=10), position=1.5))
        self.assertEqual(pickle.loads(pickle.dumps(scene)), scene)

    def test_shows_itself(self):
        self.assertEqual(repr(tactel.Wedge(150)), "Wedge(edge_angle=150.0)")

    def test_profile_of_a_function(self):
        profile = tactel.Profile.sampled(lambda x: x * x / 20, -2, 2, points=5)
        self.assertEqual(profile.x, [-2, -1, 0, 1, 2])
        self.assertEqual(profile.y, [0.2, 0.05, 0, 0.05, 0.2])


class Errors(unittest.TestCase):
    def test_names_key_and_range(self):
        with self.assertRaises(tactel.InputError) as raised:
            tactel.solve(PARABOLA.with_(sensor=tactel.Sensor(poisson=0.7)))
        self.assertIn("poisson", raised.exception.place)
        self.assertIn("0.7", raised.exception.problem)
        self.assertIn("poisson", str(raised.exception))
        self.assertIsInstance(raised.exception, ValueError)

    def test_many_name_the_scene(self):
        with self.assertRaisesRegex(tactel.InputError, "2"):
            tactel.solve_many([PARABOLA, PARABOLA, PARABOLA.with_(friction=-1)])

    def test_a_long_list_is_not_repeated(self):
        data = tactel.Set(np.zeros((4, 2), np.float32), np.zeros(4, np.float32))
        with self.assertRaisesRegex(tactel.InputError, r"noise: 7, 7, .* \.\.\.; must be") as raised:
            tactel.train(data, layers=(2, 3, 1), noise=[7] * 1_000_000)
        self.assertLess(len(str(raised.exception)), 2000)

    def test_a_path_that_is_too_long(self):
        many = 100_000
        for load, key in ((tactel.Press(0.15).drag_to([0.1] * many), "tangential"), (tactel.Press([0.1] * (many + 1)), "indentation"),
                          (tactel.Force([0.1] * 101, steps=1000), "normal_force")):
            with self.assertRaisesRegex(tactel.InputError, f"load.{key}: .*; must be at most 100000 load steps"):
                tactel.solve(PARABOLA.with_(load=load))
        PARABOLA.with_(load=tactel.Press([0.1] * 1000, steps=100)).validate()

    def test_a_file_that_is_not_there(self):
        for call in (tactel.read_scene, tactel.Sweep, tactel.read_set, tactel.SlipEstimator.load):
            with self.assertRaisesRegex(tactel.InputError, "/no/such"):
                call("/no/such/file")


    def test_a_name_with_a_nul_byte_is_not_cut(self):
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            (place / "scene.toml").write_text((ROOT / "examples/parabola.toml").read_text())
            (place / "sweep.toml").write_text(SWEEP)
            (place / "set.h5").touch()
            rows = tactel.Sweep(place / "sweep.toml").generate(5)
            net = tactel.Network.from_arrays([np.ones((3, 42)), np.ones((1, 3))], [np.zeros(3), np.zeros(1)])
            net.to_onnx(place / "slip.onnx")
            before = sorted(place.iterdir())
            simulation = f"simulate:{place / 'scene.toml'}"
            for call, name in ((tactel.read_scene, "scene.toml"), (tactel.Sweep, "sweep.toml"), (tactel.read_set, "set.h5"),
                               (tactel.Network.load, "slip.onnx"), (tactel.SlipEstimator.load, "slip.onnx"),
                               (net.to_onnx, "new.onnx"), (rows.save, "new.h5"),
                               (lambda path: tactel.open_sensor(f"simulate:{path}"), "scene.toml"),
                               (lambda path: tactel.open_sensor(simulation, calibration=path), "scene.toml"),
                               (lambda path: tactel.open_sensor("usb:04D8:0001", profile=path), "scene.toml")):
                for kind in (str, pathlib.Path):
                    with self.subTest(name=name, kind=kind), self.assertRaisesRegex(tactel.InputError, "NUL byte"):
                        call(kind(str(place / name) + "\0x"))
            self.assertEqual(sorted(place.iterdir()), before)


class Calls(unittest.TestCase):
    """A wrong argument is named, whatever class or function it is of."""

    def test_names_the_argument(self):
        load = tactel.Press(0.1)
        frames = tactel.Set(np.zeros((4, 2)), np.zeros(4))
        for call, place, problem, fix in (
                (lambda: tactel.Sensor(tactel_widht=3), "Sensor", "no argument tactel_widht", "did you mean tactel_width?"),
                (lambda: tactel.Scene(frcition=0.3), "Scene", "no argument frcition", "did you mean friction?"),
                (lambda: tactel.Scene(tactel.Pad(), tactel.Sphere(), "low"), "Scene: friction", "'low', of type str", "must be float"),
                (lambda: tactel.solve_many([PARABOLA], keep="slipindex"), "solve_many: keep", "no array slipindex", "did you mean slip_index?"),
                (lambda: tactel.solve_many([PARABOLA], progress="yes"), "solve_many: progress", "'yes', of type str",
                 "must be bool | Callable[[int, int], Any] | None"),
                (lambda: PARABOLA.with_(3), "Scene.with_", "1 argument without a name", "give none"),
                (lambda: PARABOLA.validate(deep=True), "Scene.validate", "no argument deep", "it has none"),
                (lambda: tactel.Press(0.1).drag("a", 3), "Load.drag: step", "'a', of type str",
                 "must be float | tuple[float, float] | list[float]"),
                (lambda: tactel.Wedge(opening=3), "Wedge", "no argument opening", "it has edge_angle"),
                (lambda: load.drag(0.05, stepz=2), "Load.drag", "no argument stepz", "did you mean step?"),
                (lambda: tactel.solve(PARABOLA, acuracy=0.1), "solve", "no argument acuracy", "did you mean accuracy?"),
                (lambda: tactel.solve_many([PARABOLA], progres=True), "solve_many", "no argument progres", "did you mean progress?"),
                (lambda: tactel.Sweep("a.toml", sed=3), "Sweep", "no argument sed", "did you mean seed?"),
                (lambda: tactel.train(frames, sedes=3), "train", "no argument sedes", "did you mean seeds?"),
                (lambda: tactel.Network.from_arrays([], [], slop=1), "Network.from_arrays", "no argument slop", "did you mean slope?"),
                (lambda: tactel.open_sensor(sorce="x"), "open_sensor", "no argument sorce", "did you mean source?"),
                (lambda: tactel.Press(), "Press", "no indentation", "give it"),
                (lambda: tactel.Flat(1, 2), "Flat", "2 arguments without a name", "at most 1: half_width"),
                (lambda: tactel.Flat(1, half_width=2), "Flat", "half_width twice", "leave one out"),
                (lambda: tactel.Sensor(young="soft"), "Sensor: young", "'soft', of type str", "must be float"),
                (lambda: tactel.Sensor(20.0, tactels=2.5), "Sensor: tactels", "2.5, of type float", "must be int"),
                (lambda: tactel.Profile([0, 1], [0, "b"]), "Profile: y", "[0, 'b'], of type list", "must be Sequence[float]"),
                (lambda: tactel.Sensor(mesh=3), "Sensor: mesh", "3, of type int", "must be Mesh | None"),
                (lambda: load.drag(0.05, steps=2, twist=1), "Load.drag: step", "0.05, of type float",
                 "must be tuple[float, float] | list[float]"),
                (lambda: tactel.train("set.h5"), "train: data", "'set.h5', of type str", "must be Set"),
                (lambda: tactel.solve(3), "solve: scene", "3, of type int", "must be Scene"),
                (lambda: frames.save(3), "Set.save: path", "3, of type int", "must be str | os.PathLike[str]"),
                (lambda: tactel.Sweep(3), "Sweep: path", "3, of type int", "must be str | os.PathLike[str]"),
                (lambda: tactel.SlipEstimator.load(file="x"), "SlipEstimator.load", "no argument file", "it has path")):
            with self.subTest(problem=problem), self.assertRaises(tactel.InputError) as raised:
                call()
            self.assertEqual((raised.exception.place, raised.exception.problem, raised.exception.fix), (place, problem, fix))
            self.assertEqual(str(raised.exception), f"{place}: {problem}; {fix}")
            self.assertIsInstance(raised.exception, TypeError)

    def test_what_no_type_shows(self):
        with self.assertRaisesRegex(tactel.InputError, r"Pad: \(tactels=\(4, 5, 6\), axes=3\); must be \(tactels: tuple\[int, int\]"):
            tactel.Pad(tactels=(4, 5, 6), axes=3)
        with self.assertRaisesRegex(tactel.InputError, r"Profile: x: array\(3.*must be Sequence\[float\]"):
            tactel.Profile(np.array(3.0), [0, 1])

    def test_answers_name_what_makes_them(self):
        for kind, makers in ((tactel.Network, "Network.load, Network.from_arrays, train"), (tactel.Path, "solve"),
                             (tactel.PadPaths, "solve_many"), (tactel.Tactels, "Path.tactels, Paths.tactels"),
                             (tactel.Frame, "Stream.read"), (tactel.Stream, "open_sensor")):
            with self.assertRaises(tactel.InputError) as raised:
                kind()
            self.assertEqual(str(raised.exception), f"{kind.__name__}: no constructor; it is made by {makers}")

    def test_mistakes_of_own_functions_stay(self):
        with self.assertRaisesRegex(TypeError, "unsupported operand") as raised:
            tactel.Profile.sampled(lambda x: x + "a", left=0, right=1)
        self.assertNotIsInstance(raised.exception, tactel.InputError)
        with self.assertRaisesRegex(TypeError, "positional argument") as raised:
            tactel.solve_many([PARABOLA] * 3, progress=lambda done: None)
        self.assertNotIsInstance(raised.exception, tactel.InputError)

    def test_functions_keep_their_words(self):
        self.assertEqual(inspect.signature(tactel.Sweep.generate).parameters["contacts"].default, None)
        self.assertIn("steps: ", tactel.Press.__doc__)
        self.assertIs(pickle.loads(pickle.dumps(tactel.Press)), tactel.Press)


class Pictures(unittest.TestCase):
    """Pages and VTK files are those of the program."""

    def test_files_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            for name, options in (("parabola", {}), ("wedge", {"rung": "mesh-41"}), ("pad", {})):
                with self.subTest(name=name):
                    scene = ROOT / f"examples/{name}.toml"
                    path = example(name, **options)
                    chosen = [f"--rung={rung}" for rung in options.values()]
                    field = [] if name == "parabola" else ["--field", str(place / "field.vtu")]
                    subprocess.run([PROGRAM, "solve", str(scene), *chosen, "--html", str(place / "page.html"), *field,
                                    "--step", "3", "--quiet"], check=True, capture_output=True)
                    path.to_html(place / "own.html", 2)
                    path.to_vtu(place / "own.vtu", 2) if field else None
                    self.assertTrue((place / "own.html").read_text() == (place / "page.html").read_text())
                    if field:
                        self.assertTrue((place / "own.vtu").read_text() == (place / "field.vtu").read_text())
                    self.assertTrue(html.escape(path.html()) in path._repr_html_())

    def test_wrong_calls_are_named(self):
        path = tactel.solve(PARABOLA)
        for call, says in ((lambda: path.html(len(path)), "step: .*from 0 to"), (lambda: path.to_html("/no/such/page.html"), "/no/such"),
                           (lambda: path.to_vtu("/tmp/x.vtu"), "a patch, which has no nodes"),):
            with self.subTest(says=says), self.assertRaisesRegex(tactel.InputError, says):
                call()


class Answers(unittest.TestCase):
    """JSON, tables, scene files and convergence are those of the program."""

    def program(self, *words):
        return json.loads(subprocess.run([PROGRAM, "solve", *map(str, words), "--json", "-", "--quiet"], check=True, capture_output=True, text=True).stdout)

    def test_json_of_a_scene_that_was_written(self):
        for name in ("parabola", "pad"):
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                scene, copy = tactel.read_scene(ROOT / f"examples/{name}.toml"), pathlib.Path(folder) / "scene.toml"
                copy.write_text(scene.toml())
                self.assertEqual(json.loads(example(name).json())["steps"], self.program(copy)["steps"])
                self.assertEqual(tactel.read_scene(copy).toml(), scene.toml())

    def test_pandas(self):
        class DataFrame(dict):  # what is used of pandas
            def __init__(self, columns):
                super().__init__(columns)
                self.attrs = {}

        with mock.patch.dict("sys.modules", pandas=types.SimpleNamespace(DataFrame=DataFrame)):
            line = tactel.solve(PARABOLA)
            self.assertEqual(line.to_pandas()["slip_index"].tolist(), line.slip_index.tolist())
            self.assertEqual(line.to_pandas().attrs["units"]["P"], "N/mm")
            pad = example("pad")
            table = pad.to_pandas()
            self.assertEqual(table["Q_y"].tolist(), pad.Q[:, 1].tolist())
            self.assertTrue(all(np.asarray(column).shape == (len(pad),) for column in table.values()))
            self.assertEqual(table.attrs["units"].keys(), table.keys())
            self.assertEqual([table.attrs["units"][name] for name in ("P", "Q_y", "M", "twist", "slip_index")], ["N", "N", "N mm", "degrees", ""])
        with mock.patch.dict("sys.modules", pandas=None), self.assertRaisesRegex(tactel.InputError, "pandas: not installed; install it"):
            line.to_pandas()

    def test_convergence(self):
        scene = ROOT / "examples/parabola.toml"
        found = tactel.solve(tactel.read_scene(scene)).converge()
        said = self.program(scene, "--converge")["converge"]
        self.assertEqual(found.step + 1, said["step"])
        self.assertEqual([(n.name, n.limit, n.uncertainty) for n in found.numbers], [(q["name"], q["limit"], q["uncertainty"]) for q in said["quantities"]])
        self.assertEqual(len(found.h), len(found.numbers[0].values))
        self.assertIn("limit", repr(found.numbers[0]))


class OwnNetworks(unittest.TestCase):
    """Networks of other programs, beside NumPy's answer."""

    def layers(self, widths):
        draw = np.random.default_rng(2)
        return ([draw.normal(0, 0.4, (out, n)).astype(np.float32) for n, out in zip(widths, widths[1:])],
                [draw.normal(0, 0.4, out).astype(np.float32) for out in widths[1:]])

    def test_answers_are_those_of_the_layers(self):
        weights, biases = self.layers([6, 5, 4, 1])
        frames = np.random.default_rng(3).normal(0, 0.8, (50, 6)).astype(np.float32)
        kinds = {"sigmoid": lambda z: 1 / (1 + np.exp(-z)), "tanh": np.tanh, "relu": lambda z: np.maximum(z, 0),
                 "leaky-relu": lambda z: np.where(z > 0, z, 0.2 * z)}
        for kind, activation in kinds.items():
            with self.subTest(kind=kind), tempfile.TemporaryDirectory() as folder:
                net = tactel.Network.from_arrays(weights, biases, kind, slope=0.2, largest_stress=2)
                x = frames.astype(float) / 2
                for w, b in zip(weights[:-1], biases[:-1]):
                    x = activation(x @ w.T + b)
                s = 1 / (1 + np.exp(-(x @ weights[-1].T + biases[-1])))[:, 0]
                np.testing.assert_allclose(net(frames), s, atol=1e-6)
                file = str(pathlib.Path(folder) / "own.onnx")
                net.to_onnx(file)
                np.testing.assert_array_equal(tactel.SlipEstimator.load(file)(frames), net(frames))
                self.assertEqual(tactel.SlipEstimator.load(file).metadata("learning_set"), "own")

    def test_frames_are_divided_by_their_own_stress(self):
        weights, biases = self.layers([4, 3, 1])
        net = tactel.Network.from_arrays(weights, biases, "tanh", scaling="frame")
        frame = np.array([-0.4, -0.2, 0.1, 0.3], np.float32)
        np.testing.assert_allclose(net(frame), net(7 * frame), atol=1e-6)

    def test_differences_to_rest_with_history(self):
        # One pad tactel of three axes: two frames, the newest first, and the rest, whose normal stress is -0.5 MPa.
        weights, biases = self.layers([6, 5, 1])
        net = tactel.Network.from_arrays(weights, biases, "tanh", scaling="rest", history="2", axes=3, target="slid")
        newest, earlier, rest = np.random.default_rng(2).normal(0, 0.1, (3, 20, 3)).astype(np.float32)
        rest[:, 0] = -0.5
        x = np.tanh(np.hstack([newest - rest, earlier - rest]).astype(float) / 0.5 @ weights[0].T + biases[0])
        slid = 1 / (1 + np.exp(-(x @ weights[1].T + biases[1])))[:, 0]
        np.testing.assert_allclose(net(np.hstack([newest, earlier, rest])), slid, atol=1e-6)
        with tempfile.TemporaryDirectory() as folder:
            net.to_onnx(pathlib.Path(folder) / "own.onnx")
            self.assertEqual(tactel.SlipEstimator.load(pathlib.Path(folder) / "own.onnx").metadata("target"), "slid")

    def shear_alarm(self, **options):
        """S = 1 / (1 + exp(-10 shear)) of the first of two tactels' shears, which is above 0."""
        net = tactel.Network.from_arrays([[[0, 0, 1, 0]], [[10]]], [[0], [0]], "relu")
        return tactel.Alarm(net, **options)

    def test_an_alarm_follows_known_answers(self):
        alarm = self.shear_alarm(at=0.8, touch=0.1)
        self.assertEqual(alarm.inputs, 4)
        # Begins at 0.8, holds down to 0.75 and over a frame with NaN; without contact there is no S, and the alarm ends.
        for normal, s, contact, on in ((-0.2, 0.79, True, False), (-0.2, 0.81, True, True), (-0.2, 0.76, True, True),
                                       (-0.2, np.nan, True, True), (-0.2, 0.74, True, False), (-0.2, 0.9, True, True),
                                       (-0.09, 0.9, False, False), (-0.2, 0.79, True, False)):
            said = alarm.next([0, normal, np.log(s / (1 - s)) / 10, 0])
            self.assertEqual((said.contact, said.on, said.cannot_tell), (contact, on, bool(np.isnan(s))), (normal, s))
            np.testing.assert_allclose(said.slip_index, s if contact else np.nan, atol=1e-6)
            self.assertEqual(said.status, "not finite" if np.isnan(s) else "ok")
            self.assertTrue(np.isnan(said.slip_upper) and np.isnan(said.slip_interval[0]))
        self.assertEqual(repr(said), "AlarmAnswer(slip_index=0.79, contact=True, on=False, cannot_tell=False)")
        alarm.next([0, -0.2, 1, 0])
        alarm.clear()
        self.assertFalse(alarm.next([0, -0.2, np.log(0.77 / 0.23) / 10, 0]).on)
        self.assertIsNone(self.shear_alarm().next(np.zeros(4)).contact)
        held, near = self.shear_alarm(at=0.8, touch=0, hold=2, ignore_unlike=True), [0, -0.2, 1, 0]
        self.assertEqual([held.next(near).on for _ in range(3)], [False, True, True])
        self.assertFalse(held.next(near).beyond_learnt)

    def test_an_alarm_of_moved_needs_no_network(self):
        alarm = tactel.Alarm(tactels=2, axes=2, at=0.05, touch=0.01)
        frame = np.array([-0.2, -0.1, 0.05, 0.02])
        self.assertEqual([alarm.next(frame).rest for _ in range(10)], [False] * 9 + [True])
        said = alarm.next(frame + [0, 0, 0.03, 0])  # 0.03 over 0.3
        self.assertAlmostEqual(said.moved, 0.1, places=6)
        self.assertTrue(said.on and np.isnan(said.slip_index))
        alarm.rest()
        self.assertEqual(repr(alarm.next(frame)), "AlarmAnswer(slip_index=nan, contact=True, rest=False, moved=nan, on=False, cannot_tell=True)")
        beside = self.shear_alarm(touch=0.01, rest=True)
        self.assertEqual([beside.next(frame).rest for _ in range(10)][-1], True)
        for options, says in (({}, "network: none"), ({"tactels": 2, "signal": "moved"}, "at: 0.8"), ({"tactels": 2, "touch": 0}, "touch: 0.0"),
                              ({"tactels": 2, "at": 0.05, "touch": 0.1, "signal": "slid"}, "signal: slid")):
            with self.subTest(says=says), self.assertRaisesRegex(tactel.InputError, says):
                tactel.Alarm(**options)

    def test_an_alarm_of_left_follows_the_hand(self):
        hold = {"covariance": [1e-4 if i == j else 0 for i in range(8) for j in range(i + 1)], "held_at": 2}
        alarm, held, slides = tactel.Alarm(tactels=4, rate=30), tactel.Alarm(tactels=4, rate=30, **hold), tactel.Alarm(tactels=4, rate=30, slide=0.5)
        rng, frame = np.random.default_rng(3), np.array([-0.1] * 4 + [0] * 4 + [0.025] * 4)
        turned = np.array([-0.02, 0.02, -0.02, 0.02, 0.01, -0.01, -0.01, 0.01, 0, 0, 0, 0])
        for k in range(40):
            now = frame + (k >= 30) * turned + rng.normal(0, 1e-5, 12)
            said, by_hold, by_slide = alarm.next(now), held.next(now), slides.next(now)
            self.assertEqual((said.rest, said.why, said.on), (k >= 9, "" if k >= 9 else "no rest", k > 30), k)  # the median of three
            np.testing.assert_allclose(by_slide.index, 0.5, atol=0.01)
            if k == 31:
                # z x changes by 4 x 0.02 of P = 0.4, at sqrt(2) / 2 of the rms radius; it has 0.01 in the hold, whose at is 2
                np.testing.assert_allclose(by_hold.left, 0.2 * 2 ** -0.5 / 0.01 / 2, rtol=0.01)
        self.assertLess(said.calm, 0.01)
        self.assertFalse(said.released)
        with self.assertRaisesRegex(tactel.InputError, "covariance: 37 numbers"):
            tactel.Alarm(tactels=4, covariance=[0] * 37)

    def test_devices_answer_with_the_bits_of_host_code(self):
        found = tactel.devices()
        self.assertEqual([device.index for device in found], list(range(len(found))))
        self.assertEqual(sum(device.is_default for device in found), 1)
        self.assertTrue(all(device.memory > 1e8 and device.compute_units >= 1 and device.platform for device in found))
        net = tactel.Network.from_arrays(*self.layers([12, 9, 1]), "tanh", axes=3)
        frames = np.random.default_rng(5).normal(0, 0.3, (20, 2, 12)).astype(np.float32)
        frames[3, 0, 1], frames[7] = np.nan, 0
        for device in found:
            hand, host = tactel.LiveEstimator([net, net], device.name), tactel.LiveEstimator([net, net])
            self.assertEqual((hand.device, hand.sensors, hand.inputs, host.device), (device.name, 2, 24, ""))
            rules = {"at": 0.5, "touch": 0.01}
            alarm, follows, plain = tactel.Alarm(net, device=str(device.index), **rules), tactel.Alarm(net, **rules), tactel.Alarm(net, **rules)
            for both in frames:
                answers, expected = hand.next(both.ravel()), host.next(both.ravel())
                for answer, wanted in zip(answers, expected):
                    np.testing.assert_array_equal(answer.slip_index, wanted.slip_index)
                    self.assertEqual(answer.status, wanted.status)
                said = repr(plain.next(both[0]))
                self.assertEqual(repr(alarm.next(both[0])), said)
                self.assertEqual(repr(follows.next(both[0], answers[0])), said)
        for wrong in ({"device": "none such"}, {"network": net.estimator, "device": "cpu"}):
            with self.assertRaises(tactel.InputError):
                tactel.Alarm(**{"network": net, **wrong})
        with self.assertRaisesRegex(tactel.InputError, r"frames: an array of another shape; \[24\]"):
            hand.next(frames[0])

    def test_networks_and_alarms_survive_pickling(self):
        net = tactel.Network.from_arrays(*self.layers([12, 9, 1]), "tanh", axes=3, name="mine")
        frame = np.full(12, -0.2, np.float32)
        again = pickle.loads(pickle.dumps(net))
        self.assertEqual((again(frame), again.topology), (net(frame), net.topology))
        self.assertEqual(again.estimator.metadata("learning_set"), "mine")
        alarm = self.shear_alarm(at=0.8, touch=0.1)
        near = [0, -0.2, 1, 0]
        self.assertTrue(alarm.next(near).on)
        new = pickle.loads(pickle.dumps(alarm))  # as it was made
        self.assertFalse(new.next([0, -0.2, np.log(0.77 / 0.23) / 10, 0]).on)
        self.assertEqual(repr(new.next(near)), repr(alarm.next(near)))

    def test_an_alarm_refuses_what_it_cannot_mean(self):
        for options, says in (({"at": 1.1}, "at: 1.1"), ({"touch": -1}, "touch: -1"), ({"hold": 0}, "hold: 0"), ({"widest": 0.4}, "widest: 0.4.*without a bound")):
            with self.subTest(says=says), self.assertRaisesRegex(tactel.InputError, says):
                self.shear_alarm(**options)
        for frame in (np.zeros(3), np.zeros((2, 4)), 0.0):
            with self.assertRaisesRegex(tactel.InputError, r"frame: an array of another shape; \[4\]"):
                self.shear_alarm().next(frame)

    def test_wrong_layers_are_named(self):
        weights, biases = self.layers([6, 5, 4, 1])
        wrong = (((weights, biases[:2]), {}, "biases: 2 arrays"), ((weights[:2], biases[:2]), {}, "one output through a sigmoid"),
                 ((weights[::-1], biases[::-1]), {}, "layers .* that fit each other"),
                 ((weights, biases, "gelu"), {}, "activation: gelu"), ((weights, [b[:1] for b in biases]), {}, "1 biases"),
                 (([w[0] for w in weights], biases), {}, "1 axes"), ((weights, biases), {"scaling": "none"}, "scaling"),
                 ((weights, biases), {"largest_stress": 0}, "largest_stress"), ((weights, biases), {"history": "4"}, "history of 4"),
                 (([w * np.inf for w in weights], biases), {}, "finite"))
        for arguments, options, says in wrong:
            with self.subTest(says=says), self.assertRaisesRegex(tactel.InputError, says):
                tactel.Network.from_arrays(*arguments, **options)


class Solve(unittest.TestCase):
    def test_equals_the_program(self):
        path = tactel.solve(tactel.read_scene(str(ROOT / "examples/flat.toml")))
        answer = json.loads(subprocess.run([PROGRAM, "solve", str(ROOT / "examples/flat.toml"), "--json", "-"], check=True,
                                           capture_output=True, text=True).stdout)
        self.assertEqual(path.P.tolist(), [step["P"] for step in answer["steps"]])
        self.assertEqual(path.tactels.shear.tolist(), [step["tau_xy"] for step in answer["steps"]])
        self.assertEqual(path.tactel_x.tolist(), answer["tactel_x"])
        self.assertEqual(path.model, answer["model"])

    def test_warns_of_other_units(self):
        pascal = PARABOLA.with_(sensor=tactel.Sensor(young=2e6))
        self.assertRegex(tactel.solve(pascal).warnings[0], r"^sensor\.young = 2e\+06 MPa")
        self.assertRegex(tactel.solve_many([PARABOLA, pascal]).warnings[0], r"^scenes\[1\]: sensor\.young")

    def test_obeys_coulomb_and_balance(self):
        sensor = tactel.Sensor(length=20, tactels=400, tactel_width=0.05, tactel_span=19.95)
        path = tactel.solve(PARABOLA.with_(sensor=sensor))
        self.assertTrue(path.converged.all())
        self.assertTrue((np.abs(path.Q) <= 0.5 * path.P * (1 + 1e-6)).all())
        np.testing.assert_allclose(path.slip_index, path.Q / (0.5 * path.P), rtol=1e-12)
        # Tactels side by side measure the whole base: their mean stresses sum to the forces. The end tactels hold an
        # integrable singularity.
        np.testing.assert_allclose(-path.tactels.normal.sum(axis=1) * 0.05, path.P, rtol=5e-3)
        np.testing.assert_allclose(path.tactels.shear.sum(axis=1) * 0.05, path.Q, atol=5e-3 * path.P.max())

    def test_many_are_the_same_as_one_by_one(self):
        scenes = [PARABOLA.with_(friction=mu) for mu in (0.2, 0.5, 0.9)]
        many = tactel.solve_many(scenes, precision="fp64", rung="patch-12")
        for i, scene in enumerate(scenes):
            one = tactel.solve(scene, precision="fp64", rung="patch-12")
            np.testing.assert_array_equal(many.P[i], one.P)
            np.testing.assert_array_equal(many.tactels.normal[i], one.tactels.normal)

    def test_arrays_are_views_that_keep_their_owner(self):
        many = tactel.solve_many([PARABOLA])
        p = many.P
        self.assertIs(p.base, many)
        self.assertEqual(p.__array_interface__["data"], many.P.__array_interface__["data"])
        expected = p.copy()
        del many
        np.testing.assert_array_equal(p, expected)

    def test_keeps_what_is_asked_for(self):
        frames = tactel.solve_many([PARABOLA] * 2, keep="tactels")
        self.assertEqual((frames.shape, frames.dtype), ((2, 9, 42), np.float32))
        self.assertEqual(tactel.solve_many([PARABOLA] * 2, keep="slip_index").shape, (2, 9))

    def test_other_threads_run_meanwhile(self):
        counted, done = [0], threading.Event()

        def count():
            while not done.is_set():
                counted[0] += 1
                done.wait(0.001)

        tactel.solve(PARABOLA)  # the kernel is compiled
        thread = threading.Thread(target=count)
        thread.start()
        before = counted[0]
        tactel.solve(PARABOLA.with_(sensor=tactel.Sensor(mesh=tactel.Mesh(columns=61, rows=13))), solver="reference")
        after = counted[0]
        done.set()
        thread.join()
        self.assertGreater(after - before, 3)

    def test_progress_is_told_and_may_stop(self):
        told = []
        tactel.solve_many([PARABOLA] * 40, progress=lambda done, total: told.append((done, total)))
        self.assertEqual(told[-1], (40, 40))

        def fail(done, total):
            raise RuntimeError("enough")

        with self.assertRaisesRegex(RuntimeError, "enough"):
            tactel.solve_many([PARABOLA] * 40, progress=fail)

    def test_progress_in_words(self):
        """A second of weight updates of a long training: 1 082 568 400 000 less 2 868 806 260, at 286 880 626 a second, is 3764 s."""
        notebook = "\r" + 79 * " " + "\r"
        for kind, before, after in (("terminal", "\r\x1b[K", "\r\x1b[K"), ("notebook", notebook, notebook), ("log", "", "\n")):
            live = kind != "log"
            stderr = type("OutStream", (io.StringIO,), {"__module__": "ipykernel.iostream" if kind == "notebook" else "io"})()
            stderr.isatty = lambda: kind == "terminal"
            times = iter((100.0, 100.5, 110.0 if live else 131.0, 110.1 if live else 131.1))
            with mock.patch("sys.stderr", stderr), mock.patch("tactel._time.monotonic", lambda: next(times)):
                with tactel._Progress(True, "training", "weight updates") as told:
                    told(0, 1082568400000)
                    told(10, 1082568400000)  # half a second: nothing yet
                    told(2868806260 if live else 31 * 286880626, 1082568400000)
                    told(2868806261, 1082568400000)  # soon after
            line = "training: 0.3 %, 287 M weight updates/s, 1 h 02 min left" if live else \
                "training: 0.8 %, 287 M weight updates/s, 1 h 02 min left"
            self.assertEqual(stderr.getvalue(), before + line + after)

    def test_progress_is_a_line_on_stderr(self):
        times = itertools.count(5.0)
        for progress, shown in ((True, "scenes: 100.0 %, 40 scenes/s, 0 s left"), (False, ""), (None, "")):
            stderr = io.StringIO()
            stderr.isatty = lambda: True
            with mock.patch("sys.stderr", stderr), mock.patch("tactel._time.monotonic", lambda: next(times)):
                tactel.solve_many([PARABOLA] * 40, progress=progress)
            self.assertIn(shown, stderr.getvalue())
            self.assertEqual(stderr.getvalue() == "", shown == "")


SWEEP = """[sweep]
contacts = 60
seed = 3
[sensor]
tactel_span = 18.0
[indenter]
shape = "parabola"
radius = { uniform = [5, 50] }
[contact]
friction = { uniform = [0.2, 0.8] }
[load]
indentation = 0.15
tangential_step = 0.05
tangential_steps = 5
"""
OWN_SENSORS = SWEEP.replace("[sensor]", "[sensor]\nyoung = { uniform = [1, 3] }\nthickness = { uniform = [1, 2] }")


class SetsAndNetworks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name) / "sweep.toml"
        cls.path.write_text(SWEEP)
        cls.sweep = tactel.Sweep(cls.path)
        cls.set = cls.sweep.generate()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_batches_are_the_set(self):
        self.assertEqual(self.sweep.warnings, [])
        self.assertEqual(len(self.sweep), 60)
        frames, s = [], []
        for batch, answer in self.sweep.batches(25):
            frames.append(batch)
            s.append(answer)
            if sum(map(len, s)) >= len(self.set):
                break
        np.testing.assert_array_equal(np.concatenate(frames)[:len(self.set)], self.set.frames)
        np.testing.assert_array_equal(np.concatenate(s)[:len(self.set)], self.set.slip_index)

    def test_sets_that_do_not_fit_into_memory_are_refused(self):
        for generate in (lambda: self.sweep.generate(2**62), lambda: next(self.sweep.batches(2**62))):
            with self.assertRaisesRegex(tactel.InputError, f"{2**62}; must be at most .* fit into memory"):
                generate()

    def test_another_seed_is_another_set(self):
        frames, _ = next(self.sweep.batches(60, seed=4))
        self.assertFalse(np.array_equal(frames[:10], self.set.frames[:10]))

    def test_is_the_set_of_the_program(self):
        output = pathlib.Path(self.folder.name) / "set.h5"
        subprocess.run([PROGRAM, "generate", str(self.path), "--output", str(output), "--quiet"], check=True)
        read = tactel.read_set(output)
        for name in ("frames", "indentation", "tangential", "tactel_x", "parameters"):
            np.testing.assert_array_equal(getattr(read, name), getattr(self.set, name), name)
        self.assertEqual(read.parameter_names, self.set.parameter_names)

    def test_saves_the_file_of_the_program(self):
        noisy = SWEEP.replace("seed = 3\n", "seed = 3\npress_rows = true\n") + "[transducer]\nnoise = 0.01\n"
        for name, text in (("plain", SWEEP), ("own", OWN_SENSORS), ("noisy", noisy), ("many", SWEEP.replace("= 60", "= 2000"))):
            with self.subTest(name=name):
                place = pathlib.Path(self.folder.name) / name
                sweep, there, saved = (place.with_suffix(suffix) for suffix in (".toml", ".h5", ".saved.h5"))
                sweep.write_text(text)
                subprocess.run([PROGRAM, "generate", str(sweep), "--output", str(there), "--quiet"], check=True)
                tactel.Sweep(sweep).generate().save(saved)
                self.assertTrue(saved.read_bytes() == there.read_bytes())
                tactel.read_set(there).save(saved)
                self.assertTrue(saved.read_bytes() == there.read_bytes())

    def test_batches_of_several_processes_are_not_the_same(self):
        code = f"""if True:
            import os, tactel
            sweep = tactel.Sweep({str(self.path)!r})
            child = os.fork()
            if child:
                tactel.devices()
                if os.fork():
                    os.wait(), os.wait()
                else:
                    tactel.devices()
            else:
                try:
                    sweep.batches(10)
                except tactel.InputError as error:
                    print(error, flush=True)
                sweep.batches(10, seed=4), sweep.batches(10, first=0)
                print("drawn")
        """
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        self.assertRegex(done.stdout, "each would draw the same contacts.*\ndrawn\n")
        self.assertIn("fork: the threads of OpenCL stay in the process that was forked; start processes anew", done.stderr)
        workers = mock.Mock(get_worker_info=lambda: mock.Mock(num_workers=2))
        with mock.patch.dict("sys.modules", {"torch.utils.data": workers}), self.assertRaises(tactel.InputError):
            self.sweep.batches(10)

    def test_a_sweep_survives_pickling(self):
        sweep = tactel.Sweep(self.path, 5, tactels=9)
        data = pickle.dumps(sweep)
        again = pickle.loads(data)
        np.testing.assert_array_equal(again.generate(10).frames, sweep.generate(10).frames)
        self.assertTrue(next(again.batches(10)))
        # In another process it is one of several.
        code = f"import pickle; pickle.loads({data!r}).batches(10)"
        done = subprocess.run([sys.executable, "-c", code], cwd="/", capture_output=True, text=True)
        self.assertIn("each would draw the same contacts", done.stderr)
        text = self.path.read_text()
        try:
            self.path.write_text(text.replace("0.8", "0.9"))
            with self.assertRaisesRegex(tactel.InputError, "changed since the sweep was pickled"):
                pickle.loads(data)
        finally:
            self.path.write_text(text)

    def test_counts_and_numbers_have_a_range(self):
        with self.assertRaisesRegex(tactel.InputError, "100000"):
            tactel.Press(0.2).drag((0.05, 0.02), 10**9)

    def test_saves_what_a_set_has(self):
        place = pathlib.Path(self.folder.name)
        some, again, own = place / "some.h5", place / "some_again.h5", place / "own_rubber.toml"
        own.write_text(OWN_SENSORS)
        generate = [PROGRAM, "generate", str(self.path), "--quiet", "--output"]
        for sweep, options in ((self.path, ["--columns", "tactel_x,friction"]), (own, ["--columns", "thickness"]), (self.path, ["--compress"])):
            subprocess.run([PROGRAM, "generate", str(sweep), "--quiet", "--force", "--output", str(some), *options], check=True)
            tactel.read_set(some).save(again)
            self.assertTrue(again.read_bytes() == some.read_bytes(), options)
        # A part of a sweep, or its sensor with another seed, is not that file's set: --resume does not take it for it.
        for made in (self.sweep.generate(20), tactel.Sweep(self.path, 4).generate()):
            made.save(again)
            subprocess.run([PROGRAM, "check", str(again)], check=True, capture_output=True)
            answer = subprocess.run([*generate, str(again), "--resume"], capture_output=True, text=True)
            self.assertEqual(answer.returncode, 2)
            self.assertIn("a set of the requested conditions; it is a part of the sweep, or of other options", answer.stderr)
        self.set.save(again)
        subprocess.run([*generate, str(again), "--resume"], check=True)
        with self.assertRaisesRegex(tactel.InputError, "/no/such"):
            self.set.save("/no/such/set.h5")

    def test_scenes_of_a_sweep_can_be_solved(self):
        scene = self.sweep.scene(7)
        rows = self.set.contact == 7  # the end of the pressing, then the drags
        np.testing.assert_allclose(tactel.solve(scene).slip_index, self.set.slip_index[rows], atol=1e-3)

    def test_parameters_are_those_of_the_scenes(self):
        names, scene = self.set.parameter_names, self.sweep.scene(7)
        drawn = dict(zip(names, self.set.parameters[7]))
        self.assertEqual(drawn["contact.friction"], np.float32(scene.friction))
        self.assertEqual(drawn["indenter.position"], np.float32(scene.indenter.position))
        self.assertEqual(self.set.parameters.shape, (self.set.contacts, len(names)))
        self.assertEqual(len(self.set.parameter_units), len(names))
        path, rows = tactel.solve(scene), self.set.contact == 7
        np.testing.assert_allclose(self.set.indentation[rows], path.indentation, rtol=1e-6)
        np.testing.assert_allclose(self.set.tangential[rows], path.tangential, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(self.set.tactel_x, path.tactel_x, atol=1e-6)

    def test_columns_are_views(self):
        self.assertIs(self.set.frames.base, self.set)
        self.assertEqual(self.set.frames.shape, (len(self.set), 42))

    def test_networks_learn_and_travel(self):
        nets = tactel.train(self.set, layers=(42, 21, 1), seeds=2, scaling="frame", cycles=200)
        self.assertEqual([net.seed for net in nets], [1, 2])
        s = nets[0](self.set.frames)
        mean = float(np.abs(s - self.set.slip_index).mean())
        self.assertLess(mean, 0.5 * float(np.abs(self.set.slip_index - self.set.slip_index.mean()).mean()))
        self.assertAlmostEqual(mean, nets[0].errors(self.set).mean, places=6)
        file = str(pathlib.Path(self.folder.name) / "slip.onnx")
        nets[0].to_onnx(file)
        loaded = tactel.SlipEstimator.load(file)
        np.testing.assert_array_equal(loaded(self.set.frames), s)
        self.assertEqual(loaded(self.set.frames[0]), float(s[0]))
        self.assertEqual(loaded(self.set.frames.reshape(-1, 1, 42)).shape, (len(self.set), 1))
        broken = self.set.frames[0].copy()
        broken[3] = np.nan
        self.assertTrue(np.isnan(loaded(broken)))
        self.assertEqual(loaded.status(broken[None]).tolist(), [2])
        with self.assertRaisesRegex(tactel.InputError, "42"):
            loaded(np.zeros(41, np.float32))

    def test_training_keeps_the_best_weights(self):
        """By the learning set itself: no worse than the last ones."""
        options = dict(layers=(42, 5, 1), schedule="cosine", loss="absolute", rate=0.005, warm_up=0.1, average=0.5, cycles=40)
        (best,) = tactel.train(self.set, validation=self.set, patience=30, **options)
        (last,) = tactel.train(self.set, **options)
        self.assertEqual(last.cycles, 40)
        self.assertLessEqual(best.cycles, 40)
        self.assertLessEqual(best.learning_errors.mean, last.learning_errors.mean)
        with self.assertRaisesRegex(tactel.InputError, "patience"):
            tactel.train(self.set, patience=3, **options)

    def test_bounds_are_those_of_the_file(self):
        """upper, interval and unlike of a loaded network, beside onnxruntime or an evaluation of the graph in NumPy."""
        nets = tactel.train(self.set, layers=(42, 21, 1), scaling="frame", cycles=50, bound=True, level=0.9)
        folder = pathlib.Path(self.folder.name)
        file, rows = str(folder / "bound.onnx"), str(folder / "calibration.h5")
        nets[0].to_onnx(file)
        sweep = folder / "calibration.toml"  # 1 in 1000 rows counts as unlike: no fewer can tell
        sweep.write_text(SWEEP.replace("contacts = 60", "contacts = 300").replace("seed = 3", "seed = 4"))
        subprocess.run([PROGRAM, "generate", str(sweep), "--output", rows, "--quiet"], check=True)
        subprocess.run([PROGRAM, "calibrate", "bound", file, rows, "--quiet"], check=True)
        network = tactel.SlipEstimator.load(file)
        rest = np.random.default_rng(1).normal(size=(50, 42)).astype(np.float32)  # unlike any contact
        frames = np.concatenate([self.set.frames, rest])
        if onnxruntime:
            names = ["slip_index", "slip_upper", "slip_interval", "unlike"]
            truth = dict(zip(names, onnxruntime.InferenceSession(file).run(names, {"frame": frames})))
        else:
            truth = onnx_numpy.evaluate(file, frames)
        unlike = truth["unlike"][:, 0] != 0
        self.assertTrue(0 < unlike.sum() < len(frames))
        np.testing.assert_array_equal(network.unlike(frames), unlike)
        # Sums of 42 products in single precision, in another order: 1e-5 at most. A frame whose S, width or number of
        # touching tactels lies at the edge of a class by that much may take the class beside it; none does here.
        np.testing.assert_allclose(network(frames), truth["slip_index"][:, 0], atol=1e-5)
        np.testing.assert_allclose(network.upper(frames), truth["slip_upper"][:, 0], atol=1e-5)
        np.testing.assert_allclose(network.interval(frames), truth["slip_interval"], atol=1e-5)
        self.assertEqual(network.interval(frames[0]).shape, (2,))
        plain = tactel.Network.from_arrays([np.ones((5, 42)), np.ones((1, 5))], [np.zeros(5), np.zeros(1)]).estimator
        self.assertTrue(np.isnan(plain.upper(frames)).all() and np.isnan(plain.interval(frames)).all())
        self.assertFalse(plain.unlike(frames).any())
        with self.assertRaisesRegex(tactel.InputError, "level"):
            tactel.train(self.set, layers=(42, 5, 1), cycles=1, level=0.9)

    def test_networks_with_history(self):
        path = pathlib.Path(self.folder.name) / "presses.toml"
        path.write_text(SWEEP.replace("seed = 3\n", "seed = 3\npress_rows = true\n"))
        rows = tactel.Sweep(path).generate()
        self.assertTrue(rows.press_rows)
        self.assertFalse(self.set.press_rows)
        nets = tactel.train(rows, layers=(84, 10, 1), history=2, cycles=20)
        self.assertEqual(nets[0].estimator.inputs, 84)
        self.assertAlmostEqual(nets[0].errors(rows).mean, nets[0].learning_errors.mean, places=5)
        with self.assertRaisesRegex(tactel.InputError, "press_rows"):
            tactel.train(self.set, layers=(84, 10, 1), history=2, cycles=1)
        with self.assertRaisesRegex(tactel.InputError, "press_rows"):
            nets[0].errors(self.set)

    def test_own_arrays_make_a_set(self):
        own = tactel.Set(self.set.frames.astype(float), self.set.slip_index)
        np.testing.assert_array_equal(own.frames, self.set.frames)
        with self.assertRaises(tactel.InputError):
            tactel.Set(np.zeros((3, 42)), np.zeros(4))


class Sensors(unittest.TestCase):
    def test_frames_come_in_order_and_wake_select(self):
        with tactel.open_sensor(f"simulate:{ROOT}/examples/parabola.toml?rate=500") as stream:
            self.assertEqual(stream.inputs, 42)
            self.assertTrue(select.select([stream], [], [], 5)[0])
            numbers = []
            for frame in stream:
                self.assertEqual(frame.stress.shape, (42,))
                np.testing.assert_array_equal(np.asarray(frame), frame.stress)
                numbers.append(frame.number)
                if len(numbers) == 20:
                    break
            self.assertEqual(numbers, list(range(20)))
        with self.assertRaisesRegex(tactel.InputError, "closed"):
            stream.read()


class Stubs(unittest.TestCase):
    """The types of the package, which its build writes of the module."""

    def setUp(self):
        self.text = (pathlib.Path(tactel.__file__).parent / "__init__.pyi").read_text()
        self.classes = {node.name: node.body for node in ast.parse(self.text).body if isinstance(node, ast.ClassDef)}

    def test_members_agree(self):
        for name in tactel.__all__:
            if isinstance(public := getattr(tactel, name), type) and not issubclass(public, BaseException):
                typed = {getattr(member, "name", None) or member.target.id for member in self.classes[name]
                         if isinstance(member, (ast.FunctionDef, ast.AnnAssign))}
                there = {member for member in dir(public) if not member.startswith("_")}
                self.assertEqual(there, {member for member in typed if not member.startswith("_")} - {"path"}, name)

    def test_types_are_exact(self):
        """Any stands where the answer depends on a number, on what a file says, on pandas, or is a capsule of DLPack; a new one wants words in the binding."""
        vague = {name for name, body in self.classes.items() for member in body
                 if isinstance(member, ast.FunctionDef) and ast.unparse(member.returns or member) == "Any"}
        self.assertEqual(vague, {"Network", "PadPath", "Path", "Scene", "SlipEstimator", "StepAnswer", "Sweep"})
        arguments = re.findall(r"(\w+): Any", self.text)
        self.assertEqual(set(arguments), {"args", "changes", "kwargs"})

    def test_everything_is_documented(self):
        for name in tactel.__all__:
            if name != "bonded" and not name.endswith(("Error", "Cancelled")):
                self.assertTrue(getattr(tactel, name).__doc__, name)


if __name__ == "__main__":
    unittest.main()
