#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The alarm of grips in several worlds, by the program's own commands (tactel tare, tactel monitor --rest --alarm): slips that are found,
false alarms a minute, share of the quiet time with an alarm; beside it what knows little of slip, each at one false alarm a minute.

Usage: studies/alarms.py [--seeds 1-20] [--hands 1-6] [--pairs 1-3] [--springs] [--robots FOLDER] [--people FOLDER] [--changed]
                         [--scenes] [--build build]
The laboratory of studies/laboratory.py: seeds are pairs of pads, of hands that tremble with --hands, of objects that first slid with
--pairs. FOLDER of robots: trials as studies/real_pads.py reads them. FOLDER of people: NNN.npz, a person each, with change
[48, frames] (differences of neighbouring frames over scale), scale, frames (of each trial), start and end of its motion, turn_object
and turn_relative (0.01 degrees). --changed: the robots' or else the laboratory's grips by other sensors.

Hit: an alarm begins between 1 s before the slip and 1 mm of it; of robots from the first motion to 5 frames after "moved", of people 30
frames before to 5 after a turn of 10 degrees. Already: it was on before, and stays. Late: it begins within a second after.
False: it begins while nothing slides. Nothing is chosen by what this prints. Debian: python3-numpy."""
import dataclasses
import itertools
import json
import pathlib
import sys
import tempfile

import numpy as np

import laboratory
import real_pads
import study

RATE, RELEASE = 60, 1.2
OLD = 1.0  # s before a slip from which on an alarm is a hit
SPRINGS = ({}, {"mu": 0.3}, {"mu": 0.9}, {"peak": 0.06}, {"peak": 0.015}, {"dome": 80}, {"dome": 1000}, {"outward": 0.05}, {"outward": 0},
           {"angle": 0}, {"angle": -45}, {"seed": 2})
CHANGES = ("shear x 0.37", "shear x 2.7", "P +20 %", "P -20 %", "gains +-20 %", "turned by 90 degrees", "mirrored", "half the rate",
           "a third of the rate", "10 % lost", "30 % lost", "noise x 2", "noise x 4", "pad 1 alone", "a stuck channel", "a dead tactel",
           "spikes of 400", "drift of 0.5 % a second", "drift of 2 % a second", "counts x 100000")


@dataclasses.dataclass
class Grip:
    name: str
    scene: str
    rows: np.ndarray  # [frames, pads, tactels, 3] less the zero, z of pressure above 0
    time: np.ndarray  # [frames] s
    quiet: np.ndarray  # [frames] bool: an alarm is false
    hit: tuple | None  # frames [first, last): an alarm that begins there is a hit
    slide: np.ndarray | None = None  # rows of the same object that slid before


@dataclasses.dataclass
class Sensor:
    """Grips that share a pair of pads and a hand."""
    empty: np.ndarray  # rows without load
    holds: list  # of rows
    grips: list


def windows(grip):
    """Quiet frames and the window of a hit of a grip of the laboratory."""
    slip, time = grip.slip.mean(1), grip.time
    quiet, hit = time >= grip.hold_at + 0.5, None
    quiet &= (time < grip.open_from - 0.35) | (time > grip.open_to + 0.5)
    if (slip > 1).any():
        end = int(np.argmax(slip > 1))
        before = np.flatnonzero(slip[:end] < 0.1)
        first = int(np.searchsorted(time, time[before[-1] + 1 if len(before) else 0] - OLD))
        quiet, hit = quiet & (np.arange(len(time)) < first), (first, end + 1)
    elif slip.max() > 0.1:
        quiet[:] = False  # in between: nobody asks
    recent = np.array([grip.load[max(k - 6, 0):k + 1].max() for k in range(len(time))])
    return quiet & (recent <= 0.8), hit


def of_laboratory(seeds, hands=False):
    grips = laboratory.simulate([grip for seed in seeds for grip in laboratory.draw_seed(seed, hands)])
    for seed in seeds:
        mine = [grip for grip in grips if grip.seed == seed]
        zero = mine[0].counts[:48].mean(0)
        yield Sensor(mine[0].counts[:54] - zero, [mine[0].counts - zero],
                     [Grip(grip.name, grip.scene, grip.counts - zero, grip.time, *windows(grip)) for grip in mine[1:]])


def of_pairs(seeds):
    grips = laboratory.simulate([grip for seed in seeds for grip in laboratory.draw_pairs(seed)])
    for slide, grip in zip(grips[::2], grips[1::2]):
        zero = grip.counts[:48].mean(0)
        yield Sensor(grip.counts[:54] - zero, [], [Grip(grip.name, grip.scene, grip.counts - zero, grip.time, *windows(grip),
                                                        slide.counts - slide.counts[:48].mean(0))])


def of_springs():
    """A slide is found from half of the limit on until it ends."""
    for kind in SPRINGS:
        (time, held, _), (_, slid, load) = (laboratory.springs(slides=slides, **kind) for slides in (False, True))
        zero = held[:200].mean(0)
        half = int(np.argmax(load >= 0.5))
        slid, time = slid[:1300] - zero, time[:1300]
        quiet = (time > 4.5) & (np.arange(1300) < half)
        yield Sensor(held[:200] - zero, [held[:1100] - zero], [Grip(str(kind), "springs", slid, time, quiet, (half, 1300))])


def of_robots(folder):
    trials = real_pads.read_trials(folder)
    held = next((trial for trial in trials if trial.moves is None), None)
    empty = next(trial for trial in trials if trial.gone() is not None).counts[:, -real_pads.END:]
    grips = []
    for trial in trials:
        rows, frames = np.moveaxis(trial.load, 1, 0), np.arange(len(trial.time))
        scene, hit = ("holds", None) if trial.moves is None else ("moves", (trial.first, trial.moves + 6))
        grips.append(Grip(trial.name, scene, rows, frames / RATE, frames < (hit[0] if hit else len(frames)), hit))
    yield Sensor(np.moveaxis(empty - empty.mean(1, keepdims=True), 1, 0), [] if held is None else [np.moveaxis(held.load, 1, 0)], grips)


def of_people(folder):
    """A person's first three quiet holds are recorded, and not judged."""
    paths = sorted(folder.glob("[0-9]*.npz"))
    if not paths:
        real_pads.wrong(folder, "no files NNN.npz", "give a folder of people's grips, see --help")
    for path in paths:
        data, holds, grips = np.load(path), [], []
        ends, change = np.cumsum(data["frames"]), data["change"].T
        for k, (end, frames, start, stop) in enumerate(zip(ends, data["frames"], data["start"], data["end"])):
            rows = np.cumsum(change[end - frames:end], 0, dtype=np.int32) * float(data["scale"])
            rows = rows.reshape(frames, 1, -1, 3) - rows[:100].mean(0).reshape(-1, 3)
            turn_object, turn = (data[key][end - frames:end] / 100 for key in ("turn_object", "turn_relative"))
            turn, rest = np.minimum(turn_object, turn), slice(start - 90, start - 20)
            last = min(max(stop, start + 1) + 10, frames)
            still = turn_object[rest].max() < 4 and rows[rest, 0, :, 2].sum(1).min() > 1
            most, beyond = turn[start - 20:last].max(), real_pads.onset(turn[start - 39:last] > 10, 3)
            scene = next((name for name, least in (("over 40", 40), ("20 to 40", 20), ("10 to 20", 10)) if most > least), "less")
            if still and len(holds) < 3:
                holds.append(rows[rest])
                still = False
            quiet, event = np.zeros(frames, bool), start - 39 + (beyond or 0)
            quiet[rest] = still
            grips.append(Grip(f"{path.stem}, grip {k}", scene, rows, np.arange(frames) / RATE, quiet,
                              (event - 30, event + 6) if beyond is not None and most > 10 else None))
        yield Sensor(grips[0].rows[:100], holds, grips)


