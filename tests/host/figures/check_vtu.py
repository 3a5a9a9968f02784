# SPDX-License-Identifier: Apache-2.0
"""Reads the cells of a contact on a pad from a VTU file by an XML reader, as ParaView does."""
import math
import xml.etree.ElementTree as xml


def arrays(parent):
    """Numbers of each DataArray by name, in tuples of its components."""
    out = {}
    for array in parent.findall("DataArray"):
        numbers, size = [float(word) for word in array.text.split()], int(array.get("NumberOfComponents", 1))
        out[array.get("Name")] = numbers if size == 1 else [tuple(numbers[k:k + size]) for k in range(0, len(numbers), size)]
    return out


def read(path):
    """A dictionary a quad: its corners, and its data by name."""
    root = xml.parse(path).getroot()
    assert root.tag == "VTKFile" and root.get("type") == "UnstructuredGrid", root.attrib
    piece = root.find("UnstructuredGrid/Piece")
    points, cells, data = arrays(piece.find("Points"))["Points"], arrays(piece.find("Cells")), arrays(piece.find("CellData"))
    count = int(piece.get("NumberOfCells"))
    assert len(points) == int(piece.get("NumberOfPoints"))
    assert cells["types"] == [9] * count and cells["offsets"] == [4 * (k + 1) for k in range(count)], "not all cells are quads"
    assert all(len(values) == count for values in data.values())
    corners = [points[int(k)] for k in cells["connectivity"]]
    return [{"corners": corners[4 * k:4 * k + 4], **{name: values[k] for name, values in data.items()}} for k in range(count)]


def problems(quads, thickness, friction=0.5):
    """What is wrong with quads on a surface: their height and turn, and Coulomb's law by their status."""
    out = []
    largest = max(quad["normal_traction"] for quad in quads)
    for k, quad in enumerate(quads):
        a, b, c, d = quad["corners"]
        turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
        if turn <= 0 or any(corner[2] != thickness for corner in (a, b, c, d)):
            out.append(f"cell {k} has corners {quad['corners']}")
        normal, shear, status = quad["normal_traction"], math.hypot(*quad["tangential_traction"]), quad["status"]
        fits = {0: normal == 0 and shear == 0, 1: normal > 0 and shear <= friction * normal, 2: normal > 0 and abs(shear - friction * normal) <= 1e-3 * largest}
        if not fits.get(status, False) or quad["tangential_traction"][2] != 0:
            out.append(f"cell {k} has status {status}, n = {normal}, |t| = {shear}")
    if {quad["status"] for quad in quads} != {0, 1, 2}:
        out.append("open, stick and slip are not all there")
    return out
