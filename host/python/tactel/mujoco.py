# SPDX-License-Identifier: Apache-2.0
"""Pads on the fingers of a model of MuJoCo, in m and N: their wrenches, and one PadStepper for all. Needs the package mujoco of PyPI.

    skin = tactel.mujoco.Skin(model, {"left": "left_pad", "right": "right_pad"}, pad, friction=0.6, shape=tactel.Sphere(12))
    mujoco.mj_step(model, data)
    out = skin.step(data)                # frames [pads, 3 tactels] MPa, slip_index [pads]

A pad is a geom with a frame: a site whose x and y lie in the pad, and whose z points out of the rubber, to the object; or those three
axes in the axes of the geom's body, [3, 3], through the middle of the geom. There x, y, z may be left-handed: a mirrored pad."""

import numpy as np

from . import PadStepper
from ._calls import input_error


def _mujoco():
    try:
        import mujoco
    except ImportError:
        raise input_error("mujoco", "not installed", "install it: pip install mujoco") from None
    return mujoco


def _number(model, kind, name):
    """The number of a geom or site, of its name or number."""
    if isinstance(name, str):
        kinds = _mujoco().mjtObj
        number = _mujoco().mj_name2id(model, kinds.mjOBJ_GEOM if kind == "geom" else kinds.mjOBJ_SITE, name)
        if number < 0:
            raise input_error(kind, f"no {name!r} in the model", f"name a {kind} of the model")
        return number
    if not 0 <= name < getattr(model, f"n{kind}"):
        raise input_error(kind, name, f"0 to {getattr(model, f'n{kind}') - 1}, or a name")
    return int(name)


def _frame(model, frame):
    """A number of a site, or axes that are orthonormal."""
    if np.ndim(frame) == 0:
        return _number(model, "site", frame)
    axes = np.array(frame, float)
    if axes.shape != (3, 3) or not np.allclose(axes @ axes.T, np.eye(3), atol=1e-6):
        raise input_error("frame", f"an array {axes.shape}", "a site, or [3, 3]: unit vectors x, y, z, each at right angles to the others")
    return axes


def _axes(model, data, geom, frame):
    """Origin (m) and x, y, z [3, 3] of a pad, in the world."""
    if np.ndim(frame) == 0:
        return data.site_xpos[frame], data.site_xmat[frame].reshape(3, 3).T
    return data.geom_xpos[geom], frame @ data.xmat[model.geom_bodyid[geom]].reshape(3, 3).T


def wrench(model, data, pad_geom, frame, at=(0, 0)):
    """Returns P, Qx, Qy (N), M (N mm) of all that touches a geom on its rubber, [4], in the axes of the pad.

    P presses, against z; Qx, Qy along x, y; M from x to y, about z through `at`, mm on the pad. pad_geom, frame: names or numbers of a
    geom and a site, or axes, as above. Throws InputError for others."""
    geom, frame = _number(model, "geom", pad_geom), _frame(model, frame)
    origin, (x, y, z) = _axes(model, data, geom, frame)
    origin = origin + (at[0] * x + at[1] * y) / 1000
    force, torque, local, of_contact = np.zeros(3), np.zeros(3), np.zeros(6), _mujoco().mj_contactForce
    pairs = data.contact.geom[:data.ncon]
    for k in np.flatnonzero((pairs == geom).any(1)):
        of_contact(model, data, k, local)  # of the first geom on the second, in the axes of the contact
        world = (local.reshape(2, 3) @ data.contact.frame[k].reshape(3, 3)) * (1 if pairs[k, 1] == geom else -1)
        force += world[0]
        torque += world[1] + np.cross(data.contact.pos[k] - origin, world[0])
    return np.array([-force @ z, force @ x, force @ y, 1000 * torque @ np.cross(x, y)])


class Skin:
    """The pads of a model, or of several worlds of it, on one PadStepper, `steps`. Contact w len(pads) + k is pad k of world w."""

    def __init__(self, model, pads, pad, friction, shape, *, worlds=1, **options):
        """pads: {geom: frame}, as of `wrench`. pad, options: as of PadStepper. friction: one, [worlds] or [contacts]; shape: what touches
        the pads, with its axis in their middle."""
        self._pads = [(_number(model, "geom", geom), _frame(model, frame)) for geom, frame in pads.items()]
        self._worlds = worlds
        self.steps = PadStepper(pad, worlds * len(pads), self._contacts(friction, "friction"), **options)
        self.steps.shapes(shape)

    def _contacts(self, values, name):
        """[contacts], of one value, one a world or one a contact."""
        values = np.asarray(values)
        if values.ndim == 0 or values.shape == (self._worlds,):
            values = np.repeat(np.broadcast_to(values, self._worlds), len(self._pads))
        if values.shape != (self._worlds * len(self._pads),):
            raise input_error(name, f"an array {values.shape}", f"one, [{self._worlds}] of the worlds, or [{self._worlds * len(self._pads)}] of the contacts")
        return values

    def wrench(self, data):
        """Returns [contacts, 4]: P, Qx, Qy (N), M (N mm) on the rubber of each pad, in its axes. data: MjData, or those of all worlds."""
        worlds = [data] if hasattr(data, "contact") else list(data)
        if len(worlds) != self._worlds:
            raise input_error("data", f"{len(worlds)} worlds", f"{self._worlds}")
        return np.array([wrench(one.model, one, geom, frame) for one in worlds for geom, frame in self._pads])

    def press(self, wrench, mask=None):
        """Steps contacts, or those of a mask [worlds] or [contacts], to a wrench [contacts, 4] as `wrench` returns; as PadStepper.press."""
        return self.steps.press(wrench) if mask is None else self.steps.press(wrench, mask=self._contacts(mask, "mask"))

    def step(self, data, mask=None):
        """Steps contacts to the forces of MuJoCo: press(wrench(data), mask)."""
        return self.press(self.wrench(data), mask)

    def reset(self, mask=None):
        """Contacts as if nothing had touched: all, or those of a mask [worlds] or [contacts]."""
        return self.steps.reset() if mask is None else self.steps.reset(self._contacts(mask, "mask"))
