# SPDX-License-Identifier: Apache-2.0
"""Runs the code cells of a notebook one after the other, in its folder, and compares what they print with what is stored:
run_notebook.py FILE.ipynb. With --store it stores what they print and draw."""

import ast
import base64
import contextlib
import io
import json
import os
import pathlib
import re
import sys

os.environ["MPLBACKEND"] = "agg"
import matplotlib.pyplot as plt

NUMBER = r"-?\d+(?:\.\d*)?(?:e[-+]?\d+)?"
# Networks learn with sums in the order of the processor: their numbers differ by some percent. Solved contacts differ less.
RELATIVE, ABSOLUTE = 0.05, 0.01


def pictures():
    """Takes the open figures away, as PNG."""
    for number in plt.get_fignums():
        file = io.BytesIO()
        plt.figure(number).savefig(file, format="png", dpi=64, bbox_inches="tight", metadata={"Software": None})
        yield file.getvalue()
    plt.close("all")


def run(source, name, names):
    """Returns the text and the pictures of a cell: what it prints, and the value of its last line."""
    body = ast.parse(source, name).body
    last = body.pop() if body and isinstance(body[-1], ast.Expr) else None
    printed, shown = io.StringIO(), []
    plt.show = lambda: shown.extend(pictures())
    with contextlib.redirect_stdout(printed):
        exec(compile(ast.Module(body, []), name, "exec"), names)
        value = eval(compile(ast.Expression(last.value), name, "eval"), names) if last else None
        if value is not None:
            print(repr(value))
    return printed.getvalue(), [*shown, *pictures()]


def agree(text, stored):
    """Whether two texts have the same words, and numbers that are close."""
    if re.sub(NUMBER, "", text).split() != re.sub(NUMBER, "", stored).split():
        return False
    ours, theirs = re.findall(NUMBER, text), re.findall(NUMBER, stored)
    return len(ours) == len(theirs) and all(abs(float(a) - float(b)) <= max(RELATIVE * abs(float(b)), ABSOLUTE) for a, b in zip(ours, theirs))


def main():
    store = sys.argv[1] == "--store"
    notebook = pathlib.Path(sys.argv[-1]).resolve()
    os.chdir(notebook.parent)
    document = json.loads(notebook.read_text(encoding="utf-8"))
    names, wrong, number = {}, 0, 0
    for cell in document["cells"]:
        if cell["cell_type"] != "code":
            continue
        number += 1
        text, drawn = run("".join(cell["source"]), f"{notebook.name}, cell {number}", names)
        if store:
            cell["execution_count"] = number
            cell["outputs"] = [{"name": "stdout", "output_type": "stream", "text": text.splitlines(True)}] if text else []
            cell["outputs"] += [{"data": {"image/png": base64.b64encode(png).decode()}, "metadata": {}, "output_type": "display_data"}
                                for png in drawn]
            continue
        stored = "".join(line for output in cell["outputs"] for line in output.get("text", []))
        if not agree(text, stored) or len(drawn) != sum("data" in output for output in cell["outputs"]):
            wrong += 1
            print(f"cell {number} printed, with {len(drawn)} pictures:\n{text}stored:\n{stored}")
    if store:
        notebook.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    if notebook.stat().st_size > 200_000:
        sys.exit(f"{notebook.name}: more than 200 kB")
    sys.exit(wrong)


if __name__ == "__main__":
    main()
