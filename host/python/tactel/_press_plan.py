# SPDX-License-Identifier: Apache-2.0
"""The presses that tell most of a line. The information J^T J of the fit at the nominal sensor weighs a set; offsets, and the friction
of each press where it is fitted, are eliminated. One determinant would give E and nu two votes of forty-four, so that the criterion is
compound (A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum Experimental Designs, 2007):
    log det(gains) / transducers + 4 log det(sensor's numbers, gains eliminated) / numbers.
Presses are taken one by one, and then exchanged as long as there are better ones (V. V. Fedorov, Theory of Optimal Experiments, 1972)."""

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import Cylinder, Flat, Press, Scene, Sensor, Wedge, read_scene
from ._calls import _tactel, input_error, write_text
from ._known_presses import Grid, Options, by_force, indented, is_pad, press_numbers, sensor_numbers, transducers
from ._press_files import Table, read_fit, read_tables, same_sensor, steps

WEAK = 0.01  # information on each unknown: determinants exist before every transducer has been pressed
WEIGHT = 4  # of E and nu beside gains: ten planned presses then tell neither less than twenty random ones
NEVER_FOUND = 0.5  # relative deviation of a gain, with all candidates
REST, MOTION, HOLD, WINDOW = 1.0, 0.3, 0.7, 0.4  # s of a planned press: at rest, then for each load step; of which it is read
BESIDE = 1.0  # mm of rubber beside the lowest part of an indenter
MOST_CANDIDATES = 5000


@dataclass(frozen=True)
class Candidate:
    indenter: str  #: for people
    scene: Scene

    @property
    def timing(self):
        """A second at rest, then a second for each load step."""
        begin = REST + (MOTION + HOLD) * np.arange(steps(self.scene))
        return begin, begin + MOTION, begin + MOTION + HOLD - WINDOW / 2 - 0.1


