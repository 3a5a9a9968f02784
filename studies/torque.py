#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What |Q| / (mu P) misses under torque: alarms of networks taught S against those of networks taught |Q| / (mu P).

Simulates drags with twist until sliding on a pad of 4 x 4 tactels, from pure drags to pure twists. Prints the tables of
docs/notebook/2026-11-23-torque.md; --figure draws its figure. Some minutes on two cores.

Usage: studies/torque.py [--build build] [--contacts 20000] [--seeds 2] [--history 4] [--figure FILE.svg] [--check]
--contacts: of the learning set; a fifth as many judge. --check: simulates a few drags, and checks the exact numbers.

An alarm begins at the first step at which the estimate reaches a threshold U; a drag is detected where that is before
sliding, the first step without a sticking cell (host/training/decision.h). A step is false where S is below 0.7 and the
estimate is not below U. U is chosen on the judged set, so that a share of the steps with S below 0.7 is false. "Of them
false": of the detected drags, those whose first alarm is at such a step; they have no lead, which is a median.
The share of torque of a drag is 0 for a pure drag, 1 for a pure twist: arccos(|Q| / (mu P)) over 90 degrees where
sliding begins. Debian: python3-h5py, python3-numpy, python3-matplotlib."""
import pathlib
import tempfile

import h5py
import numpy as np

import study

PAD = """
[sweep]
contacts = {contacts}
seed = {seed}
press_rows = true

[sensor]                        # the layout of uSkin; the rubber is assumed
kind = "pad"
tactels = [4, 4]
pitch = 4.7
thickness = 4.0
young = 0.5
poisson = 0.48

[contact]
friction = {{ uniform = [0.2, 1.0] }}

[[indenter]]
shape = "sphere"
radius = {{ log_uniform = [8, 40] }}
position = [{{ uniform = [-5, 5] }}, {{ uniform = [-5, 5] }}]

[[indenter]]
shape = "paraboloid"
radii = [{{ log_uniform = [8, 40] }}, {{ log_uniform = [8, 40] }}]
position = [{{ uniform = [-5, 5] }}, {{ uniform = [-5, 5] }}]
yaw = {{ uniform = [0, 180] }}