def changed(kind, rows):
    """Rows [frames, pads, tactels, 3] as another sensor would read them, and which of the frames there are."""
    rows, random, there = rows.astype(float), np.random.default_rng(1), np.arange(len(rows))
    force = rows[..., 2].sum((1, 2))
    held = force > 0.5 * np.quantile(force, 0.9)
    if kind.startswith("shear"):
        rows[..., :2] *= float(kind.split()[-1])
    elif kind.startswith("P"):  # by a wrong zero of z
        rows[held, ..., 2] += float(kind.split()[1]) / 100 * rows[held, ..., 2].mean((0, 2), keepdims=True)[0]
    elif kind.startswith("gains"):
        rows *= 1 + random.uniform(-0.2, 0.2, rows.shape[1:])
    elif kind.startswith("turned"):
        side = real_pads.SIDE
        grid = np.rot90(rows.reshape(*rows.shape[:2], side, side, 3), axes=(2, 3)).reshape(rows.shape)
        rows = np.stack([grid[..., 1], -grid[..., 0], grid[..., 2]], axis=-1)
    elif kind == "mirrored":
        rows = rows.reshape(*rows.shape[:2], real_pads.SIDE, real_pads.SIDE, 3)[:, :, :, ::-1].reshape(rows.shape) * [-1, 1, 1]
    elif kind.endswith("the rate"):
        there = there[::2 if kind.startswith("half") else 3]
    elif kind.endswith("lost"):
        there = there[random.random(len(rows)) >= float(kind.split()[0]) / 100]
    elif kind.startswith("noise"):
        noise = np.abs(np.diff(rows, axis=0)).mean((0, 1, 2)) * np.sqrt(np.pi) / 2  # of an axis, deviation of a reading
        rows += random.normal(0, 1, rows.shape) * noise * np.sqrt(float(kind.split()[-1])**2 - 1)
    elif kind == "pad 1 alone":
        rows[:, 1:] = random.normal(0, 1, rows[:, 1:].shape)
    elif kind == "a stuck channel":
        rows[:, 0, 5, 0] = rows[0, 0, 5, 0]
    elif kind == "a dead tactel":
        rows[:, 0, 5] = 0
    elif kind.startswith("spikes"):
        rows += 400 * random.choice([-1, 1], rows.shape) * (random.random(rows.shape) < 5e-4)
    elif kind.startswith("drift"):
        rows *= 1 + float(kind.split()[2]) / 100 * np.arange(len(rows))[:, None, None, None] / RATE
    elif kind.startswith("counts"):
        rows *= float(kind.split()[-1])
    return rows[there], there


