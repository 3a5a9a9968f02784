#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A vector environment of gymnasium: fingers hold things that shake, feel their tactels and choose their grip.

  pip install gymnasium
  python examples/gymnasium_grip.py

One call of tactel steps all contacts; those that slipped begin anew by a mask. Friction and weight are unknown to the agent.
An environment can be copied and pickled, and goes on with the same bits."""
import time

import gymnasium
import numpy as np
import tactel

PAD = tactel.Pad(tactels=(4, 4), pitch=2.0, thickness=4.0, young=2.0, poisson=0.48)


class GripVector(gymnasium.vector.VectorEnv):
    """Observation [envs, 48]: frames, MPa. Action [envs, 1]: change of the grip, -1 to 1, of 10 % a step. Reward: less for more
    grip, -10 for a slip, which ends an episode; a new one begins in the next step, or by reset(options={"reset_mask": [envs] bool})."""

    metadata = {"autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}

    def __init__(self, num_envs=256, episode=200):
        self.num_envs, self.episode = num_envs, episode
        self.single_observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (48,), np.float32)
        self.single_action_space = gymnasium.spaces.Box(-1, 1, (1,), np.float32)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)
        self.steps = tactel.PadStepper(PAD, num_envs, 0.5, cells=12, cell=0.88, most_solves=6)
        self.steps.shapes(tactel.Sphere(12.0))
        self.over = np.ones(num_envs, bool)
        self.age, self.mu, self.weight, self.pace, self.grip = np.zeros((5, num_envs))

    def begin(self, which):
        """New friction, weight (N) and pace (rad a step), held by little more than the weight at rest takes."""
        count = which.sum()
        self.mu[which], self.weight[which] = self.np_random.uniform(0.25, 1, count), self.np_random.uniform(0.5, 3, count)
        self.pace[which], self.age[which] = self.np_random.uniform(0.05, 0.3, count), 0
        self.grip[which] = 1.2 * self.weight[which] / self.mu[which]
        self.steps.set_friction(self.mu)
        self.steps.reset(which)

    def press(self, which=None):
        load = self.weight * (1 + 0.5 * np.sin(self.pace * self.age)) * (self.age > 0)  # first the grip alone
        return self.steps.press(np.stack([self.grip, 0 * load, -load, 0 * load], 1), mask=which)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        which = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, bool)))
        self.begin(which)
        self.over[which] = False
        return self.press(which).frames.copy(), {}

    def step(self, actions):
        began = self.over.copy()
        self.grip = np.where(began, self.grip, np.clip(self.grip * (1 + 0.1 * np.clip(actions[:, 0], -1, 1)), 0.3, 30))
        self.age += 1
        if began.any():
            self.begin(began)
        out = self.press()
        slipped = ((out.flags & self.steps.SLIDES) != 0) & ~began
        ended = (self.age >= self.episode) & ~slipped & ~began
        reward = np.where(began, 0, -0.01 * self.grip - 10 * slipped)
        self.over = slipped | ended
        return out.frames.copy(), reward, slipped, ended, {"slip_index": out.slip_index.copy()}


if __name__ == "__main__":
    for name, policy in (("never changes its grip", lambda S: 0 * S), ("sees S, aims at 0.6", lambda S: 8 * (S - 0.6))):
        envs = GripVector()
        envs.reset(seed=1)
        S, total, slips, start = np.zeros(envs.num_envs), 0.0, 0, time.perf_counter()
        for _ in range(400):
            _, reward, slipped, _, info = envs.step(np.clip(policy(S), -1, 1)[:, None])
            S, total, slips = info["slip_index"], total + reward.sum(), slips + slipped.sum()
        steps, seconds = 400 * envs.num_envs, time.perf_counter() - start
        print(f"who {name}: reward {total / steps:.3f} a step, {slips} slips in {steps} steps, {steps / seconds:.0f} steps a second")
