#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Slip index and `moved` of two real pads that hold a box, judged by the motion of a marker on the box: prints tables such as those
of docs/notebook/2026-11-26-real-pads.md and draws a figure of each trial.

Usage: studies/real_pads.py FOLDER [--output DIR] [--build build] [--contacts N] [--shear-gain R]
FOLDER holds trials data_sample_*, such as the folder data_set of github.com/imanlab/proactive-slip-control (MIT): Nazari, Mandil
and Ghalamzan, "Proactive slip control by learned slip model and trajectory adaptation", CoRL 2022. A trial has counts of two uSkin
pads (xela_sensor1.csv, xela_sensor2.csv), times (robot_state.csv) and places of a marker (marker.csv).
First motion: the box has turned by 0.6 degrees or gone 0.5 mm from the mean of its first 20 frames, for 5 frames; moved: 2.5 degrees
or 2 mm. The marker judges and decides nothing: zero, gains, networks and scores are fixed without it. A threshold is 1.2 times the
largest score in the first trial that never moves, the recorded hold. Other sensors: studies/alarms.py --robots FOLDER --changed.
DIR gets network/, frames and a figure NAME.svg of each trial. Debian: python3-numpy, python3-matplotlib."""
import dataclasses
import json
import pathlib
import re
import tempfile
import tomllib

import numpy as np

import study

SIDE, PITCH = 4, 4.7  # tactels along x and y; mm between their middles
TACTELS = SIDE * SIDE
START = 30  # frames at the beginning, before the arm moves
SPAN = 5  # frames of a change
QUARTER = 15  # frames of 0.25 s
GONE = 0.005  # the object is gone where the mean reading of z falls by this share within 0.25 s; a held box: 0.001
END = 20  # frames at the end, without load where the object is gone
GAIN = 1e-5  # MPa a count of z, assumed: the network divides each frame by its largest normal stress, so that S has no part of it
RUBBER = {"thickness": 4.0, "young": 0.5, "poisson": 0.48}  # mm, MPa: assumed, as in examples/uskin_4x4.toml
ALARM = 0.8  # upper bound of S at which the alarm begins: the default of monitor --view
TOPOLOGY, EPOCHS, SEEDS = "48-96-48-1", 20, 4
SLID = ("--network", "48-96-48-1_leaky-relu", "--scaling", "rest", "--target", "slip_path", "--schedule", "cosine", "--epochs", 30, "--batch",
        512, "--noise", 0.006)  # as scripts/networks
PADS = ("--profile", "uskin-4x4") * 2
MARGIN = 1.2  # threshold over the largest score in the recorded hold
FIRST, MOVED, AT_REST, LASTS = (0.6, 0.5), (2.5, 2.0), 20, 5  # degrees and mm; frames

# A flat face wider than the tactels, pressed, dragged to all sides and twisted; what is unknown is drawn. The transducers have
# what was measured on such pads: 2 to 4 % of memory for 0.3 to 0.6 s, zeros that drift by 10 %, repeated rows.
SWEEP = f"""[sweep]
contacts = CONTACTS
seed = SEED
[sensor]
kind = "pad"
tactels = [{SIDE}, {SIDE}]
pitch = {PITCH}
thickness = {{ uniform = [3, 5] }}
young = {RUBBER["young"]}
poisson = {{ choice = [0.45, 0.48] }}
[indenter]
shape = "box"
half_widths = [{{ uniform = [8, 12] }}, {{ uniform = [8, 12] }}]
edge = {{ uniform = [0.2, 1] }}
position = [{{ uniform = [-1, 1] }}, {{ uniform = [-1, 1] }}]
yaw = {{ uniform = [-5, 5] }}
tilt = {{ uniform = [0, 0.1] }}
tilt_direction = {{ uniform = [0, 360] }}
[contact]
friction = {{ uniform = [0.3, 2] }}
[load]
normal_force = {{ log_uniform = [5, 20] }}
[load.irregular]
strokes = {{ choice = [1, 2, 3] }}
stroke = {{ uniform = [0, 0.3] }}
stroke_steps = {{ uniform = [3, 8] }}
direction = {{ uniform = [0, 360] }}
twist = {{ normal = [0, 2] }}
reversal = 0.3
[transducer]
step_time = 0.1
gain_spread = {{ uniform = [0, 0.2] }}
memory = {{ uniform = [0.02, 0.04] }}
memory_time = {{ uniform = [0.3, 0.6] }}
drift = {{ uniform = [0, 0.1] }}
repeats = {{ uniform = [0.06, 0.09] }}
mixing = {{ uniform = [0, 0.05] }}
noise_of_largest = 0.005
"""


def wrong(place, problem, fix):
    raise SystemExit(f"{place}: {problem}; {fix}")


def table(path, columns):
    """Numbers [frames, columns] of a CSV file below a line of names."""
    try:
        numbers = np.genfromtxt(path, delimiter=",", skip_header=1, ndmin=2)
    except OSError:
        wrong(path, "cannot be read", "a trial has xela_sensor1.csv, xela_sensor2.csv, robot_state.csv and marker.csv")
    except ValueError as error:
        wrong(path, "lines of different lengths: " + " ".join(str(error).split()), "copy the file again")
    if numbers.shape[1] < columns or not np.isfinite(numbers).all():
        wrong(path, f"no {columns} numbers in every line below the first", "copy the file again")
    return numbers


def onset(on, lasts=1):
    """The first of so many frames in a row; None where there are none."""
    rows = np.flatnonzero(np.convolve(on.astype(int), np.ones(lasts, int), "valid") == lasts)
    return int(rows[0]) if len(rows) else None


def motion(marker):
    """Turn (degrees) and way (mm) of poses [frames, x y z (m) and a quaternion] from their mean at the start."""
    turns = marker[:, 3:7] / np.linalg.norm(marker[:, 3:7], axis=1, keepdims=True)
    start = np.linalg.eigh(turns[:AT_REST].T @ turns[:AT_REST])[1][:, -1]  # the mean whatever the signs
    way = np.linalg.norm(marker[:, :3] - marker[:AT_REST, :3].mean(0), axis=1)
    return np.degrees(2 * np.arccos(np.minimum(np.abs(turns @ start), 1))), 1000 * way


@dataclasses.dataclass
class Trial:
    name: str
    counts: np.ndarray  # [pads, frames, tactels, 3], tactels row by row, axes x, y, z; z grows with pressure
    time: np.ndarray  # [frames], s
    turn: np.ndarray  # [frames], degrees from the marker's mean over the first 20 frames
    way: np.ndarray  # [frames], mm, the same
    load: np.ndarray = None  # [pads, frames, tactels, 3]: counts less those of the pads without load

    def beyond(self, limits):
        return (self.turn > limits[0]) | (self.way > limits[1])

    @property
    def first(self):
        """The frame of the first motion; None: it never moves."""
        return onset(self.beyond(FIRST), LASTS) if self.moves is not None else None

    @property
    def moves(self):
        """The frame from which on the box has moved; None: it holds."""
        return onset(self.beyond(MOVED), LASTS)

    def gone(self):
        """The first frame that the object leaves within 0.25 s, by z alone; None: it stays."""
        z = self.counts[..., 2].mean((0, 2))
        falls = np.flatnonzero(z[:-QUARTER] - z[QUARTER:] > GONE * z[:START].mean())
        return falls[0] if len(falls) else None


def read_trials(folder):
    paths = sorted(folder.glob("data_sample_*"))
    if not paths:
        wrong(folder, "no folders data_sample_*", "give the folder data_set of github.com/imanlab/proactive-slip-control")
    trials = []
    for path in paths:
        files = [table(path / f"xela_sensor{pad}.csv", 3 * TACTELS) for pad in (1, 2)]
        state, marker = table(path / "robot_state.csv", 1), table(path / "marker.csv", 7)
        lengths = {len(file) for file in (*files, state, marker)}
        if len(lengths) > 1 or min(lengths) < START + QUARTER + END:
            wrong(path, f"files of {', '.join(map(str, sorted(lengths)))} frames",
                  f"all files of a trial have one length, of {START + QUARTER + END} at least")
        counts = np.stack([file[:, :3 * TACTELS].reshape(-1, TACTELS, 3) for file in files])
        trials.append(Trial(path.name.removeprefix("data_sample_"), counts, state[:, -1], *motion(marker)))
    subtract_zero(folder, trials)
    return trials


def subtract_zero(folder, trials):
    """Zero of a trial: its end without the object, else the mean of those of the other trials. Frames end before the fall."""
    zero = {id(trial): trial.counts[:, -END:].mean(1) for trial in trials if trial.gone() is not None}
    if not zero:
        wrong(folder, "no trial ends without the object, so that the zero of the pads is unknown", "add one that does")
    mean = np.mean(list(zero.values()), axis=0)
    for trial in trials:
        end = trial.gone()
        trial.load = (trial.counts - zero.get(id(trial), mean)[:, None])[:, :end]
        trial.time, trial.turn, trial.way = trial.time[:end], trial.turn[:end], trial.way[:end]
        if len(trial.time) < START or (trial.load[:, :START, :, 2].mean((1, 2)) <= 0).any():
            wrong(folder / f"data_sample_{trial.name}", "nothing is held at the start", "leave this trial out")


def spread(load):
    """Shear at the outer tactels, outward, over the mean normal stress: [..., tactels, 3], z of pressure above 0."""
    grid = load.reshape(*load.shape[:-2], SIDE, SIDE, 3)
    outward_x = grid[..., :, -1, 0].mean(-1) - grid[..., :, 0, 0].mean(-1)
    outward_y = grid[..., -1, :, 1].mean(-1) - grid[..., 0, :, 1].mean(-1)
    return (outward_x + outward_y) / 4 / load[..., 2].mean(-1)


class Chain:
    def __init__(self, build, output):
        self.run, self.output = study.Program(build), output

    def simulated_spread(self):
        """Of the assumed rubber under a box as wide as the array, half a pitch outside of the outer tactels."""
        scene = self.output / "press.toml"
        scene.write_text("[sensor]\nkind = \"pad\"\n" + "".join(f"{key} = {value}\n" for key, value in RUBBER.items())
                         + f"tactels = [{SIDE}, {SIDE}]\npitch = {PITCH}\n[indenter]\nshape = \"box\"\n"
                         f"half_widths = [{SIDE * PITCH / 2}, {SIDE * PITCH / 2}]\nedge = 0.5\n[contact]\nfriction = 0.5\n"
                         "[load]\nindentation = 0.3\n")
        step = json.loads(self.run("solve", scene, "--json", "-"))["steps"][-1]
        return spread(np.stack([step["tau_x"], step["tau_y"], -np.array(step["sigma_z"])], axis=-1))

    def slid_networks(self, contacts):
        """Networks of `slid` of four seeds, taught by the grips of examples/uskin_holds.toml, or as many contacts as there are."""
        with tempfile.TemporaryDirectory(dir=self.output) as folder:
            grips, sweep = pathlib.Path(folder) / "grips.h5", pathlib.Path(folder) / "grips.toml"
            sweep.write_text(re.sub(r"contacts = (\d+)", lambda found: f"contacts = {min(int(found[1]), contacts)}",
                                    (study.ROOT / "examples/uskin_holds.toml").read_text()))
            self.run("generate", sweep, "--output", grips, "--rung", "pad-8")
            self.run("train", grips, "--output", self.output / "slid", *SLID, "--seeds", SEEDS, "--force")
        return sorted((self.output / "slid").glob("*.onnx"))

    def networks(self, contacts):
        """Networks of four seeds with a bound of 95 %, taught and calibrated by simulated contacts."""
        with tempfile.TemporaryDirectory(dir=self.output) as folder:
            sets = []
            for seed, count in ((1, contacts), (2, max(contacts // 4, 100))):
                sweep = pathlib.Path(folder) / f"sweep_{seed}.toml"
                sweep.write_text(SWEEP.replace("CONTACTS", str(count)).replace("SEED", str(seed)))
                sets.append(sweep.with_suffix(".h5"))
                self.run("generate", sweep, "--output", sets[-1], "--rung", "pad-8")
            self.run("train", sets[0], "--output", self.output / "network", "--network", TOPOLOGY, "--schedule", "batch", "--epochs",
                     EPOCHS, "--scaling", "frame", "--activation", "leaky-relu", "--bound", "--bound-set", sets[1], "--recall",
                     sets[1], "--seeds", SEEDS, "--force")
        report = json.loads((self.output / "network/training.json").read_text())["networks"]
        print("Mean error of S on simulated contacts, by seed: " + ", ".join(f"{one['recalling']['mean']:.3f}" for one in report) + ".\n")
        return sorted((self.output / "network").glob("*.onnx"))

    def write(self, name, load):
        """Lines of both pads' load [pads, frames, tactels, 3] in counts, at 60 Hz."""
        path = self.output / f"{name}.csv"
        frames = np.moveaxis(load, 1, 0).reshape(load.shape[1], -1)
        names = ["time", *(f"pad{pad}_{tactel}{axis}" for pad in (1, 2) for tactel in range(1, TACTELS + 1) for axis in "xyz")]
        np.savetxt(path, np.column_stack([np.arange(len(frames)) / 60, frames]), delimiter=",", fmt="%.6g", header=",".join(names), comments="")
        return f"csv:{path}"

    def monitor(self, source, calibration, *words):
        said = self.run("monitor", "--source", source, *PADS, "--calibration", calibration, "--drift", 0, *words, "--quiet")
        return [json.loads(line) for line in said.splitlines()]

    def answers(self, load, shear_gain, network):
        """What tactel monitor says of both pads: S, its upper bound and whether the frame is unlike those that the network learnt,
        [pads, frames], and whether the alarm is on, [frames]."""
        calibration = self.output / "counts.toml"
        calibration.write_text(f"[calibration]\noffset = 0\ngain = {[shear_gain * GAIN, shear_gain * GAIN, -GAIN] * (2 * TACTELS)}\n")
        said = self.monitor(self.write("frames", load), calibration, "--network", network, "--alarm", ALARM, "--touch", 0)
        of_pads = [[[float(line["pads"][pad][key]) for line in said] for pad in (0, 1)] for key in ("slip_index", "slip_upper", "unlike")]
        return *np.array(of_pads), np.array([line["alarm"] for line in said])

    def hold(self, rest, load, *network):
        """A calibration by readings without load and by a recorded hold, and its threshold of `moved`, or of a network's `slid`."""
        path = self.output / "hold.toml"
        self.run("tare", "--source", self.write("rest", rest), *PADS, "--output", path, "--hold", self.write("held", load), "--force",
                 *network)
        return path, tomllib.loads(path.read_text())["calibration"]["slid" if network else "moved"]

    def moved(self, load, calibration, *network):
        """`moved`, or `slid` of a network, [frames, pads], 0 where no rest is known, and whether the alarm is on, [frames]."""
        said = self.monitor(self.write("frames", load), calibration, *(network or ["--signal", "moved"]), "--alarm")
        return np.array([[pad["slid" if network else "moved"] or 0 for pad in line["pads"]] for line in said]), [line["alarm"] for line in said]