def of_changed(kind, sensors):
    for sensor in sensors:
        other, grips = lambda rows: changed(kind, rows)[0], []
        for grip in sensor.grips:
            rows, there = changed(kind, grip.rows)
            hit = tuple(np.searchsorted(there, grip.hit)) if grip.hit else None
            grips.append(dataclasses.replace(grip, rows=rows, time=grip.time[there], quiet=grip.quiet[there], hit=hit))
        alike = kind.startswith(("P", "drift")) or kind.endswith(("rate", "lost"))
        yield Sensor(sensor.empty if alike else other(sensor.empty), [other(rows) for rows in sensor.holds], grips)


def judge(on, quiet, hit):
    """Of an alarm [frames]: false ones, quiet frames and those with an alarm; of a slip whether it is a hit, already on, late."""
    begins, first = on & ~np.r_[False, on[:-1]], quiet & ~np.r_[False, quiet[:-1]]
    counts = {"false": (begins & quiet & ~first) | (on & first), "quiet": quiet, "on": on & quiet}
    found = {key: np.count_nonzero(frames) for key, frames in counts.items()} | {"slip": hit is not None}
    if hit:
        a, b = hit
        found["already"] = bool(on[max(a - 1, 0)] and on[a:a + 5].all())
        found["hit"] = not found["already"] and bool(begins[a:b].any())
        found["late"] = not found["already"] and not found["hit"] and bool(begins[b:b + RATE].any())
    return found


def latch(score, at):
    """The alarm [frames] of a score; NaN leaves it as it is."""
    turns = np.where(score >= at, 1, np.where(score < at / RELEASE, 0, -1))
    turns[0] = max(turns[0], 0)
    return turns[np.maximum.accumulate(np.where(turns >= 0, np.arange(len(turns)), 0))] == 1


