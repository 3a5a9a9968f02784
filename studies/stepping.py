#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What simulators feel of a contact that is pressed, dragged, twisted and slides: stepped contacts of tactel, springs with memory
at points, and the law of tactile images min(kt speed, mu p), beside the reference of the same scene.

Prints the tables of docs/stepping.md. With MuJoCo installed also its contact held under shear.
Usage: studies/stepping.py [--build build] [--check [--exact]]   --check: fails where the claims of the table do not hold, beside the
rung pad-24, in a tenth of the time; --exact: beside the reference, as the tables are. A minute."""
import sys
import time

import study

arguments = study.options(__doc__)
for option in ("--check", "--exact"):
    arguments.add_argument(option, action="store_true")
arguments = arguments.parse_args()
sys.path.insert(0, str(arguments.build.resolve() / "python"))
import numpy as np
import tactel

RADIUS, DEPTH, MU = 12.0, 0.5, 0.6
PAD = tactel.Pad(tactels=(4, 4), pitch=2.0, thickness=4.0, young=0.5, poisson=0.48)
DRAGS = [(0.05, 0), (0.1, 0), (0.15, 0), (0.2, 0), (0.2, 0), (0.2, 0), (0.2, 0), (0.2, 0), (0.3, 0.1), (0.4, 0.2), (0.6, 0.4), (0.8, 0.6)]
TWIST = [0, 0, 0, 0, 2, 4, 6, 8, 8, 8, 8, 8]  # degrees
POSES = np.array([(DEPTH, 0, 0, 0)] + [(DEPTH, *at, turn) for at, turn in zip(DRAGS, TWIST)])  # mm, degrees


def slip_index(x, y, grip, tx, ty):
    """S of tractions at points: the dual problem of fem/pad/slip_margin.h, by reweighted least squares."""
    wrench = np.array([tx.sum(), ty.sum(), (x * ty - y * tx).sum()])
    if not np.abs(wrench).max() > 1e-9 * grip.sum():
        return 0.0
    modes = np.stack([np.stack([0 * x + 1, 0 * x]), np.stack([0 * x, 0 * x + 1]), np.stack([-y, x])])  # [twist, xy, points]
    twist, least = wrench / (wrench @ wrench), np.inf
    for _ in range(100):
        speed = np.hypot(*np.tensordot(twist, modes, 1))
        least = min(least, (grip * speed).sum())
        weight = grip / np.maximum(speed, 1e-9 * speed.max())
        twist = np.linalg.solve(np.einsum("aip,bip,p", modes, modes, weight), wrench)
        twist /= twist @ wrench
    return 1 / least


class Points:
    """Points below the sphere, each with a pressure by its overlap and a traction by `law`, over [24, 24] points."""

    def __init__(self, reference):
        reach = np.sqrt(2 * RADIUS * DEPTH - DEPTH**2)
        i = (np.arange(24) - 11.5) * reach / 12
        self.x, self.y = (a.ravel() for a in np.meshgrid(i, i, indexing="ij"))
        overlap = np.maximum(0, DEPTH - (RADIUS - np.sqrt(RADIUS**2 - self.x**2 - self.y**2)))
        self.grip = MU * reference.P[0] * overlap / overlap.sum()  # N a point
        self.first = reference.Q[1, 0] / 0.05 / (overlap > 0).sum()  # N/mm: that the first drag gives

    def tractions(self, stiffness, memory, held=False):
        """Tractions of the points and whether they stick, step by step: springs with memory, or forces by the motion of the step alone."""
        tx, ty = 0 * self.x, 0 * self.x
        touches = self.grip > 0
        for change in np.diff(POSES, axis=0, prepend=POSES[:1]):
            turn = np.radians(change[3])
            dx, dy = (0, 0) if held else (stiffness * (change[1] - turn * self.y), stiffness * (change[2] + turn * self.x))
            tx, ty = memory * tx + dx, memory * ty + dy
            longer = np.maximum(np.hypot(tx, ty) / np.maximum(self.grip, 1e-30), 1)
            tx, ty = tx / longer * touches, ty / longer * touches
            yield tx, ty, longer[touches] <= 1

    def steps(self, stiffness, memory, held=False):
        """Q [steps, 2], S [steps] and the share that sticks."""
        answers = np.array([(tx.sum(), ty.sum(), slip_index(self.x, self.y, self.grip, tx, ty), sticks.mean())
                            for tx, ty, sticks in self.tractions(stiffness, memory, held)])
        return answers[:, :2], answers[:, 2], answers[:, 3]

    def fitted(self, memory, reference):
        """The same with the stiffness whose Q misses the reference least: better than any that is known beforehand."""
        def off(k):
            return max(np.abs((tx.sum() - Q[0], ty.sum() - Q[1])).max() for (tx, ty, _), Q in zip(self.tractions(k, memory), reference.Q))
        best = min(self.first * np.geomspace(0.3, 30, 40), key=off)
        return self.steps(best, memory)


def stepped(cells, reference):
    """By tactel: pressed in four steps, then one a pose."""
    width = np.ptp(reference.cell_x[reference.normal_force[0] > 0])
    steps = tactel.PadStepper(PAD, 1, MU, cells=cells, cell=1.12 * width / cells)
    steps.shapes(tactel.Sphere(RADIUS))
    for k in (1, 2, 3):
        steps.move([(k / 4 * DEPTH, 0, 0, 0)], travel=False)
    answers = []
    for pose in POSES:
        answer = steps.move([pose], travel=False)
        answers.append((answer.force[0, 1:3].copy(), answer.slip_index[0], answer.stick_fraction[0], answer.frames[0].copy()))
    return [np.array(a) for a in zip(*answers)]


def errors(reference, Q, S, stick, frames=None):
    shear = "not a layer"
    if frames is not None:
        truth = reference.frames[:, 16:] - reference.frames[:1, 16:]
        change = frames[:, 16:] - frames[:1, 16:]
        shear = f"{100 * np.sqrt(((change - truth)**2).sum() / (truth**2).sum()):.1f} %"
    P = reference.P[0]
    return (np.abs(S - reference.slip_index)[1:].max(), np.abs(stick - reference.stick_fraction)[1:].mean(),
            np.hypot(*(Q - reference.Q).T).max() / (MU * P), shear)


def mujoco_creep():
    """mm/s at which MuJoCo's contact creeps that is held at rest by 3 N under 0.9 N of shear; None without MuJoCo."""
    try:
        import mujoco
    except ImportError:
        return None
    model = mujoco.MjModel.from_xml_string("""<mujoco><option timestep=".002" gravity="0 0 0" cone="elliptic" impratio="10" integrator="implicitfast"/>
      <worldbody><geom type="plane" size="1 1 .1" friction="0.6 .005 .0001"/><body pos="0 0 .012"><freejoint/>
      <geom type="sphere" size=".012" mass=".05" friction="0.6 .005 .0001" solref=".004 1"/></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    model.dof_damping[3:] = 1  # it does not roll
    data.xfrc_applied[1, :3] = (0.9, 0, -3)
    for _ in range(1000):
        mujoco.mj_step(model, data)
    return 1e3 * data.qvel[0]


def speeds(contacts=256, ticks=20):
    """Contact-steps a processor second: by name, of smooth drags by force with four solves a step, and of springs in NumPy."""

    def rate(step):
        step(0)  # compiles
        begin = time.process_time()
        for tick in range(1, ticks + 1):
            step(tick)
        return contacts * ticks / (time.process_time() - begin)

    for cells in (8, 16):
        steps = tactel.PadStepper(PAD, contacts, MU, cells=cells, cell=10.5 / cells, most_solves=4)
        steps.shapes(tactel.Sphere(RADIUS))
        yield f"stepped, {cells} x {cells} cells", rate(lambda tick: steps.press([2.0, 0.04 * tick, 0.02 * tick, 0]))
    i = (np.arange(12) - 5.5) * 0.88
    x, y = (a.ravel() for a in np.meshgrid(i, i))
    gap, traction = np.tile(RADIUS - np.sqrt(RADIUS**2 - x**2 - y**2), (contacts, 1)), np.zeros((contacts, 144, 2))

    def springs(_):
        nonlocal traction
        traction = traction + [1e-4, 5e-5]
        most = MU * 0.02 * np.maximum(DEPTH - gap, 0)
        traction *= np.minimum(1, most / np.maximum(np.hypot(traction[..., 0], traction[..., 1]), 1e-12))[..., None]
    yield "springs with memory, 12 x 12 in NumPy", rate(springs)


load = tactel.Press(DEPTH).drag_to([tuple(map(float, at)) for at in DRAGS], [float(turn) for turn in TWIST])
scene = tactel.Scene(PAD, tactel.PadIndenter(tactel.Sphere(RADIUS)), friction=MU, load=load)
rough = arguments.check and not arguments.exact
reference = tactel.solve(scene, rung="pad-24", solver="twin") if rough else tactel.solve(scene, rung="reference")
points = Points(reference)
rows = {"stepped, 8 x 8 cells": errors(reference, *stepped(8, reference)),
        "stepped, 16 x 16 cells": errors(reference, *stepped(16, reference)),
        "springs with memory, fitted to this path": errors(reference, *points.fitted(1, reference)),
        "min(kt speed, mu p), fitted, while it moves": errors(reference, *points.fitted(0, reference)),
        "the same, held still": errors(reference, *points.steps(1, 0, held=True))}
print(study.head("model", "error of S", "stick fraction, mean error", "Q, over mu P", "change of base shear, rms"))
for name, (S, stick, Q, shear) in rows.items():
    print(study.row(name, f"{S:.3f}", f"{stick:.2f}", f"{Q:.3f}", shear))
for name, rate in [] if arguments.check else speeds():
    print(f"{name}: {rate / 1000:.0f} thousand contact-steps a processor second")
creep = mujoco_creep()
print("MuJoCo: not installed" if creep is None else f"MuJoCo, held under 0.9 of 3 N: creeps by {creep:.2f} mm/s")
if arguments.check:
    S = {name: numbers[0] for name, numbers in rows.items()}
    assert S["stepped, 8 x 8 cells"] < 0.015 and S["stepped, 16 x 16 cells"] < 0.006, S
    assert S["springs with memory, fitted to this path"] > 0.05 and S["min(kt speed, mu p), fitted, while it moves"] > 0.3, S
    assert S["the same, held still"] > 0.95, S
