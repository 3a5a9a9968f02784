# SPDX-License-Identifier: Apache-2.0
"""Sets that no tactel wrote, from a good one. Usage: forge_sets.py GOOD.h5 FOLDER
FOLDER/bad_*.h5 must be refused, FOLDER/good_*.h5 hold the rows and names of GOOD.h5."""
import pathlib
import shutil
import sys

import h5py
import numpy as np

good, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])


def forge(name):
    shutil.copy(good, folder / f"{name}.h5")
    return h5py.File(folder / f"{name}.h5", "r+")


def replace(file, name, **made):
    attributes = {key: value for key, value in file[name].attrs.items() if key != "checksum"}
    del file[name]
    file.create_dataset(name, **made).attrs.update(attributes)


def attribute(name, key, value, **more):
    with forge(name) as file:
        del file.attrs[key]
        if more:
            file.attrs.create(key, value, **more)
        elif value is not None:
            file.attrs[key] = value


LATER = ("indentation", "tangential", "tactel_x", "parameters")


with h5py.File(good) as file:
    contacts, parameters = file["parameters"].shape
    rows, inputs = file["inputs"].shape
    names = file.attrs["indenter_names"].decode().split("\n")
    text = file.attrs["format"]

# Attributes: an array where one text stands, other types, too long.
attribute("bad_format_array", "format", np.array([text] * 1000))
attribute("bad_format_number", "format", 1)
attribute("bad_format_missing", "format", None)
attribute("bad_sweep_array", "sweep", np.array([b"x" * 999] * 50))
attribute("bad_seed_array", "seed", np.array([1, 2, 3]))
attribute("bad_seed_text", "seed", "seven")
attribute("good_format_variable", "format", text.decode())
attribute("good_names_variable", "indenter_names", "\n".join(names))
attribute("good_names_list", "indenter_names", names)
attribute("good_names_fixed_list", "indenter_names", np.array([n.encode() for n in names]))
attribute("bad_seed_negative", "seed", -1)
attribute("bad_seed_real", "seed", 7.5)
attribute("bad_seed_digits", "seed", "7")
attribute("bad_columns_without_slip_index", "columns", "inputs")
attribute("bad_contacts", "contacts", contacts + 1)
attribute("bad_columns_missing", "columns", None)

# Datasets: rank, type, extent.
for name, shape in (("inputs", (rows, inputs, 1)), ("inputs", (rows * inputs,)), ("slip_index", (rows, 1)),
                    ("contact", (rows, 1, 1)), ("slip_index", (rows - 1,)), ("status", (rows + 1,)), ("inputs", (rows, 0)),
                    ("inputs", ()), ("step", (0,)), ("indentation", (rows - 1,)), ("tangential", (rows, 1)),
                    ("tactel_x", (inputs // 2 - 1,)), ("tactel_x", (inputs // 2, 1)), ("tactel_x", (0,)),
                    ("parameters", (contacts,)), ("parameters", (contacts - 1, parameters)),
                    ("parameters", (contacts, parameters + 1)), ("parameters", (contacts, 0))):
    with forge(f"bad_{name}_{'x'.join(map(str, shape))}") as file:
        replace(file, name, shape=shape, dtype=file[name].dtype)
for name, kind in (("inputs", "S4"), ("slip_index", "i4"), ("contact", "f8"), ("friction", h5py.string_dtype()),
                   ("status", np.dtype([("a", "u1")])), ("tangential", "i4"), ("tactel_x", "S4"), ("parameters", "u2")):
    with forge(f"bad_{name}_{np.dtype(kind).kind}") as file:
        replace(file, name, shape=file[name].shape, dtype=kind)
with forge("bad_group") as file:
    del file["step"]
    file.create_group("step")
with forge("bad_missing") as file:
    del file["residual"]
# Datasets that the attribute columns names, and numbers that no set has.
for name in LATER:
    with forge(f"bad_missing_{name}") as file:
        del file[name]
for name, number in (("indentation", np.nan), ("tangential", np.inf), ("tactel_x", np.nan), ("tactel_x", 1e9),
                     ("parameters", np.inf)):
    with forge(f"bad_{name}_{number}") as file:
        values = file[name][:]
        values.flat[1] = number
        replace(file, name, data=values)
for key in ("columns", "units"):
    with forge(f"bad_parameters_{key}") as file:
        file["parameters"].attrs[key] = "one"
with forge("bad_parameters_names") as file:
    del file["parameters"].attrs["columns"]
with forge("bad_null") as file:
    del file["residual"]
    file["residual"] = h5py.Empty("f4")
# Rows that are claimed and not there: 2^40 of them, in chunks of which none was written.
with forge("bad_huge") as file:
    for name in list(file):
        extent = (1 << 39,) + file[name].shape[1:]
        replace(file, name, shape=extent, dtype=file[name].dtype, chunks=(4096,) + extent[1:], fletcher32=True)
with forge("bad_huge_squeezed") as file:
    for name in list(file):
        extent = (1 << 39,) + file[name].shape[1:]
        replace(file, name, shape=extent, dtype=file[name].dtype, chunks=(4096,) + extent[1:], compression="gzip")
with forge("bad_external") as file:
    values = file["residual"][:]
    replace(file, "residual", shape=values.shape, dtype="f4", external=[("/etc/passwd", 0, h5py.h5f.UNLIMITED)])

# As users may store them anew, without checksums.
for name, how in (("good_contiguous", {}), ("good_gzip", {"compression": "gzip", "chunks": True}),
                  ("good_double", {"chunks": True, "fletcher32": True})):
    with forge(name) as file:
        for key in list(file):
            values = file[key][:]
            replace(file, key, data=values.astype("f8") if name == "good_double" and values.dtype.kind == "f" else values,
                    **how)
