#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Slip index of two real pads that hold a box, by a network taught by simulation alone: prints tables such as those of
docs/notebook/2026-11-23-real-pads.md and draws a figure of each trial.

Usage: docs/real_pads.py FOLDER [--output DIR] [--build build] [--contacts N] [--shear-gain R]
FOLDER holds trials data_sample_*, such as the folder data_set of github.com/imanlab/proactive-slip-control (MIT): Nazari, Mandil
and Ghalamzan, "Proactive slip control by learned slip model and trajectory adaptation", CoRL 2022. A trial has counts of two uSkin
pads (xela_sensor1.csv, xela_sensor2.csv), times (robot_state.csv) and a marker's label of slip (slip_label.csv).
The label judges and decides nothing: zero, gains, network, threshold of the alarm and scores are fixed without it.
DIR gets network/, frames and a figure NAME.svg of each trial. Debian: python3-numpy, python3-matplotlib."""
import argparse
import dataclasses
import json
import pathlib
import subprocess
import tempfile

import numpy as np

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
TOPOLOGY, EPOCHS = "48-96-48-1", 20

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
        wrong(path, "cannot be read", "a trial has xela_sensor1.csv, xela_sensor2.csv, robot_state.csv and slip_label.csv")
    except ValueError as error:
        wrong(path, "lines of different lengths: " + " ".join(str(error).split()), "copy the file again")
    if numbers.shape[1] < columns or not np.isfinite(numbers).all():
        wrong(path, f"no {columns} numbers in every line below the first", "copy the file again")
    return numbers


@dataclasses.dataclass
class Trial:
    name: str
    counts: np.ndarray  # [pads, frames, tactels, 3], tactels row by row, axes x, y, z; z grows with pressure
    time: np.ndarray  # [frames], s
    slip: np.ndarray  # [frames], the marker's label
    load: np.ndarray = None  # [pads, frames, tactels, 3]: counts less those of the pads without load

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
        state, label = table(path / "robot_state.csv", 1), table(path / "slip_label.csv", 1)
        lengths = {len(file) for file in (*files, state, label)}
        if len(lengths) > 1 or min(lengths) < START + QUARTER + END:
            wrong(path, f"files of {', '.join(map(str, sorted(lengths)))} frames",
                  f"all files of a trial have one length, of {START + QUARTER + END} at least")
        counts = np.stack([file[:, :3 * TACTELS].reshape(-1, TACTELS, 3) for file in files])
        trials.append(Trial(path.name.removeprefix("data_sample_"), counts, state[:, -1], label[:, 0] > 0))
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
        trial.time, trial.slip = trial.time[:end], trial.slip[:end]
        if len(trial.slip) < START or (trial.load[:, :START, :, 2].mean((1, 2)) <= 0).any():
            wrong(folder / f"data_sample_{trial.name}", "nothing is held at the start", "leave this trial out")


def spread(load):
    """Shear at the outer tactels, outward, over the mean normal stress: [..., tactels, 3], z of pressure above 0."""
    grid = load.reshape(*load.shape[:-2], SIDE, SIDE, 3)
    outward_x = grid[..., :, -1, 0].mean(-1) - grid[..., :, 0, 0].mean(-1)
    outward_y = grid[..., -1, :, 1].mean(-1) - grid[..., 0, :, 1].mean(-1)
    return (outward_x + outward_y) / 4 / load[..., 2].mean(-1)


class Chain:
    def __init__(self, build, output):
        self.program, self.output = build.resolve() / "tactel", output
        if not self.program.is_file():
            wrong(self.program, "no such program", "build it, or name its folder by --build")

    def run(self, *words):
        done = subprocess.run([self.program, *map(str, words), "--quiet"], capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"tactel {' '.join(map(str, words))}: exit code {done.returncode}\n{done.stderr}")
        return done.stdout

    def simulated_spread(self):
        """Of the assumed rubber under a box as wide as the array, half a pitch outside of the outer tactels."""
        scene = self.output / "press.toml"
        scene.write_text("[sensor]\nkind = \"pad\"\n" + "".join(f"{key} = {value}\n" for key, value in RUBBER.items())
                         + f"tactels = [{SIDE}, {SIDE}]\npitch = {PITCH}\n[indenter]\nshape = \"box\"\n"
                         f"half_widths = [{SIDE * PITCH / 2}, {SIDE * PITCH / 2}]\nedge = 0.5\n[contact]\nfriction = 0.5\n"
                         "[load]\nindentation = 0.3\n")
        step = json.loads(self.run("solve", scene, "--json", "-"))["steps"][-1]
        return spread(np.stack([step["tau_x"], step["tau_y"], -np.array(step["sigma_z"])], axis=-1))

    def network(self, contacts):
        """A network with a bound of 95 %, taught and calibrated by simulated contacts."""
        with tempfile.TemporaryDirectory(dir=self.output) as folder:
            sets = []
            for seed, count in ((1, contacts), (2, max(contacts // 4, 100))):
                sweep = pathlib.Path(folder) / f"sweep_{seed}.toml"
                sweep.write_text(SWEEP.replace("CONTACTS", str(count)).replace("SEED", str(seed)))
                sets.append(sweep.with_suffix(".h5"))
                self.run("generate", sweep, "--output", sets[-1], "--rung", "pad-8")
            self.run("train", sets[0], "--output", self.output / "network", "--network", TOPOLOGY, "--schedule", "batch", "--epochs",
                     EPOCHS, "--scaling", "frame", "--activation", "leaky-relu", "--bound", "--bound-set", sets[1], "--recall",
                     sets[1], "--force")
        report = json.loads((self.output / "network/training.json").read_text())["networks"][0]
        print(f"Mean error of S on simulated contacts: {report['recalling']['mean']:.3f}.\n")
        return next((self.output / "network").glob("*.onnx"))

    def answers(self, trial, shear_gain, network):
        """What tactel monitor says of both pads: S, its upper bound and whether the frame is unlike those that the network learnt,
        [pads, frames], and whether the alarm is on, [frames]."""
        zero = trial.counts[:, 0] - trial.load[:, 0]
        gain = [shear_gain * GAIN, shear_gain * GAIN, -GAIN] * (2 * TACTELS)
        calibration, lines = (self.output / f"{trial.name}.{end}" for end in ("toml", "csv"))
        calibration.write_text(f"[calibration]\noffset = {zero.ravel().tolist()}\ngain = {gain}\n")
        frames = np.moveaxis(trial.counts[:, :len(trial.time)], 1, 0).reshape(len(trial.time), -1)
        names = ["time", *(f"pad{pad}_{tactel}{axis}" for pad in (1, 2) for tactel in range(1, TACTELS + 1) for axis in "xyz")]
        np.savetxt(lines, np.column_stack([trial.time, frames]), delimiter=",", fmt="%.6g", header=",".join(names), comments="")
        said = self.run("monitor", "--source", f"csv:{lines}", "--profile", "uskin-4x4", "--profile", "uskin-4x4", "--calibration",
                        calibration, "--network", network, "--alarm", ALARM, "--touch", 0, "--drift", 0)
        said = [json.loads(line) for line in said.splitlines()]
        of_pads = [[[float(line["pads"][pad][key]) for line in said] for pad in (0, 1)] for key in ("slip_index", "slip_upper", "unlike")]
        return *np.array(of_pads), np.array([line["alarm"] for line in said])


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
    scores = {"S": S, "S less its start": S - S[:, :START].mean(1, keepdims=True), "change of S within 5 frames": change(S),
              "bound": upper, "bound less its start": upper - upper[:, :START].mean(1, keepdims=True)}
    return {name: values.max(0) for name, values in scores.items()}


def area(score, label):
    """Area under the ROC curve: how often a frame of slip has a higher score than one without, ties half. NaN: only one of both."""
    if label.all() or not label.any():
        return np.nan
    _, place, count = np.unique(score, return_inverse=True, return_counts=True)
    rank = (np.cumsum(count) - (count - 1) / 2)[place]
    slips = label.sum()
    return (rank[label].sum() - slips * (slips + 1) / 2) / (slips * (len(label) - slips))


def print_areas(trials, scores):
    judged = [i for i, trial in enumerate(trials) if trial.slip.any() and not trial.slip.all()]
    print("Area under the ROC curve of the label of slip:\n")
    print("| score | all trials | " + "".join(f"{trials[i].name} | " for i in judged).rstrip() + "\n|---" + "|---" * (len(judged) + 1) + "|")
    label = np.concatenate([trial.slip for trial in trials])
    for name in scores[0]:
        each = [area(score[name], trial.slip) for score, trial in zip(scores, trials)]
        cells = [area(np.concatenate([score[name] for score in scores]), label), *(each[i] for i in judged)]
        print(f"| {name} | " + " | ".join(f"{cell:.3f}" for cell in cells) + " |")


def figure(path, trial, S, upper, alarm):
    import matplotlib
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"font.size": 10, "axes.grid": True, "grid.color": "#dddddd", "axes.axisbelow": True, "legend.frameon": False,
                         "svg.fonttype": "none", "svg.hashsalt": "tactel", "font.family": "DejaVu Sans", "figure.facecolor": "white"})
    shown, (index, ratio, force) = plt.subplots(3, 1, sharex=True, figsize=(8.4, 7), layout="constrained", height_ratios=(2, 1, 1))
    P = trial.load[..., 2].sum(2)
    Q = np.linalg.norm(trial.load[..., :2].sum(2), axis=-1)
    for pad, colour in enumerate(("#1f5fa8", "#d9660a")):
        index.plot(trial.time, S[pad], color=colour, label=f"S, pad {pad + 1}")
        index.plot(trial.time, upper[pad], color=colour, lw=0.8, ls="--", label=f"upper bound, pad {pad + 1}")
        ratio.plot(trial.time, Q[pad] / P[pad], color=colour, label=f"pad {pad + 1}")
        force.plot(trial.time, P[pad] / 1000, color=colour, label=f"pad {pad + 1}")
    for axes in (index, ratio, force):
        axes.set_ylim(axes.get_ylim())
        for begin in np.flatnonzero(trial.slip & ~np.r_[False, trial.slip[:-1]]):
            end = begin + np.argmin(np.r_[trial.slip[begin:], False]) - 1
            axes.axvspan(trial.time[begin], trial.time[end], color="#e8d5a0", lw=0, zorder=0,
                         label="slip, by the marker" if axes is force and begin == np.argmax(trial.slip) else None)
    index.fill_between(trial.time, 1.02, 1.06, where=alarm, color="#b3261e", lw=0, label=f"alarm, bound above {ALARM}")
    index.set(ylim=(0, 1.08), ylabel="S", title=f"{trial.name}: S by a network taught by simulation alone")
    index.legend(ncols=3, fontsize=8, loc="lower right")
    ratio.set(ylabel="|Q| / P, counts")
    force.set(ylabel="P, 1000 counts", xlabel="s")
    force.legend(fontsize=8)
    shown.savefig(path, metadata={"Date": None})
    plt.close(shown)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--output", type=pathlib.Path, default=pathlib.Path("real_pads"), metavar="DIR")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="holds the program")
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
    network = chain.network(options.contacts)

    scores = []
    print("| trial | frames | slip | S at the start | largest S | frames of alarm: slip | others | unlike what was learnt |\n|---" + "|---" * 7
          + "|")
    for trial in trials:
        S, upper, unlike, alarm = chain.answers(trial, shear_gain, network)
        figure(options.output / f"{trial.name}.svg", trial, S, upper, alarm)
        scores.append(network_scores(S, upper) | baselines(trial.load))
        alarms = [f"{100 * alarm[chosen].mean():.0f} %" if chosen.any() else "" for chosen in (trial.slip, ~trial.slip)]
        print(f"| {trial.name} | {len(trial.slip)} | {trial.slip.sum()} | {S.max(0)[:START].mean():.2f} | {S.max():.2f} | {alarms[0]} | "
              f"{alarms[1]} | {100 * unlike.mean():.0f} % |")
    print()
    print_areas(trials, scores)


if __name__ == "__main__":
    main()
