# SPDX-License-Identifier: Apache-2.0
"""A contact as an input deck of CalculiX (ccx), in plane strain: one layer of C3D8 elements, held in z. bench/peers times it.

Each surface node has a contact pair of its own with a horizontal facet at the height of the indenter above it. The gap is therefore that
of tactel, vertical at the node's place. Penalties stand for the laws of Signorini and Coulomb. C3D8 has the stiffness of tactel's q4."""
import pathlib
import re
import subprocess
import tempfile
import time

# Pressure a gap and traction a slip, times E over an element's width. Larger ones are more exact, and need more increments.
PENALTY, STICK_PENALTY = 1000, 100
# First part of a drag. ccx shortens and lengthens increments; from a longer one it falls back to a shorter one.
FIRST_INCREMENT = 0.02


def mesh_lines(sensor):
    """x of the columns; y of the rows, whose heights fall geometrically from bottom to top."""
    columns, count = sensor["columns"], sensor["rows"] - 1
    x = [sensor["length"] * (i / (columns - 1) - 0.5) for i in range(columns)]
    heights = [sensor["grading"] ** (-k / max(1, count - 1)) for k in range(count)]
    y = [0.0]
    for height in heights:
        y.append(y[-1] + height * sensor["thickness"] / sum(heights))
    return x, y


def deck(sensor, radius, friction, moves):
    """Text for a parabola at x = 0; moves: [(indentation, tangential)] mm. The first, without history, is one increment."""
    x, y = mesh_lines(sensor)
    columns, rows, width = len(x), len(y), x[1] - x[0]
    
    def number(i, j, k):
        return 1 + i + columns * (j + rows * k)

    text = ["*NODE, NSET=ALL\n"]
    text += [f"{number(i, j, k)}, {x[i]:.12g}, {y[j]:.12g}, {k}\n" for k in (0, 1) for j in range(rows) for i in range(columns)]
    text.append("*ELEMENT, TYPE=C3D8, ELSET=RUBBER\n")
    element = 0
    for j in range(rows - 1):
        for i in range(columns - 1):
            element += 1
            corners = [number(i + a, j + b, k) for k in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
            text.append(f"{element}, " + ", ".join(map(str, corners)) + "\n")
    text.append("*NSET, NSET=BASE\n" + "".join(f"{number(i, 0, k)},\n" for k in (0, 1) for i in range(columns)))
    # A box above each node that may touch; its lower face is the facet.
    reach = 2 * max(depth for depth, _ in moves)
    touched = [i for i in range(columns) if x[i] ** 2 / (2 * radius) <= reach]
    node = number(columns - 1, rows - 1, 1)
    boxes, half = [], 2 * width
    text.append("*NODE, NSET=INDENTER\n")
    for i in touched:
        bottom = y[-1] + x[i] ** 2 / (2 * radius)
        box = []
        for z in (-0.5, 1.5):
            for dx, dy in ((-half, 0), (half, 0), (half, width), (-half, width)):
                node += 1
                box.append(node)
                text.append(f"{node}, {x[i] + dx:.12g}, {bottom + dy:.12g}, {z}\n")
        boxes.append(box)
    text.append("*ELEMENT, TYPE=C3D8, ELSET=BOXES\n")
    for k, box in enumerate(boxes):
        text.append(f"{element + 1 + k}, " + ", ".join(map(str, box)) + "\n")
    text.append(f"*MATERIAL, NAME=RUBBER\n*ELASTIC\n{sensor['young']}, {sensor['poisson']}\n"
                "*SOLID SECTION, ELSET=RUBBER, MATERIAL=RUBBER\n*SOLID SECTION, ELSET=BOXES, MATERIAL=RUBBER\n")
    scale = sensor["young"] / width
    text.append(f"*SURFACE INTERACTION, NAME=LAWS\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{PENALTY * scale:.6g}, 1e-9, 1e-3\n"
                f"*FRICTION\n{friction:.12g}, {STICK_PENALTY * scale:.6g}\n")
    for k, i in enumerate(touched):
        text.append(f"*SURFACE, NAME=N{k}, TYPE=NODE\n{number(i, rows - 1, 0)}\n{number(i, rows - 1, 1)}\n"
                    f"*SURFACE, NAME=F{k}\n{element + 1 + k}, S3\n"
                    f"*CONTACT PAIR, INTERACTION=LAWS, TYPE=NODE TO SURFACE\nN{k}, F{k}\n")
    text.append("*BOUNDARY\nALL, 3, 3\nBASE, 1, 2\nINDENTER, 3, 3\n")
    for k, (depth, drag) in enumerate(moves):
        static = f"*STATIC\n{FIRST_INCREMENT}, 1." if k else "*STATIC, DIRECT\n1., 1."
        text.append(f"*STEP, INC=100000\n{static}\n*BOUNDARY\nINDENTER, 1, 1, {drag:.12g}\nINDENTER, 2, 2, {-depth:.12g}\n"
                    "*NODE PRINT, NSET=BASE, TOTALS=ONLY, FREQUENCY=100000\nRF\n*END STEP\n")
    return "".join(text)


def solve(sensor, radius, friction, moves):
    """[(P, Q)] N/mm of each move, and the seconds that ccx took. Raises RuntimeError where it gives up."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "contact.inp"
        path.write_text(deck(sensor, radius, friction, moves))
        start = time.perf_counter()
        run = subprocess.run(["ccx", "-i", "contact"], cwd=folder, capture_output=True, text=True, timeout=300)
        seconds = time.perf_counter() - start
        found = path.with_suffix(".dat").read_text() if path.with_suffix(".dat").exists() else ""
    totals = re.findall(r"total force.*?\n\s*\n\s*(\S+)\s+(\S+)\s+\S+", found)
    if run.returncode or len(totals) != len(moves):
        raise RuntimeError(f"ccx solves {len(totals)} of {len(moves)} moves:\n{run.stdout[-800:]}")
    # Forces of the base on the rubber.
    return [(float(y), -float(x)) for x, y in totals], seconds