def hysteresis(score, threshold):
    """The alarm of a score."""
    on = False
    for value in score:
        on = value >= threshold or (on and value >= threshold / MARGIN)
        yield on


def change(values):
    """Size of the change within SPAN frames [pads, frames] of values [pads, frames, ...]; the first frames take the mean of the
    next ones."""
    moved = values[:, SPAN:] - values[:, :-SPAN]
    size = np.linalg.norm(moved.reshape(*moved.shape[:2], -1), axis=2)
    return np.hstack([np.repeat(size[:, :2 * SPAN].mean(1, keepdims=True), SPAN, axis=1), size])


def baselines(load):
    """Five scores [frames] of a trial that need no model, from counts [pads, frames, tactels, 3]; each the mean of both pads."""
    start = load[:, :START].mean(1, keepdims=True)
    moved = load - start
    ratio = np.linalg.norm(load[..., :2].sum(2), axis=-1) / load[..., 2].sum(2)
    place = np.arange(SIDE) - (SIDE - 1) / 2
    weight = place / (SIDE * (place**2).sum())  # of the slope of a plane that is fitted to a grid
    grid = moved.reshape(*moved.shape[:2], SIDE, SIDE, 3)
    curl = np.einsum("pfrc,c->pf", grid[..., 1], weight) - np.einsum("pfrc,r->pf", grid[..., 0], weight)
    scores = {"change within 5 frames": change(load),
              "Q / P over its start": ratio / ratio[:, :START].mean(1, keepdims=True),
              "change of net shear": np.linalg.norm(moved[..., :2].sum(2), axis=-1),
              "loss of P": -moved[..., 2].sum(2), "curl of the shear": np.abs(curl)}
    return {name: values.mean(0) for name, values in scores.items()}


