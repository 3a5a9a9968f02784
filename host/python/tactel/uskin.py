# SPDX-License-Identifier: Apache-2.0
"""Frames and slippage index of the public data set slip_detection_dataset_2021 (uSkin sensor, BSD licence).

Zenha, Denoun, Coppola, Jamone: Tactile Slip Detection in the Wild, IROS 2021. The user downloads the HDF5 files. Each trial is
a group PLANNER/OBJECT/PoseN/ExpN with
  tactile_data_raw     [18, 3, frames] counts: pin 3 c + r of column c and row r; axes x and y are shear, z is normal
  tactile_timestamps   [frames] ms
  tactile_slips_label  [frames] 0 to 6, see `Label`.
The counts are of a magnetic sensor and no stresses. S needs none: the unit cancels in Q / P, and in networks with
scaling "frame". It takes equal gains of pins and axes for granted.
"""

import enum
import os
from dataclasses import dataclass

import numpy as np

from ._calls import input_error

_FILE = "use an unchanged file of slip_detection_dataset_2021"
_COLUMNS, _ROWS, _AXES = 6, 3, {"x": 0, "y": 1}
_TOUCH = 0.05  # share of the largest normal force below which a frame has no S
_LARGEST = 10_000_000  # frames of one trial: 15 hours at 180 Hz


class Label(enum.IntEnum):
    """What a person noted for a frame."""

    STILL = 0  # not held, or held without motion; no slip
    STILL_SLIP = 1
    RELEASED = 2
    GRASPED = 3
    MOVING = 4
    MOVING_SLIP = 5
    OTHER = 6


def _slips(label):
    return np.isin(label, (Label.STILL_SLIP, Label.MOVING_SLIP))


@dataclass(frozen=True)
class Trial:
    """One grasp. Arrays have an entry for each of its frames while the object is held."""

    name: str  #: the group in the file
    time: np.ndarray  #: [frames] s, from the first frame of the trial
    label: np.ndarray  #: [frames] int, `Label`
    frames: np.ndarray  #: [frames, 2 pins] fp32 counts less those at rest: normal (compression is negative), then shear
    P: np.ndarray  #: [frames] counts: normal force, the sum over all 18 pins
    Q: np.ndarray  #: [frames] counts: shear force along `shear`, the sum over all 18 pins
    friction: float  #: median of |Q| / P over the frames labelled as slip; NaN where there are fewer than 10
    slip_index: np.ndarray  #: [frames] |Q| / (friction P); NaN where P is below 5 % of its largest, or friction is NaN

    @property
    def slipping(self):
        """[frames] bool: labelled as slip."""
        return _slips(self.label)


def _refuse(place, problem, fix):
    raise input_error(place, problem, fix)


def _dataset(group, path, name, rank, kinds):
    data = group.get(name)
    place = f"{path}:{group.name}/{name}"
    if getattr(data, "shape", None) is None or len(data.shape) != rank or data.dtype.kind not in kinds:
        _refuse(place, f"no dataset of numbers with {rank} dimensions", _FILE)
    if not 0 < data.shape[-1] <= _LARGEST:
        _refuse(place, f"{data.shape[-1]} frames", f"a trial has 1 to {_LARGEST}")
    return data


def _arrays(group, path):
    """Counts, time (s) and label of a trial, checked."""
    raw = _dataset(group, path, "tactile_data_raw", 3, "fiu")
    time = _dataset(group, path, "tactile_timestamps", 1, "fiu")
    label = _dataset(group, path, "tactile_slips_label", 1, "iu")
    place = f"{path}:{group.name}"
    if raw.shape != (_COLUMNS * _ROWS, 3, time.shape[0]) or label.shape != time.shape:
        _refuse(place, f"counts {raw.shape}, times {time.shape} and labels {label.shape} do not fit [18, 3, frames]", _FILE)
    raw, time, label = raw[...].astype(np.float64), time[...].astype(np.float64), label[...].astype(np.int64)
    if not np.isfinite(raw).all() or not np.isfinite(time).all():
        _refuse(place, "counts or times that are not finite", _FILE)
    if (np.diff(time) < 0).any():
        _refuse(f"{place}/tactile_timestamps", "times that fall", _FILE)
    if label.min() < Label.STILL or label.max() > Label.OTHER:
        _refuse(f"{place}/tactile_slips_label", f"labels {label.min()} to {label.max()}", "labels are 0 to 6")
    return raw, (time - time[0]) / 1000, label


def _trial(name, raw, time, label, shear, row):
    """The held part of a trial, or None where no frame is labelled as grasped with a frame at rest before it."""
    grasped = np.flatnonzero(label == Label.GRASPED)
    if grasped.size == 0 or grasped[0] == 0:
        return None
    after = np.flatnonzero(label[grasped[0]:] == Label.RELEASED)
    end = grasped[0] + after[0] if after.size else label.size
    held = slice(grasped[0], end)
    counts = raw[:, :, held] - raw[:, :, :grasped[0]].mean(axis=2)[:, :, None]
    normal, tangential = counts[:, 2], counts[:, _AXES[shear]]
    total = normal.sum(axis=0)
    sign = 1.0 if total.mean() > 0 else -1.0  # an object only presses
    P, Q = sign * total, tangential.sum(axis=0)
    pins = _ROWS * np.arange(_COLUMNS) + row
    frames = np.concatenate([-sign * normal[pins], tangential[pins]]).T.astype(np.float32)
    touching = (P > 0) & (P >= _TOUCH * P.max())
    slipping = touching & _slips(label[held])
    friction = float(np.median(np.abs(Q[slipping]) / P[slipping])) if slipping.sum() >= 10 else np.nan
    slip_index = np.full(P.shape, np.nan)
    if friction > 0:
        slip_index[touching] = np.abs(Q[touching]) / (friction * P[touching])
    return Trial(name, time[held], label[held], frames, P, Q, friction, slip_index)


def trials(path, *, shear="x", row=1):
    """Iterates over the grasps of a file of the data set, as `Trial`.

    shear: axis of the sensor, "x" or "y", that runs along the columns of pins as mounted. row: 0 to 2, the row of six pins that
    frames are taken from. Needs h5py. Trials without a frame at rest before the grasp are left out.
    Raises InputError, with the dataset's name, for a file that is none of the data set.
    """
    import h5py

    if shear not in _AXES:
        _refuse("shear", repr(shear), "x or y")
    if row not in range(_ROWS):
        _refuse("row", repr(row), "0, 1 or 2")
    if "\0" in os.fsdecode(path):
        _refuse("path", repr(path), "must have no NUL byte")
    with h5py.File(path, "r") as file:
        names = []

        def keep(name, item):
            if isinstance(item, h5py.Group) and "tactile_data_raw" in item:
                names.append(name)

        file.visititems(keep)
        if not names:
            _refuse(str(path), "no group with tactile_data_raw", "use a file of slip_detection_dataset_2021")
        for name in names:
            trial = _trial(name, *_arrays(file[name], path), shear, row)
            if trial is not None:
                yield trial
