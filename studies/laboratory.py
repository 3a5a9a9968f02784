# SPDX-License-Identifier: Apache-2.0
"""A virtual laboratory of grips, with nothing of tactel in it: two pads of 4 x 4 tactels hold a rigid object.

A pad is 8 x 8 cells of rubber on springs that pull at their neighbours, with Coulomb friction that falls with speed, and creep. The object
(box, uneven box, ball, cylinder, edge, half a face) has mass and inertia; the hand's force and acceleration are a script, of thirteen
scenes. The transducers have gains, crosstalk, creep, hysteresis, noise, repeated and lost rows, and spikes. NumPy; all grips at once.
Units: mm, N, MPa, s, kg. Arrays: [grips, pads, axes, rows, columns]; pad 2 is the mirror image of pad 1."""
import dataclasses

import numpy as np

SIDE, CELLS, LENGTH, RATE, STEPS = 4, 8, 18.8, 60, 12  # tactels, cells a side; mm; Hz; steps of the object a frame
AREA, GRAVITY = (LENGTH / CELLS)**2, 9.81
SCENES = ("quiet", "moves", "walk", "squeeze", "weights_hold", "regrip_hold", "weights_slip", "jerk_slip", "relax_slip", "turn_slip",
          "slow_slip", "regrip_slip", "pull_slip")
OBJECTS = ("box", "uneven", "ball", "cylinder", "edge", "half")
CENTRES = (np.arange(CELLS) + 0.5) * LENGTH / CELLS - LENGTH / 2
Y, X = np.meshgrid(CENTRES, CENTRES, indexing="ij")
MIRROR = np.array([1.0, -1.0])[:, None, None]


class Random(np.random.Generator):
    def __init__(self, *seed):
        super().__init__(np.random.PCG64(seed))

    def log(self, low, high, size=None):
        return np.exp(self.uniform(np.log(low), np.log(high), size))


def draw_pads(random):
    """Rubber and transducers of two pads: [2], or [2, tactels, axes]."""
    thickness, shear = random.uniform(2.5, 5, 2), random.log(0.1, 0.5, 2)
    gain = np.exp(random.normal(0, 0.1, (2, SIDE**2, 3))) * random.log(15000, 40000, (2, 1, 1))
    gain[..., :2] *= random.log(0.4, 2.5, (2, 1, 1))  # nobody knows how much a count of shear is worth
    rubber = dict(thickness=thickness, kt=shear / thickness, kn=random.uniform(2.5, 8, 2) * shear / thickness,
                  reach=random.uniform(0.25, 0.5, 2) * thickness, tilt=random.normal(0, 0.3, 2))
    senses = dict(gain=gain, mix=np.eye(3) + random.normal(0, 0.03, (2, SIDE**2, 3, 3)), spread=random.uniform(0.02, 0.12, 2),
                  tip=random.uniform(0.15, 0.5, 2), near=random.uniform(0, 0.05, 2), play=0.03 * random.log(0.003, 0.02, 2),
                  creep=random.uniform([0.01, 0.01, 0], [0.04, 0.05, 0.05], (2, 3)), time=np.array([0.4, 4, 40]) * random.log(0.6, 1.6, (2, 3)))
    wire = dict(zero=np.array([16000, 16400, 37300]) + random.normal(0, 300, (2, SIDE**2, 3)), repeats=random.uniform(0.04, 0.1),
                noise=np.array([1.5, 1.5, 4]) * random.log(0.7, 1.5, (2, 3)), lost=random.uniform(0, 0.02) * random.integers(2),
                spikes=random.log(1e-4, 2e-3) * (random.random() < 0.3))
    return rubber | senses | wire


@dataclasses.dataclass
class Grip:
    """What a hand does to an object, and after simulate() what was read."""
    seed: int
    number: int
    scene: str
    shape: str
    pads: dict
    friction: dict
    face: dict
    hold_at: float  # s: the object is lifted
    force: np.ndarray  # [frames] N on each pad
    mass: np.ndarray  # [frames] kg that the pads carry
    acceleration: np.ndarray  # [frames, 2] m / s^2 of the hand, less gravity
    pull: np.ndarray  # [frames, 2] N
    centre: np.ndarray  # [2] mm, of mass
    size: float  # mm, radius of gyration
    open_from: float = np.inf  # s, of a second grip
    open_to: float = np.inf
    time: np.ndarray = None  # [rows] s; lost rows are absent
    counts: np.ndarray = None  # [rows, pads, tactels, 3]
    slip: np.ndarray = None  # [rows, pads] mm, rms of the touching cells since the object was lifted
    load: np.ndarray = None  # [rows] sum of shear over its limit

    @property
    def name(self):
        return f"seed {self.seed}, grip {self.number}"


