#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Grippers in MuJoCo lift and shake boxes of unknown friction and mass; the skin of a finger sets their grip.

  pip install mujoco
  python examples/mujoco_grip.py [grippers]

Each tick tactel steps the contacts of all grippers at once, to the forces of MuJoCo. A network that was taught by stepped
frames reads S from 4 x 4 tactels without knowing mu, and the grip grows where S is high. Where the network is sure that a
box slides, shear over normal stress is its friction: a hand that remembers it needs less grip. A minute."""
import sys

import mujoco
import numpy as np
import tactel
import tactel.mujoco

PAD = tactel.Pad(tactels=(4, 4), pitch=2.0, thickness=4.0, young=2.0, poisson=0.48)
BALL = tactel.Sphere(radius=12.0)  # mm: the finger's curvature
GRIPPERS = int(sys.argv[1]) if len(sys.argv) > 1 else 48
random = np.random.default_rng(5)
MU, MASS = random.uniform(0.25, 1.0, GRIPPERS), random.uniform(0.1, 0.6, GRIPPERS)  # kg
LEAST = MASS * 9.81 / 2 / MU  # N: the grip below which a box falls
NOISE = 0.003  # of a frame's largest stress
SLIDES_FROM = 0.9  # what the network reads of a box that slides

SCENE = """<mujoco><option timestep="0.002" integrator="implicitfast" cone="elliptic" impratio="10"/><worldbody>
<body pos="0 0 .3"><joint name="lift" type="slide" axis="0 0 1" damping="50"/>
<geom type="box" size=".06 .02 .01" pos="0 0 .08" mass="1" contype="0" conaffinity="0"/>
<body pos="-.05 0 0"><joint name="l" type="slide" axis="1 0 0" damping="5"/><geom name="pad" type="sphere" size=".012"
mass=".05" friction="{mu} .003 .0001" condim="4" solref=".004 1"/><site name="pad" xyaxes="0 1 0 0 0 1"/></body>
<body pos=".05 0 0"><joint name="r" type="slide" axis="-1 0 0" damping="5"/><geom type="sphere" size=".012" mass=".05"
friction="{mu} .003 .0001" condim="4" solref=".004 1"/></body></body>
<body name="box" pos="0 0 .3"><freejoint/><geom type="box" size=".02 .03 .04" mass="{mass}" friction="{mu} .003 .0001"
condim="4"/></body><geom type="plane" size="1 1 .1" pos="0 0 .26" friction="1 .003 .0001"/></worldbody>
<actuator><motor joint="l"/><motor joint="r"/><position joint="lift" kp="2000" kv="200"/></actuator></mujoco>"""


GRID = {"cells": 12, "cell": 0.88, "most_solves": 6}


def learn(count=1500, ticks=50):
    """A network that reads S, taught by stepped frames of contacts that wander and slide."""
    mu = random.uniform(0.2, 1.2, count)
    steps = tactel.PadStepper(PAD, count, mu, **GRID)
    steps.shapes(BALL)
    P0, (f, phase) = np.exp(random.uniform(np.log(0.8), np.log(14), count)), (random.uniform(0.3, 2, (4, count)), random.uniform(0, 6, (4, count)))
    frames, S = [], []
    for k in range(-2, ticks):
        wave = np.sin(2 * np.pi * f * max(k, 0) / 50 + phase) * (k >= 0)
        P = P0 * (1 + 0.25 * wave[0])
        Q, angle = 1.02 * mu * P * wave[1], phase[2] + 0.6 * wave[2]
        out = steps.press(np.stack([P, Q * np.cos(angle), Q * np.sin(angle), 0.3 * Q * wave[3]], 1))
        if k >= 0:
            frames.append(out.frames.copy()), S.append(np.minimum(out.slip_index, 1))
    frames, S = np.concatenate(frames), np.concatenate(S)
    network, = tactel.train(tactel.Set(frames, S), layers="48-64-32-1_leaky-relu", schedule="cosine", scaling="frame", noise=NOISE, cycles=100)
    print(f"learnt from {len(S)} stepped frames: error of S {np.median(np.abs(network(frames) - S)):.3f} (median)")
    return network


class Remembered:
    """S of frames by the network, and by the friction of each box as soon as it has shown it by sliding."""

    def __init__(self, network):
        self.network, self.mu = network, np.full(GRIPPERS, np.nan)

    def __call__(self, frames):
        S = self.network(frames)
        normal, x, y = frames.reshape(-1, 3, 16).sum(2).T
        ratio = np.hypot(x, y) / np.maximum(-normal, 1e-9)
        self.mu = np.where(S > SLIDES_FROM, np.fmax(self.mu, ratio), self.mu)
        return np.where(np.isnan(self.mu), S, np.minimum(ratio / self.mu, 1))


def held(control, read=None):
    """Grippers that still hold their box after lift and shake, and their grip over the least."""
    models = [mujoco.MjModel.from_xml_string(SCENE.format(mu=mu, mass=mass)) for mu, mass in zip(MU, MASS)]
    worlds = [mujoco.MjData(model) for model in models]
    skin = tactel.mujoco.Skin(models[0], {"pad": "pad"}, PAD, MU, BALL, worlds=GRIPPERS, **GRID)
    grip = np.full(GRIPPERS, control if read is None and control else 2.0)
    for tick in range(1300):
        t = 0.002 * tick
        height = 0 if t < 0.6 else min(0.1, 0.25 * (t - 0.6)) + (0.015 * np.sin(6 * np.pi * (t - 1.2)) if t > 1.2 else 0)
        for model, world, force in zip(models, worlds, grip):
            world.ctrl[:] = force, force, height
            mujoco.mj_step(model, world)
        if tick % 5 or t < 0.3 or control:
            continue
        wrench = skin.wrench(worlds)
        out = skin.press(wrench)
        frames = out.frames + NOISE * np.abs(out.frames).max(1, keepdims=True) * random.standard_normal(out.frames.shape)
        S = np.where(wrench[:, 0] > 0.05, out.slip_index if read is None else np.ravel(read(frames)), 0)
        aim = 0.5 if isinstance(read, tactel.Network) else 0.6  # what a network reads errs by a tenth
        grip = np.clip(grip * (1 + 0.5 * np.maximum(0, S - aim) - 0.02 * np.maximum(0, aim - 0.1 - S)), 0.3, 30)
    fell = np.array([w.joint("lift").qpos[0] - (w.body("box").xpos[2] - 0.3) for w in worlds])
    stays = fell < 0.005  # m
    return stays.sum(), np.median((grip / LEAST)[stays]) if stays.any() else 0.0


read = learn()
for name, control, reader in (("4 N", 4.0, None), ("10 N", 10.0, None), ("by the true S", None, None), ("by a network", None, read), ("by a network that remembers friction", None, Remembered(read))):
    count, over = held(control, reader)
    print(f"grip {name}: holds {count} of {GRIPPERS} boxes at {over:.1f} times the least grip (median)")
