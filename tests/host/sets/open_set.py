# SPDX-License-Identifier: Apache-2.0
"""Opens a set with h5py, as the documentation says, and checks what it promises. Usage: open_set.py SET.h5"""
import sys

import h5py
import numpy as np

TYPES = {
    "inputs": "<f4", "slip_index": "<f4", "normal_force": "<f4", "tangential_force": "<f4", "friction": "<f4",
    "stick_fraction": "<f4", "contact_nodes": "<u2", "contact": "<u8", "step": "<u4", "indenter": "<u2",
    "status": "u1", "residual": "<f4",
}

with h5py.File(sys.argv[1], "r") as file:
    assert set(file) == set(TYPES), set(file) ^ set(TYPES)
    rows = len(file["slip_index"])
    for name, kind in TYPES.items():
        assert file[name].dtype == np.dtype(kind), (name, file[name].dtype)
        assert file[name].shape == ((rows, 42) if name == "inputs" else (rows,)), (name, file[name].shape)
        assert file[name].attrs["unit"], name
    for name in ("tactel", "format", "sweep", "seed", "device", "rung", "indenter_names", "units"):
        assert name in file.attrs, name
    s, q, p, mu = (file[name][:].astype(float) for name in ("slip_index", "tangential_force", "normal_force", "friction"))
    assert rows > 100 and np.all(p > 0)
    assert np.abs(s - q / (mu * p)).max() < 1e-6  # fp32 storage
    normal, shear = file["inputs"][:, :21], file["inputs"][:, 21:]
    assert normal.min() < 0 and -normal.min() > normal.max()  # compression is negative
    pitch = 1.0  # mm: 21 tactels on 20 mm
    assert np.all(shear[s > 0.5].sum(axis=1) > 0)  # the rubber is dragged towards +x
    # What the base carries balances P and Q; a sum over tactels integrates to a few percent.
    assert np.median(np.abs(-pitch * normal.sum(axis=1) / p - 1)) < 0.05
    assert np.median(np.abs(pitch * shear.sum(axis=1)[s > 0.5] / q[s > 0.5] - 1)) < 0.05
    assert len(file.attrs["indenter_names"].decode().split("\n")) > file["indenter"][:].max()