def smooth(time, start, duration):
    x = np.clip((time - start) / duration, 0, 1)
    return x * x * (3 - 2 * x)


def draw_face(shape, random):
    radius = {"ball": random.uniform(20, 70), "cylinder": random.uniform(10, 60), "edge": random.uniform(1.5, 4)}.get(shape, 0)
    rough = random.log(0.015, 0.08) if shape == "uneven" else random.log(0.001, 0.01)
    angle, number = random.uniform(0, 2 * np.pi, (2, 6)), 2 * np.pi / (random.log(3, 20) * random.log(0.7, 1.4, (2, 6)))
    waves = [np.full((2, 6), rough / np.sqrt(3)), number * np.cos(angle), number * np.sin(angle), random.uniform(0, 2 * np.pi, (2, 6))]
    return dict(radius=radius, turn=random.uniform(0, np.pi), offset=random.uniform(-2, 5, 2), slope=random.normal(0, 0.002, (2, 2)),
                waves=np.stack(waves))


def draw_friction(random):
    return dict(mu=random.log(0.3, 1.4), kinetic=random.uniform(0.7, 1), speed=random.log(0.2, 10),
                cells=np.exp(random.normal(0, 0.08, (2, CELLS, CELLS))))


class Script:
    """What a hand does with time: still for a second, press, lift, hold, and then the scene. Loads are shares of 2 mu P, the limit."""

    def __init__(self, random, scene, force, limit, weight=None):
        self.random, self.limit, self.open = random, limit, (np.inf, np.inf)
        self.time = time = np.arange(int(random.uniform(9, 13) * RATE)) / RATE
        press, self.lift = random.uniform(0.15, 0.5), random.uniform(0.15, 0.6)
        lift_at = 1 + press + (random.uniform(0.4, 1) if random.random() < 0.6 else random.uniform(0, 0.1))
        self.hold_at = lift_at + self.lift
        self.event, self.lasts = self.hold_at + random.uniform(1.2, 2.5), random.uniform(0.4, 3)
        self.over, self.safe = random.uniform(1.08, 1.5), random.uniform(0.4, 0.8)  # loads that slip, and that hold
        self.weight = weight or random.uniform(0.12, min(0.5, 0.95 * self.safe))
        down = random.normal(-np.pi / 2, 0.15) if random.random() < 0.8 else random.uniform(0, 2 * np.pi)
        way = random.uniform(0, 2 * np.pi)
        self.down, self.way = (np.array([np.cos(angle), np.sin(angle)]) for angle in (down, way))
        self.room = max(0.3, (self.safe - self.weight) / self.weight * GRAVITY)  # m / s^2 that a hold bears
        eases = random.uniform(0, 0.08) * (1 - np.exp(-np.maximum(time - 1 - press, 0) / random.log(0.3, 4)))
        self.force = force * smooth(time, 1, press) * (1 - eases)
        self.load = self.weight * smooth(time, lift_at, self.lift)
        self.pull = np.zeros((len(time), 2))
        self.acceleration = -random.uniform(0.5, 1) * np.sin(2 * np.pi * np.clip((time - lift_at) / self.lift, 0, 1))[:, None] * self.down
        getattr(self, scene)()
        fast = np.sin(2 * np.pi * random.log(5, 12) * time[:, None] * [1, 1.13] + random.uniform(0, 6, 2) + 3 * np.sin(time)[:, None])
        self.acceleration += (time > lift_at)[:, None] * random.log(0.02, 0.2) * fast
        self.force *= 1 + random.log(0.001, 0.008) * (0.5 * random.normal(0, 1, len(time)) + np.sin(np.pi * time))

    def pulse(self, start, width):
        return np.sin(np.pi * np.clip((self.time - start) / width, 0, 1))[:, None]

    def quiet(self):
        pass

    def moves(self):
        at = self.hold_at + self.random.uniform(0.6, 1.2)
        while at < self.time[-1] - 1:
            width = self.random.uniform(0.1, 0.8)
            self.acceleration += self.room * self.random.uniform(-1, 1) * self.pulse(at, width) * self.way
            at += width + self.random.uniform(0.1, 1)

    def walk(self):
        time, size = self.time, min(self.random.log(0.3, 3), 0.6 * self.room)
        swing = np.sin(2 * np.pi * self.random.log(5, 25) * time) * (0.6 + 0.4 * np.sin(2 * np.pi * 1.8 * time))
        self.acceleration += (size * smooth(time, self.event, 0.5) * swing)[:, None] * self.way

    def squeeze(self):
        change = max(self.random.uniform(0.1, 0.4) * self.random.choice([1, -0.7]), self.weight / self.safe - 1)
        ramp = self.random.uniform(0.2, 0.8)
        self.force *= 1 + change * (smooth(self.time, self.event, ramp) - smooth(self.time, self.event + ramp + 1, ramp))

    def weights(self, most):
        at = self.event
        for share in self.random.dirichlet(np.ones(self.random.integers(3, 7))):
            self.load += share * (most - self.weight) * smooth(self.time, at, 0.05)
            at = min(at + self.random.uniform(0.15, 0.6), self.time[-1] - 1.2)

    def weights_hold(self):
        self.weights(self.safe)

    def weights_slip(self):
        self.weights(self.over)

    def jerk_slip(self):
        most = (self.over / self.weight - 0.3) * 1.15 * GRAVITY
        self.acceleration -= most * self.pulse(self.event, min(self.lasts, 1)) * self.down

    def relax(self, start, lasts):
        self.force *= 1 - (1 - self.weight / self.over) * smooth(self.time, start, lasts)

    def relax_slip(self):
        self.relax(self.event, self.lasts)

    def turn_slip(self):
        self.force *= 1 - 0.9 * min(1, 1 - 0.3 * self.weight) * smooth(self.time, self.event, 2 * self.lasts)

    def slow_slip(self):
        self.load *= 1 + (0.97 * self.over / self.weight - 1) * smooth(self.time, self.event, 4)

    def regrip(self):
        at, time = self.hold_at + self.random.uniform(1, 1.8), self.time
        self.open = at, at + 1.25 + self.lift
        self.force *= 1 - smooth(time, at, 0.25) * (1 - smooth(time, at + 0.6, 0.3))
        again = self.weight * (1 - smooth(time, at, 0.25) + smooth(time, at + 1.25, self.lift))
        self.load = np.where(time < at, self.load, again)

    def regrip_hold(self):
        self.regrip()

    def regrip_slip(self):
        self.regrip()
        self.relax(self.open[1] + 1.2, self.lasts)

    def pull_slip(self):
        self.pull = (self.over + self.weight) * self.limit * smooth(self.time, self.event, self.lasts)[:, None] * self.way

    def tremble(self, slips):
        """As a hand: five tones, and it tightens as something happens."""
        random, time = self.random, self.time
        speed, size = np.r_[random.log(0.2, 2, 3), random.log(4, 12, 2)], random.log(0.004, 0.07, 5)
        self.force *= 1 + (size * np.sin(2 * np.pi * np.outer(time, speed) + random.uniform(0, 6, 5))).sum(1) * (time > 1)
        tighter = (random.log(1.1, 6) - 1) * (0.25 if slips else 1)
        self.force *= 1 + tighter * smooth(time, self.event + random.uniform(-0.4, 0.3), random.log(0.1, 0.8))