def total(found):
    slips, holds = [f for f in found if f["slip"]], [f for f in found if f["quiet"]]
    share = lambda of, key: sum(f[key] > 0 for f in of) / len(of) if of else np.nan
    false, quiet, on = (sum(f[key] for f in found) for key in ("false", "quiet", "on"))
    minutes = quiet / RATE / 60
    return {key: share(slips, key) for key in ("hit", "already", "late")} | dict(
        slips=len(slips), minutes=minutes, false=false / max(minutes, 1e-9), on=on / max(quiet, 1), holds=len(holds), alarmed=share(holds, "false"))


def row(name, found):
    t = total(found)
    cells = [f"{t[key]:.2f}" for key in ("hit", "already", "late")] + [f"{t[key]:.1f}" for key in ("minutes", "false")]
    print(study.row(name, t["slips"], *cells, f"{t['on']:.3f}", f"{t['alarmed']:.2f} of {t['holds']}"), flush=True)


def at_one(scores, grips):
    """What a score finds where it gives one false alarm a minute, or as near to it as it can below."""
    judged = lambda at: [judge(latch(score, at), grip.quiet, grip.hit) for score, grip in zip(scores, grips)]
    quiet = np.concatenate([score[grip.quiet] for score, grip in zip(scores, grips)])
    low, high, best = 1e-5, 0.5, judged(np.inf)  # share of the quiet frames that are above
    for _ in range(12 if len(quiet) else 0):
        middle = np.sqrt(low * high)
        at = np.nanquantile(quiet, 1 - middle)
        found = judged(at) if at > 0 else None
        if found is None or total(found)["false"] > 1:
            high = middle
        else:
            low, best = middle, found
    return best


def at_rest(force, touches):
    """The mean of P [frames] over the last third of a second in which it was as steady as three times the steadiest so far."""
    rows = np.lib.stride_tricks.sliding_window_view(np.r_[np.full(19, np.nan), force], 20)
    mean = rows.mean(1)
    steady = np.where(touches & (mean > 0), rows.std(1) / np.maximum(mean, 1e-9), np.inf)
    steady[np.isnan(steady)] = np.inf
    still = steady <= np.clip(3 * np.minimum.accumulate(steady), 0.006, 0.05)
    return mean[np.maximum.accumulate(np.where(still, np.arange(len(force)), 0))]


def nulls(grip, touch):
    """Scores [frames] that know little of slip."""
    force = grip.rows[..., 2].sum(2)
    touches = force > touch
    shear = np.linalg.norm(grip.rows[..., :2].sum(2), axis=-1) / np.where(touches, force, np.inf)
    before = np.column_stack([at_rest(*pad) for pad in zip(force.T, touches.T)])
    held = force[grip.quiet].mean() if grip.quiet.any() else force.mean()
    rises = np.where(touches & (before > touch), force / np.fmax(before, touch) - 1, 0)
    return {"P alone: its rise since rest": rises.max(1), "|Q| / P": shear.max(1), "time since touch": np.cumsum(touches.any(1)) * touches.any(1),
            "1 / P, the same in all frames": np.full(len(force), 1 / max(held, 1e-9))}


