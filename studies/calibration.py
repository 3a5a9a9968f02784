#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A calibration from end to end without hardware: prints tables such as those of docs/notebook/2026-11-23-calibration.md.

Simulated sensors with gains, offsets, noise and a rubber of their own send frames through an emulated USB device.
tactel records them, tares, tactel.calibrate calibrates, and tactel reads S of other drags with a network. The frames come from full-mesh finite
elements in finer load steps (`solve --solver full-mesh`), and from the measuring chain and the wire format below; the
calibration fits contacts on patches. Both share the scene file and nothing else.

Usage: studies/calibration.py [--build build] [--sensors 12] [--together 6] [--work DIR] [--check]
--check: one sensor, a small network, and bounds on the errors; a test. The work directory keeps answers of the finite
elements and the network. Lengths are in mm, stresses in MPa, forces in N/mm, times in s. Debian: python3-numpy,
python3-scipy, libumockdev-preload0."""
import concurrent.futures
import dataclasses
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import study

TACTELS, SPAN = 8, 17.0
MU = 0.5
NOMINAL = {"young": 2.0, "poisson": 0.45, "thickness": 1.5}
GAIN, OFFSET = 0.0015, 2048  # of the data sheet: MPa by a count, counts of a converter of 12 bits
GAIN_SPREAD, OFFSET_SPREAD, NOISE = 0.2, 50, 0.01  # standard deviations: relative, counts, of the largest stress
RATE = 100  # frames a second
RAMP, HOLD, REST = 0.15, 0.3, 0.8  # s to a load step, at it, and between presses
WINDOW = 0.2  # s in the middle of a hold, of which frames are taken
FIRST_REST = 3.0  # s at rest before the first press, of which tare takes two
FINER = 3  # load steps of the finite elements for each of the scene
MESH = (161, 33)  # columns and rows of nodes; 241 x 49 changes stresses by 0.1 % of the largest


@dataclasses.dataclass(frozen=True)
class Press:
    radius: float
    position: float
    depth: float
    drags: tuple

    def scene(self, sensor, mesh):
        """A scene file: on a mesh in finer load steps, or on a patch in those of the press."""
        drags, last = [], 0.0
        for drag in self.drags:
            steps = FINER if mesh else 1
            drags += [round(last + (drag - last) * (i + 1) / steps, 9) for i in range(steps)]
            last = drag
        model = f"columns = {MESH[0]}\nrows = {MESH[1]}\ngrading = 2.0" if mesh else 'model = "patch"'
        return (f"[sensor]\ntactels = {TACTELS}\ntactel_span = {SPAN}\n{model}\n"
                + "".join(f"{key} = {value}\n" for key, value in sensor.items())
                + f'[indenter]\nshape = "cylinder"\nradius = {self.radius}\nposition = {self.position}\n'
                + f"[contact]\nfriction = {MU}\n[load]\nindentation = {self.depth}\n"
                + f"indentation_steps = {FINER if mesh else 1}\ntangential = {drags}\n")


def known_presses(count):
    return [Press(6.0 if k % 2 else 15.0, round(-7.5 + 15 * k / (count - 1), 3), round(0.1 + 0.02 * (k % 4), 3),
                  (0.04, 0.10, 0.16)) for k in range(count)]


def drags(count):
    """Drags to judge S by, of other cylinders at other places than those of the calibration."""
    return [Press(9.0 + 2 * k, round(-5.2 + 10.4 * k / max(count - 1, 1), 3), round(0.11 + 0.015 * (k % 3), 3),
                  (0.04, 0.08, 0.12, 0.18, 0.26)) for k in range(count)]


@dataclasses.dataclass
class Case:
    """What of a sensor the data sheet does not say."""
    name: str
    rubber: bool = False  # E and nu
    thickness: bool = False
    time_constant: float = 0  # s; 0: stresses stay
    waits: bool = False  # presses begin with amplifiers at rest; times of motion are known, and RC is fitted

    def rubber_of(self, seed):
        """E is drawn for every sensor; there are four pairs of nu and thickness, as each takes minutes to solve."""
        rubber = dict(NOMINAL)
        if self.rubber:
            rubber["young"] *= float(np.exp(0.3 * np.random.default_rng([seed, 1]).standard_normal()))
            rubber["poisson"] = (0.43, 0.44, 0.46, 0.47)[seed % 4]
        if self.thickness:
            rubber["thickness"] = (1.53, 1.44, 1.56, 1.47)[seed % 4]
        return rubber


@dataclasses.dataclass
class Truth:
    """A sensor: rubber, transducers, and the answers of the finite elements to its presses."""
    rubber: dict
    gain: np.ndarray  # [channels]
    offset: np.ndarray
    noise: float  # MPa
    answers: list  # of each press: stress [knots, channels], S and P [knots] at load steps of the finite elements


class Chain:
    def __init__(self, options, work):
        self.work, self.run, self.package = work, study.Program(options.build), options.build.resolve() / "python"

    def calibrate(self, *words):
        """python -m tactel.calibrate of the build."""
        done = subprocess.run([sys.executable, "-m", "tactel.calibrate", *map(str, words)], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(self.package)})
        if done.returncode:
            raise SystemExit(f"tactel.calibrate {' '.join(map(str, words))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")

    def answer(self, press, rubber):
        """Stress [knots, channels], S and P [knots] of a press by the full mesh at E = 1; kept in a file."""
        sensor = {**rubber, "young": 1.0}
        text = press.scene(sensor, mesh=True)
        name = f"fem_{press.radius}_{press.position}_{press.depth}_{len(press.drags)}_{rubber['poisson']}_{rubber['thickness']}"
        path = self.work / f"{name}.json"
        if not path.exists():
            (self.work / f"{name}.toml").write_text(text)
            self.run("solve", self.work / f"{name}.toml", "--solver", "full-mesh", "--json", path, "--quiet")
        steps = json.loads(path.read_text())["steps"]
        assert all(step["converged"] for step in steps)
        stresses = [step["sigma_y"] + step["tau_xy"] for step in steps]
        return (np.array(stresses), np.array([step["slip_index"] for step in steps]),
                np.array([step["P"] for step in steps]))

    def network(self, contacts, cycles):
        """A network that learnt rubbers of many kinds with noise, in nominal units."""
        path = self.work / f"network_{contacts}_{cycles}"
        sweep = (f"[sweep]\ncontacts = {contacts}\nseed = 5\n[sensor]\ntactels = {TACTELS}\ntactel_span = {SPAN}\n"
                 "poisson = { uniform = [0.42, 0.48] }\nthickness = { uniform = [1.4, 1.6] }\n"
                 '[[indenter]]\nshape = "cylinder"\nradius = { log_uniform = [5, 25] }\nposition = { uniform = [-6.5, 6.5] }\n'
                 f"[contact]\nfriction = {MU}\n[load]\nindentation = {{ uniform = [0.08, 0.18] }}\n"
                 "tangential_step = { uniform = [0.02, 0.04] }\ntangential_steps = 9\n")
        found = list(path.glob("*.onnx"))
        if not found:
            (self.work / "sweep.toml").write_text(sweep)
            self.run("generate", self.work / "sweep.toml", "--output", self.work / "set.h5", "--quiet", "--force")
            self.run("train", self.work / "set.h5", "--output", path, "--network", "16-32-16-1", "--schedule", "batch",
                     "--cycles", cycles, "--scaling", "frame", "--noise", "0.01", "--activation", "leaky-relu",
                     "--quiet", "--force")
            found = list(path.glob("*.onnx"))
        return found[0]


def timeline(truth):
    """Knots of all presses: times [knots] s and stresses [knots, channels] MPa; for each press and load step the middle
    of its hold, s, and its answer."""
    time, stress, holds = [0.0, FIRST_REST], [np.zeros(2 * TACTELS)] * 2, []
    for stresses, slip, force in truth.answers:
        middles = []
        for k in range(0, len(stresses), FINER):
            for i in range(FINER):
                time.append(time[-1] + RAMP / FINER)
                stress.append(truth.rubber["young"] * stresses[k + i])
            time.append(time[-1] + HOLD)
            stress.append(stress[-1])
            middles.append((time[-1] - HOLD / 2, slip[k + FINER - 1], truth.rubber["young"] * force[k + FINER - 1]))
        holds.append(middles)
        for wait in (RAMP, REST):
            time.append(time[-1] + wait)
            stress.append(np.zeros(2 * TACTELS))
    return np.array(time), np.array(stress), holds


def amplified(stress, time_constant, at_rest, steps=20):
    """A high-pass v' = x' - v / RC in steps of the midpoint rule, much smaller than RC. stress: [frames, channels];
    at_rest: frames before which a wait of many RC was cut out."""
    if time_constant == 0:
        return stress
    v, out = np.zeros(stress.shape[1]), [np.zeros(stress.shape[1])]
    step = 1 / RATE / steps / time_constant
    for k, change in enumerate(np.diff(stress, axis=0) / steps):
        v = v * (k not in at_rest)
        for _ in range(steps):
            half = v + (change - v * step) / 2
            v = v + change - half * step
        out.append(v)
    return np.array(out)


def crc(data):
    """CRC-16 of CCITT by its definition: the remainder of data x^16, with the first 16 bits inverted."""
    bits = int.from_bytes(data, "big") << 16
    bits ^= 0xFFFF << 8 * len(data)
    for i in range(8 * len(data) + 15, 15, -1):
        if bits >> i & 1:
            bits ^= 0x11021 << i - 16
    return bits


def frames_of(codes):
    """Frames: two bytes of sync, a counter of four, 16 bits a channel, CRC. codes: [frames, channels]."""
    stream = bytearray()
    for i, row in enumerate(codes):
        frame = b"\xa5\x5a" + i.to_bytes(4, "little") + row.astype("<u2").tobytes()
        stream += frame + crc(frame).to_bytes(2, "little")
    return bytes(stream), 2 + 4 + 4 * TACTELS + 2


def profile_text(gain, offset):
    channels = list(range(2 * TACTELS))
    return ('[device]\nname = "simulated"\nvendor = 0x1209\nproduct = 0x0002\ntransport = "bulk"\nstart = [0x01]\n'
            '[format]\nkind = "generic"\nsync = [0xA5, 0x5A]\nheader = 6\ncounter_offset = 2\ncounter_width = 4\n'
            f'channels = {2 * TACTELS}\nsample = "u16"\nchecksum = "crc16"\nconfirmations = 1\n'
            f"[channels]\nnormal = {channels[:TACTELS]}\nshear = {channels[TACTELS:]}\n"
            f"[calibration]\ngain = {gain}\noffset = {offset}\n")


def calibration_text(gain, offset):
    return f"[calibration]\ngain = {gain.tolist()}\noffset = {offset.tolist()}\n"


class Sensor:
    """One simulated sensor on its way through the programs, in a folder of its own."""

    def __init__(self, chain, case, seed, presses, test_drags):
        self.chain, self.case, self.presses, self.drags = chain, case, presses, test_drags
        self.random = np.random.default_rng(seed)
        rubber = case.rubber_of(seed)
        gain = GAIN * (1 + GAIN_SPREAD * self.random.standard_normal(2 * TACTELS))
        offset = OFFSET + OFFSET_SPREAD * self.random.standard_normal(2 * TACTELS)
        answers = [chain.answer(press, rubber) for press in presses + test_drags]
        largest = rubber["young"] * max(np.abs(stress).max() for stress, _, _ in answers[:len(presses)])
        self.truth = Truth(rubber, gain, offset, NOISE * largest, answers)
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=chain.work))
        self.record()

    def path(self, name):
        return self.folder / name

    def record(self):
        """Sends all presses through the emulated device into tactel record."""
        time, stress, self.holds = timeline(self.truth)
        at = np.arange(int(time[-1] * RATE)) / RATE
        played = np.column_stack([np.interp(at, time, column) for column in stress.T])
        at_rest = [int((hold[0][0] - HOLD / 2 - RAMP) * RATE) for hold in self.holds] if self.case.waits else []
        measured = amplified(played, self.case.time_constant, at_rest)
        measured = measured + self.truth.noise * self.random.standard_normal(measured.shape)
        codes = np.clip(np.rint(measured / self.truth.gain + self.truth.offset), 0, 4095)
        stream, length = frames_of(codes)
        self.path("frames").write_bytes(stream)
        self.path("factory.toml").write_text(profile_text(GAIN, OFFSET))
        player = [self.chain.run.path.with_name("tactel_play_frames"), str(self.path("frames")), str(length), str(RATE)]
        command = [self.chain.run.path, "record", "--source", "usb:1209:0002", "--profile", str(self.path("factory.toml")),
                   "--output", str(self.path("all.tactel")), "--frames", str(self.path("all.csv")), "--force",
                   "--seconds", str(at[-1] + 1.0)]
        for _ in range(10):
            done = subprocess.run(player + command, capture_output=True, text=True,
                                  env={**os.environ, "LD_PRELOAD": "libumockdev-preload.so.0"})
            if done.returncode not in (0, 1) or "lost 0, bad 0" not in done.stderr:  # 1: the device's memory was full
                raise SystemExit(f"record: exit code {done.returncode}\n{done.stderr}")
            self.arrival = np.loadtxt(self.path("all.csv"), delimiter=",", skiprows=1, usecols=2)
            if done.returncode == 0 and len(self.arrival) == len(at) and self.holds_are_seen():
                return
        raise SystemExit("record: frames came late ten times; is the machine busy?")

    def arrived(self, middle):
        """Arrival of the frame in the middle of a hold, as a user reads it in the recorded frames."""
        return self.arrival[round(middle * RATE)]

    def holds_are_seen(self):
        """Whether all frames that arrived around the middle of a hold were sent during it."""
        middles = [middle for hold in self.holds for middle, _, _ in hold]
        sent = [np.flatnonzero(np.abs(self.arrival - self.arrived(m)) <= WINDOW / 2) / RATE - m for m in middles]
        return all(np.abs(of_hold).max() <= HOLD / 2 for of_hold in sent)

    def tare(self):
        self.chain.run("tare", "--source", f"replay:{self.path('all.tactel')}", "--output", self.path("tare.toml"))
        return ["--calibration", self.path("tare.toml")]

    def true_values(self):
        self.path("true.toml").write_text(calibration_text(self.truth.gain, self.truth.offset))
        return ["--calibration", self.path("true.toml")]

    def calibrate(self, name="calibrated", fit="", forces=True, every=1, **sensor):
        """Options for a profile that was fitted to the known presses. fit: keys of [fit]; sensor: what was measured."""
        nominal = {**NOMINAL, **sensor}
        text = f"[fit]\n{fit}\n"
        if self.case.waits:  # the search starts from half the time constant
            text += f"time_constant = true\n[transducer]\ntime_constant = {self.case.time_constant / 2}\n"
        for i, press in list(enumerate(self.presses))[::every]:
            scene = f"{name}_{i}.toml"
            self.path(scene).write_text(press.scene(nominal, mesh=False))
            times = [round(float(self.arrived(middle) - self.arrival[0]), 4) for middle, _, _ in self.holds[i]]
            force = [P * (1 + 0.01 * self.random.standard_normal()) for _, _, P in self.holds[i]]
            text += f'[press{i}]\nscene = "{scene}"\nrecording = "all.tactel"\ntimes = {times}\nwindow = {WINDOW}\n'
            text += f"P = {force}\n" if forces else ""
            if self.case.waits:
                text += f"begin = {[round(t - HOLD / 2 - RAMP, 4) for t in times]}\n"
                text += f"end = {[round(t - HOLD / 2, 4) for t in times]}\n"
        self.path(f"{name}_presses.toml").write_text(text)
        self.chain.calibrate("sensor", self.path(f"{name}_presses.toml"), "--profile", self.path("factory.toml"),
                             "--output", self.path(f"{name}.toml"), "--json", self.path(f"{name}.json"))
        return ["--profile", self.path(f"{name}.toml")]

    def gain_error(self, name="calibrated"):
        """Root mean square of the relative error of the gains."""
        found = np.array([gain["value"] for gain in json.loads(self.path(f"{name}.json").read_text())["gain"]], float)
        return np.sqrt(np.mean((found / self.truth.gain - 1) ** 2))

    def noise_error(self, name="calibrated"):
        """Largest relative error of the noise at rest."""
        found = np.array(json.loads(self.path(f"{name}.json").read_text())["rest_noise"], float)
        return np.abs(found * self.truth.gain / self.truth.noise - 1).max()

    def found(self, key, name="calibrated"):
        return json.loads(self.path(f"{name}.json").read_text())[key]["value"]

    def error(self, network, values):
        """Root mean square of S of tactel monitor less that of the finite elements, over the frames in the holds of the
        drags. values: options for the calibration."""
        lines = self.chain.run("monitor", "--source", f"replay:{self.path('all.tactel')}", "--network", network, "--quiet",
                               *values).splitlines()
        lines = [json.loads(line) for line in lines]
        sent = np.array([line["frame"] for line in lines]) / RATE
        slip = np.array([line["slip_index"] or 0.0 for line in lines])  # null is acted on as 0
        errors = []
        for middles in self.holds[len(self.presses):]:
            for middle, true, _ in middles[1:]:  # of the drag
                near = np.abs(sent - middle) <= WINDOW / 2
                errors.append(slip[near] - true)
        errors = np.concatenate(errors)
        return np.sqrt(np.mean(errors**2))


CASES = (Case("gains, offsets, noise"), Case("and E, nu", True), Case("and thickness", True, True),
         Case("and RC = 20 s", True, True, 20), Case("and RC = 5 s", True, True, 5),
         Case("RC = 20 s, waits, RC fitted", True, True, 20, True), Case("RC = 5 s, waits, RC fitted", True, True, 5, True))


def rows_of(together, function, items):
    with concurrent.futures.ThreadPoolExecutor(together) as pool:
        return list(pool.map(function, items))


def row(name, values):
    """A line of a table: mean and worst of each column. values: [sensors, columns]."""
    cells = (f"{np.mean(column):.3f} ({np.max(column):.3f})" for column in np.transpose(values))
    print(study.row(name, *cells), flush=True)


def stages(sensor, network):
    """Errors of S by factory values, after tare, after calibrate and by true values; the error of the gains."""
    return [sensor.error(network, []), sensor.error(network, sensor.tare()), sensor.error(network, sensor.calibrate()),
            sensor.error(network, sensor.true_values()), sensor.gain_error()]


def table_of_cases(chain, network, sensors, together, cases=CASES):
    presses, test_drags = known_presses(10), drags(6)
    for case in cases:  # the finite elements first, one at a time
        for seed in range(min(sensors, 4)):
            for press in presses + test_drags:
                chain.answer(press, case.rubber_of(seed))
    print(study.head("unknown", "factory values", "after `tare`", "after `calibrate`", "true values", "gains off by"))
    for case in cases:
        made = rows_of(together, lambda seed: Sensor(chain, case, seed, presses, test_drags), range(sensors))
        row(case.name, rows_of(3, lambda sensor: stages(sensor, network), made))


def table_of_calibrations(chain, network, sensors, together):
    """Other ways to calibrate the sensors of the third case."""
    def again(sensor, how):
        options = dict(how)
        if options.pop("measured", False):
            options["thickness"] = sensor.truth.rubber["thickness"]
        values = sensor.calibrate("again", **options)
        return [sensor.error(network, values), sensor.gain_error("again"),
                abs(sensor.found("poisson", "again") - sensor.truth.rubber["poisson"])]

    made = rows_of(together, lambda seed: Sensor(chain, CASES[2], seed, known_presses(10), drags(6)), range(sensors))
    print(study.head("calibration of the third line", "error of S", "gains off by", "nu off by"))
    for name, how in {"thickness held at 1.5 mm": {}, "thickness measured": {"measured": True},
                      "thickness fitted": {"fit": "thickness = true"}, "nu held at 0.45": {"fit": "poisson = false"},
                      "without forces": {"forces": False}, "5 of the 10 presses": {"every": 2}}.items():
        row(name, rows_of(3, lambda sensor: again(sensor, how), made))


def check(chain):
    """One sensor of the third case, with quicker presses, a coarser mesh and a small network. Frames may be 0.1 s late."""
    global RATE, RAMP, HOLD, REST, WINDOW, FIRST_REST, MESH
    RATE, RAMP, HOLD, REST, WINDOW, FIRST_REST, MESH = 200, 0.05, 0.3, 0.4, 0.1, 2.5, (101, 21)
    sensor = Sensor(chain, CASES[2], 1, known_presses(7), drags(2))
    factory, tared, calibrated, true, gains = stages(sensor, chain.network(contacts=1500, cycles=15))
    print(f"S: factory {factory:.3f}, tare {tared:.3f}, calibrate {calibrated:.3f}, true {true:.3f}; gains {gains:.4f}, "
          f"noise {sensor.noise_error():.3f}")
    # Medians over 28 windows of 20 frames scatter by sqrt(0.83 pi / 2 / 560) = 5 %; four of these for 16 channels.
    assert sensor.noise_error() < 0.2, "the noise in the calibrated profile is another"
    # A mean of 20 frames has noise of 0.2 % of the largest stress. A gain follows from some three presses that load its
    # tactel with a third of that, so that it is off by 0.5 %. The mesh and the held thickness add 1 % together.
    assert gains < 0.02, "gains are further off than noise and thickness explain"
    # S follows from sums over some three tactels in shear and normal stress: gains that are off by 2 % move it by 0.015.
    assert calibrated < true + 0.015, "calibrated values are worse than true ones"
    # By the same sums gains that are off by 20 % move S by 0.15, beside the error of the network.
    assert tared > calibrated + 0.02, "gains do not matter: is the sensor ideal?"
    # Offsets of 50 counts are 0.075 MPa, a fifth of the largest stress: more than gains that are off by 20 %.
    assert factory > tared, "offsets do not matter: is the sensor ideal?"


def main():
    parser = study.options(__doc__)
    parser.add_argument("--sensors", type=int, default=12)
    parser.add_argument("--together", type=int, default=6, help="sensors that send at once")
    parser.add_argument("--check", action="store_true", help="one sensor, with bounds")
    parser.add_argument("--work", type=pathlib.Path, help="directory for files; default: one that is removed")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        work = options.work or pathlib.Path(folder)
        work.mkdir(parents=True, exist_ok=True)
        chain = Chain(options, work.resolve())
        if options.check:
            return check(chain)
        network = chain.network(contacts=20000, cycles=30)
        table_of_cases(chain, network, options.sensors, options.together)
        print()
        table_of_calibrations(chain, network, options.sensors, options.together)


if __name__ == "__main__":
    sys.exit(main())