[[indenter]]
shape = "box"
half_widths = [{{ uniform = [2, 5] }}, {{ uniform = [2, 5] }}]
edge = {{ uniform = [0.2, 1.0] }}
position = [{{ uniform = [-4, 4] }}, {{ uniform = [-4, 4] }}]
yaw = {{ uniform = [0, 90] }}
"""
LOAD = """
[[load]]
weight = {weight}
indentation = {{ uniform = [0.1, 0.6] }}
[load.irregular]
press_steps = 4
stroke = {stroke}
stroke_steps = 30
direction = {{ uniform = [0, 360] }}
twist = {twist}
"""
TWIST = "{ normal = [0, 25] }"
LOADS = (LOAD.format(weight=1, stroke="{ log_uniform = [0.3, 2] }", twist=0)
         + LOAD.format(weight=4, stroke="{ log_uniform = [0.1, 2] }", twist=TWIST)
         + LOAD.format(weight=1, stroke=1e-6, twist=TWIST))
SKIN = """
[transducer]                    # of a real skin
step_time = 0.02
memory = { uniform = [0.02, 0.04] }
memory_time = { uniform = [0.3, 0.6] }
drift = { uniform = [0, 0.1] }
repeats = { uniform = [0, 0.1] }
mixing = { uniform = [0, 0.05] }
noise_of_largest = 0.005
"""
INPUTS, HIDDEN = 48, "96-48-1"
TRAINING = ("--block", 100_000, "--rows", 8_000_000, "--activation", "leaky-relu")
FULL = 3  # the step at full indentation
SLIDING = 1  # /status
FALSE_BELOW = 0.7
SHARES = (0.01, 0.05)  # of the steps with S < 0.7
RATIO = r"\|Q\| / (mu P)"
QUARTERS = ("pure drag", "0 to 1/4", "1/4 to 1/2", "1/2 to 3/4", "3/4 to 1", "pure twist")


class Drags:
    """The drags of a set, row by row from full indentation on, and where each of them begins to slide."""

    def __init__(self, path):
        with h5py.File(path) as file:
            step = file["step"][:].astype(int)
            self.of_set = np.flatnonzero(step >= FULL)
            step = step[self.of_set]
            self.s, self.ratio, self.twist, drag, contact, status = (
                file[name][:][self.of_set] for name in ("slip_index", "force_ratio", "twist", "tangential", "contact", "status"))
        drag, sliding = np.hypot(*drag.T), status == SLIDING
        self.drag = np.unique(contact, return_inverse=True)[1]
        self.count = self.drag.max() + 1
        self.rows = np.arange(len(self.s))
        first = self.first(sliding)
        self.slides = first < len(self.s)
        self.before = self.rows < first[self.drag]
        at = np.where(self.slides, first, len(self.s) - 1)
        self.step, self.way = step, drag + np.abs(self.twist)  # along a ray: proportional to the way
        self.slide_step, self.slide_way = step[at], self.way[at]
        twists, drags = np.zeros(self.count, bool), np.zeros(self.count, bool)
        np.logical_or.at(twists, self.drag, np.abs(self.twist) > 1e-3)
        np.logical_or.at(drags, self.drag, drag > 1e-3)
        torque = np.arccos(np.clip(self.ratio[at], 0, 1)) * 2 / np.pi
        self.kind = np.where(~twists, 0, np.where(~drags, 5, 1 + np.minimum(4 * torque, 3).astype(int)))

    def first(self, rows):
        """[drags] the first of these rows in each drag; the number of all rows where there is none."""
        first = np.full(self.count, len(self.rows))
        np.minimum.at(first, self.drag[rows], self.rows[rows])
        return first

    def calm(self):
        return self.before & (self.s < FALSE_BELOW)

    def detected(self, value, threshold):
        """[drags] whether an alarm precedes sliding, whether its first one is false, and the lead in steps and share of the way."""
        alarm = self.first(self.before & (value >= threshold))
        on = (alarm < len(self.rows)) & self.slides
        alarm = np.where(on, alarm, 0)
        return on, on & (self.s[alarm] < FALSE_BELOW), self.slide_step - self.step[alarm], 1 - self.way[alarm] / self.slide_way

    def threshold(self, value, share):
        """The least U at which at most this share of the calm steps is false."""
        calm = np.sort(value[self.calm()])
        return np.nextafter(calm[len(calm) - 1 - int(share * len(calm))], np.inf)


def exact_table(drags):
    """What a perfect reader of |Q| / (mu P) misses, without any network."""
    lines = [study.head("share of torque", "drags that slide", "steps with S > 0.9", f"of them {RATIO} < 0.5")]
    late = drags.before & (drags.s > 0.9)
    for kind, name in [*enumerate(QUARTERS), (None, "all")]:
        ours = late & ((drags.kind == kind)[drags.drag] if kind is not None else True) & drags.slides[drags.drag]
        count = np.sum(drags.slides & (drags.kind == kind)) if kind is not None else np.sum(drags.slides)
        lines.append(study.row(name, count, np.sum(ours), f"{np.mean(drags.ratio[ours] < 0.5):.3f}"))
    return lines


def detection_table(drags, share, readers):
    """A line a reader, where so many of the calm steps are false; means over seeds. readers: {name: [[rows], of each seed]}."""
    lines = [study.head("reader", "U", *QUARTERS, "all", "of them false", "lead, steps; share")]
    spread = 0
    for name, seeds in readers.items():
        cells = []
        for value in seeds:
            limit = drags.threshold(value, share)
            on, false, steps, way = drags.detected(value, limit)
            kinds = [np.mean(on[drags.slides & (drags.kind == kind)]) for kind in range(len(QUARTERS))]
            led = on & ~false
            cells.append([limit, *kinds, np.mean(on[drags.slides]), np.mean(false[on]), np.median(steps[led]), np.median(way[led])])
        *numbers, steps, way = np.mean(cells, axis=0)
        spread = max(spread, np.ptp(np.array(cells)[:, -4]))
        lines.append(study.row(name, *(f"{x:.3f}" for x in numbers), f"{steps:.1f}; {way:.2f}"))
    return [*lines, "", f"Seeds differ by {spread:.3f} in all drags at most."]


def check(drags):
    """Laws that the network study rests on: torque only adds to S; a pure twist has no Q, and S of it reaches 1."""
    assert np.all(drags.ratio <= drags.s + 2e-3), np.max(drags.ratio - drags.s)  # S: four rounds of reweighting, 7.5e-4
    twist = (drags.kind == 5)[drags.drag]
    assert np.sum(drags.kind == 5) > 20 and np.max(drags.ratio[twist]) < 2e-3, np.max(drags.ratio[twist])  # sweeps: 1e-3
    slides = twist & drags.slides[drags.drag]
    sliding = drags.s[slides & ~drags.before]  # a little below 1 until all cells slide as one
    assert np.min(sliding) > 0.9 and np.median(sliding) > 0.999, (np.min(sliding), np.median(sliding))
    late = twist & drags.before & (drags.s > 0.9)
    assert np.any(late) and np.mean(drags.ratio[late] < 0.5) == 1


def draw(path, title, curves):
    """ROC curves: {title of a panel: {reader: ([false steps], [detected])}}."""
    figure, panels = study.panels(1, len(curves), figsize=(9, 3.8), squeeze=False)
    figure.suptitle(title)
    for axes, (panel, readers) in zip(panels[0], curves.items()):
        for k, (reader, points) in enumerate(readers.items()):
            axes.plot(*points, ("C0", "C1")[k % 2] + ("-", "--")[k // 2 % 2], label=reader.replace("\\", ""))
        axes.set(title=panel, xlim=(0, 0.3), ylim=(0, 1), xlabel="steps with S < 0.7 that are false",
                 ylabel="drags detected before sliding")
        axes.legend(loc="lower right")
    study.save(figure, path)


def main():
    parser = study.options(__doc__)
    parser.add_argument("--contacts", type=int, default=20000)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--history", type=int, default=4)
    parser.add_argument("--figure", type=pathlib.Path)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()

    tactel = study.Program(options.build)

    def made(folder, name, contacts, seed, chain):
        sweep = folder / f"{name}.toml"
        sweep.write_text(PAD.format(contacts=contacts, seed=seed) + LOADS + chain)
        tactel("generate", sweep, "--rung", "pad-8", "--output", folder / f"{name}.h5", "--quiet")
        return folder / f"{name}.h5"

    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        if options.check:
            return check(Drags(made(folder, "few", 300, 3, "")))
        curves = {}
        for chain, text in (("ideal", ""), ("skin", SKIN)):
            learning = made(folder, f"{chain}_learning", options.contacts, 1, text)
            judged = made(folder, f"{chain}_judged", options.contacts // 5, 2, text)
            drags = Drags(judged)
            if chain == "ideal":
                print("Exact, without a network:\n", *exact_table(drags), sep="\n", flush=True)
            readers = {"S itself": [drags.s], f"{RATIO} itself": [drags.ratio]}
            for target, name in (("slip_index", "network of S"), ("force_ratio", f"network of {RATIO}")):
                networks = folder / f"{chain}_{target}"
                tactel("train", learning, "--target", target, "--seeds", options.seeds, *TRAINING, "--history", options.history,
                       "--network", f"{INPUTS * options.history}-{HIDDEN}", "--output", networks, "--quiet")
                tactel("recall", networks, judged, "--rows", folder / "rows.csv", "--quiet")
                rows = np.genfromtxt(folder / "rows.csv", delimiter=",", skip_header=1)
                rows = rows[np.isin(rows[:, 0], drags.of_set)]
                assert np.array_equal(rows[:, 0], drags.of_set) and np.all(np.isfinite(rows)), "a row without an answer"
                readers[name] = list(rows[:, 2:].T)
                print(f"\n{name}, {chain}: mean error {np.mean(np.abs(rows[:, 2:] - rows[:, 1:2])):.4f} of its own target")
            for share in SHARES:
                print(f"\nDetected before sliding, {chain}, {share:.0%} of the steps with S below {FALSE_BELOW} false:\n",
                      *detection_table(drags, share, readers), sep="\n", flush=True)
            learning.unlink()
            for kinds, panel in (((0, 1), "share of torque below 1/4"), ((4, 5), "share of torque above 3/4")):
                ours = drags.slides & np.isin(drags.kind, kinds)
                for name, seeds in list(readers.items())[2:]:
                    points = [(np.mean(seeds[0][drags.calm()] >= u), np.mean(drags.detected(seeds[0], u)[0][ours]))
                              for u in np.linspace(0.02, 1, 99)]
                    label = name.removeprefix("network of ").replace("\\", "") + (", skin" if text else "")
                    curves.setdefault(panel, {})[label] = tuple(zip(*points))
        if options.figure:
            draw(options.figure, "Alarms on drags with twist, networks taught S and |Q| / (mu P)", curves)


if __name__ == "__main__":
    main()