class Judge:
    def __init__(self, build, folder, scenes):
        self.run, self.folder, self.scenes = study.Program(build), folder, scenes

    def csv(self, name, rows, time=None):
        path = self.folder / f"{name}.csv"
        time = np.arange(len(rows)) / RATE if time is None else time
        names = ["time", *(f"c{k}" for k in range(rows[0].size))]
        table = np.column_stack([time, rows.reshape(len(rows), -1)])
        np.savetxt(path, table, delimiter=",", fmt="%.8g", header=",".join(names), comments="")
        return f"csv:{path}"

    def tare(self, sensor, words):
        """A calibration; None where the program refuses the recordings, and says so."""
        pads = ("--profile", "uskin-4x4") * sensor.empty.shape[1]
        seconds = f"{0.9 * len(sensor.empty) / RATE:.3f}"
        try:
            self.run("tare", "--source", self.csv("empty", sensor.empty), *pads, "--seconds", seconds, "--output",
                     self.folder / "pads.toml", "--force", *words)
        except SystemExit as error:
            if not words:
                raise
            print(str(error).strip().splitlines()[-1], file=sys.stderr)
            return None
        return self.folder / "pads.toml"

    def lines(self, grip, calibration):
        pads = ("--profile", "uskin-4x4") * grip.rows.shape[1]
        said = self.run("monitor", "--source", self.csv("grip", grip.rows, grip.time), *pads, "--calibration", calibration, "--drift", 0,
                        "--rest", "--alarm", "--quiet")
        lines = [json.loads(line) for line in said.splitlines() if line.startswith('{"frame"')]
        if len(lines) != len(grip.rows):
            real_pads.wrong(grip.name, f"{len(lines)} lines of {len(grip.rows)} frames", "see what tactel monitor says")
        of_pads = lambda line: [pad.get("moved") or 0 for pad in line.get("pads", [line])]
        return np.array([line["alarm"] for line in lines]), np.array([max(of_pads(line)) for line in lines])

    def found(self, sensor, rule):
        """Whether its recordings are accepted, and of each grip what the alarm found, and `moved` [frames]."""
        recorded = sensor.holds if rule == "hold" else [sensor.grips[0].slide] if rule == "slide" else []
        words = [word for k, rows in enumerate(recorded) for word in (f"--{rule}", self.csv(f"recorded{k}", rows))]
        calibration = self.tare(sensor, words)
        accepted, calibration = calibration is not None, calibration or self.tare(sensor, [])
        said = [self.lines(grip, calibration) for grip in sensor.grips]
        judged = [judge(on, grip.quiet, grip.hit) | {"scene": grip.scene} for (on, _), grip in zip(said, sensor.grips)]
        return accepted, judged, [moved for _, moved in said]

    def play(self, name, sensors, rules, with_nulls=True):
        """Prints the rows of a world, for the alarm by each of the rules "no hold", "hold", "slide", and of the nulls."""
        sensors = list(sensors)
        grips = list(itertools.chain(*(sensor.grips for sensor in sensors)))
        for rule in rules:
            accepted, judged, moved = zip(*(self.found(sensor, rule) for sensor in sensors))
            judged = list(itertools.chain(*judged))
            row(f"{name}, {rule}" + ("" if rule == "no hold" else f", {sum(accepted)} of {len(accepted)} accepted"), judged)
            for scene in dict.fromkeys(grip.scene for grip in grips) if self.scenes else ():
                row(f"... {scene}", [found for found in judged if found["scene"] == scene])
        if with_nulls:
            row("moved, same rest", at_one(list(itertools.chain(*moved)), grips))
            touch = 0.02 * np.median([np.quantile(grip.rows[..., 2].sum(2), 0.9) for grip in grips])
            scores = [nulls(grip, touch) for grip in grips]
            for null in scores[0]:
                row(null, at_one([score[null] for score in scores], grips))


def numbers(text):
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def main(arguments=None):
    parser = study.options(__doc__)
    for world in ("seeds", "hands", "pairs"):
        parser.add_argument(f"--{world}", type=numbers, metavar="A-B")
    for world in ("robots", "people"):
        parser.add_argument(f"--{world}", type=pathlib.Path, metavar="FOLDER")
    for flag in ("springs", "changed", "scenes"):
        parser.add_argument(f"--{flag}", action="store_true")
    options = parser.parse_args(arguments)
    worlds = {"people": of_people, "laboratory": of_laboratory, "hands": lambda seeds: of_laboratory(seeds, True), "pairs": of_pairs,
              "springs": lambda _: of_springs(), "robots": of_robots}
    given = vars(options) | {"laboratory": options.seeds}
    if options.changed and not (options.robots or options.seeds):
        parser.error("--changed: needs --robots FOLDER or --seeds A-B")
    with tempfile.TemporaryDirectory() as folder:
        judged = Judge(options.build, pathlib.Path(folder), options.scenes)
        print(study.head("world, rule", "slips", "hit", "already", "late", "quiet minutes", "false a minute", "on", "grips with a false one"))
        for name, world in worlds.items():
            if given[name]:
                judged.play(name, world(given[name]), ("slide" if name == "pairs" else "hold", "no hold"))
        for kind in CHANGES if options.changed else ():
            world = of_robots(options.robots) if options.robots else of_laboratory(options.seeds)
            judged.play(kind, of_changed(kind, world), ("hold",) if options.robots else ("no hold",), with_nulls=False)


if __name__ == "__main__":
    main()