class Plan:
    def __init__(self, candidates, count=10, options=Options(), forces=True, noise=None, share=0.01):
        """noise: [transducers] MPa of a reading, NaN: no transducer; None: `share` of the largest stress."""
        if not 1 <= count <= len(candidates):
            raise input_error("--presses", count, f"must be 1 to {len(candidates)}, the number of candidates")
        scenes, self.of = [candidate.scene for candidate in candidates], transducers(candidates[0].scene)
        force = np.array([by_force(scene) for scene in scenes])
        told = (~force).any() and (forces or force.any())
        every = np.ones(len(scenes), bool)
        self.numbers = [n for n, asked in sensor_numbers(scenes[0], options, len(scenes)) if asked and (told or n.key != "young")]
        self.frictions = press_numbers(scenes, options, [""] * len(scenes), every)[0]
        grid = Grid(scenes, [candidate.timing for candidate in candidates], [candidate.indenter for candidate in candidates], options.time_constant,
                    self.numbers + self.frictions, "patch-12")
        self.noise = np.full(len(self.of), share * np.abs(grid.frame).max()) if noise is None else np.asarray(noise, float)
        self.P = [float(grid.P[rows].max()) for rows in grid.rows]
        self.own = len(self.numbers) + bool(self.frictions)  # the last one is the press's friction
        self.information = [self._of_press(grid, i, rows, forces, options) for i, rows in enumerate(grid.rows)]
        self.chosen = self._choose(count)

    def _of_press(self, grid, i, rows, forces, options):
        """Sums over the rows of a press, weighted by noise: of 1, stress, stress^2 [3, transducers]; of 1 and of stress with the numbers
        [2, transducers, numbers]; of the numbers [numbers, numbers]."""
        weight = np.where(np.isfinite(self.noise), 1 / self.noise**2, 0)
        frame, slopes = grid.frame[rows], list(grid.parabolas[:len(self.numbers)])
        if self.frictions:
            slopes += [grid.parabolas[len(self.numbers) + k] for k, n in enumerate(self.frictions) if n.presses[i]] or [(np.zeros((1, *grid.frame.shape)), np.zeros((1, len(grid.P))))]
        by = np.array([slope[0][0, rows] for slope in slopes]).reshape(self.own, *frame.shape)
        sums = weight * np.array([np.full(frame.shape[1], len(frame)), frame.sum(0), (frame**2).sum(0)])
        cross = np.array([np.einsum("c,krc->ck", weight, by), np.einsum("c,rc,krc->ck", weight, frame, by)])
        numbers = np.einsum("c,krc,lrc->kl", weight, by, by)
        P = grid.P[rows]
        if forces:  # the gauge's error is one for all forces of a press
            P_by = np.array([np.mean(slope[1][0, rows][P > 0] / P[P > 0]) for slope in slopes]) / options.force_noise
            numbers += np.outer(P_by, P_by)
        if self.frictions:
            known = [n for n in self.frictions if n.presses[i]]
            numbers[-1, -1] += 1 / known[0].deviation**2 if known else 1
        return sums, cross, numbers

    def _total(self, chosen):
        """Gains' information [transducers], it with the numbers, and that on the numbers, with all else eliminated."""
        m, size = len(self.numbers), len(self.numbers) + (len(chosen) if self.frictions else 0)
        parts = [self.information[i] for i in chosen]
        sums = sum(part[0] for part in parts)
        cross, numbers = np.zeros((2, len(self.of), size)), np.zeros((size, size))
        for k, (_, of_cross, of_numbers) in enumerate(parts):
            place = [*range(m), *([m + k] if self.frictions else [])]
            cross[:, :, place] += of_cross
            numbers[np.ix_(place, place)] += of_numbers
        loaded = sums[0] > 0
        sums, cross = sums[:, loaded], cross[:, loaded]
        gain = WEAK + sums[2] - sums[1] ** 2 / sums[0]
        of_gain = cross[1] - (sums[1] / sums[0])[:, None] * cross[0]
        numbers += WEAK * np.eye(size) - (cross[0] / sums[0][:, None]).T @ cross[0] - (of_gain / gain[:, None]).T @ of_gain
        return loaded, gain, of_gain, numbers

    def _criterion(self, chosen):
        _, gain, _, numbers = self._total(chosen)
        m = len(self.numbers)
        told = np.linalg.slogdet(numbers)[1] - np.linalg.slogdet(numbers[m:, m:])[1]
        return np.log(gain).mean() + WEIGHT * told / max(m, 1)

    def _choose(self, count):
        chosen, free = [], set(range(len(self.information)))

        def exchange(place):
            kept = chosen[place]
            value, best = max((self._criterion(chosen[:place] + [i] + chosen[place + 1:]), i) for i in free | {kept})
            better = value > self._criterion(chosen) + 1e-9 * abs(value)
            if better:
                free.add(kept), free.discard(best)
                chosen[place] = best
            return better
        while len(chosen) < count:
            chosen.append(min(free))
            free.discard(chosen[-1])
            exchange(len(chosen) - 1)
        while any([exchange(place) for place in range(count)]):
            pass
        return sorted(chosen)

    def deviations(self, chosen):
        """Standard deviations to expect: of gains [transducers], relative, NaN: not pressed; of numbers by key; correlation."""
        loaded, gain, of_gain, numbers = self._total(chosen)
        covariance = np.linalg.inv(numbers)
        by, gains = of_gain / gain[:, None], np.full(len(self.of), math.nan)
        gains[loaded] = np.sqrt(1 / gain + np.einsum("ck,kl,cl->c", by, covariance, by))
        m = len(self.numbers)
        own = np.sqrt(np.diag(covariance)[:m])
        return gains, {n.key: float(d) for n, d in zip(self.numbers, own)}, covariance[:m, :m] / np.outer(own, own)

    def lost(self, options):
        """What no plan finds, or only badly with all candidates together."""
        gains, told, correlation = self.deviations(range(len(self.information)))
        said = [f"No candidate loads the {name} enough: its gain has a deviation of {100 * d:.0f} % with all of them." for name, d, noise in
                zip(self.of, gains, self.noise) if math.isfinite(noise) and not d < NEVER_FOUND]
        if "young" not in told:
            said.append("No plan finds sensor.young: it takes measured forces; gains are then those over E.")
        if not options.thickness:
            said.append("sensor.thickness is held: it and sensor.poisson change frames nearly alike, so measure it.")
        return said + [f"{self.numbers[j].name} and {self.numbers[k].name} are not told apart by all candidates (correlation {correlation[k, j]:.3f})."
                       for k, j in zip(*np.nonzero(np.tril(np.abs(correlation) > 0.98, -1)))]


# Candidates


def _dragged(scene, drag):
    thirds = [round(drag / 3, 3), round(drag * 2 / 3, 3), drag] if drag else []
    return scene.with_(load=scene.load.with_(tangential=thirds, tangential_step=0.0, tangential_steps=None, angle=None))