def network_scores(S, upper):
    """Scores [frames] of a trial by answers [pads, frames]; each the larger of both pads."""
    scores = {"S": S, "S less its start": S - S[:, :START].mean(1, keepdims=True), "bound": upper}
    return {name: values.max(0) for name, values in scores.items()}


def null_scores(load):
    """What knows nothing of slip: 1/P at rest, the same in all frames of a trial, and the number of the frame."""
    frames = load.shape[1]
    return {"1 / P at rest": np.full(frames, 1 / load[:, :START, :, 2].sum(2).mean()), "frame number": np.arange(frames)}


def area(score, label):
    """Area under the ROC curve: how often a frame of slip has a higher score than one without, ties half. NaN: only one of both."""
    if label.all() or not label.any():
        return np.nan
    _, place, count = np.unique(score, return_inverse=True, return_counts=True)
    rank = (np.cumsum(count) - (count - 1) / 2)[place]
    slips = label.sum()
    return (rank[label].sum() - slips * (slips + 1) / 2) / (slips * (len(label) - slips))


def events(trial, on):
    """When the alarm on [frames] begins: frames after "moved", negative before it; or "none", or of a false one its frame."""
    begins = onset(on)
    quiet = len(on) if trial.moves is None else trial.first
    if begins is not None and begins < quiet:
        return f"false at {begins}"
    return ("" if trial.moves is None else "none") if begins is None else f"{begins - trial.moves:+d}"