def draw_grip(seed, number, scene, shape, pads, like=None, hands=False):
    """A grip of a scene. like: the same object a second time, its friction moved by 7 %, the force by 0.6 to 1.6."""
    random = Random(seed, number)
    friction, face = draw_friction(random), draw_face(shape, random)
    force = random.log(4, 20) * (0.6 if shape in ("ball", "edge") else 1)
    if like is not None:
        friction, face = dict(like.friction, mu=like.friction["mu"] * np.exp(random.normal(0, 0.07))), like.face
        force = like.force.max() * random.log(0.6, 1.6)
    limit = 2 * friction["mu"] * force
    script = Script(random, scene, force, limit, 0.45 if number == 0 else random.uniform(0.6, 0.8) if scene == "slow_slip" else None)
    if hands:
        script.tremble(scene.endswith("slip"))
    aside = np.array([-script.down[1], script.down[0]]) * random.choice([-1, 1])
    centre = aside * random.uniform(5, 12) if scene == "turn_slip" else random.normal(0, 1, 2)
    return Grip(seed, number, scene, shape, pads, friction, face, script.hold_at, np.maximum(script.force, 0), script.load * limit / GRAVITY,
                script.acceleration - GRAVITY * script.down, script.pull, centre, random.uniform(20, 50), *script.open)