def varied(scene, position=None, indentation=None, normal_force=None, drag=None):
    """The scene at all of these places, depths or forces, and drags; None: as it is."""
    scenes = [indented(scene, position=x) for x in position] if position else [scene]
    if indentation:
        scenes = [s.with_(load=s.load.with_(indentation=[d], normal_force=[])) for s in scenes for d in indentation]
    if normal_force:
        scenes = [s.with_(load=s.load.with_(indentation=[], normal_force=[f])) for s in scenes for f in normal_force]
    return [_dragged(s, d) for s in scenes for d in drag] if drag else scenes


def usual_candidates(nominal):
    """Rods of radius 3, 6 and 15 mm, a flat of 4 mm and a wedge of 150 degrees, at 11 places, to two depths, without and with drags."""
    sensor = nominal.sensor.with_(mesh=None)
    deep, far = round(sensor.thickness * 2 / 15, 2), round(sensor.thickness * 0.08 / 1.5, 3)
    found = []
    for name, shape, half in [*((f"cylinder, radius {r}", Cylinder(float(r)), 0) for r in (3, 6, 15)), ("flat, half_width 2", Flat(2.0), 2),
                              ("wedge, edge_angle 150", Wedge(150.0), 0)]:
        span = sensor.length if sensor.tactel_span is None else sensor.tactel_span
        reach = min(span / 2, sensor.length / 2 - BESIDE - half)
        scene = Scene(sensor, shape, nominal.friction, Press(deep, steps=2))
        found += [Candidate(name, s) for s in varied(scene, [round(reach * k / 5, 1) for k in range(-5, 6)], [deep / 2, deep], None, [0, far, -far])]
    return found


def read_candidates(path, tactels):
    """Candidates, options and the text of [fit] and [transducer] of a list."""
    tables, found = read_tables(path), []
    options = read_fit(path, tables)
    for name, values in tables.items():
        if name in ("fit", "transducer"):
            continue
        table = Table(path, name, values)
        scene = read_scene(Path(path).parent / table.text("scene", "a scene file: indenter, friction, load and nominal sensor"))
        by = {key: table.numbers(key, f"{what}, or an array of them", one=True) for key, what in
              (("position", "mm along the array"), ("indentation", "a depth in mm"), ("normal_force", "a force in N/mm"), ("drag", "mm; 0: no drag"))}
        table.finish()
        if by["indentation"] and by["normal_force"]:
            table.refuse("normal_force", "given", "must be left out, because indentation is given too")
        if is_pad(scene) or scene.sensor.tactels != tactels:
            table.refuse("scene", "another sensor", f"must be a scene with the profile's {tactels} tactels")
        for one in varied(scene, **by):
            if not steps(one):
                table.refuse("scene", "a drag until sliding", "must have a drag with a number of steps: load.tangential, or drag in this table")
            try:
                one.validate()
            except ValueError as error:
                raise input_error(f"{path}: {name}: {error.place}", error.problem, error.fix) from None
            found.append(Candidate(name, one))
        same_sensor(path, name, scene, found[0].indenter, found[0].scene)
        if len(found) > MOST_CANDIDATES:
            raise input_error(f"{path}: {name}", f"{len(found)} candidates", f"must be at most {MOST_CANDIDATES} in all")
    if not found:
        raise input_error(f"{path}: press", "none", "must be at least one table of candidates: scene, position, indentation, drag")

    def text(table):
        lines = [f"{key} = {json.dumps(value)}" for key, value in tables.get(table, {}).items()]
        return "\n".join([f"[{table}]", *lines, ""]) if lines else ""
    return found, options, text("fit") + text("transducer")


# The command


def _rows(gains, told):
    """(name, key, value, unit) of the deviations."""
    half = len(gains) // 2
    return [("gain of normal stress, median", "normal_gain", np.nanmedian(gains[:half]), "%"), ("gain of shear stress, median", "shear_gain", np.nanmedian(gains[half:]), "%"),
            ("gain, worst transducer", "worst_gain", np.nanmax(gains), "%")] + [
        (name, key, told.get(key, math.nan), unit) for name, key, unit in
        (("sensor.young", "young", "%"), ("sensor.poisson", "poisson", ""), ("sensor.thickness", "thickness", " mm"), ("shift of the tactels", "shift", " mm"),
         ("transducer.time_constant", "time_constant", "%"))]


