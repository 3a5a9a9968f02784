# SPDX-License-Identifier: Apache-2.0
"""The first call of a process that takes a device, by eight threads at once; where Python's interpreter is another; Ctrl-C."""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"

# What each thread calls; it returns numbers or a text.
CALLS = {
    "devices": "[device.name for device in tactel.devices()]",
    "solve a line": "tactel.solve(LINE).slip_index",
    "solve a pad": "tactel.solve(PAD).slip_index",
    "solve_many lines": "tactel.solve_many([LINE] * 20).slip_index",
    "solve_many pads": "tactel.solve_many([PAD] * 20).slip_index",
    "generate lines": "tactel.Sweep('learning_mix.toml').generate(20).frames",
    "generate pads": "tactel.Sweep('pad_sweep.toml').generate(20, rung='pad-8').frames",
    "generate grips": "tactel.Sweep('uskin_grips.toml').generate(2, rung='pad-8').frames",
    "one sweep of all": "SWEEP.generate(20, rung='pad-8').frames",
    "batches": "next(iter(tactel.Sweep('pad_sweep.toml').batches(20, rung='pad-8')))[0]",
    "PadStepper": "stepped()",
    "train": "tactel.train(SET, layers=(42, 21, 1), seeds=2, cycles=2)[0](SET.frames)",
    "LiveEstimator": "[tactel.LiveEstimator([NETWORK], 'cpu').next(np.full(48, -0.1))[0].slip_index]",
    "Alarm": "[tactel.Alarm(NETWORK, device='cpu').next(np.full(48, -0.1)).slip_index]",
}
COLD = """
import sys, threading
import numpy as np
import tactel

LINE, PAD, SWEEP = tactel.read_scene("parabola.toml"), tactel.read_scene("pad.toml"), tactel.Sweep("pad_sweep.toml")
NETWORK = tactel.Network.load("uskin-4x4")
SET = tactel.Set(np.random.default_rng(1).normal(size=(50, 42)), np.linspace(0, 1, 50))

def stepped():
    steps = tactel.PadStepper(PAD.sensor, 4, 0.5, cells=12)
    steps.shapes(tactel.Sphere(8))
    return steps.press([0.5, 0.1, 0, 0]).slip_index

def call():
    return np.asarray(CALL)

together, answers = threading.Barrier(8), []

def in_a_thread():
    together.wait()
    answers.append(call())

threads = [threading.Thread(target=in_a_thread) for _ in range(8)]
for thread in threads: thread.start()
for thread in threads: thread.join()
later = call()
assert later.size > 0
print(sum(answer.tobytes() == later.tobytes() for answer in answers), "of 8 have the answer of a later call")
"""


def python(code, **options):
    return subprocess.run([sys.executable, "-c", code], cwd=EXAMPLES, capture_output=True, text=True, timeout=300, **options)


class FirstUse(unittest.TestCase):
    def test_by_eight_threads(self):
        starts = int(os.environ.get("TACTEL_COLD_STARTS", 1))  # processes for each call
        for name, call in starts * list(CALLS.items()):
            with self.subTest(name):
                done = python(COLD.replace("CALL", call))
                self.assertEqual((done.returncode, done.stdout), (0, "8 of 8 have the answer of a later call\n"), done.stderr)

    def test_in_a_subinterpreter_is_refused(self):
        done = python("""if True:
            import _xxsubinterpreters as interpreters
            one = interpreters.create()
            try:
                interpreters.run_string(one, "import tactel")
            except interpreters.RunFailedError as error:
                print(error)
            import tactel
            print(tactel.solve(tactel.read_scene("parabola.toml")).slip_index.size > 0)
        """)
        self.assertRegex(done.stdout, "ImportError.*tactel: works in the main interpreter of a process alone.*\nTrue\n")
        self.assertEqual(done.returncode, 0, done.stderr)


class Interrupt(unittest.TestCase):
    """Ctrl-C while a call computes for long. A call is heard within a second; a busy machine gets three. A fast machine calls again."""

    def seconds_until_heard(self, setup, call, then="True"):
        code = "import numpy as np, sys, tactel, time\n" + textwrap.dedent(setup) + textwrap.dedent(f"""
            print("begins", flush=True)
            try:
                while True:
                    {call}
            except KeyboardInterrupt:
                print("heard", flush=True)
            assert {then}
        """)
        # A shell's background job, as a night's run may be, leaves SIGINT ignored to its children.
        child = subprocess.Popen([sys.executable, "-c", code], cwd=EXAMPLES, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                 preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        self.assertEqual(child.stdout.readline(), "begins\n", child.stderr.read() if child.poll() is not None else "")
        time.sleep(0.7)
        asked = time.monotonic()
        child.send_signal(signal.SIGINT)
        said = child.stdout.readline()
        seconds = time.monotonic() - asked
        _, error = child.communicate(timeout=60)
        self.assertEqual((said, child.returncode), ("heard\n", 0), error)
        return seconds

    def heard(self, *words):
        self.assertLess(self.seconds_until_heard(*words), 3)

    def test_generate(self):
        self.heard("sweep = tactel.Sweep('pad_sweep.toml')", "sweep.generate(200000)")

    def test_generate_grips(self):
        self.heard("sweep = tactel.Sweep('uskin_grips.toml')", "sweep.generate(8000)")

    def test_batches(self):
        self.heard("sweep = tactel.Sweep('pad_sweep.toml')", "next(iter(sweep.batches(100000)))")

    def test_solve_many(self):
        self.heard("scenes = [tactel.read_scene('pad.toml')] * 20000", "tactel.solve_many(scenes)")

    def test_solve(self):
        for words in "solver='twin', rung='pad-24'", "rung='reference'":
            with self.subTest(words):
                self.heard("scene = tactel.read_scene('pad.toml')\nscene = scene.with_(load=tactel.Press(0.4).drag((0.002, 0), steps=1000))",
                           f"tactel.solve(scene, {words})")

    def test_tables_of_free_sides(self):
        with tempfile.TemporaryDirectory() as empty:
            self.heard(f"""
                import os
                os.environ["TACTEL_CACHE_DIR"] = {empty!r}
                pad = tactel.Pad(tactels=(4, 4), pitch=2, thickness=4, young=0.5, poisson=0.48, length=46, width=46)
                scene = tactel.read_scene("pad.toml").with_(sensor=pad)
            """, "tactel.solve(scene)")

    def test_a_step_leaves_the_contacts_as_they_were(self):
        self.heard("""
            pad = tactel.Pad(tactels=(4, 4), pitch=2, thickness=4, young=0.5, poisson=0.48)
            steps = tactel.PadStepper(pad, 40000, 0.6, cells=16, cell=0.5)
            steps.shapes(tactel.Sphere(8))
        """, "before = steps.state([0, 1, 39999]); steps.press([1, 0.3, 0.1, 0])", "(steps.state([0, 1, 39999]) == before).all()")

    def test_train(self):
        self.heard("rows = tactel.Set(np.random.default_rng(1).normal(size=(100000, 42)), np.linspace(0, 1, 100000))",
                   "tactel.train(rows, layers=(42, 96, 96, 1), seeds=4, cycles=1000)")

    def test_a_progress_function_that_fails_at_the_end(self):
        done = python("""if True:
            import tactel
            def fails(done, all):
                if done == all: raise KeyError("mine")
            try:
                tactel.solve_many([tactel.read_scene("parabola.toml")], progress=fails)
            except KeyError as error:
                print(error)
        """)
        self.assertEqual((done.returncode, done.stdout), (0, "'mine'\n"), done.stderr)


if __name__ == "__main__":
    unittest.main()