def draw_seed(seed, hands=False):
    """Fourteen grips of one pair of pads: a box that is held and moved, to record, then the thirteen scenes."""
    pads = draw_pads(Random(seed, 1000))
    grips = [draw_grip(seed, 0, "moves", "box", pads)]
    shapes = [OBJECTS[(k + seed) % len(OBJECTS)] for k in range(len(SCENES))]
    return grips + [draw_grip(seed, k + 1, *which, pads, hands=hands) for k, which in enumerate(zip(SCENES, shapes))]


def draw_pairs(seed):
    """Twenty-six grips of one pair of pads: each object twice, first until it slides."""
    pads, random, grips = draw_pads(Random(seed, 1001)), Random(seed, 1002), []
    for k, scene in enumerate(SCENES):
        slide = draw_grip(seed, 100 + 2 * k, random.choice(["pull_slip", "weights_slip"]), OBJECTS[random.integers(len(OBJECTS))], pads)
        grips += [slide, draw_grip(seed, 101 + 2 * k, scene, slide.shape, pads, like=slide)]
    return grips


def around(a):
    """Sum of the neighbours of each cell."""
    total = np.zeros_like(a)
    total[..., 1:, :] += a[..., :-1, :]
    total[..., :-1, :] += a[..., 1:, :]
    total[..., :, 1:] += a[..., :, :-1]
    total[..., :, :-1] += a[..., :, 1:]
    return total


NEIGHBOURS = around(np.ones((CELLS, CELLS)))


