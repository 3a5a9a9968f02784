# SPDX-License-Identifier: Apache-2.0
"""Runs the code cells of a notebook one after the other, in its folder, without a display: run_notebook.py FILE.ipynb"""

import json
import os
import pathlib
import sys

os.environ["MPLBACKEND"] = "agg"
notebook = pathlib.Path(sys.argv[1]).resolve()
os.chdir(notebook.parent)
names = {}
for number, cell in enumerate(json.loads(notebook.read_text())["cells"], 1):
    if cell["cell_type"] == "code":
        exec(compile("".join(cell["source"]), f"{notebook.name}, cell {number}", "exec"), names)
