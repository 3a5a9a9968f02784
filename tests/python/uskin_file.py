# SPDX-License-Identifier: Apache-2.0
"""A small file of our own in the format of slip_detection_dataset_2021. Usage: uskin_file.py FILE.h5"""

import sys

import h5py
import numpy as np

REST, HELD = 5, 40  # frames


def write(path, normal, shear, label, *, rest=100.0, name="PLANNER/brush/Pose1/Exp1", **changes):
    """A trial of frames [frames, 6] in row 1, compression positive, shear along x; other rows are still."""
    raw = np.full((18, 3, len(label)), rest)
    raw[1::3, 2] += np.asarray(normal).T
    raw[1::3, 0] += np.asarray(shear).T
    datasets = {"tactile_data_raw": raw, "tactile_timestamps": 5.5 * np.arange(len(label)) + 7e8,
                "tactile_slips_label": np.asarray(label), "tactile_changes_label": np.ones(len(label), int), **changes}
    with h5py.File(path, "a") as file:
        for key, data in datasets.items():
            if data is not None:
                file.create_dataset(f"{name}/{key}", data=data)


def by_hand():
    """P = 60, Q from 0 to 24 in 20 frames, then sliding at 24: mu = 0.4, S = Q / 24."""
    Q = np.concatenate([np.zeros(REST), np.linspace(0, 24, HELD - 20), np.full(20, 24.0)])
    held = np.concatenate([np.zeros(REST), np.ones(HELD)])
    normal = np.outer(10 * held, np.ones(6))
    shear = np.outer(Q, np.array([0, 1, 2, 2, 1, 0]) / 6)
    label = np.array([0] * REST + [3] + [4] * (HELD - 21) + [5] * 10 + [1] * 10)
    return normal, shear, label, Q[REST:] / 24


if __name__ == "__main__":
    write(sys.argv[1], *by_hand()[:3])