class Hand:
    """All grips at once. Arrays begin with [grips], most with [grips, pads]."""

    def __init__(self, grips):
        self.grips, count = grips, len(grips)
        of_pads = lambda key: np.array([grip.pads[key] for grip in grips])
        self.kt, self.kn, self.thickness = (of_pads(key)[:, :, None, None] for key in ("kt", "kn", "thickness"))
        self.lateral = self.kt * of_pads("reach")[:, :, None, None]**2 / AREA
        self.normal_lateral = np.minimum(0.18, 0.25 * of_pads("reach")[:, :, None, None]**2 / AREA)
        self.tilt = np.array([grip.pads["tilt"] for grip in grips])
        of_friction = lambda key: np.array([grip.friction[key] for grip in grips])[:, None, None, None]
        self.mu = of_friction("mu") * np.array([grip.friction["cells"] for grip in grips])
        self.kinetic, self.speed = of_friction("kinetic"), of_friction("speed")
        self.stiffness = (self.kt[:, :, 0, 0] * LENGTH**2).sum(1)  # N / mm
        self.place, self.velocity = np.zeros((count, 3)), np.zeros((count, 3))  # mm, mm, radians
        self.u, self.slid, self.q = (np.zeros((count, 2, 2, CELLS, CELLS)) for _ in range(3))
        self.crept = np.zeros((2, count, 2, 2, CELLS, CELLS))
        self.sliding = np.zeros((count, 2, CELLS, CELLS))  # mm / s
        self.size, self.centre = np.array([grip.size for grip in grips]), np.array([grip.centre for grip in grips])
        face = lambda key: np.array([grip.face[key] for grip in grips])
        self.radius, self.turn, self.offset, self.slope, self.waves = (face(key) for key in ("radius", "turn", "offset", "slope", "waves"))
        self.shape = np.array([grip.shape for grip in grips])

    def gap(self):
        """mm [grips, pads, cells] between pad and face, where they just meet."""
        place = self.place[:, :, None, None, None]
        turn, x, y = place[:, 2] * MIRROR, X - MIRROR * place[:, 0], Y - place[:, 1]
        x, y = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
        across = MIRROR * -np.sin(self.turn)[:, None, None, None] * x + np.cos(self.turn)[:, None, None, None] * y
        size, kx, ky, phase = (self.waves[:, k, :, :, None, None] for k in range(4))
        gap = (size * np.cos(kx * x[:, :, None] + ky * y[:, :, None] + phase)).sum(2)
        gap += self.slope[:, :, 0, None, None] * x + self.slope[:, :, 1, None, None] * y
        net = (self.q * AREA).sum((3, 4))  # N: a finger that yields turns
        lever = 2 * self.tilt[:, None, :] * net / (self.kn[..., 0] * LENGTH**3) * MIRROR[:, :, 0]
        gap -= lever[..., 0, None, None] * X + lever[..., 1, None, None] * Y
        is_shape = lambda name: (self.shape == name)[:, None, None, None]
        radius = np.maximum(self.radius, 1e-9)[:, None, None, None]
        gap += np.where(is_shape("ball"), (x**2 + y**2) / 2 / radius, 0) + np.where(is_shape("cylinder"), across**2 / 2 / radius, 0)
        outside = (is_shape("edge") & (np.abs(across) > radius)) | (is_shape("half") & (across > self.offset[:, :, None, None]))
        return gap + np.where(outside, 1e9, 0)

    def press(self, force):
        """Pressure MPa [grips, pads, cells] of a force N [grips]."""
        gap, force = self.gap(), force[:, None, None, None]
        low = gap.min((2, 3), keepdims=True)
        high = low + force / (self.kn * AREA) + 1e-6
        for _ in range(30):
            middle = (low + high) / 2
            less = (self.kn * np.maximum(middle - gap, 0)).sum((2, 3), keepdims=True) * AREA < force
            low, high = np.where(less, middle, low), np.where(less, high, middle)
        pressure = self.kn * np.maximum(high - gap, 0)
        for _ in range(2):
            pressure = pressure + self.normal_lateral * (around(pressure) - NEIGHBOURS * pressure)
        total = pressure.sum((2, 3), keepdims=True) * AREA
        self.pressure = np.where(force > 1e-3, pressure * force / np.maximum(total, 1e-9), 0)

    def step(self, mass, outside, held, crept, dt):
        """Moves the object by dt under forces outside [grips, 3] N, N, N mm, and the rubber with it, which has crept."""
        place = self.place[:, :, None, None, None]
        moved = np.stack([MIRROR * (place[:, 0] - place[:, 2] * Y), place[:, 1] + MIRROR * place[:, 2] * X], 2)
        stiff, pulled = (self.kt + self.lateral * NEIGHBOURS)[:, :, None], self.lateral[:, :, None] * around(self.u)
        moved = moved - crept
        q = stiff * (moved - self.slid) - pulled
        slow = self.kinetic + (1 - self.kinetic) * np.exp(-self.sliding / self.speed)
        size, limit = np.sqrt((q**2).sum(2)), self.mu * slow * self.pressure
        slips = size > limit
        self.q = q * np.where(slips, limit / np.maximum(size, 1e-12), 1)[:, :, None]
        self.u = (self.q + pulled) / stiff
        slid = moved - self.u
        speed = np.where(slips & (self.pressure > 0), np.sqrt(((slid - self.slid)**2).sum(2)) / dt, 0)
        self.slid, self.sliding = slid, 0.7 * self.sliding + 0.3 * speed
        fx, fy = MIRROR * self.q[:, :, 0], self.q[:, :, 1]
        force = np.stack([fx.sum((1, 2, 3)), fy.sum((1, 2, 3)), (MIRROR * X * fy - Y * fx).sum((1, 2, 3))], 1) * AREA
        touching = self.pressure > 0
        stuck = (touching & ~slips).sum((1, 2, 3)) / np.maximum(touching.sum((1, 2, 3)), 1)
        viscous = 0.3 * np.sqrt(self.stiffness * 1000 * mass) / 1000 * np.maximum(stuck, 0.02)
        inertia = np.stack([mass, mass, mass * (self.size**2 + (self.centre**2).sum(1))], 1)
        self.velocity += dt * 1000 * (outside - force - viscous[:, None] * [1, 1, 60] * self.velocity) / inertia
        gone = (np.abs(self.place[:, :2]).max(1) > 12) | (np.abs(self.place[:, 2]) > 0.6)
        self.velocity[~held | gone] = 0
        self.place += dt * self.velocity

    def frame(self, k):
        at = lambda values: np.array([v[min(k, len(v) - 1)] for v in values])
        dt, weight = 1 / RATE / STEPS, at([grip.mass for grip in self.grips])
        hand, pull = at([grip.acceleration for grip in self.grips]), at([grip.pull for grip in self.grips])
        mass = np.maximum(np.maximum(weight, 0.03), self.stiffness * 1000 * (2 * dt)**2)  # as light as the step lets it be
        self.press(at([grip.force for grip in self.grips]))
        crept = self.crept.sum(0)
        for _ in range(STEPS):
            c, s = np.cos(self.place[:, 2]), np.sin(self.place[:, 2])
            arm = np.stack([self.centre[:, 0] * c - self.centre[:, 1] * s, self.centre[:, 0] * s + self.centre[:, 1] * c], 1)
            load = -weight[:, None] * hand
            outside = np.column_stack([load + pull, arm[:, 0] * load[:, 1] - arm[:, 1] * load[:, 0]])
            self.step(mass, outside, (weight > 1e-6) | (np.abs(pull).sum(1) > 0), crept, dt)
        for b, (part, time) in enumerate(((0.05, 0.4), (0.05, 7))):
            self.crept[b] += (1 - np.exp(-1 / RATE / time)) * (part * self.q / self.kt[:, :, None] - self.crept[b])


