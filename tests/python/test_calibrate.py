# SPDX-License-Identifier: Apache-2.0
"""tactel.calibrate: presses on simulated sensors with unknown gains and E; the command, its files and its errors."""
import contextlib
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import warnings
from dataclasses import replace

import known_sensors
import numpy as np
from known_sensors import Known, texts

import tactel
from tactel import calibrate, read_scene
from tactel._press_plan import Candidate, Plan, usual_candidates

HELD = calibrate.Options(poisson=False)
one_numpy = unittest.skipIf(os.environ.get("TACTEL_NUMPY") == "2", "Debian's SciPy is for NumPy 1")


def known(seed, **how):
    return Known(seed, poisson=0.45, tactels=8, **how)


def changed(sensor, k, **changes):
    """The presses, one of them with another scene."""
    presses = list(sensor.presses)
    presses[k] = replace(presses[k], scene=presses[k].scene.with_(**changes))
    return presses


@one_numpy
class TestFit(unittest.TestCase):
    def test_finds_gains_and_rubber(self):
        sensor = Known(3, tactels=8)
        found = calibrate.fit(sensor.presses, calibrate.Options(rest_noise=sensor.rest_noise))
        self.assertTrue(found.converged)
        self.assertEqual(texts(found), [])
        self.assertGreaterEqual(sensor.within(found, 3), 15)  # 99.7 % of a normal distribution
        self.assertTrue(found.numbers["young"].within(sensor.young, 3))
        self.assertTrue(found.numbers["poisson"].within(sensor.poisson, 3))
        self.assertEqual(found.numbers["thickness"].deviation, 0)
        self.assertIn("sensor.thickness is held", found.held[0])

    def test_dead_swapped_and_saturated_channels_are_named(self):
        sensor = known(1)
        presses = [replace(press, readings=press.readings.copy()) for press in sensor.presses]
        random, lowest = np.random.default_rng(5), min(press.readings[:, 6].min() for press in sensor.presses)
        for press in presses:
            press.readings[:, 3] = 7
            press.readings[:, 12] = 2000 + 3 * random.standard_normal(len(press.readings))
            press.readings[:, [1, 5]] = press.readings[:, [5, 1]]
        with self.subTest("dead and swapped"):
            found = calibrate.fit(presses, HELD)
            self.assertEqual(sorted(fault.kind for fault in found.faults), ["dead_channel", "dead_channel", "swapped_channels"])
            self.assertIn("normal stress of tactel 3: the reading never changes; it has no gain", texts(found))
            self.assertIn("shear stress of tactel 4: the reading does not follow the stress; it has no gain", texts(found))
            for channel in (1, 3, 5, 12):
                self.assertTrue(np.isnan(found.gain[channel].value))
            self.assertTrue(found.gain[10].within(sensor.gain[10], 4))
        with self.subTest("saturated"):
            end = lowest + 0.1 * (2048 - lowest)
            cut = [replace(press, readings=np.maximum(press.readings, end)) for press in sensor.presses]
            found = calibrate.fit(cut, replace(HELD, lowest_reading=end))
            self.assertEqual({fault.kind for fault in found.faults}, {"saturated"})
            self.assertTrue(found.numbers["young"].within(sensor.young, 4))

    def test_a_wrong_press_is_named_and_left_out(self):
        sensor = known(2)
        found = calibrate.fit(changed(sensor, 6, indenter=tactel.Indenter(tactel.Wedge(150), -1.7)), HELD)
        self.assertEqual([fault.kind for fault in found.faults], ["wrong_press"])
        self.assertIn("press 7: residuals", texts(found)[0])
        self.assertTrue(np.isnan(found.residuals[6]).all())
        self.assertTrue(found.numbers["young"].within(sensor.young, 4))

    def test_the_number_that_does_not_fit_is_named(self):
        sensor = known(6)
        self.assertEqual(texts(calibrate.fit(sensor.presses, HELD)), [])
        presses = list(sensor.presses)
        for k in range(1, 20, 2):
            presses[k] = changed(sensor, k, indenter=presses[k].scene.indenter.with_(shape=tactel.Cylinder(6 / 1.05)))[k]
        said = texts(calibrate.fit(presses, HELD), "model_misfit")
        self.assertRegex(said[0], r"indenter.radius of press 2, press 4 and 8 more\? the readings ask for (5.9|6)\d*")

    def test_residuals_beyond_the_noise_at_rest_are_named(self):
        sensor = known(6)
        found = calibrate.fit(sensor.presses, replace(HELD, rest_noise=sensor.rest_noise / 1.5))
        self.assertRegex(texts(found)[0], "residuals are 1.[45] times the noise at rest, .* in press")
        other = [replace(press, scene=press.scene.with_(indenter=press.scene.indenter.with_(shape=tactel.Cylinder(0.3 * press.scene.indenter.shape.radius))))
                 for press in sensor.presses]
        found = calibrate.fit(other, replace(HELD, rest_noise=sensor.rest_noise))
        self.assertEqual(len(texts(found, "wrong_indenter")), 1)

    def test_without_forces_young_is_held(self):
        sensor = known(4)
        found = calibrate.fit([replace(press, P=None) for press in sensor.presses], HELD)
        self.assertEqual(found.numbers["young"], calibrate.Fitted(2.0, 0.0))
        self.assertIn("sensor.young is held", found.held[0])
        self.assertAlmostEqual(found.gain[4].value / sensor.gain[4], 2 / sensor.young, delta=0.02)  # stress over E is what readings tell

    def test_the_gauge_errs_once_a_press(self):
        of_gauge = 0.01 / np.sqrt(20)
        young = calibrate.fit(known(5, noise=0.0005).presses, HELD).numbers["young"]
        self.assertGreaterEqual(young.deviation / young.value, 0.999 * of_gauge)
        self.assertLessEqual(young.deviation / young.value, 2 * of_gauge)  # with the model's error
        young = calibrate.fit(known(5, gauge=0.05).presses, HELD).numbers["young"]  # scatter of 5 %, where 1 % is said
        self.assertAlmostEqual(young.deviation / young.value, 5 * of_gauge, delta=3 * 0.16 * 5 * of_gauge)  # of 20 presses it is known within 16 %

    def test_finds_the_time_constant(self):
        timing = [1, 1.6, 2.4, 3.2, 4], [1.2, 1.8, 2.6, 3.4, 4.2], [1.5, 2.3, 3.1, 3.9, 4.7]
        sensor = known(7, time_constant=1.7, timing=timing)
        found = calibrate.fit(sensor.presses, replace(HELD, time_constant=1.0, fit_time_constant=True))
        self.assertTrue(found.converged)
        self.assertTrue(found.numbers["time_constant"].within(1.7, 3))
        self.assertLess(found.numbers["time_constant"].deviation, 0.1)
        self.assertGreaterEqual(sensor.within(found, 3), 15)

    def test_finds_the_friction_of_presses(self):
        sensor = known(9, count=10)
        presses = [changed(sensor, k, friction=0.5 if k % 2 else 0.7)[k] for k in range(10)]
        found = calibrate.fit(presses, replace(HELD, friction=0.3))
        self.assertTrue(found.converged)
        self.assertGreaterEqual(sum(mu.within(0.6) for mu in found.friction), 7)  # 9.5 of a normal distribution; fewer than 7: one of 1000
        self.assertTrue(all(mu.within(0.6, 5) and mu.deviation <= 0.21 for mu in found.friction))

    def test_amplifiers_respond_as_their_equation(self):
        """v' = x' - v / RC in steps of 0.1 ms."""
        timing, stress, RC, dt = ([0.2, 1.0, 1.6], [0.5, 1.0, 1.9], [0.9, 1.3, 1.9]), np.array([-0.2, 0.5, 0.1]), 0.7, 1e-4
        times = np.arange(0, 1.9 + dt / 2, dt)
        x = sum((to - before) * (np.clip((times - b) / (e - b), 0, 1) if e > b else times >= b - dt / 2)
                for b, e, to, before in zip(*timing[:2], stress, [0, *stress]))
        v = [0.0]
        for change in np.diff(x):
            v.append(v[-1] * np.exp(-dt / RC) + change)
        read = calibrate.amplifier_response(timing, RC) @ stress
        for k, time in enumerate(timing[2]):
            self.assertAlmostEqual(read[k], v[round(time / dt)], delta=2e-4)  # dt / RC of a jump
        np.testing.assert_allclose(calibrate.amplifier_response(timing, np.inf) @ stress, stress)

    def test_wrong_presses_are_refused(self):
        sensor = known(4)
        for presses in ([], [replace(sensor.presses[0], readings=np.zeros((4, 16)), P=None)], [replace(sensor.presses[0], readings=np.zeros((5, 15)))]):
            with self.assertRaises(tactel.InputError):
                calibrate.fit(presses, HELD)
        with self.assertRaises(tactel.InputError):
            calibrate.fit(sensor.presses, replace(HELD, fit_time_constant=True))


