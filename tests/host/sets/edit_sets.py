# SPDX-License-Identifier: Apache-2.0
"""Edits of a good set that no checksum of a chunk notices. Usage: edit_sets.py GOOD.h5 FOLDER
Writes FOLDER/NAME.h5 for each edit: `tactel check` must not call any of them as written."""
import pathlib
import shutil
import sys

import h5py
import numpy as np

good, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])


def edit(name):
    shutil.copy(good, folder / f"{name}.h5")
    return h5py.File(folder / f"{name}.h5", "r+")


def fixed(owner, key, text):
    """Of the kind that tactel writes."""
    owner.attrs.create(key, np.bytes_(text.encode() + b"\0"), dtype=f"S{len(text.encode()) + 1}")


with edit("exchanged_names") as file:
    file.move("normal_force", "other")
    file.move("tangential_force", "normal_force")
    file.move("other", "tangential_force")
with edit("exchanged_checksums") as file:
    one, two = file["normal_force"].attrs, file["tangential_force"].attrs
    one["checksum"], two["checksum"] = two["checksum"], one["checksum"]
with h5py.File(good) as file:
    texts = [key for key in file.attrs if isinstance(file.attrs[key], bytes)]
    counts = [key for key in file.attrs if key not in texts]
assert {"sweep", "indenter_names", "press_rows", "plan", "checksum", "columns"} <= set(texts), texts
assert {"seed", "contacts"} <= set(counts), counts
for key in texts + counts:
    with edit(f"deleted_{key}") as file:
        del file.attrs[key]
for key in texts:
    with edit(f"edited_{key}") as file:
        fixed(file, key, file.attrs[key].decode().replace("e", "E").replace("0", "1") + " ")
for key in counts:
    with edit(f"edited_{key}") as file:
        file.attrs.modify(key, file.attrs[key] + np.uint64(1))
for form, options in (("gzip", {"compression": "gzip"}), ("lzf", {"compression": "lzf"}), ("float64", {"dtype": "<f8"}), ("big_endian", {"dtype": ">f4"})):
    with edit(f"copied_{form}") as file:
        values, attributes = file["slip_index"][:], {key: file["slip_index"].attrs[key] for key in ("checksum", "unit") if key in file["slip_index"].attrs}
        del file["slip_index"]
        file.create_dataset("slip_index", data=values, chunks=(8192,), **options).attrs.update(attributes)
with edit("added_attribute") as file:
    file.attrs["note"] = "mine"
for name, key in (("inputs", "unit"), ("parameters", "unit"), ("parameters", "columns"), ("parameters", "units"),
                  ("slip_index", "checksum")):
    with edit(f"deleted_{key}_of_{name}") as file:
        del file[name].attrs[key]
with edit("edited_unit") as file:
    fixed(file["normal_force"], "unit", "kN/mm")
with edit("columns_in_another_order") as file:
    table = file["parameters"]
    columns = table.attrs["columns"].decode().split("\n")
    at = columns.index("indenter.radius")
    columns[at], columns[at - 1] = columns[at - 1], columns[at]
    fixed(table, "columns", "\n".join(columns))
for name, link in (("soft_link", h5py.SoftLink("/normal_force")), ("external_link", h5py.ExternalLink(good, "/slip_index"))):
    with edit(name) as file:
        del file["slip_index"]
        file["slip_index"] = link
with edit("hard_link") as file:
    del file["slip_index"]
    file["slip_index"] = file["normal_force"]
with edit("virtual_dataset") as file:
    rows, attributes = file["slip_index"].shape[0], dict(file["slip_index"].attrs)
    del file["slip_index"]
    layout = h5py.VirtualLayout(shape=(rows,), dtype="f4")
    layout[:] = h5py.VirtualSource(good, "slip_index", shape=(rows,))
    file.create_virtual_dataset("slip_index", layout).attrs.update(attributes)
with edit("added_dataset") as file:
    file["mine"] = np.zeros(3)
with edit("added_link") as file:
    file["mine"] = h5py.SoftLink("/slip_index")
with edit("deleted_dataset") as file:
    del file["friction"]
with edit("numbers_with_their_checksum_gone") as file:
    attributes = {key: value for key, value in file["slip_index"].attrs.items() if key != "checksum"}
    values = file["slip_index"][:]
    values[0] += 1
    del file["slip_index"]
    file.create_dataset("slip_index", data=values).attrs.update(attributes)