class Readings:
    """What the transducers of all grips say of the stresses of their cells."""

    def __init__(self, hand):
        pads = [grip.pads for grip in hand.grips]
        of = lambda key: np.array([pad[key] for pad in pads])
        self.gain, self.mix, self.creep, self.time = of("gain"), of("mix"), of("creep"), of("time")
        self.spread, self.tip, self.near, self.play = (of(key)[:, :, None, None] for key in ("spread", "tip", "near", "play"))
        self.thickness = hand.thickness
        distance = (CENTRES[:, None] - CENTRES) / (0.4 * of("thickness")[:, :, None, None])
        blur = np.exp(-0.5 * distance**2)
        self.blur = (blur / blur.sum(-1, keepdims=True))[:, :, None]
        self.memory, self.last = np.zeros((3, len(pads), 2, SIDE**2, 3)), np.zeros((len(pads), 2, SIDE**2, 3))

    def next(self, hand):
        """Counts [grips, pads, tactels, 3] less the zero, without noise."""
        fields = self.blur @ np.concatenate([hand.q, hand.pressure[:, :, None]], 2) @ self.blur.swapaxes(3, 4)
        slope = lambda a, axis: np.gradient(a, LENGTH / CELLS, axis=axis)
        x, y, z = np.moveaxis(fields, 2, 0)
        lift, outward = slope(x, 3) + slope(y, 2), self.spread * self.thickness
        seen = np.stack([x - outward * slope(z, 3), y - outward * slope(z, 2), z - self.tip * lift], 2)
        tactels = seen.reshape(*seen.shape[:3], SIDE, CELLS // SIDE, SIDE, CELLS // SIDE).mean((4, 6))
        count = around(np.ones((SIDE, SIDE)))
        own = np.moveaxis(tactels, 2, -1).reshape(len(seen), 2, SIDE**2, 3)
        near = np.moveaxis(around(tactels) / count, 2, -1).reshape(own.shape)
        value = np.einsum("gptab,gptb->gpta", self.mix, own) + self.near * (near - own)
        for k in range(3):
            fades = 1 - np.exp(-1 / RATE / self.time[:, :, k])[..., None, None]
            self.memory[k] += fades * (self.creep[:, :, k, None, None] * value - self.memory[k])
        value = value + self.memory.sum(0)
        self.last = np.clip(self.last, value - self.play, value + self.play)  # hysteresis
        return self.gain * (value + self.last) / 2


def spoil(grip, counts):
    """Adds zero, noise, drift, spikes and repeated rows; returns counts and the rows that arrive."""
    random, pads = Random(grip.seed, grip.number, 7), grip.pads
    counts = pads["zero"] + counts + random.normal(0, 1, counts.shape) * pads["noise"][:, None]
    counts += random.normal(0, 0.5) * np.arange(len(counts))[:, None, None, None] / RATE * [0.3, 0.3, 1]
    counts += random.normal(0, 300, counts.shape) * (random.random(counts.shape) < pads["spikes"])
    for k in np.flatnonzero(random.random(len(counts)) < pads["repeats"]):
        counts[k] = counts[max(k - 1, 0)]
    return np.rint(counts), random.random(len(counts)) >= pads["lost"]


def simulate(grips):
    """Fills time, counts, slip and load of all grips."""
    hand = Hand(grips)
    readings, frames = Readings(hand), max(len(grip.force) for grip in grips)
    counts, slip, load = (np.zeros((frames, len(grips), *shape), np.float32) for shape in ((2, SIDE**2, 3), (2,), ()))
    origin = np.zeros_like(hand.slid)
    for k in range(frames):
        hand.frame(k)
        counts[k] = readings.next(hand)
        time, touching = k / RATE, hand.pressure > 0
        loose = [grip.force[min(k, len(grip.force) - 1)] < 1e-3 for grip in grips]
        anew = np.array([less or time < grip.hold_at or grip.open_from <= time < grip.open_to for less, grip in zip(loose, grips)])
        origin[anew] = hand.slid[anew]
        way = ((hand.slid - origin)**2).sum(2) * touching
        slip[k] = np.sqrt(way.sum((2, 3)) / np.maximum(touching.sum((2, 3)), 1))
        load[k] = np.sqrt((hand.q**2).sum(2)).sum((1, 2, 3)) / np.maximum((hand.mu * hand.pressure).sum((1, 2, 3)), 1e-9)
    for g, grip in enumerate(grips):
        n = len(grip.force)
        read, arrives = spoil(grip, counts[:n, g])
        grip.time, grip.counts = np.flatnonzero(arrives) / RATE, read[arrives]
        grip.slip, grip.load, grip.force, grip.mass = slip[:n, g][arrives], load[:n, g][arrives], grip.force[arrives], grip.mass[arrives]
    return grips


def springs(mu=0.6, peak=0.03, dome=140.0, outward=0.025, angle=-90.0, slides=True, seed=1, rate=100):
    """Two pads whose tactels are single springs with Coulomb's law: still, press, hold, load in four seconds, slide for three, open.
    Returns time [frames], counts [frames, pads, tactels, 3], and the share of the limit that is carried [frames]."""
    random = np.random.default_rng(seed)
    y, x = np.meshgrid(*(2 * [(np.arange(SIDE) - 1.5) * 4.7]), indexing="ij")
    pressure, stiff = peak * np.clip(1 - (x**2 + y**2) / dome, 0.15, 1), 0.02  # MPa; MPa / mm
    time = np.arange(int(14.5 * rate)) / rate
    press = np.minimum(np.clip(time - 3, 0, 1), np.clip(14 - time, 0, 1))
    wanted = 0.02 + np.clip((time - 7) / 4, 0, 1) * (1.3 if slides else 0.4)
    way = np.linspace(0, 2 * mu * peak / stiff, 2001)[:, None, None]
    carried = np.minimum(stiff * way, mu * pressure).sum((1, 2)) / (mu * pressure.sum())
    tau = np.minimum(stiff * np.interp(wanted, carried, way[:, 0, 0])[:, None, None], mu * pressure) * press[:, None, None]
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    p = press[:, None, None] * pressure
    pads = [np.stack([side * along[0] * tau + outward * p * x, side * along[1] * tau + outward * p * y, p], -1) for side in (1, -1)]
    counts = 1e5 * np.stack(pads, 1).reshape(len(time), 2, SIDE**2, 3) * (1 + 0.05 * random.standard_normal((2, SIDE**2, 3)))
    return time, np.rint(30000 + counts + 2 * random.standard_normal(counts.shape)), tau.sum((1, 2)) / np.maximum(mu * p.sum((1, 2)), 1e-9)