def row(name, trials, scores, threshold, alarms=None):
    """A row of the table: area of "moved", in all trials and in each that moves, and events by trial; false alarms a minute. alarms:
    [trials][frames]; none: by the threshold."""
    moved = [trial.beyond(MOVED) for trial in trials]
    each = [area(score, label) for score, label in zip(scores, moved)]
    alarms = alarms or [list(hysteresis(score, threshold)) for score in scores]
    false = seconds = 0
    for trial, on in zip(trials, np.array(alarms, dtype=object)):
        quiet = np.array(on, bool)[:trial.first]
        false += np.count_nonzero(quiet & ~np.r_[False, quiet[:-1]])
        seconds += len(quiet) / 60
    cells = [area(np.concatenate(scores), np.concatenate(moved)), *(one for one in each if not np.isnan(one))]
    print(study.row(name, "" if threshold is None else f"{threshold:.3g}", " ".join(f"{cell:.3f}" for cell in cells),
                    *(events(trial, np.array(on, bool)) for trial, on in zip(trials, alarms)), f"{60 * false / seconds:.0f}"))


def head(trials):
    print(study.head("score", "threshold", "area of moved: all; each", *(trial.name for trial in trials), "false a minute"))


def figure(path, trial, S, upper, alarm):
    shown, (index, ratio, force) = study.panels(3, 1, sharex=True, figsize=(8.4, 7), height_ratios=(2, 1, 1))
    P = trial.load[..., 2].sum(2)
    Q = np.linalg.norm(trial.load[..., :2].sum(2), axis=-1)
    for pad, colour in enumerate((study.BLUE, study.ORANGE)):
        index.plot(trial.time, S[pad], color=colour, label=f"S, pad {pad + 1}")
        index.plot(trial.time, upper[pad], color=colour, lw=0.8, ls="--", label=f"upper bound, pad {pad + 1}")
        ratio.plot(trial.time, Q[pad] / P[pad], color=colour, label=f"pad {pad + 1}")
        force.plot(trial.time, P[pad] / 1000, color=colour, label=f"pad {pad + 1}")
    for axes in (index, ratio, force):
        axes.set_ylim(axes.get_ylim())
        if trial.moves is not None:
            axes.axvspan(trial.time[trial.moves], trial.time[-1], color="#e8d5a0", lw=0, zorder=0,
                         label="moved, by the marker" if axes is force else None)
    index.fill_between(trial.time, 1.02, 1.06, where=alarm, color="#b3261e", lw=0, label=f"alarm, bound above {ALARM}")
    index.set(ylim=(0, 1.08), ylabel="S", title=f"{trial.name}: S by a network taught by simulation alone")
    index.legend(ncols=3, fontsize=8, loc="lower right")
    ratio.set(ylabel="|Q| / P, counts")
    force.set(ylabel="P, 1000 counts", xlabel="s")
    force.legend(fontsize=8)
    study.save(shown, path)


