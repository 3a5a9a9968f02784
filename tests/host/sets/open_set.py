# SPDX-License-Identifier: Apache-2.0
"""Opens a set with h5py, as the documentation says, and checks what it promises. Usage: open_set.py SET.h5"""
import sys

import h5py
import numpy as np

TYPES = {
    "inputs": "<f4", "slip_index": "<f4", "normal_force": "<f4", "tangential_force": "<f4", "friction": "<f4",
    "stick_fraction": "<f4", "contact_nodes": "<u2", "contact": "<u8", "step": "<u4", "indenter": "<u2",
    "status": "u1", "residual": "<f4", "indentation": "<f4", "tangential": "<f4",
}

with h5py.File(sys.argv[1], "r") as file:
    others = {"tactel_x", "parameters"}
    scales = {"row", "input", "contacts", "parameter", "tactel"}
    assert set(file) == set(TYPES) | others | scales, set(file) ^ set(TYPES) ^ others ^ scales
    assert set(file.attrs["columns"].decode().split("\n")) == set(file) - scales
    rows = len(file["slip_index"])
    dimensions = {name: ["row"] for name in TYPES}
    dimensions |= {"inputs": ["row", "input"], "parameters": ["contacts", "parameter"], "tactel_x": ["tactel"]}
    for name, its in dimensions.items():
        assert [[scale.name for scale in along.values()] for along in file[name].dims] == [["/" + one] for one in its], name
        assert file[name].shape == tuple(len(file[one]) for one in its), name
        for axis, one in enumerate(its):  # both refer to each other
            assert h5py.h5ds.is_attached(file[name].id, file[one].id, axis), (name, one)
    for name, kind in TYPES.items():
        assert file[name].dtype == np.dtype(kind), (name, file[name].dtype)
        assert file[name].shape == ((rows, 42) if name == "inputs" else (rows,)), (name, file[name].shape)
        assert file[name].attrs["unit"], name
    for name in ("seed", "contacts", "contacts_without_rows", "fallback_contacts", "unsolved_contacts"):
        assert file.attrs[name].dtype == np.uint64 and file.attrs[name].shape == (), name
    for name in ("tactel", "format", "sweep", "seed", "device", "rung", "indenter_names", "units"):
        assert name in file.attrs, name
    s, q, p, mu = (file[name][:].astype(float) for name in ("slip_index", "tangential_force", "normal_force", "friction"))
    assert rows > 100 and np.all(p > 0)
    assert np.abs(s - q / (mu * p)).max() < 1e-6  # fp32 storage
    normal, shear = file["inputs"][:, :21], file["inputs"][:, 21:]
    assert normal.min() < 0 and -normal.min() > normal.max()  # compression is negative
    x = file["tactel_x"][:]
    assert x.dtype == np.dtype("<f4") and np.array_equal(x, np.linspace(-10, 10, 21, dtype="f4"))  # 21 tactels on 20 mm
    pitch = x[1] - x[0]
    # A drag begins where the indentation ends, at 0, goes on in equal steps, and keeps its depth.
    contact, depth, drag = (file[name][:] for name in ("contact", "indentation", "tangential"))
    for k in np.unique(contact):
        its = contact == k
        assert drag[its][0] == 0 and np.all(np.diff(drag[its]) > 0) and np.ptp(np.diff(drag[its])) < 1e-5, k
        assert np.ptp(depth[its]) == 0 and depth[its][0] > 0, k
    table = file["parameters"]
    columns = table.attrs["columns"].decode().split("\n")
    assert len(columns) == len(table.attrs["units"].decode().split("\n")) == len(set(columns)) == table.shape[1]
    assert table.dtype == np.dtype("<f4") and len(table) == file.attrs["contacts"]
    of = {name: table[:][contact, k] for k, name in enumerate(columns)}  # [rows]
    assert np.array_equal(of["indenter"], file["indenter"][:]) and np.array_equal(of["contact.friction"], file["friction"][:])
    kinds = np.array(file.attrs["indenter_names"].decode().split("\n"))[file["indenter"][:]]
    for kind, name in (("triangular", "edge_angle"), ("parabolic", "radius"), ("exponential", "rate"), ("trapezoidal", "slope")):
        has = np.isfinite(of[f"indenter.{name}"])
        assert np.all(has[kinds == kind]) and (kinds == kind).any(), (kind, set(kinds))
        assert not has[kinds == ("triangular" if kind != "triangular" else "parabolic")].any(), name
    assert np.all(shear[s > 0.5].sum(axis=1) > 0)  # the rubber is dragged towards +x
    # What the base carries balances P and Q; a sum over tactels integrates to a few percent.
    assert np.median(np.abs(-pitch * normal.sum(axis=1) / p - 1)) < 0.05
    assert np.median(np.abs(pitch * shear.sum(axis=1)[s > 0.5] / q[s > 0.5] - 1)) < 0.05
    assert len(file.attrs["indenter_names"].decode().split("\n")) > file["indenter"][:].max()