def pad_presses():
    """Two spheres pressed and dragged beside 4 x 4 tactels, and a flat between them."""
    pad, found = tactel.Pad(thickness=4, young=0.5, poisson=0.46), []
    for k in range(12):
        side = -0.2 if k % 2 else 0.2
        if k < 8:
            indenter = tactel.PadIndenter(tactel.Sphere(6.0 if k % 3 else 10.0), (4.7 * (k % 4 - 1.5) + 0.8, 9.4 * (k // 4 - 0.5) - 0.6 + 1.2 * (k % 2)))
        else:
            indenter = tactel.PadIndenter(tactel.Punch(2.5), (4.7 if k % 2 else -4.7, 4.7 if k < 10 else -4.7))
        depth = 0.6 + 0.1 * (k % 4) if k < 8 else 0.35
        found.append(tactel.Scene(pad, indenter, 0.8, tactel.Press(depth, steps=2).drag_to([(side, 0.0), (side, -side)])))
    return found


@one_numpy
class TestPad(unittest.TestCase):
    young, noise = 0.6, 2e-4  # MPa

    def known(self, scenes):
        random = np.random.default_rng(11)
        paths = tactel.solve_many([scene.with_(sensor=scene.sensor.with_(young=self.young)) for scene in scenes], rung="pad-8", precision="fp64")
        gain, offset = 1e-5 * (1 + 0.15 * random.standard_normal(48)), 20000 + 100 * random.standard_normal(48)
        stress = np.concatenate([np.reshape(s, (*paths.P.shape, 16)) for s in (paths.tactels.normal, paths.tactels.shear_x, paths.tactels.shear_y)], 2)
        readings = (stress + self.noise * random.standard_normal(stress.shape)) / gain + offset
        return gain, [calibrate.Press(f"press {k + 1}", scene, readings[k], np.array(paths.P[k]) * (1 + 0.01 * random.standard_normal()))
                      for k, scene in enumerate(pad_presses())]

    def test_finds_gains_of_three_axes(self):
        gain, presses = self.known(pad_presses())
        found = calibrate.fit(presses, replace(HELD, rungs=("pad-8", "pad-8")))
        self.assertTrue(found.converged)
        self.assertTrue(found.numbers["young"].within(self.young, 3))
        self.assertEqual(found.numbers["shift_y"].deviation, 0)
        self.assertEqual(found.names[47], "shear stress along y of tactel 15")
        self.assertGreaterEqual(sum(one.within(true, 3) for one, true in zip(found.gain, gain)), 45)  # 99.7 % of a normal distribution

    def test_the_tilt_of_a_flat_is_named(self):
        rise = 2.5 * np.tan(np.radians(0.5))  # mm of the edge: the height at the axis stays
        tilted = [scene if isinstance(scene.indenter.shape, tactel.Sphere) else
                  scene.with_(indenter=scene.indenter.with_(tilt=0.5, tilt_direction=90.0),
                              load=scene.load.with_(indentation=[0.175 + rise, 0.35 + rise], indentation_steps=1)) for scene in pad_presses()]
        found = calibrate.fit(self.known(tilted)[1], replace(HELD, rungs=("pad-8", "pad-8")))
        self.assertIn("tilt of the indenters along their y", " ".join(texts(found)))


PROFILE = """# keep me
[format]
kind = "csv"
channels = 16
[channels]
normal = [0, 1, 2, 3, 4, 5, 6, 7]
shear = [8, 9, 10, 11, 12, 13, 14, {last}]
[calibration]
gain = 0.01
noise = 0.3
"""


@one_numpy
class TestCommand(unittest.TestCase):
    """Recordings of a sensor of eight tactels, half a second at rest and on each load step."""

    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.kept.cleanup)
        cls.folder = pathlib.Path(cls.kept.name)
        cls.random = np.random.default_rng(7)
        cls.gain, cls.offset = 0.01 * (1 + 0.2 * cls.random.standard_normal(16)), 100 * cls.random.standard_normal(16)
        cls.write("p.toml", PROFILE.format(last=15))
        sensor = tactel.Sensor(tactels=8, tactel_span=17)
        cls.plan = "[fit]\npoisson = false\n"
        for k in range(6):
            scene = tactel.Scene(sensor, tactel.Indenter(tactel.Cylinder(12), -7 + 2.8 * k), 0.6, tactel.Press(0.15).drag_to([0.03, 0.06]))
            P = cls.press(f"press{k}", scene)
            cls.plan += f'[press{k}]\nscene = "press{k}.toml"\nrecording = "press{k}.tactel"\ntimes = [0.75, 1.25, 1.75]\nwindow = 0.3\nP = {P}\n'

    @classmethod
    def write(cls, name, text):
        (cls.folder / name).write_text(text)

    @classmethod
    def press(cls, name, scene, rest=50, hold=50):
        """Writes the scene and records a press of E = 2.6 at 100 Hz. Returns its forces."""
        cls.write(name + ".toml", scene.toml())
        path = tactel.solve_many([scene.with_(sensor=scene.sensor.with_(young=2.6))], rung="patch-24", precision="fp64")
        stress = np.vstack([np.zeros((rest, 16)), np.repeat(path.frames[0], hold, axis=0)])
        readings = (stress + 0.002 * cls.random.standard_normal(stress.shape)) / cls.gain + cls.offset
        lines = [f"{k / 100:.2f}," + ",".join(f"{one:.6f}" for one in row) for k, row in enumerate(readings)]
        cls.write(name + ".csv", "\n".join(["time," + ",".join(f"c{i}" for i in range(16)), *lines]) + "\n")
        subprocess.run([os.environ["TACTEL_PROGRAM"], "record", "--source", f"csv:{cls.folder / name}.csv", "--profile", str(cls.folder / "p.toml"),
                        "--output", str(cls.folder / name) + ".tactel", "--quiet"], check=True)
        return [round(float(P), 6) for P in path.P[0]]

    def run_command(self, *words):
        """Exit code, standard output and standard error."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # of pipes that other tests left, found meanwhile
            try:
                code = calibrate.main([str(word) for word in words])
            except SystemExit as end:
                code = end.code
        return code, out.getvalue(), err.getvalue()

    def sensor(self, text, *more):
        self.write("r.toml", text)
        return self.run_command("sensor", self.folder / "r.toml", "--profile", self.folder / "p.toml", "--output", self.folder / "p2.toml", *more)

    def test_writes_a_profile_page_and_numbers(self):
        names = {kind: self.folder / f"c.{kind}" for kind in ("json", "html", "svg")}
        code, out, err = self.sensor(self.plan, "--json", names["json"], "--html", names["html"], "--plot", names["svg"])
        self.assertEqual((code, err), (0, ""))
        for part in ("sensor.young = 2.6", "sensor.thickness is held", "transducer.noise = 0.00"):
            self.assertIn(part, out)
        self.assertNotIn("tare with this profile", out)
        self.assertIn("Gains of 16 of 16 transducers", names["html"].read_text())
        self.assertNotIn("src=", names["html"].read_text())
        self.assertIn("<svg", names["svg"].read_text())
        found = json.loads(names["json"].read_text())
        self.assertEqual(set(found), {"converged", "iterations", "young", "poisson", "thickness", "shift", "friction", "fitted", "correlation", "held",
                                      "faults", "gain", "offset", "noise", "rest_noise", "residuals"})
        self.assertAlmostEqual(found["young"]["value"], 2.6, delta=0.03)
        profile = tactel._tactel._read_profile(str(self.folder / "p2.toml"))
        self.assertTrue(profile["text"].startswith("# keep me\n"))
        for c in range(16):
            self.assertAlmostEqual(profile["gain"][c], found["gain"][c]["value"], places=15)
            self.assertLess(abs(profile["gain"][c] - self.gain[c]), 4 * found["gain"][c]["deviation"])
            # A median of 18 windows of 30 frames scatters by sqrt(0.83 pi / 2 / 540) = 5 %; three of these.
            self.assertAlmostEqual(profile["noise"][c] * self.gain[c] / 0.002, 1, delta=0.15)

    def test_monitor_and_the_command_take_either_profile(self):
        """Profiles of the program's time, and those of this command, calibrate again to the same gains; monitor reads both."""
        self.assertEqual(self.sensor(self.plan)[0], 0)
        first = (self.folder / "p2.toml").read_text()
        old = first.replace("# keep me\n", "# keep me\n# sensor.young = 2.5991 +- 0.012 MPa\n")
        self.write("old.toml", old)
        for name in ("p2.toml", "old.toml"):
            with tactel.open_sensor(f"replay:{self.folder / 'press0.tactel'}", str(self.folder / name)) as stream:
                rest = np.array([frame.stress for frame in stream][:50])
            self.assertLess(np.abs(rest.mean(0)).max(), 0.003)  # MPa
            code = self.run_command("sensor", self.folder / "r.toml", "--profile", self.folder / name, "--output", self.folder / "p3.toml", "--quiet")[0]
            self.assertEqual(code, 0)
            again = re.search(r"\ngain = .*", (self.folder / "p3.toml").read_text())[0]
            self.assertEqual(again, re.search(r"\ngain = .*", first)[0])

    def test_wrong_files_are_named(self):
        press = '[a]\nscene = "press0.toml"\nrecording = "press0.tactel"\n'
        timed = press + "times = [1, 1.5, 1.9]\n"
        for text, part in ((("[fit]\n"), "at least one table of a press"), ('[a]\nscene = "press0.toml"\n', "a.recording"), (press + "times = [1, 2]\n", "load steps, 3"),
                           (press + "times = [1, 1.5, 9]\n", "9 s has no frame"), (timed + "P = [1]\n", "as long as times, 3"), (timed + "force = 2\n", "a.force"),
                           (timed + "P = [0, 0.5, 0.5]\n", "a.P"), (timed + "window = 1e9\n", "a.window"), (timed + "window = 0\n", "a.window"),
                           (press + "times = [1, 1.9, 1.5]\n", "each later than the one before"), ("a = 1\n", "a: no table"), ("[a\n", "must be a TOML file"),
                           (timed + "begin = [0.9, 1.2, 1.6]\nend = [0.8, 1.4, 1.8]\n", "s, not before begin"), ("[fit]\nforce_noise = 0\n" + timed, "fit.force_noise"),
                           ("[fit]\ntime_constant = true\n" + timed, "transducer.time_constant")):
            with self.subTest(text=text):
                code, _, err = self.sensor(text)
                self.assertEqual(code, 2)
                self.assertIn(part, err)
                self.assertEqual(len(err.splitlines()), 1)
        code, _, err = self.run_command("sensor", self.folder / "r.toml", "--profile", "uskin-4x4", "--output", self.folder / "p2.toml")
        self.assertEqual(code, 2)
        self.sensor(timed)
        code, _, err = self.run_command("sensor", self.folder / "r.toml", "--profile", "uskin-4x6", "--output", self.folder / "p2.toml")
        self.assertIn("a scene of a pad with the profile's 4 x 6 tactels", err)

    def test_a_kill_leaves_the_old_file(self):
        path = self.folder / "kept.toml"
        path.write_text("old")
        killed = f"""if True:
            import os
            from tactel import _calls
            os.fsync = lambda _: os.kill(os.getpid(), 9)
            _calls.write_text({str(path)!r}, "new")
        """
        self.assertEqual(subprocess.run([sys.executable, "-c", killed], check=False).returncode, -9)
        self.assertEqual(path.read_text(), "old")

    def test_says_what_is_missing(self):
        code = "import sys; sys.modules['scipy'] = None; from tactel import calibrate; sys.exit(calibrate.main(['sensor', 'r', '--profile', 'p', '--output', 'o']))"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (2, "tactel.calibrate: scipy: not installed; install it: pip install scipy\n"))

    def test_a_plan_leads_to_a_calibrated_profile(self):
        self.write("rod.toml", tactel.Scene(tactel.Sensor(tactels=8, tactel_span=17), tactel.Cylinder(12), 0.6, tactel.Press(0.15).drag_to([0.03, 0.06])).toml())
        self.write("list.toml", '[fit]\npoisson = false\n[rod]\nscene = "rod.toml"\nposition = [-7, -5, -3, -1, 1, 3, 5, 7]\nindentation = [0.1, 0.15]\ndrag = [0, 0.06, -0.06]\n')
        self.write("unused.toml", PROFILE.format(last=-1))
        output, names = self.folder / "my plan.toml", [self.folder / f"my plan-{k:02}" for k in range(1, 7)]
        code, out, err = self.run_command("plan", self.folder / "unused.toml", "--candidates", self.folder / "list.toml", "--presses", 6, "--output", output,
                                          "--json", self.folder / "plan.json")
        self.assertEqual((code, err), (0, ""))
        self.assertIn("sensor.young", out)
        found = json.loads((self.folder / "plan.json").read_text())
        self.assertEqual((found["candidates"], len(found["presses"]), found["noise"][0], found["noise"][15]), (48, 6, 0.003, None))  # 0.3 units of 0.01 MPa
        self.assertIsNone(found["planned"]["poisson"])
        text = output.read_text()
        for name in names:
            P = self.press(name.name, read_scene(f"{name}.toml"), 100, 100)
            text = text.replace("# P = [ ]", f"P = {P}", 1)
        output.write_text(text)
        code, _, err = self.run_command("sensor", output, "--profile", self.folder / "unused.toml", "--output", self.folder / "p2.toml", "--json", self.folder / "c.json")
        self.assertEqual(code, 0, err)
        fitted = json.loads((self.folder / "c.json").read_text())
        profile = tactel._tactel._read_profile(str(self.folder / "p2.toml"))
        for c in range(15):
            self.assertLess(abs(profile["gain"][c] - self.gain[c]), 4 * fitted["gain"][c]["deviation"])
        self.assertEqual(profile["gain"][15], 0.01, "no tactel uses it")

    def test_wrong_lists_are_named(self):
        self.write("rod.toml", tactel.Scene(tactel.Sensor(tactels=8), tactel.Cylinder(12), 0.6, tactel.Press(0.15)).toml())
        self.write("three.toml", tactel.Scene(tactel.Sensor(tactels=3), tactel.Cylinder(12), 0.6, tactel.Press(0.15)).toml())
        rod = '[rod]\nscene = "rod.toml"\n'
        for text, part in (("[fit]\npoisson = false\n", "at least one table of candidates"), ("[rod]\nposition = 1\n", "rod.scene"), (rod + "places = 1\n", "rod.places"),
                           (rod + "position = [0, 99]\n", "indenter.position"), (rod + "indentation = 1\nnormal_force = 1\n", "rod.normal_force"),
                           ("[fit]\nfriction = 2\n" + rod, "fit.friction"), (rod, "--presses"), ('[rod]\nscene = "three.toml"\n', "the profile's 8 tactels")):
            with self.subTest(text=text):
                self.write("list.toml", text)
                code, _, err = self.run_command("plan", self.folder / "p.toml", "--candidates", self.folder / "list.toml")
                self.assertEqual(code, 2)
                self.assertIn(part, err)
        self.assertIn("plan serves lines", self.run_command("plan", "uskin-4x4")[2])


@one_numpy
class TestPlan(unittest.TestCase):
    candidates = [one for one in usual_candidates(tactel.Scene(known_sensors.NOMINAL.with_(tactels=8), tactel.Cylinder(6), 0.6))
                  if abs(one.scene.indenter.position) < 9]

    def test_expects_the_deviations_that_the_fit_reports(self):
        few = self.candidates[4::23]
        timing = few[0].timing
        self.assertEqual(len(timing[0]), len(timing[2]))
        options = calibrate.Options(poisson=False, shift=True, friction=0.2, time_constant=2.0, fit_time_constant=True)
        plan = Plan(few, len(few), options, noise=[0.03] * 16)
        gains, told, _ = plan.deviations(plan.chosen)
        random = np.random.default_rng(3)
        paths = [tactel.solve_many([one.scene], rung="patch-12", precision="fp64") for one in few]
        presses = []
        for k, (one, path) in enumerate(zip(few, paths)):
            stress = calibrate.amplifier_response(one.timing, 2.0) @ np.concatenate([path.tactels.normal[0], path.tactels.shear[0]], 1)
            presses.append(calibrate.Press(f"press {k}", one.scene, (stress + 0.03 * random.standard_normal(stress.shape)) / 0.001, np.array(path.P[0]), one.timing))
        found = calibrate.fit(presses, replace(options, rungs=("patch-12", "patch-12")))
        self.assertEqual(set(told), {"young", "shift", "time_constant"})
        rows = sum(len(press.readings) for press in presses)
        for gain, expected in zip(found.gain, gains):
            if expected < 0.5:  # the plan's weak information counts beyond
                # The fit takes the noise of its own residuals, which scatters by 1 / sqrt(2 rows); three of these, and 5 % of parabolas.
                self.assertAlmostEqual(gain.deviation / gain.value / expected, 1, delta=3 / np.sqrt(2 * rows) + 0.05 + abs(gain.value / 0.001 - 1))
        for key in ("young", "time_constant"):
            number = found.numbers[key]
            self.assertAlmostEqual(number.deviation / number.value / told[key], 1, delta=0.15)

    def test_says_what_no_plan_finds(self):
        middle = [one for one in self.candidates if abs(one.scene.indenter.position) < 3 and not one.scene.load.tangential]
        plan = Plan(middle, 2, HELD, forces=False)
        lost = " ".join(plan.lost(HELD))
        self.assertIn("No plan finds sensor.young", lost)
        self.assertIn("No candidate loads the normal stress of tactel 1 enough", lost)
        self.assertNotIn("normal stress of tactel 4 ", lost)

    def test_ten_planned_presses_tell_as_much_as_twenty_random_ones(self):
        plan = Plan(self.candidates, 10, HELD)
        planned = plan.deviations(plan.chosen)
        random = [plan.deviations(list(np.random.default_rng(seed).permutation(len(self.candidates))[:20])) for seed in range(20)]
        self.assertLessEqual(np.nanmedian(planned[0]), np.median([np.nanmedian(np.nan_to_num(one[0], nan=1.0)) for one in random]))
        # Of E ten presses know less, as each has one error of the gauge.
        self.assertLessEqual(planned[1]["young"], 1.05 * np.sqrt(2) * np.median([one[1]["young"] for one in random]))

    def test_wrong_numbers_are_refused(self):
        for count in (0, len(self.candidates) + 1):
            with self.assertRaises(tactel.InputError):
                Plan(self.candidates[:5], count)
        self.assertIsInstance(self.candidates[0], Candidate)


if __name__ == "__main__":
    unittest.main()