def _write_plan(path, chosen, fit_text, forces):
    path = Path(path)
    text = ("# Planned presses. Record each with tactel record, from before the first touch; then python -m tactel.calibrate sensor reads\n"
            "# this file. A press is a second at rest, then a second for each load step of its scene: move at begin, rest from end on.\n"
            "# Correct times, begin and end to what was done.\n" + fit_text)
    for i, press in enumerate(chosen):
        name = f"{path.stem}-{i + 1:02}"
        write_text(path.parent / f"{name}.toml", press.scene.with_(title=press.indenter).toml())
        begin, end, time = (json.dumps([round(float(t), 3) for t in part]) for part in press.timing)
        text += (f"\n[press-{i + 1:02}]  # {press.indenter} at {press.scene.indenter.position:g} mm\nscene = {json.dumps(name + '.toml')}\n"
                 f"recording = {json.dumps(name + '.tactel')}\ntimes = {time}\nbegin = {begin}\nend = {end}\nwindow = {WINDOW}\n")
        if forces:
            text += f"# P = [ ]  # N/mm: force over length of the indenter, measured at these {steps(press.scene)} times\n"
    write_text(path, text)


def plan_command(given, warn):
    profile = _tactel._read_profile(given.profile)
    if profile["pads"]:
        raise input_error(f"{given.profile}: pad", "given", "must be left out: plan serves lines; press a pad as docs/calibration.md says, and record that")
    tactels, options, fit_text = len(profile["channel"]) // 2, Options(), ""
    if given.candidates:
        candidates, options, fit_text = read_candidates(given.candidates, tactels)
    else:
        nominal = read_scene(given.scene) if given.scene else Scene(Sensor(tactels=tactels))
        if is_pad(nominal) or nominal.sensor.tactels != tactels:
            raise input_error(f"--scene: {given.scene}", "another sensor", f"must be a scene with the profile's {tactels} tactels")
        candidates = usual_candidates(nominal)
    noise = None
    if given.noise is None and profile["noise"]:
        of = [abs(profile["noise"][c] * profile["gain"][c]) if c >= 0 else math.nan for c in profile["channel"]]
        noise = [one if one > 0 else math.nan for one in of]
    elif given.noise is not None and not 0 < given.noise < math.inf:
        raise input_error("--noise", given.noise, "must be a number above 0")
    plan = Plan(candidates, given.presses, options, not given.without_force, noise, given.noise or 0.01)
    chosen, lost = [candidates[i] for i in plan.chosen], plan.lost(options)
    gains, told, _ = plan.deviations(plan.chosen)
    rows = _rows(gains, told)

    def null(value):
        return float(value) if math.isfinite(value) else None
    if given.output:
        _write_plan(given.output, chosen, fit_text, not given.without_force)
    if given.json:
        presses = [{"indenter": press.indenter, "P": plan.P[i], "position": press.scene.indenter.position, "scene": press.scene.toml()} for press, i in
                   zip(chosen, plan.chosen)]
        found = {"candidates": len(candidates), "presses": presses, "noise": [null(one) for one in plan.noise],
                 "planned": {**{key: null(value) for _, key, value, _ in rows}, "gain": [null(one) for one in gains]}, "lost": lost}
        write_text(given.json, json.dumps(found, indent=2) + "\n")
    if given.quiet:
        return 0
    if noise is None and given.noise is None:
        warn("noise is taken as 1 % of the largest stress: the profile's [calibration] has none")
    for i, (press, place) in enumerate(zip(chosen, plan.chosen)):
        load = press.scene.load
        depth = f"{load.normal_force[-1]:g} N/mm" if by_force(press.scene) else f"{load.indentation[-1]:g} mm"
        drag = f"{load.tangential[-1]:.4g} mm" if len(load.tangential) else "as in its scene" if load.tangential_step else "none"
        print(f"{i + 1:>3}  {press.indenter:<28} {press.scene.indenter.position:>6.4g} mm {depth:>10} {drag:>9} {plan.P[place]:>7.3g} N/mm")
    print("\nstandard deviation to expect")
    for name, _, value, unit in rows:
        if math.isfinite(value):
            print(f"{name:<32} {100 * value if unit == '%' else value:>8.2g}{unit}")
    print("\n".join(lost))
    if given.output:
        print(f"\n{given.output} and its scenes are written: record each press, and fill in P")
    return 0