def main():
    parser = study.options(__doc__)
    parser.add_argument("folder", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--output", type=pathlib.Path, default=pathlib.Path("real_pads"), metavar="DIR")
    parser.add_argument("--contacts", type=int, default=60000, help="simulated, to learn from")
    parser.add_argument("--shear-gain", type=float, metavar="R", help="counts of z that a count of shear is worth (by the spread at rest)")
    options = parser.parse_args()
    trials = read_trials(options.folder)
    options.output.mkdir(parents=True, exist_ok=True)
    chain = Chain(options.build, options.output)

    measured = np.array([spread(trial.load[:, :START].mean(1)) for trial in trials])
    if measured.mean() <= 0:
        wrong(options.folder, "shear at rest points inward, where a press spreads rubber", "check the order and signs of the axes")
    simulated = chain.simulated_spread()
    shear_gain = float(options.shear_gain or simulated / measured.mean())  # NumPy 2 would print its type
    print(f"{len(trials)} trials, {sum(trial.gone() is not None for trial in trials)} of which end without the object.\n"
          f"Shear at the outer tactels over mean normal stress at rest: {measured.min():.3f} to {measured.max():.3f} in counts, "
          f"{simulated:.3f} simulated.\nA count of shear is taken as {shear_gain:.2f} counts of z.")
    networks = chain.networks(options.contacts)

    print(study.head("trial", "frames", "first motion", "moved", "largest turn, degrees", "largest way, mm"))
    for trial in trials:
        print(study.row(trial.name, len(trial.time), trial.first or "", trial.moves or "holds", f"{trial.turn.max():.1f}",
                        f"{trial.way.max():.1f}"))
    held = next((i for i, trial in enumerate(trials) if trial.moves is None), None)
    if held is None:
        wrong(options.folder, "the box moves in all trials", "add one that holds, which gives the threshold")
    print(f"\nThreshold: {MARGIN} times the largest score in {trials[held].name}, whose own false alarms it excludes.\n"
          "Events: frames from \"moved\" to the alarm.\n")
    loads = [trial.load for trial in trials]
    empty = next(trial for trial in trials if trial.gone() is not None).counts[:, -END:]
    rest = empty - empty.mean(1, keepdims=True)

    def row_of_moved(name, loads, hold, *network):
        calibration, threshold = chain.hold(rest, hold, *network)
        said = [chain.moved(load, calibration, *network) for load in loads]
        row(name, trials, [each.max(1) for each, _ in said], threshold, [alarm for _, alarm in said])
        return [each for each, _ in said], threshold

    def of_network(loads, network):
        said = [chain.answers(load, shear_gain, network) for load in loads]
        scores = [network_scores(S, upper) for S, upper, _, _ in said]
        return {name: [score[name] for score in scores] for name in scores[0]}, said

    head(trials)
    of_pads, threshold = row_of_moved("moved, without a network", loads, loads[held])
    for pad in (0, 1):
        row(f"moved, pad {pad + 1} alone", trials, [each[:, pad] for each in of_pads], threshold)
    slid = [("--network", network) for network in chain.slid_networks(options.contacts)]
    for seed, network in enumerate(slid, 1):
        of_pads, threshold = row_of_moved(f"slid, seed {seed}", loads, loads[held], *network)
        for pad in (0, 1):
            row(f"slid, seed {seed}, pad {pad + 1} alone", trials, [each[:, pad] for each in of_pads], threshold)
    simple = [baselines(load) | null_scores(load) for load in loads]
    for name in simple[0]:
        scores = [score[name] for score in simple]
        row(name, trials, scores, MARGIN * scores[held].max())
    for seed, network in enumerate(networks, 1):
        by_name, said = of_network(loads, network)
        for name, scores in by_name.items():
            row(f"{name}, seed {seed}", trials, scores, MARGIN * scores[held].max())
        row(f"bound, seed {seed}, monitor --alarm {ALARM}", trials, by_name["bound"], None, [list(one[3]) for one in said])
        for trial, (S, upper, _, alarm) in zip(trials, said) if seed == 1 else ():
            figure(options.output / f"{trial.name}.svg", trial, S, upper, alarm)


if __name__ == "__main__":
    main()
